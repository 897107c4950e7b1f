/// NURBS curves and surfaces in double precision. Names, symbols and algorithm numbers are from Piegl and Tiller, *The
/// NURBS Book* (second edition, 1997).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace bob {

constexpr int max_degree = 9;

/// A point of N dimensions in homogeneous coordinates: (w x1, .., w xN, w).
template <std::size_t N>
using Homogeneous = std::array<double, N + 1>;

/// Converts points (x1, .., xN, w) to (w x1, .., w xN, w), translated and scaled. The largest weight becomes 1, which
/// keeps products in range without changing the curve.
template <std::size_t N>
void make_homogeneous(std::span<Homogeneous<N>> points, const double* center = nullptr, double size = 1) {
    double largest = 0;
    for (const auto& p : points) largest = std::max(largest, p[N]);
    for (auto& p : points) {
        p[N] /= largest;
        for (std::size_t axis = 0; axis < N; ++axis) p[axis] = (p[axis] - (center ? center[axis] : 0)) / size * p[N];
    }
}

/// Degree p, n + 1 control points, n + p + 2 nondecreasing knots. The curve is defined from knots[p] to knots[n + 1];
/// the knots before and after need not be repeated ("unclamped", as for periodic curves).
template <std::size_t N>
struct NurbsCurve {
    int degree = 0;
    std::vector<double> knots;
    std::vector<Homogeneous<N>> control_points;
};

struct NurbsSurface {
    int degree_u = 0, degree_v = 0;
    std::vector<double> knots_u, knots_v;
    std::vector<Homogeneous<3>> control_points;  // v fastest

    [[nodiscard]] std::size_t size_u() const { return knots_u.size() - static_cast<std::size_t>(degree_u) - 1; }
    [[nodiscard]] std::size_t size_v() const { return knots_v.size() - static_cast<std::size_t>(degree_v) - 1; }
};

/// A polynomial piece in Bernstein form, for the parameters low..high of its curve.
template <std::size_t N>
struct BezierCurve {
    double low = 0, high = 1;
    std::vector<Homogeneous<N>> control_points;  // degree + 1

    [[nodiscard]] int degree() const { return static_cast<int>(control_points.size()) - 1; }
};

struct BezierPatch {
    double low_u = 0, high_u = 1, low_v = 0, high_v = 1;
    int degree_u = 0, degree_v = 0;
    std::vector<Homogeneous<3>> control_points;  // (degree_u + 1)(degree_v + 1), v fastest
};

/// A2.1: the span i with knots[i] <= u < knots[i + 1]. Outside the domain, the first or last nonempty one. The domain
/// must not be empty.
[[nodiscard]] std::size_t find_span(int degree, std::span<const double> knots, double u);

/// A2.2 and equation 2.7: the derivatives 0..order of the degree + 1 basis functions that are nonzero on the span. The
/// value result[k][j] is the k-th derivative of N_{span - degree + j, degree} at u; zero for k above the degree.
using BasisDerivatives = std::array<std::array<double, max_degree + 1>, max_degree + 1>;
[[nodiscard]] BasisDerivatives basis_derivatives(std::size_t span, double u, int degree, std::span<const double> knots,
                                                 int order);

/// A4.4: the partial derivatives of S at (u, v). The value result[k * (order + 1) + l] is d^(k+l) S / du^k dv^l; zero
/// for k + l > order.
[[nodiscard]] std::vector<std::array<double, 3>> surface_derivatives(const NurbsSurface& surface, double u, double v,
                                                                     int order);

/// A4.1: the point at u.
template <std::size_t N>
[[nodiscard]] std::array<double, N> curve_point(const NurbsCurve<N>& curve, double u);

/// The Bezier pieces between distinct neighbouring knots, in the order of their parameters (v fastest for surfaces), by
/// knot insertion (A5.1 on each span). Common points are equal to the bit: ends and edges at knots of multiplicity up
/// to the degree, and where a curve or surface closes.
template <std::size_t N>
[[nodiscard]] std::vector<BezierCurve<N>> decompose(const NurbsCurve<N>& curve);
[[nodiscard]] std::vector<BezierPatch> decompose(const NurbsSurface& surface);

/// The part from a to b of a Bezier curve, as parameters in 0..1 or slightly outside. Each end depends on its own
/// parameter alone: adjacent parts share it to the bit, and 0 and 1 keep the curve's.
template <std::size_t N>
[[nodiscard]] BezierCurve<N> part(const BezierCurve<N>& curve, double a, double b);

/// The part from (a_u, a_v) to (b_u, b_v) of a Bezier patch, as parameters in 0..1.
[[nodiscard]] BezierPatch part(const BezierPatch& patch, double a_u, double b_u, double a_v, double b_v);

// Defined for N = 2, trimming curves in (u, v), and N = 4, (x, y, z, radius) of a tube.

}  // namespace bob
