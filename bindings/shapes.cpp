/// Shapes: made of arrays, and measured.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <vector>

#include "bindings.h"
#include "shapes/brep.h"
#include "shapes/extent.h"
#include "shapes/implicit.h"
#include "shapes/mesh.h"
#include "shapes/tube.h"

using namespace nb::literals;

namespace {

void init_mesh(bob::Mesh* self, const Points& vertices, const Array<const std::int32_t, -1, 3>& triangles,
               const std::optional<Points>& normals) {
    expect(triangles.shape(0) > 0, "triangles: expected at least one");
    const auto count = static_cast<std::int64_t>(vertices.shape(0));
    for (std::size_t i = 0; i < 3 * triangles.shape(0); ++i) {
        expect(triangles.data()[i] >= 0 && triangles.data()[i] < count, "triangles: index out of range");
    }
    expect(!normals || normals->shape(0) == vertices.shape(0), "normals: expected one for each vertex");
    const auto vertex_normals = normals ? items<bob::Vec3>(*normals) : std::span<const bob::Vec3>{};
    const nb::gil_scoped_release release;
    new (self) bob::Mesh(items<bob::Vec3>(vertices), items<bob::Triangle>(triangles), vertex_normals);
}

using Matrix = Array<const double, 3, 4>;
using Corners = Array<const double, 2, 3>;

void init_implicit(bob::Implicit* self, const bob::Expression& formula, const Corners& bounds) {
    bob::Bounds box;
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = bounds.data()[axis];
        box.high[axis] = bounds.data()[3 + axis];
        expect(box.low[axis] < box.high[axis], "bounds: expected each low below its high");
    }
    const nb::gil_scoped_release release;
    new (self) bob::Implicit(formula, box);
}

/// None where the formula is positive everywhere.
std::optional<Array<double, 2, 3>> find_bounds(const bob::Expression& formula) {
    std::optional<bob::Bounds> found;
    {
        const nb::gil_scoped_release release;
        found = bob::find_bounds(formula);
    }
    if (!found) return std::nullopt;
    auto result = make_array<double, 2, 3>(2, 3);
    std::copy_n(found->low, 3, result.data());
    std::copy_n(found->high, 3, result.data() + 3);
    return result;
}

using Knots = Array<const double, -1>;

/// The degree of `count` control points, for which there are count + degree + 1 knots.
int degree(std::size_t count, const Knots& knots) {
    expect(count >= 2 && knots.shape(0) >= count + 2 && knots.shape(0) <= count + 1 + bob::max_degree &&
               knots.shape(0) <= 2 * count,
           "knots: expected one for each control point and degree + 1 more");
    return static_cast<int>(knots.shape(0) - count) - 1;
}

std::vector<double> values(const Knots& knots) { return {knots.data(), knots.data() + knots.shape(0)}; }

template <std::size_t N>
bob::NurbsCurve<N> curve(const Array<const double, -1, N + 1>& control_points, const Knots& knots) {
    const auto points = items<bob::Homogeneous<N>>(control_points);
    return {degree(points.size(), knots), values(knots), {points.begin(), points.end()}};
}

/// Sequences of faces, of their loops and of these' curves, as `_core.pyi` has them.
void init_brep(bob::Brep* self, const nb::sequence& faces, double tolerance) {
    using Surface = std::tuple<Array<const double, -1, -1, 4>, Knots, Knots, nb::sequence>;
    using Curve = std::tuple<Array<const double, -1, 3>, Knots>;
    std::vector<bob::Face> converted;
    for (const nb::handle face : faces) {
        const auto [control_points, knots_u, knots_v, loops] = nb::cast<Surface>(face);
        const std::size_t size_u = control_points.shape(0), size_v = control_points.shape(1);
        const auto* points = reinterpret_cast<const bob::Homogeneous<3>*>(control_points.data());
        bob::Face& target = converted.emplace_back();
        target.surface = {degree(size_u, knots_u), degree(size_v, knots_v), values(knots_u), values(knots_v),
                          {points, points + size_u * size_v}};
        for (const nb::handle loop : loops) {
            bob::TrimLoop& curves = target.loops.emplace_back();
            for (const nb::handle item : nb::cast<nb::sequence>(loop)) {
                const auto [trim_points, trim_knots] = nb::cast<Curve>(item);
                curves.push_back(curve<2>(trim_points, trim_knots));
            }
        }
    }
    const nb::gil_scoped_release release;
    new (self) bob::Brep(converted, tolerance);
}

void init_tube(bob::Tube* self, const Array<const double, -1, 5>& control_points, const Knots& knots) {
    const auto path = curve<4>(control_points, knots);
    const nb::gil_scoped_release release;
    new (self) bob::Tube(path);
}

template <class S>
Array<double, 2, 3> placed_bounds(const S& shape, const Matrix& map) {
    auto result = make_array<double, 2, 3>(2, 3);
    const nb::gil_scoped_release release;
    bob::placed_bounds(shape, map.data(), result.data());
    return result;
}

template <class S>
double placed_radius(const S& shape, const Matrix& map, const Array<const double, 3>& center,
                     double largest_singular_value) {
    const nb::gil_scoped_release release;
    return bob::placed_radius(shape, map.data(), center.data(), largest_singular_value);
}

/// A class of shapes whose extents the core finds.
template <class S>
nb::class_<S, bob::Shape> measured_class(nb::module_& m, const char* name) {
    return nb::class_<S, bob::Shape>(m, name)
        .def("bounds", &placed_bounds<S>, "map"_a.noconvert())
        .def("radius", &placed_radius<S>, "map"_a.noconvert(), "center"_a.noconvert(), "largest_singular_value"_a);
}

}  // namespace

void bind_shapes(nb::module_& m) {
    nb::class_<bob::Shape>(m, "Shape").def_prop_ro("bytes", &bob::Shape::bytes);

    nb::class_<bob::Mesh, bob::Shape>(m, "Mesh")
        .def("__init__", &init_mesh, "vertices"_a.noconvert(), "triangles"_a.noconvert(),
             "normals"_a.noconvert().none())
        .def_prop_ro("bvh_bytes", [](const bob::Mesh& mesh) { return mesh.bvh().bytes(); });

    measured_class<bob::Implicit>(m, "Implicit")
        .def("__init__", &init_implicit, "formula"_a, "bounds"_a.noconvert())
        .def_prop_ro("center", [](const bob::Implicit& s) { return nb::make_tuple(s.center()[0], s.center()[1], s.center()[2]); })
        .def_prop_ro("half_side", &bob::Implicit::half_side)
        .def_prop_ro("cells", [](const bob::Implicit& s) { return s.cells().cells().size(); })
        .def_prop_ro("unresolved_rays", &bob::Implicit::unresolved_rays);
    m.def("find_bounds", &find_bounds, "formula"_a);

    measured_class<bob::Brep>(m, "Brep")
        .def("__init__", &init_brep, "faces"_a, "tolerance"_a)
        .def_prop_ro("patches", [](const bob::Brep& s) { return s.pieces().patches.size(); })
        .def_prop_ro("pieces", [](const bob::Brep& s) { return s.pieces().count; });
    measured_class<bob::Tube>(m, "Tube")
        .def("__init__", &init_tube, "control_points"_a.noconvert(), "knots"_a.noconvert())
        .def_prop_ro("pieces", &bob::Tube::pieces);
}
