#include "nurbs/nurbs.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bob {
namespace {

/// Interpolates from a to b. Exactly a if t is 0 or both are equal, exactly b if t is 1.
template <std::size_t D>
std::array<double, D> mix(const std::array<double, D>& a, const std::array<double, D>& b, double t) {
    std::array<double, D> result;
    for (std::size_t i = 0; i < D; ++i) {
        result[i] = t < 0.5 ? a[i] + t * (b[i] - a[i]) : b[i] - (1 - t) * (b[i] - a[i]);
    }
    return result;
}

template <std::size_t D>
void add(std::array<double, D>& sum, double factor, const std::array<double, D>& point) {
    for (std::size_t i = 0; i < D; ++i) sum[i] += factor * point[i];
}

/// Whether two points are equal up to rounding.
template <std::size_t D>
bool nearly_equal(const std::array<double, D>& a, const std::array<double, D>& b) {
    double size = 0, distance = 0;
    for (std::size_t i = 0; i < D; ++i) {
        size = std::max(size, std::fabs(a[i]));
        distance = std::max(distance, std::fabs(b[i] - a[i]));
    }
    return distance <= 1e-12 * size;
}

/// The nonempty spans of the domain.
std::vector<std::size_t> bezier_spans(int degree, std::span<const double> knots) {
    const auto p = static_cast<std::size_t>(degree);
    std::vector<std::size_t> spans;
    for (std::size_t k = p; k + p + 1 < knots.size(); ++k) {
        if (knots[k] < knots[k + 1]) spans.push_back(k);
    }
    return spans;
}

/// The Bezier control points of the pieces on these spans, degree + 1 for each. In terms of the blossom f of span k
/// from a to b, control point i is f(knots[k - p + 1 + i], .., knots[k + i]), and becomes f(a, .., b, ..), with i times
/// b.
template <class Point>
std::vector<Point> bezier_points(int degree, std::span<const double> knots, std::span<const std::size_t> spans,
                                 std::span<const Point> control_points) {
    const auto p = static_cast<std::size_t>(degree);
    std::vector<Point> result;
    result.reserve(spans.size() * (p + 1));
    for (std::size_t s = 0; s < spans.size(); ++s) {
        const std::size_t k = spans[s];
        const double a = knots[k], b = knots[k + 1];
        result.insert(result.end(), control_points.begin() + static_cast<std::ptrdiff_t>(k - p),
                      control_points.begin() + static_cast<std::ptrdiff_t>(k + 1));
        Point* piece = &result[s * (p + 1)];
        for (std::size_t inserted = 1; inserted < p; ++inserted) {  // a replaces the knots before it
            for (std::size_t i = 0; i + inserted < p; ++i) {
                const double low = knots[k - p + i + inserted], high = knots[k + i + 1];
                piece[i] = mix(piece[i], piece[i + 1], (a - low) / (high - low));
            }
        }
        for (std::size_t inserted = 1; inserted < p; ++inserted) {  // b replaces the knots after it
            for (std::size_t i = p; i > inserted; --i) {
                piece[i] = mix(piece[i - 1], piece[i], (b - a) / (knots[k + i - inserted + 1] - a));
            }
        }
        // Pieces joined by a knot of multiplicity up to p round differently: share the end.
        if (s > 0 && k - spans[s - 1] <= p) piece[0] = piece[-1];
    }
    // Also for closed curves with unclamped knots.
    if (!result.empty() && nearly_equal(result.front(), result.back())) result.back() = result.front();
    return result;
}

/// The control points of the part from a to b of a Bezier curve, `step` apart, by blossoms. Each end depends on its own
/// parameter alone, so adjacent parts share their ends to the bit.
template <class Point>
void part_points(std::span<const Point> control_points, double a, double b, Point* result, std::size_t step = 1) {
    std::array<Point, max_degree + 1> at_a, at_b;
    for (std::size_t i = 0; i < control_points.size(); ++i) at_a[i] = control_points[i];
    for (std::size_t j = control_points.size(); j-- > 0;) {  // at_a[0..j] has one more a, and j times b remain
        for (std::size_t i = 0; i <= j; ++i) at_b[i] = at_a[i];
        for (std::size_t count = j; count > 0; --count) {
            for (std::size_t i = 0; i < count; ++i) at_b[i] = mix(at_b[i], at_b[i + 1], b);
        }
        result[j * step] = at_b[0];
        for (std::size_t i = 0; i < j; ++i) at_a[i] = mix(at_a[i], at_a[i + 1], a);
    }
}

/// Maps each row of a grid, `size` points, and transposes the grid. Applied twice, it maps the rows, then the columns.
template <class Map>
std::vector<Homogeneous<3>> map_rows_and_turn(std::span<const Homogeneous<3>> grid, std::size_t size, Map map) {
    const std::size_t rows = grid.size() / size;
    std::vector<Homogeneous<3>> result;
    for (std::size_t row = 0; row < rows; ++row) {
        const std::vector<Homogeneous<3>> mapped = map(grid.subspan(row * size, size));
        result.resize(rows * mapped.size());
        for (std::size_t i = 0; i < mapped.size(); ++i) result[i * rows + row] = mapped[i];
    }
    return result;
}

}  // namespace

