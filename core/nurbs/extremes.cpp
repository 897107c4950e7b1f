#include "nurbs/extremes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/interruption.h"
#include "nurbs/loop_pieces.h"

namespace bob {
namespace {

constexpr int border_samples = 16, inside_samples = 6;  // of a piece of a border, and of a span along either parameter
constexpr int halvings = 60, newton_steps = 16;

/// The height of a surface along a direction.
class Height {
public:
    Height(const NurbsSurface& surface, const std::array<double, 3>& direction) : surface_(surface), direction_(direction) {
        knots_u = distinct_knots(surface.degree_u, surface.knots_u), knots_v = distinct_knots(surface.degree_v, surface.knots_v);
    }

    std::vector<double> knots_u, knots_v;

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
    [[nodiscard]] double dot(const std::array<double, 3>& x) const { return x[0] * direction_[0] + x[1] * direction_[1] + x[2] * direction_[2]; }

    const NurbsSurface& surface_;
    std::array<double, 3> direction_;
};

/// The largest value of f between two parameters around its largest sample, by thirds.
template <class F>
double largest(const F& f, double a, double b) {
    for (int i = 0; i < halvings; ++i) {
        const double c = std::lerp(a, b, 0.382), d = std::lerp(a, b, 0.618);
        (f(c) < f(d) ? a : b) = f(c) < f(d) ? c : d;
    }
    return f((a + b) / 2);
}

/// The highest point of a border's pieces.
double highest_of_border(const Height& height, const std::vector<Piece>& pieces) {
    double best = -HUGE_VAL;
    for (const Piece& piece : pieces) {
        Interruption::check();
        const auto f = [&](double t) {
            const At point = at(piece, t);
            return height.at(point.u, point.v);
        };
        std::array<double, border_samples + 1> samples;
        for (int i = 0; i <= border_samples; ++i) samples[static_cast<std::size_t>(i)] = f(static_cast<double>(i) / border_samples);
        const auto top = std::ranges::max_element(samples);
        best = std::max(best, *top);
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
    std::array<double, 2> result;
    for (const double sign : {-1.0, 1.0}) {
        const Height height(surface, {sign * direction[0], sign * direction[1], sign * direction[2]});
        const double low_u = height.knots_u.front(), high_u = height.knots_u.back(), low_v = height.knots_v.front(), high_v = height.knots_v.back();
        std::vector<Piece> pieces;
        for (const TrimLoop& loop : loops) std::ranges::move(pieces_of(loop), std::back_inserter(pieces));
        if (loops.empty()) {
            // Of each span, so that no extreme is between samples.
            for (const double v : {low_v, high_v}) {
                for (std::size_t i = 0; i + 1 < height.knots_u.size(); ++i) pieces.push_back({0, 1, {{height.knots_u[i], v, 1}, {height.knots_u[i + 1], v, 1}}});
            }
            for (const double u : {low_u, high_u}) {
                for (std::size_t i = 0; i + 1 < height.knots_v.size(); ++i) pieces.push_back({0, 1, {{u, height.knots_v[i], 1}, {u, height.knots_v[i + 1], 1}}});
            }
        }
        const TrimRegion region(loops, {low_u, high_u, low_v, high_v});
        result[sign > 0] = sign * highest_inside(height, region, highest_of_border(height, pieces));
    }
    return result;
}

}  // namespace bob
