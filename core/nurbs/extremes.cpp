#include "nurbs/extremes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/interruption.h"
#include "base/vec3d.h"
#include "nurbs/loop_pieces.h"

namespace bob {
namespace {

constexpr int border_samples = 16, inside_samples = 6;  // of a piece of a border, and of a span along either parameter
constexpr int golden_steps = 60, newton_steps = 16;
constexpr double golden = 1 / std::numbers::phi;

/// The height of a surface along a direction.
class Height {
public:
    Height(const NurbsSurface& surface, const Vec3d& direction) : surface_(surface), direction_(direction) {
        knots_u = distinct_knots(surface.degree_u, surface.knots_u), knots_v = distinct_knots(surface.degree_v, surface.knots_v);
    }

    std::vector<double> knots_u, knots_v;

    /// No point is higher than this, up to rounding: a surface of positive weights lies in the hull of its control points.
    [[nodiscard]] double bound() const {
        double highest = -HUGE_VAL, largest = 0;
        for (const auto& [x, y, z, w] : surface_.control_points) {
            if (!(w > 0)) return HUGE_VAL;
            const double height = dot({x / w, y / w, z / w});
            highest = std::max(highest, height), largest = std::max(largest, std::abs(height));
        }
        return highest - 1e-14 * largest;
    }

    [[nodiscard]] double clamped_u(double u) const { return std::clamp(u, knots_u.front(), knots_u.back()); }
    [[nodiscard]] double clamped_v(double v) const { return std::clamp(v, knots_v.front(), knots_v.back()); }
    [[nodiscard]] double at(double u, double v) const { return dot(surface_derivatives(surface_, clamped_u(u), clamped_v(v), 0)[0]); }

    /// Newton's method for a place without slope, from a place nearby. False if it leads elsewhere.
    bool level(double& u, double& v) const {
        const double size_u = knots_u.back() - knots_u.front(), size_v = knots_v.back() - knots_v.front();
        for (int step = 0; step < newton_steps; ++step) {
            const auto by = surface_derivatives(surface_, u, v, 2);
            const double slope_u = dot(by[3]), slope_v = dot(by[1]), uu = dot(by[6]), uv = dot(by[4]), vv = dot(by[2]);
            const double determinant = uu * vv - uv * uv;
            const double du = (vv * slope_u - uv * slope_v) / determinant, dv = (uu * slope_v - uv * slope_u) / determinant;
            // Comparisons with NaN are false.
            if (!(std::abs(du) <= size_u && std::abs(dv) <= size_v)) return false;
            u = clamped_u(u - du), v = clamped_v(v - dv);
            if (std::abs(du) <= 1e-13 * size_u && std::abs(dv) <= 1e-13 * size_v) break;
        }
        return true;
    }

private:
    [[nodiscard]] double dot(const Vec3d& x) const { return bob::dot(x, direction_); }

    const NurbsSurface& surface_;
    Vec3d direction_;
};

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

/// The highest point of a border's pieces; any point at `bound`, if one is there.
double highest_of_border(const Height& height, const std::vector<LoopPiece>& pieces, double bound) {
    double best = -HUGE_VAL;
    for (const LoopPiece& piece : pieces) {
        Interruption::check();
        const auto f = [&](double t) {
            const At point = at(piece, t);
            return height.at(point.u, point.v);
        };
        std::array<double, border_samples + 1> samples;
        for (int i = 0; i <= border_samples; ++i) samples[static_cast<std::size_t>(i)] = f(static_cast<double>(i) / border_samples);
        const auto top = std::ranges::max_element(samples);
        best = std::max(best, *top);
        if (best >= bound) return best;
        const auto i = static_cast<double>(top - samples.begin());
        best = std::max(best, largest(f, std::max(i - 1, 0.0) / border_samples, std::min(i + 1, static_cast<double>(border_samples)) / border_samples));
    }
    return best;
}

std::vector<double> inside(const std::vector<double>& knots) {
    std::vector<double> result;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        for (int k = 0; k < inside_samples; ++k) result.push_back(std::lerp(knots[i], knots[i + 1], (k + 0.5) / inside_samples));
    }
    return result;
}

/// The highest point away from the border that is above `best`, or `best`.
double highest_inside(const Height& height, const TrimRegion& region, double best) {
    const std::vector<double> u = inside(height.knots_u), v = inside(height.knots_v);
    std::vector<double> samples;
    for (const double at_u : u) {
        Interruption::check();
        for (const double at_v : v) samples.push_back(height.at(at_u, at_v));
    }
    for (std::size_t i = 0; i < u.size(); ++i) {
        for (std::size_t j = 0; j < v.size(); ++j) {
            const double own = samples[i * v.size() + j];
            const bool is_top = (i == 0 || samples[(i - 1) * v.size() + j] <= own) && (i + 1 == u.size() || samples[(i + 1) * v.size() + j] <= own) &&
                                (j == 0 || samples[i * v.size() + j - 1] <= own) && (j + 1 == v.size() || samples[i * v.size() + j + 1] <= own);
            if (own > best && region.contains(u[i], v[j])) best = own;
            double at_u = u[i], at_v = v[j];
            if (is_top && height.level(at_u, at_v) && region.contains(at_u, at_v)) best = std::max(best, height.at(at_u, at_v));
        }
    }
    return best;
}

}  // namespace

std::array<double, 2> extremes(const NurbsSurface& surface, std::span<const TrimLoop> loops, const std::array<double, 3>& direction) {
    const Height up(surface, direction), down(surface, -1.0 * direction);
    const auto &u = up.knots_u, &v = up.knots_v;
    std::vector<LoopPiece> pieces;
    for (const TrimLoop& loop : loops) std::ranges::move(pieces_of(loop), std::back_inserter(pieces));
    if (loops.empty()) {
        // One piece for each span, so that no extreme is between samples.
        for (const double at_v : {v.front(), v.back()}) {
            for (std::size_t i = 0; i + 1 < u.size(); ++i) pieces.push_back({0, 1, {{u[i], at_v, 1}, {u[i + 1], at_v, 1}}});
        }
        for (const double at_u : {u.front(), u.back()}) {
            for (std::size_t i = 0; i + 1 < v.size(); ++i) pieces.push_back({0, 1, {{at_u, v[i], 1}, {at_u, v[i + 1], 1}}});
        }
    }
    const TrimRegion region(loops, {u.front(), u.back(), v.front(), v.back()});
    const auto highest = [&](const Height& height) {
        const double bound = height.bound(), best = highest_of_border(height, pieces, bound);
        return best < bound ? highest_inside(height, region, best) : best;
    };
    return {-highest(down), highest(up)};
}

}  // namespace bob