std::size_t find_span(int degree, std::span<const double> knots, double u) {
    const auto first = knots.begin() + degree, last = knots.end() - degree - 1;
    const auto above = u < *last ? std::upper_bound(first, last, std::max(u, *first))
                                 : std::lower_bound(first, last, *last);
    return static_cast<std::size_t>(above - knots.begin()) - 1;
}

BasisDerivatives basis_derivatives(std::size_t span, double u, int degree, std::span<const double> knots, int order) {
    const auto p = static_cast<std::size_t>(degree);
    std::array<double, max_degree + 1> left, right;
    double ndu[max_degree + 1][max_degree + 1];  // [r][j], r <= j: N_r of degree j; [j][r], r < j: differences of knots
    ndu[0][0] = 1;
    for (std::size_t j = 1; j <= p; ++j) {
        left[j] = u - knots[span + 1 - j];
        right[j] = knots[span + j] - u;
        double saved = 0;
        for (std::size_t r = 0; r < j; ++r) {
            ndu[j][r] = knots[span + r + 1] - knots[span + 1 + r - j];
            // Fractions of the span first: they are at most 1, however close the knots.
            ndu[r][j] = saved + right[r + 1] / ndu[j][r] * ndu[r][j - 1];
            saved = left[j - r] / ndu[j][r] * ndu[r][j - 1];
        }
        ndu[j][j] = saved;
    }

    BasisDerivatives result{};
    for (std::size_t j = 0; j <= p; ++j) result[0][j] = ndu[j][p];
    for (std::size_t k = 1; k <= static_cast<std::size_t>(std::min(order, degree)); ++k) {
        auto& row = result[k];
        for (std::size_t j = 0; j <= p - k; ++j) row[j] = ndu[j][p - k];
        for (std::size_t d = p - k + 1; d <= p; ++d) {  // one derivative and one degree at a time: equation 2.7
            double saved = 0;
            for (std::size_t j = 0; j < d; ++j) {
                const double slope = static_cast<double>(d) * row[j] / ndu[d][j];
                row[j] = saved - slope;
                saved = slope;
            }
            row[d] = saved;
        }
    }
    return result;
}

std::vector<std::array<double, 3>> surface_derivatives(const NurbsSurface& surface, double u, double v, int order) {
    const std::size_t span_u = find_span(surface.degree_u, surface.knots_u, u);
    const std::size_t span_v = find_span(surface.degree_v, surface.knots_v, v);
    const BasisDerivatives basis_u = basis_derivatives(span_u, u, surface.degree_u, surface.knots_u, order);
    const BasisDerivatives basis_v = basis_derivatives(span_v, v, surface.degree_v, surface.knots_v, order);
    const auto p = static_cast<std::size_t>(surface.degree_u), q = static_cast<std::size_t>(surface.degree_v);
    const std::size_t n = static_cast<std::size_t>(order) + 1;

    // A3.6: the derivatives of the homogeneous surface; zero above its degrees.
    std::vector<Homogeneous<3>> homogeneous(n * n);
    for (std::size_t l = 0; l < n && l <= q; ++l) {
        std::array<Homogeneous<3>, max_degree + 1> column{};
        for (std::size_t i = 0; i <= p; ++i) {
            const Homogeneous<3>* row = &surface.control_points[(span_u - p + i) * surface.size_v() + span_v - q];
            for (std::size_t j = 0; j <= q; ++j) add(column[i], basis_v[l][j], row[j]);
        }
        for (std::size_t k = 0; k + l < n && k <= p; ++k) {
            for (std::size_t i = 0; i <= p; ++i) add(homogeneous[k * n + l], basis_u[k][i], column[i]);
        }
    }

    // A4.4: Leibniz' rule for the product of the weight and S.
    std::vector<double> binomial(n * n);
    for (std::size_t k = 0; k < n; ++k) {
        binomial[k * n] = 1;
        for (std::size_t i = 1; i <= k; ++i) {
            binomial[k * n + i] = binomial[(k - 1) * n + i] + binomial[(k - 1) * n + i - 1];
        }
    }
    std::vector<std::array<double, 3>> result(n * n);
    for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t l = 0; k + l < n; ++l) {
            const auto& [x, y, z, w] = homogeneous[k * n + l];
            std::array<double, 3> sum = {x, y, z};
            for (std::size_t i = 0; i <= k; ++i) {
                for (std::size_t j = i == 0; j <= l; ++j) {
                    const double weight = homogeneous[i * n + j][3];
                    add(sum, -binomial[k * n + i] * binomial[l * n + j] * weight, result[(k - i) * n + l - j]);
                }
            }
            for (std::size_t i = 0; i < 3; ++i) result[k * n + l][i] = sum[i] / homogeneous[0][3];
        }
    }
    return result;
}

