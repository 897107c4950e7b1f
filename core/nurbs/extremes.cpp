#include "nurbs/extremes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "base/interruption.h"
#include "base/vec3d.h"
#include "nurbs/loop_pieces.h"

namespace bob {
namespace {

constexpr int border_samples = 16, inside_samples = 6;  // of a piece of a border, and of a span along either parameter
constexpr int golden_steps = 60, newton_steps = 16;
constexpr double golden = 1 / std::numbers::phi;

/// The distinct knots of a surface, from one end of its domain to the other.
struct Knots {
    explicit Knots(const NurbsSurface& surface)
        : u(distinct_knots(surface.degree_u, surface.knots_u)), v(distinct_knots(surface.degree_v, surface.knots_v)) {}

    [[nodiscard]] double clamped_u(double at) const { return std::clamp(at, u.front(), u.back()); }
    [[nodiscard]] double clamped_v(double at) const { return std::clamp(at, v.front(), v.back()); }

    std::vector<double> u, v;
};

Vec3d point(const NurbsSurface& surface, const Knots& knots, double u, double v) {
    return surface_derivatives(surface, knots.clamped_u(u), knots.clamped_v(v), 0)[0];
}

/// No point of the surface is higher than this along a direction, up to rounding: with positive weights it lies in the
/// hull of its control points.
double bound_of_height(const NurbsSurface& surface, const Vec3d& direction) {
    double highest = -HUGE_VAL, largest = 0;
    for (const auto& [x, y, z, w] : surface.control_points) {
        if (!(w > 0)) return HUGE_VAL;
        const double height = dot({x / w, y / w, z / w}, direction);
        highest = std::max(highest, height), largest = std::max(largest, std::abs(height));
    }
    return highest - 1e-14 * largest;
}

/// Newton's method for a place without slope along a direction, from a place nearby. False if it leads elsewhere.
bool level(const NurbsSurface& surface, const Knots& knots, const Vec3d& direction, double& u, double& v) {
    const double size_u = knots.u.back() - knots.u.front(), size_v = knots.v.back() - knots.v.front();
    for (int step = 0; step < newton_steps; ++step) {
        const auto by = surface_derivatives(surface, u, v, 2);
        const auto along = [&](std::size_t i) { return dot(by[i], direction); };
        const double slope_u = along(3), slope_v = along(1), uu = along(6), uv = along(4), vv = along(2);
        const double determinant = uu * vv - uv * uv;
        const double du = (vv * slope_u - uv * slope_v) / determinant, dv = (uu * slope_v - uv * slope_u) / determinant;
        // Comparisons with NaN are false.
        if (!(std::abs(du) <= size_u && std::abs(dv) <= size_v)) return false;
        u = knots.clamped_u(u - du), v = knots.clamped_v(v - dv);
        if (std::abs(du) <= 1e-13 * size_u && std::abs(dv) <= 1e-13 * size_v) break;
    }
    return true;
}

/// The largest value of f between two parameters around its largest sample: golden-section search.
template <class F>
double largest(const F& f, double a, double b) {
    double c = std::lerp(b, a, golden), d = std::lerp(a, b, golden), at_c = f(c), at_d = f(d);
    for (int i = 0; i < golden_steps; ++i) {
        if (at_c < at_d) {
            a = c, c = d, at_c = at_d, d = std::lerp(a, b, golden), at_d = f(d);
        } else {
            b = d, d = c, at_d = at_c, c = std::lerp(b, a, golden), at_c = f(c);
        }
    }
    return std::max(at_c, at_d);
}

/// The border of a face, in pieces, with points along each.
class Border {
public:
    Border(const NurbsSurface& surface, const Knots& knots, std::span<const TrimLoop> loops) : surface_(surface), knots_(knots) {
        for (const TrimLoop& loop : loops) std::ranges::move(pieces_of(loop), std::back_inserter(pieces_));
        if (loops.empty()) add_sides();
        for (const LoopPiece& piece : pieces_) {
            Interruption::check();
            for (int i = 0; i <= border_samples; ++i) points_.push_back(point_at(piece, static_cast<double>(i) / border_samples));
        }
    }

