#include "nurbs/moments.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/interruption.h"
#include "base/vec3d.h"
#include "nurbs/loop_pieces.h"

namespace bob {
namespace {

/// Area, normal and position, in this sequence; or the integrands of these.
constexpr std::size_t width = 13;
using Values = std::array<double, width>;

void add(Values& sum, double factor, const Values& values) {
    for (std::size_t i = 0; i < width; ++i) sum[i] += factor * values[i];
}

/// Kronrod's 15 nodes in -1..1 from the middle outward, with their weights, and the weights of Gauss' 7 nodes among them.
constexpr double nodes[] = {0.0, 0.207784955007898467600689403773245, 0.405845151377397166906606412076961,
                            0.586087235467691130294144691693012, 0.741531185599394439863864773280788,
                            0.864864423359769072789712788640926, 0.949107912342758524526189684047851,
                            0.991455371120812639206854697526329};
constexpr double kronrod[] = {0.209482141084727828012999174891714, 0.204432940075298892414161999234649,
                              0.190350578064785409913256402421014, 0.169004726639267902826583426598550,
                              0.140653259715525918745189590510238, 0.104790010322250183839876322541518,
                              0.063092092629978553290700663189204, 0.022935322010529224963732008058970};
constexpr double gauss[] = {0.417959183673469387755102040816327, 0, 0.381830050505118944950369775488975, 0,
                            0.279705391489276667901467771423780, 0, 0.129484966168869693270611432679082, 0};

/// The integral of f over a..b, halved until the rules differ by less than the tolerance, or up to `depth` times.
template <class F>
void integrate(const F& f, double a, double b, double tolerance, int depth, Values& sum) {
    const double middle = (a + b) / 2, half = (b - a) / 2;
    Values fine{}, coarse{};
    const auto take = [&](double t, std::size_t k) {
        const Values values = f(t);
        add(fine, kronrod[k], values);
        if (gauss[k] != 0) add(coarse, gauss[k], values);
    };
    take(middle, 0);
    for (std::size_t k = 1; k < std::size(nodes); ++k) take(middle - half * nodes[k], k), take(middle + half * nodes[k], k);
    double error = 0;
    for (std::size_t i = 0; i < width; ++i) error = std::max(error, std::abs(half * (fine[i] - coarse[i])));
    // Comparisons are arranged so that NaN ends the halving.
    if (error > tolerance && depth > 0 && a < middle && middle < b) {
        integrate(f, a, middle, tolerance / 2, depth - 1, sum);
        integrate(f, middle, b, tolerance / 2, depth - 1, sum);
    } else {
        add(sum, half, fine);
    }
}

constexpr double inner_tolerance = 1e-10, outer_tolerance = 1e-9;  // in squares of the face's size
constexpr int inner_depth = 10, outer_depth = 16;

/// A surface in units of its size, and its integrals along u.
class Lines {
public:
    explicit Lines(const NurbsSurface& surface) : surface_(surface) {
        Vec3d low = euclidean(surface.control_points.front()), high = low;
        for (const auto& point : surface.control_points) {
            const auto at = euclidean(point);
            for (std::size_t i = 0; i < 3; ++i) low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
        }
        double size = 0;
        for (std::size_t i = 0; i < 3; ++i) size = std::max(size, high[i] - low[i]), center_[i] = (low[i] + high[i]) / 2;
        size_ = size > 0 ? size : 1;
        for (auto& point : surface_.control_points) {
            for (std::size_t i = 0; i < 3; ++i) point[i] = (point[i] - center_[i] * point[3]) / size_;
        }
        knots_u = distinct_knots(surface.degree_u, surface.knots_u), knots_v = distinct_knots(surface.degree_v, surface.knots_v);
        columns_.resize(2 * surface.size_u());
    }

    std::vector<double> knots_u, knots_v;  // distinct, of the domain

    /// The integral from the start of the domain to u, at v. Both are taken into the domain.
    [[nodiscard]] Values integral(double u, double v) {
        v = std::clamp(v, knots_v.front(), knots_v.back());
        u = std::clamp(u, knots_u.front(), knots_u.back());
        const auto q = static_cast<std::size_t>(surface_.degree_v);
        const std::size_t span = find_span(surface_.degree_v, surface_.knots_v, v), n = surface_.size_u();
        const BasisDerivatives basis = basis_derivatives(span, v, surface_.degree_v, surface_.knots_v, 1);
        std::ranges::fill(columns_, Homogeneous<3>{});
        for (std::size_t i = 0; i < n; ++i) {
            const Homogeneous<3>* row = &surface_.control_points[i * surface_.size_v() + span - q];
            for (std::size_t j = 0; j <= q; ++j) {
                for (std::size_t k = 0; k < 4; ++k) columns_[i][k] += basis[0][j] * row[j][k], columns_[n + i][k] += basis[1][j] * row[j][k];
            }
        }
        Values sum{};
        for (std::size_t i = 0; i + 1 < knots_u.size() && knots_u[i] < u; ++i) {
            const double end = std::min(u, knots_u[i + 1]);
            const std::size_t own = find_span(surface_.degree_u, surface_.knots_u, knots_u[i]);
            integrate([&](double at) { return integrand(own, at); }, knots_u[i], end, inner_tolerance, inner_depth, sum);
        }
        return sum;
    }