template <std::size_t N>
std::array<double, N> curve_point(const NurbsCurve<N>& curve, double u) {
    const std::size_t span = find_span(curve.degree, curve.knots, u);
    const BasisDerivatives basis = basis_derivatives(span, u, curve.degree, curve.knots, 0);
    const auto p = static_cast<std::size_t>(curve.degree);
    Homogeneous<N> sum{};
    for (std::size_t j = 0; j <= p; ++j) add(sum, basis[0][j], curve.control_points[span - p + j]);
    std::array<double, N> point;
    for (std::size_t i = 0; i < N; ++i) point[i] = sum[i] / sum[N];
    return point;
}

template <std::size_t N>
std::vector<BezierCurve<N>> decompose(const NurbsCurve<N>& curve) {
    const std::vector<std::size_t> spans = bezier_spans(curve.degree, curve.knots);
    const auto points = bezier_points(curve.degree, curve.knots, spans, std::span(curve.control_points));
    const std::ptrdiff_t size = curve.degree + 1;
    std::vector<BezierCurve<N>> pieces;
    for (auto begin = points.begin(); const std::size_t k : spans) {
        pieces.push_back({curve.knots[k], curve.knots[k + 1], {begin, begin + size}});
        begin += size;
    }
    return pieces;
}

std::vector<BezierPatch> decompose(const NurbsSurface& surface) {
    const std::vector<std::size_t> spans_u = bezier_spans(surface.degree_u, surface.knots_u);
    const std::vector<std::size_t> spans_v = bezier_spans(surface.degree_v, surface.knots_v);
    using Points = std::span<const Homogeneous<3>>;
    const auto rows = map_rows_and_turn(surface.control_points, surface.size_v(), [&](Points row) {
        return bezier_points(surface.degree_v, surface.knots_v, spans_v, row);
    });
    const auto grid = map_rows_and_turn(rows, surface.size_u(), [&](Points column) {
        return bezier_points(surface.degree_u, surface.knots_u, spans_u, column);
    });
    const auto size_u = static_cast<std::size_t>(surface.degree_u) + 1;
    const auto size_v = static_cast<std::size_t>(surface.degree_v) + 1;
    std::vector<BezierPatch> patches;
    for (std::size_t s = 0; s < spans_u.size(); ++s) {
        for (std::size_t t = 0; t < spans_v.size(); ++t) {
            const double* u = &surface.knots_u[spans_u[s]];
            const double* v = &surface.knots_v[spans_v[t]];
            BezierPatch patch{u[0], u[1], v[0], v[1], surface.degree_u, surface.degree_v, {}};
            for (std::size_t i = 0; i < size_u; ++i) {
                const auto begin = grid.begin() + ((s * size_u + i) * spans_v.size() + t) * size_v;
                patch.control_points.insert(patch.control_points.end(), begin, begin + size_v);
            }
            patches.push_back(std::move(patch));
        }
    }
    return patches;
}

template <std::size_t N>
BezierCurve<N> part(const BezierCurve<N>& curve, double a, double b) {
    BezierCurve<N> result{std::lerp(curve.low, curve.high, a), std::lerp(curve.low, curve.high, b), curve.control_points};
    part_points(std::span(curve.control_points), a, b, result.control_points.data());
    return result;
}

BezierPatch part(const BezierPatch& patch, double a_u, double b_u, double a_v, double b_v) {
    const auto size_u = static_cast<std::size_t>(patch.degree_u) + 1;
    const auto size_v = static_cast<std::size_t>(patch.degree_v) + 1;
    std::array<Homogeneous<3>, (max_degree + 1) * (max_degree + 1)> columns;  // of the rows' parts
    const std::span<const Homogeneous<3>> points = patch.control_points;
    for (std::size_t i = 0; i < size_u; ++i) part_points(points.subspan(i * size_v, size_v), a_v, b_v, &columns[i], size_u);
    BezierPatch result{std::lerp(patch.low_u, patch.high_u, a_u), std::lerp(patch.low_u, patch.high_u, b_u),
                       std::lerp(patch.low_v, patch.high_v, a_v), std::lerp(patch.low_v, patch.high_v, b_v),
                       patch.degree_u, patch.degree_v, patch.control_points};
    for (std::size_t j = 0; j < size_v; ++j) {
        const auto column = std::span<const Homogeneous<3>>(columns).subspan(j * size_u, size_u);
        part_points(column, a_u, b_u, &result.control_points[j], size_v);
    }
    return result;
}

template std::array<double, 2> curve_point(const NurbsCurve<2>&, double);
template std::array<double, 4> curve_point(const NurbsCurve<4>&, double);
template std::vector<BezierCurve<2>> decompose(const NurbsCurve<2>&);
template std::vector<BezierCurve<4>> decompose(const NurbsCurve<4>&);
template BezierCurve<2> part(const BezierCurve<2>&, double, double);
template BezierCurve<4> part(const BezierCurve<4>&, double, double);

}  // namespace bob