    /// The highest point along a direction; any point at `bound`, if one is there.
    [[nodiscard]] double highest(const Vec3d& direction, double bound) const {
        std::vector<double> heights(points_.size());
        std::ranges::transform(points_, heights.begin(), [&](const Vec3d& point) { return dot(point, direction); });
        double best = heights.empty() ? -HUGE_VAL : *std::ranges::max_element(heights);
        constexpr std::ptrdiff_t samples = border_samples + 1;
        for (std::size_t k = 0; k < pieces_.size() && best < bound; ++k) {
            const auto first = heights.begin() + static_cast<std::ptrdiff_t>(k) * samples, last = first + samples - 1;
            const auto top = std::max_element(first, last + 1), before = std::max(top - 1, first), after = std::min(top + 1, last);
            // A smooth top exceeds the samples around it by less than they differ from the next.
            double difference = 0;
            for (auto own = std::max(top - 2, first); own < std::min(top + 2, last); ++own) difference = std::max(difference, std::abs(own[1] - own[0]));
            if (*top + difference <= best) continue;
            Interruption::check();
            const auto share = [&](auto sample) { return static_cast<double>(sample - first) / border_samples; };
            best = std::max(best, largest([&](double t) { return dot(point_at(pieces_[k], t), direction); }, share(before), share(after)));
        }
        return best;
    }

private:
    /// The sides of an untrimmed knots, one piece for each span, so that no extreme is between samples.
    void add_sides() {
        const auto &u = knots_.u, &v = knots_.v;
        for (const double at_v : {v.front(), v.back()}) {
            for (std::size_t i = 0; i + 1 < u.size(); ++i) pieces_.push_back({0, 1, {{u[i], at_v, 1}, {u[i + 1], at_v, 1}}});
        }
        for (const double at_u : {u.front(), u.back()}) {
            for (std::size_t i = 0; i + 1 < v.size(); ++i) pieces_.push_back({0, 1, {{at_u, v[i], 1}, {at_u, v[i + 1], 1}}});
        }
    }
    [[nodiscard]] Vec3d point_at(const LoopPiece& piece, double t) const {
        const At place = at(piece, t);
        return point(surface_, knots_, place.u, place.v);
    }

    const NurbsSurface& surface_;
    const Knots& knots_;
    std::vector<LoopPiece> pieces_;
    std::vector<Vec3d> points_;  // border_samples + 1 for each piece
};

/// Points of a face away from its border.
class Inside {
public:
    Inside(const NurbsSurface& surface, const Knots& knots, std::span<const TrimLoop> loops)
        : surface_(surface), knots_(knots), region_(loops, {knots.u.front(), knots.u.back(), knots.v.front(), knots.v.back()}),
          u_(between(knots.u)), v_(between(knots.v)) {
        for (const double at_u : u_) {
            Interruption::check();
            for (const double at_v : v_) points_.push_back(point(surface, knots, at_u, at_v));
        }
    }

    /// The highest point along a direction that is above `best`, or `best`.
    [[nodiscard]] double highest(const Vec3d& direction, double best) const {
        std::vector<double> heights(points_.size());
        std::ranges::transform(points_, heights.begin(), [&](const Vec3d& point) { return dot(point, direction); });
        const std::size_t rows = u_.size(), columns = v_.size();
        for (std::size_t i = 0; i < rows; ++i) {
            for (std::size_t j = 0; j < columns; ++j) {
                const double* const own = &heights[i * columns + j];
                const bool is_top = (i == 0 || own[-static_cast<std::ptrdiff_t>(columns)] <= *own) && (i + 1 == rows || own[columns] <= *own) &&
                                    (j == 0 || own[-1] <= *own) && (j + 1 == columns || own[1] <= *own);
                if (*own > best && region_.contains(u_[i], v_[j])) best = *own;
                double at_u = u_[i], at_v = v_[j];
                if (is_top && level(surface_, knots_, direction, at_u, at_v) && region_.contains(at_u, at_v)) {
                    best = std::max(best, dot(point(surface_, knots_, at_u, at_v), direction));
                }
            }
        }
        return best;
    }

private:
    static std::vector<double> between(const std::vector<double>& knots) {
        std::vector<double> result;
        for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
            for (int k = 0; k < inside_samples; ++k) result.push_back(std::lerp(knots[i], knots[i + 1], (k + 0.5) / inside_samples));
        }
        return result;
    }

    const NurbsSurface& surface_;
    const Knots& knots_;
    TrimRegion region_;
    std::vector<double> u_, v_;
    std::vector<Vec3d> points_;  // (u, v)
};

}  // namespace

std::vector<std::array<double, 2>> extremes(const NurbsSurface& surface, std::span<const TrimLoop> loops,
                                            std::span<const std::array<double, 3>> directions) {
    const Knots knots(surface);
    const Border border(surface, knots, loops);
    std::optional<Inside> inside;
    const auto highest = [&](const Vec3d& direction) {
        const double bound = bound_of_height(surface, direction), best = border.highest(direction, bound);
        if (best >= bound) return best;
        if (!inside) inside.emplace(surface, knots, loops);
        return inside->highest(direction, best);
    };
    std::vector<std::array<double, 2>> result;
    for (const Vec3d& direction : directions) result.push_back({-highest(-1.0 * direction), highest(direction)});
    return result;
}

}  // namespace bob