    [[nodiscard]] Moments moments(const Values& sum) const {
        const double square = size_ * size_;
        Moments result;
        result.area = square * sum[0];
        for (std::size_t i = 0; i < 3; ++i) result.normal[i] = square * sum[1 + i];
        for (std::size_t i = 0; i < 9; ++i) result.position[i] = square * (size_ * sum[4 + i] + center_[i / 3] * sum[1 + i % 3]);
        return result;
    }

private:
    static Vec3d euclidean(const Homogeneous<3>& point) { return {point[0] / point[3], point[1] / point[3], point[2] / point[3]}; }

    [[nodiscard]] Values integrand(std::size_t span, double u) const {
        const auto p = static_cast<std::size_t>(surface_.degree_u);
        const BasisDerivatives basis = basis_derivatives(span, u, surface_.degree_u, surface_.knots_u, 1);
        Homogeneous<3> s{}, by_u{}, by_v{};
        for (std::size_t i = 0; i <= p; ++i) {
            const Homogeneous<3>&at = columns_[span - p + i], &across = columns_[surface_.size_u() + span - p + i];
            for (std::size_t k = 0; k < 4; ++k) {
                s[k] += basis[0][i] * at[k], by_u[k] += basis[1][i] * at[k], by_v[k] += basis[0][i] * across[k];
            }
        }
        Vec3d x, du, dv;
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = s[k] / s[3];
            du[k] = (by_u[k] - by_u[3] * x[k]) / s[3], dv[k] = (by_v[k] - by_v[3] * x[k]) / s[3];
        }
        const Vec3d normal = cross(du, dv);
        Values values;
        values[0] = length(normal);
        for (std::size_t i = 0; i < 3; ++i) {
            values[1 + i] = normal[i];
            for (std::size_t j = 0; j < 3; ++j) values[4 + 3 * i + j] = x[i] * normal[j];
        }
        return values;
    }

    NurbsSurface surface_;
    Vec3d center_{};
    double size_ = 1;
    std::vector<Homogeneous<3>> columns_;  // of the curve at v, then its derivative by v
};

constexpr int looked = 16;  // points of a piece, between which it crosses a knot at most once, and of a polygon

/// The parameters where a piece crosses knots, and its ends.
std::vector<double> breaks_of(const LoopPiece& piece, const Lines& lines) {
    std::vector<double> result{0, 1};
    std::array<At, looked + 1> points;
    for (int i = 0; i <= looked; ++i) points[static_cast<std::size_t>(i)] = at(piece, static_cast<double>(i) / looked);
    const auto cross = [&](const std::vector<double>& knots, double At::*axis) {
        for (std::size_t i = 0; i < looked; ++i) {
            const auto [low, high] = std::minmax(points[i].*axis, points[i + 1].*axis);
            for (auto knot = std::ranges::upper_bound(knots, low); knot != knots.end() && *knot < high; ++knot) {
                double a = static_cast<double>(i) / looked, b = static_cast<double>(i + 1) / looked;
                const bool rises = points[i].*axis < *knot;
                for (double middle = (a + b) / 2; a < middle && middle < b; middle = (a + b) / 2) {
                    ((at(piece, middle).*axis < *knot) == rises ? a : b) = middle;
                }
                result.push_back(b);
            }
        }
    };
    cross(lines.knots_u, &At::u), cross(lines.knots_v, &At::v);
    std::ranges::sort(result);
    return result;
}

using Polygon = std::vector<std::array<double, 2>>;

Polygon polygon_of(const std::vector<LoopPiece>& pieces) {
    Polygon result;
    for (const LoopPiece& piece : pieces) {
        const int count = piece.degree() == 1 ? 1 : looked;
        for (int i = 0; i < count; ++i) {
            const At point = at(piece, static_cast<double>(i) / count);
            result.push_back({point.u, point.v});
        }
    }
    return result;
}

double area_of(const Polygon& polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()], &o = polygon[0];
        sum += ((a[0] - o[0]) * (b[1] - o[1]) - (b[0] - o[0]) * (a[1] - o[1])) / 2;
    }
    return sum;
}

