/// NURBS at many parameters in one call.
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "bindings.h"
#include "nurbs/delaunay.h"
#include "nurbs/nurbs.h"

using namespace nb::literals;

namespace {

using Numbers = Array<const double, -1>;

std::span<const double> checked_knots(int degree, const Numbers& knots, const char* what) {
    const auto values = items<double>(knots);
    const auto p = static_cast<std::size_t>(degree);
    expect(degree >= 1 && degree <= bob::max_degree, "degree: expected 1..9");
    expect(values.size() >= 2 * p + 2 && values[p] < values[values.size() - p - 1] &&
               std::adjacent_find(values.begin(), values.end(), [](double a, double b) { return !(a <= b); }) ==
                   values.end(),
           what);
    return values;
}

/// Number of derivatives 0..order; limited, so that array sizes do not overflow.
std::size_t checked_rows(int order) {
    expect(order >= 0 && order <= 100, "order: expected 0..100");
    return static_cast<std::size_t>(order) + 1;
}

std::pair<Array<std::int64_t, -1>, Array<double, -1, -1, -1>> basis_derivatives(int degree, const Numbers& knots,
                                                                               const Numbers& u, int order) {
    const auto values = checked_knots(degree, knots, "knots: expected a domain, and no decreasing knots");
    const std::size_t rows = checked_rows(order);
    const std::size_t columns = static_cast<std::size_t>(degree) + 1;
    auto spans = make_array<std::int64_t, -1>(u.shape(0));
    auto derivatives = make_array<double, -1, -1, -1>(u.shape(0), rows, columns);
    interruptible([&] {
        bob::parallel_for(u.shape(0), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t span = bob::find_span(degree, values, u.data()[i]);
                const bob::BasisDerivatives basis = bob::basis_derivatives(span, u.data()[i], degree, values, order);
                spans.data()[i] = static_cast<std::int64_t>(span);
                double* target = derivatives.data() + i * rows * columns;
                for (std::size_t k = 0; k < rows; ++k, target += columns) {
                    if (k < basis.size()) {
                        std::copy_n(basis[k].begin(), columns, target);
                    } else {
                        std::fill_n(target, columns, 0.0);
                    }
                }
            }
        });
    });
    return {spans, derivatives};
}

Array<double, -1, -1, -1, 3> surface_derivatives(const Array<const double, -1, -1, 4>& control_points,
                                                 const Numbers& knots_u, const Numbers& knots_v, int degree_u,
                                                 int degree_v, const Numbers& u, const Numbers& v, int order) {
    const auto u_knots = checked_knots(degree_u, knots_u, "knots_u: expected a domain, and no decreasing knots");
    const auto v_knots = checked_knots(degree_v, knots_v, "knots_v: expected a domain, and no decreasing knots");
    const std::size_t rows = checked_rows(order);
    expect(u.shape(0) == v.shape(0), "v: expected as many as u");
    const auto* points = reinterpret_cast<const bob::Homogeneous<3>*>(control_points.data());
    const bob::NurbsSurface surface{degree_u, degree_v, {u_knots.begin(), u_knots.end()},
                                    {v_knots.begin(), v_knots.end()},
                                    {points, points + control_points.shape(0) * control_points.shape(1)}};
    expect(surface.size_u() == control_points.shape(0) && surface.size_v() == control_points.shape(1),
           "control_points: expected as many as the knots and degrees say");
    auto result = make_array<double, -1, -1, -1, 3>(u.shape(0), rows, rows, 3);
    interruptible([&] {
        bob::parallel_for(u.shape(0), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const auto derivatives = bob::surface_derivatives(surface, u.data()[i], v.data()[i], order);
                std::copy_n(derivatives.data()->data(), rows * rows * 3, result.data() + i * rows * rows * 3);
            }
        });
    });
    return result;
}

Array<std::int32_t, -1, 3> triangulate(const Array<const std::int32_t, -1, 2>& points,
                                       const Array<const std::int32_t, -1, 2>& edges) {
    std::vector<std::array<std::int32_t, 3>> triangles;
    interruptible([&] {
        triangles = bob::triangulate(items<bob::PlanePoint>(points), items<std::array<std::int32_t, 2>>(edges));
    });
    auto result = make_array<std::int32_t, -1, 3>(triangles.size(), 3);
    std::copy_n(triangles.data()->data(), 3 * triangles.size(), result.data());
    return result;
}

template <std::size_t N>
void make_homogeneous(const Array<double, -1, -1>& points) {
    bob::make_homogeneous<N>({reinterpret_cast<bob::Homogeneous<N>*>(points.data()), points.shape(0)});
}

Array<double, -1, -1> homogeneous(const Array<const double, -1, -1>& points) {
    const std::size_t size = points.shape(1);
    expect(size == 3 || size == 4, "points: expected 2 or 3 coordinates and a weight");
    auto result = make_array<double, -1, -1>(points.shape(0), size);
    std::copy_n(points.data(), points.size(), result.data());
    size == 3 ? make_homogeneous<2>(result) : make_homogeneous<3>(result);
    return result;
}

}  // namespace

void bind_nurbs(nb::module_& m) {
    m.def("triangulate", &triangulate, "points"_a.noconvert(), "edges"_a.noconvert(),
          "Triangles (t, 3) between distinct points (n, 2), in 0..2**25, of the area that an odd number of loops of edges (m, 2) "
          "surround. ValueError if edges cross.");
    m.def("homogeneous", &homogeneous, "points"_a,
          "Points (n, k), each with its weight behind it, multiplied by their weights, of which the largest becomes 1.");
    m.def("basis_derivatives", &basis_derivatives, "degree"_a, "knots"_a.noconvert(), "u"_a.noconvert(), "order"_a,
          "The spans (k,) of parameters (k,), and the derivatives 0..order of the degree + 1 basis functions that are not zero on them, "
          "(k, order + 1, degree + 1). Parameters outside of the domain continue its first or last span.");
    m.def("surface_derivatives", &surface_derivatives, "control_points"_a.noconvert(), "knots_u"_a.noconvert(),
          "knots_v"_a.noconvert(), "degree_u"_a, "degree_v"_a, "u"_a.noconvert(), "v"_a.noconvert(), "order"_a,
          "The partial derivatives (k, order + 1, order + 1, 3) of a surface of homogeneous control points (n, m, 4) at parameters (k,): "
          "[:, i, j] is the i-th in u, the j-th in v. Those with i + j > order are zero.");
}