bool surrounds(const Polygon& polygon, const std::array<double, 2>& point) {
    bool inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        if ((a[1] <= point[1]) != (b[1] <= point[1])) {
            inside ^= point[0] < a[0] + (point[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
        }
    }
    return inside;
}

struct Rectangle {
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};

    [[nodiscard]] bool overlaps(const Rectangle& other) const {
        return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1];
    }
};

Rectangle around(const Polygon& polygon) {
    Rectangle result;
    for (const auto& point : polygon) {
        for (int i : {0, 1}) result.low[i] = std::min(result.low[i], point[static_cast<std::size_t>(i)]), result.high[i] = std::max(result.high[i], point[static_cast<std::size_t>(i)]);
    }
    return result;
}

/// 1 for each loop that runs so that the inside is on its left, else -1. Loops may touch, so the majority of a loop's points decides.
std::vector<int> signs_of(const std::vector<Polygon>& polygons) {
    std::vector<int> result;
    std::vector<Rectangle> boxes;
    std::ranges::transform(polygons, std::back_inserter(boxes), around);
    for (std::size_t i = 0; i < polygons.size(); ++i) {
        Interruption::check();
        std::size_t depth = 0;
        for (std::size_t j = 0; j < polygons.size(); ++j) {
            if (i == j || !boxes[i].overlaps(boxes[j])) continue;
            const auto inside = std::ranges::count_if(polygons[i], [&](const auto& point) { return surrounds(polygons[j], point); });
            depth += 2 * static_cast<std::size_t>(inside) > polygons[i].size();
        }
        result.push_back((area_of(polygons[i]) > 0) == (depth % 2 == 0) ? 1 : -1);
    }
    return result;
}

/// The middle of the longest line along u within the loops, of some lines. Without loops, near the middle of the domain.
std::array<double, 2> inside_of(const std::vector<Polygon>& polygons, const Lines& lines) {
    constexpr int count = 31;
    const double low_u = lines.knots_u.front(), high_u = lines.knots_u.back(), low_v = lines.knots_v.front(), high_v = lines.knots_v.back();
    std::array<double, 2> best{std::lerp(low_u, high_u, 0.49), std::lerp(low_v, high_v, 0.48)};
    double longest = 0, bottom = high_v, top = low_v;
    for (const Polygon& polygon : polygons) {
        for (const auto& point : polygon) bottom = std::min(bottom, point[1]), top = std::max(top, point[1]);
    }
    bottom = std::max(bottom, low_v), top = std::min(top, high_v);
    for (int i = 0; i < count && !polygons.empty(); ++i) {
        const double v = std::lerp(bottom, top, (i + 0.5) / count);
        std::vector<double> crossings;
        for (const Polygon& polygon : polygons) {
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                const auto &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
                if ((a[1] <= v) != (b[1] <= v)) crossings.push_back(std::clamp(a[0] + (v - a[1]) * (b[0] - a[0]) / (b[1] - a[1]), low_u, high_u));
            }
        }
        std::ranges::sort(crossings);
        for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
            const double length = crossings[k + 1] - crossings[k];
            if (length > longest) longest = length, best = {std::lerp(crossings[k], crossings[k + 1], 0.49), v};
        }
    }
    return best;
}

}  // namespace

Moments moments(const NurbsSurface& surface, std::span<const TrimLoop> loops) {
    Lines lines(surface);
    Values sum{};
    if (loops.empty()) {
        for (std::size_t i = 0; i + 1 < lines.knots_v.size(); ++i) {
            Interruption::check();
            integrate([&](double v) { return lines.integral(lines.knots_u.back(), v); }, lines.knots_v[i], lines.knots_v[i + 1],
                      outer_tolerance, outer_depth, sum);
        }
        Moments result = lines.moments(sum);
        result.inside = inside_of({}, lines);
        return result;
    }
    std::vector<std::vector<LoopPiece>> pieces;
    std::vector<Polygon> polygons;
    for (const TrimLoop& loop : loops) polygons.push_back(polygon_of(pieces.emplace_back(pieces_of(loop))));
    const std::vector<int> signs = signs_of(polygons);
    const double low = lines.knots_v.front(), high = lines.knots_v.back();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        for (const LoopPiece& piece : pieces[i]) {
            Interruption::check();
            const std::vector<double> breaks = breaks_of(piece, lines);
            const auto along = [&](double t) {
                const At point = at(piece, t);
                Values values{};
                if (point.dv != 0 && low <= point.v && point.v <= high) add(values, signs[i] * point.dv, lines.integral(point.u, point.v));
                return values;
            };
            for (std::size_t k = 0; k + 1 < breaks.size(); ++k) integrate(along, breaks[k], breaks[k + 1], outer_tolerance, outer_depth, sum);
        }
    }
    Moments result = lines.moments(sum);
    result.inside = inside_of(polygons, lines);
    return result;
}

}  // namespace bob
