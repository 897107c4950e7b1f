/// Shapes: construction from arrays, and measurement.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/parallel.h"
#include "bindings.h"
#include "nurbs/extremes.h"
#include "nurbs/moments.h"
#include "shapes/brep/brep.h"
#include "shapes/implicit/contouring.h"
#include "shapes/implicit/implicit.h"
#include "shapes/implicit/vm_solid.h"
#include "shapes/mesh/lying.h"
#include "shapes/mesh/mesh.h"
#include "shapes/tube/tube.h"

using namespace nb::literals;

namespace {

using Vertices = Array<const double, -1, 3>;
using Triangles = Array<const std::int32_t, -1, 3>;

using Uvs = Array<const float, -1, 2>;
using Texels = Array<const std::uint8_t, -1, -1, 3>;
using Alpha = Array<const std::uint8_t, -1, -1>;
using Alphas = Array<const float, -1>;

Array<float, -1, 3, 3> corner_normals(const bob::Mesh& mesh) {
    std::vector<bob::CornerNormals> normals;
    interruptible([&] { normals = mesh.corner_normals(); });
    auto result = make_array<float, -1, 3, 3>(normals.size(), 3, 3);
    const auto* const from = reinterpret_cast<const float*>(normals.data());
    std::copy_n(from, 9 * normals.size(), result.data());
    return result;
}

void check_triangles(const Vertices& vertices, const Triangles& triangles) {
    const auto count = static_cast<std::int64_t>(vertices.shape(0));
    for (std::size_t i = 0; i < 3 * triangles.shape(0); ++i) {
        expect(triangles.data()[i] >= 0 && triangles.data()[i] < count, "triangles: index out of range");
    }
}

/// Reads the arrays during its whole lifetime.
void init_mesh(bob::Mesh* self, const Vertices& vertices, const Triangles& triangles, const std::optional<Points>& normals,
               const std::optional<Points>& colors, const std::optional<Points>& face_colors, const std::optional<Uvs>& uv,
               const std::shared_ptr<bob::Texture>& texture, const std::optional<Alphas>& alphas, float alpha_cutoff) {
    expect(triangles.shape(0) > 0, "triangles: expected at least one");
    check_triangles(vertices, triangles);
    expect(!normals || normals->shape(0) == vertices.shape(0), "normals: expected one for each vertex");
    expect(!colors || colors->shape(0) == vertices.shape(0), "colors: expected one for each vertex");
    expect(!face_colors || face_colors->shape(0) == triangles.shape(0), "face_colors: expected one for each triangle");
    expect(!texture || (uv && uv->shape(0) == vertices.shape(0)), "uv: expected one for each vertex");
    expect(!alphas || alphas->shape(0) == vertices.shape(0), "alphas: expected one for each vertex");
    const auto vectors = [](const std::optional<Points>& array) {
        return array ? items<bob::Vec3>(*array) : std::span<const bob::Vec3>{};
    };
    auto owner = std::make_shared<std::tuple<Vertices, Triangles, std::optional<Points>, std::optional<Points>, std::optional<Points>,
                                             std::optional<Uvs>, std::optional<Alphas>>>(vertices, triangles, normals, colors,
                                                                                         face_colors, uv, alphas);
    without_gil([&] {
        new (self) bob::Mesh({items<bob::Mesh::Point>(vertices), items<bob::Triangle>(triangles), vectors(normals), owner, vectors(colors),
                              vectors(face_colors), uv ? items<bob::Mesh::Uv>(*uv) : std::span<const bob::Mesh::Uv>{}, texture,
                              alphas ? std::span(alphas->data(), alphas->size()) : std::span<const float>{}, alpha_cutoff});
    });
}

bob::Wrap wrap_of(std::string_view name) {
    if (name == "repeat") return bob::Wrap::repeat;
    if (name == "mirror") return bob::Wrap::mirror;
    expect(name == "clamp", "wrap: expected repeat, clamp or mirror");
    return bob::Wrap::clamp;
}

/// Reads the arrays during its whole lifetime.
void init_picture(bob::Picture* self, const Texels& texels, const std::optional<Alpha>& alpha) {
    expect(texels.size() > 0, "texture: expected at least one texel");
    expect(!alpha || 3 * alpha->size() == texels.size(), "alpha: expected one for each texel");
    auto owner = std::make_shared<std::tuple<Texels, std::optional<Alpha>>>(texels, alpha);
    without_gil([&] {
        new (self) bob::Picture({texels.data(), texels.size()}, static_cast<int>(texels.shape(0)), static_cast<int>(texels.shape(1)),
                                alpha ? std::span(alpha->data(), alpha->size()) : std::span<const std::uint8_t>{}, std::move(owner));
    });
}

void init_texture(bob::Texture* self, const std::shared_ptr<bob::Picture>& picture, std::string_view across, std::string_view down) {
    new (self) bob::Texture(picture, wrap_of(across), wrap_of(down));
}

/// Linear RGB at places, (n, 2): u and v, with pixel footprints in texels.
Array<float, -1, 3> texture_colors(const bob::Texture& texture, const Uvs& uv, const Array<const float, -1>& widths) {
    expect(widths.shape(0) == uv.shape(0), "widths: expected one for each place");
    auto result = make_array<float, -1, 3>(uv.shape(0), 3);
    for (std::size_t i = 0; i < uv.shape(0); ++i) {
        const bob::Vec3 color = texture(uv.data()[2 * i], uv.data()[2 * i + 1], widths.data()[i]);
        for (int k = 0; k < 3; ++k) result.data()[3 * i + static_cast<std::size_t>(k)] = color[k];
    }
    return result;
}

using Corners = Array<const double, 2, 3>;

Array<double, 2, 3> to_array(const bob::Bounds& bounds) {
    auto result = make_array<double, 2, 3>(2, 3);
    std::copy_n(bounds.low, 3, result.data());
    std::copy_n(bounds.high, 3, result.data() + 3);
    return result;
}

void init_implicit(bob::Implicit* self, const bob::Expression& formula, const Corners& bounds, const bob::ColorFormula* color) {
    bob::Bounds box;
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = bounds.data()[axis];
        box.high[axis] = bounds.data()[3 + axis];
        expect(box.low[axis] < box.high[axis], "bounds: expected each low below its high");
    }
    interruptible([&] { new (self) bob::Implicit(formula, box, color); });
}

Array<float, -1, 3> implicit_colors(const bob::Implicit& shape, const Array<const double, -1, 3>& points) {
    expect(shape.is_colored(), "shape: expected one with colours");
    const auto& [center, radius] = shape.sphere();
    auto result = make_array<float, -1, 3>(points.shape(0), 3);
    interruptible([&] {
        bob::parallel_for(points.shape(0), 256, [&](std::size_t begin, std::size_t end) {
            std::vector<bob::Vec3> own(end - begin);
            for (std::size_t i = begin; i < end; ++i) {
                for (int axis = 0; axis < 3; ++axis) {
                    const double coordinate = points.data()[3 * i + static_cast<std::size_t>(axis)];
                    own[i - begin][axis] = static_cast<float>((coordinate - center[axis]) / radius);
                }
            }
            shape.colors(own, {reinterpret_cast<bob::Vec3*>(result.data()) + begin, own.size()});
        });
    });
    return result;
}

using NewVertices = Array<double, -1, 3>;
using NewTriangles = Array<std::int32_t, -1, 3>;

std::tuple<NewVertices, NewTriangles> dual_contour(const bob::Implicit& shape, double step) {
    expect(step > 0, "step: expected a number above 0");
    bob::Triangulation mesh;
    interruptible([&] { mesh = bob::dual_contour(shape, step); });
    auto vertices = make_array<double, -1, 3>(mesh.vertices.size(), 3);
    auto triangles = make_array<std::int32_t, -1, 3>(mesh.triangles.size(), 3);
    std::copy_n(mesh.vertices.data()->data(), 3 * mesh.vertices.size(), vertices.data());
    std::copy_n(mesh.triangles.data()->data(), 3 * mesh.triangles.size(), triangles.data());
    return {std::move(vertices), std::move(triangles)};
}

std::optional<Array<double, 2, 3>> find_bounds(const bob::Expression& formula) {
    std::optional<bob::Bounds> found;
    interruptible([&] { found = bob::find_bounds(formula); });
    if (!found) return std::nullopt;
    return to_array(*found);
}

std::tuple<bob::Expression, std::optional<Array<double, 2, 3>>, bool> vm_solid(const bob::Expression& formula) {
    std::optional<bob::VmSolid> solid;
    interruptible([&] { solid = bob::vm_solid(formula); });
    std::optional<Array<double, 2, 3>> bounds;
    if (solid->bounds) bounds = to_array(*solid->bounds);
    return {std::move(solid->formula), std::move(bounds), solid->cut};
}

using Knots = Array<const double, -1>;

/// The degree of `count` control points, given count + degree + 1 knots.
int degree(std::size_t count, const Knots& knots) {
    expect(count >= 2 && knots.shape(0) >= count + 2 && knots.shape(0) <= count + 1 + bob::max_degree &&
               knots.shape(0) <= 2 * count,
           "knots: expected one for each control point, and degree + 1 more");
    return static_cast<int>(knots.shape(0) - count) - 1;
}

std::vector<double> values(const Knots& knots) { return {knots.data(), knots.data() + knots.shape(0)}; }

template <std::size_t N>
bob::NurbsCurve<N> curve(const Array<const double, -1, N + 1>& control_points, const Knots& knots) {
    const auto points = items<bob::Homogeneous<N>>(control_points);
    return {degree(points.size(), knots), values(knots), {points.begin(), points.end()}};
}

/// Control points (n, 3), each (u, v, weight), and knots.
using Curve = std::tuple<Array<const double, -1, 3>, Knots>;
/// Control points (n, m, 4), each (x, y, z, weight); knots of u and of v; loops of curves.
using Surface = std::tuple<Array<const double, -1, -1, 4>, Knots, Knots, nb::typed<nb::sequence, nb::typed<nb::sequence, Curve>>>;
using Surfaces = nb::typed<nb::sequence, Surface>;

bob::Face face_of(const nb::handle& face) {
    const auto [control_points, knots_u, knots_v, loops] = nb::cast<Surface>(face);
    const std::size_t size_u = control_points.shape(0), size_v = control_points.shape(1);
    const auto* points = reinterpret_cast<const bob::Homogeneous<3>*>(control_points.data());
    bob::Face target;
    target.surface = {degree(size_u, knots_u), degree(size_v, knots_v), values(knots_u), values(knots_v),
                      {points, points + size_u * size_v}};
    for (const nb::handle loop : loops) {
        bob::TrimLoop& curves = target.loops.emplace_back();
        for (const nb::handle item : nb::cast<nb::sequence>(loop)) {
            const auto [trim_points, trim_knots] = nb::cast<Curve>(item);
            curves.push_back(curve<2>(trim_points, trim_knots));
        }
    }
    return target;
}

/// `colors`: linear RGB of the faces. `numbers`: equal for pieces of one face.
void init_brep(bob::Brep* self, const Surfaces& faces, double tolerance, const std::optional<Points>& colors,
               const std::optional<Array<const std::int32_t, -1>>& numbers) {
    std::vector<bob::Face> converted;
    for (const nb::handle face : faces) converted.push_back(face_of(face));
    expect(!colors || colors->shape(0) == converted.size(), "colors: expected one for each face");
    for (std::size_t i = 0; colors && i < converted.size(); ++i) converted[i].color = items<bob::Vec3>(*colors)[i];
    expect(!numbers || numbers->shape(0) == converted.size(), "numbers: expected one for each face");
    for (std::size_t i = 0; numbers && i < converted.size(); ++i) converted[i].number = static_cast<std::uint32_t>(numbers->data()[i]);
    interruptible([&] { new (self) bob::Brep(bob::Brep::of_weighted_points(std::move(converted), tolerance)); });
}

/// Fills `size` numbers for each face by write(face, numbers), of homogeneous faces, in parallel.
template <class Write>
void for_each_face(const Surfaces& faces, double* numbers, std::size_t size, Write write) {
    std::vector<bob::Face> converted;
    for (const nb::handle face : faces) bob::make_homogeneous(converted.emplace_back(face_of(face)));
    interruptible([&] {
        bob::parallel_for(converted.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) write(converted[i], numbers + size * i);
        });
    });
}

Array<double, -1, 3, 2> face_extremes(const Surfaces& faces, const Array<const double, 3, 3>& directions) {
    auto result = make_array<double, -1, 3, 2>(nb::len(faces), 3, 2);
    const auto along = items<std::array<double, 3>>(directions);
    for_each_face(faces, result.data(), 6, [&](const bob::Face& face, double* to) {
        for (const auto& found : bob::extremes(face.surface, face.loops, along)) to = std::ranges::copy(found, to).out;
    });
    return result;
}

Array<double, -1, 15> face_moments(const Surfaces& faces) {
    auto result = make_array<double, -1, 15>(nb::len(faces), 15);
    for_each_face(faces, result.data(), 15, [](const bob::Face& face, double* to) {
        const bob::Moments found = bob::moments(face.surface, face.loops);
        *to++ = found.area;
        to = std::ranges::copy(found.normal, to).out;
        to = std::ranges::copy(found.position, to).out;
        std::ranges::copy(found.inside, to);
    });
    return result;
}

void init_tube(bob::Tube* self, const Array<const double, -1, 5>& control_points, const Knots& knots) {
    auto path = curve<4>(control_points, knots);
    interruptible([&] { new (self) bob::Tube(bob::Tube::of_weighted_points(std::move(path))); });
}

Array<double, 2, 3> bounds(const bob::Shape& shape, const Matrix& map) {
    bob::Bounds found;
    interruptible([&] { found = shape.bounds(bob::affine_map(map.data())); });
    return to_array(found);
}

double radius(const bob::Shape& shape, const Matrix& map, const Array<const double, 3>& center) {
    double found = 0;
    interruptible([&] { found = shape.radius(bob::affine_map(map.data()), center.data()); });
    return found;
}

}  // namespace

void bind_shapes(nb::module_& m) {
    nb::class_<bob::Shape>(m, "Shape", "`map`, (4, 4), maps the shape's own units to its place.")
        .def("bounds", &bounds, "map"_a, "The lowest and the highest coordinates, (2, 3), of the placed shape.")
        .def("radius", &radius, "map"_a, "center"_a, "The distance from `center` to the farthest point of the placed shape.")
        .def("prepare", [](const bob::Shape& shape) { interruptible([&] { shape.prepare(); }); },
             "Builds the data for ray intersection, once.")
        .def_prop_ro("bytes", [](const bob::Shape& shape) { return without_gil([&] { return shape.bytes(); }); }, "Of the data for ray intersection.");

    nb::class_<bob::Picture>(m, "Picture",
        "`texels` (height, width, 3) are sRGB, from the top row down, `alpha` (height, width); they must not change while it lives.")
        .def("__init__", &init_picture, "texels"_a.noconvert(), "alpha"_a.noconvert().none() = nb::none())
        .def_prop_ro("bytes", &bob::Picture::bytes);

    nb::class_<bob::Texture>(m, "Texture", "A picture, which others may share, and how it wraps: repeat, clamp or mirror.")
        .def("__init__", &init_texture, "picture"_a, "across"_a, "down"_a)
        .def("__call__", &texture_colors, "uv"_a.noconvert(), "widths"_a.noconvert());

    nb::class_<bob::Mesh, bob::Shape>(m, "Mesh",
        "The arrays, `vertices` (v, 3), `triangles` (t, 3), `normals` and `colors` (v, 3), `face_colors` (t, 3), `uv` (v, 2) and `alphas` "
        "(v,), must not change while it lives.")
        .def("__init__", &init_mesh, "vertices"_a.noconvert(), "triangles"_a.noconvert(),
             "normals"_a.noconvert().none(), "colors"_a.noconvert().none() = nb::none(),
             "face_colors"_a.noconvert().none() = nb::none(), "uv"_a.noconvert().none() = nb::none(), "texture"_a.none() = nb::none(),
             "alphas"_a.noconvert().none() = nb::none(), "alpha_cutoff"_a = 0)
        .def("corner_normals", &corner_normals, "The unit normals at the corners of its triangles, (t, 3, 3).")
        .def_prop_ro("bvh_bytes", [](const bob::Mesh& mesh) { return without_gil([&] { return mesh.bvh_bytes(); }); });

    nb::class_<bob::Implicit, bob::Shape>(m, "Implicit")
        .def("__init__", &init_implicit, "formula"_a, "bounds"_a.noconvert(), "color"_a.none() = nb::none())
        .def_prop_ro("cells", [](const bob::Implicit& s) { return s.cells().cells().size(); })
        .def_prop_ro("is_coarse", [](const bob::Implicit& s) { return s.cells().is_coarse(); })
        .def_prop_ro("unresolved_rays", &bob::Implicit::unresolved_rays)
        .def("dual_contour", &dual_contour, "step"_a,
             "Vertices (v, 3) and triangles (t, 3), anticlockwise seen from outside. ValueError if there are too many.")
        .def("colors", &implicit_colors, "points"_a.noconvert(), "Linear RGB (n, 3) at points (n, 3), of a shape with colours.");
    m.def("seems_to_lie", [](const Vertices& vertices, const Triangles& triangles) {
        check_triangles(vertices, triangles);
        return without_gil([&] { return bob::seems_to_lie(items<bob::Vec3d>(vertices), items<std::array<std::int32_t, 3>>(triangles)); });
    }, "vertices"_a, "triangles"_a, "Whether y is more likely the up axis of (V, 3) vertices and (T, 3) triangles than z.");
    m.def("find_bounds", &find_bounds, "formula"_a,
          "A box (2, 3) around the inside of a formula; None if it has none, ValueError if it does not end.");
    m.def("vm_solid", &vm_solid, "formula"_a, "The solid of a .vm file's formula, its bounds, and whether they cut it.");

    m.def("face_extremes", &face_extremes, "faces"_a, "directions"_a,
          "(n, 3, 2): the smallest and largest products of each face's points with each of three directions (3, 3).");
    m.def("face_moments", &face_moments, "faces"_a,
          "(n, 15): of each face its area, the integral (3,) of its unit normal, that of position times normal, (3, 3), and (u, v) of a "
          "point inside.");
    nb::class_<bob::Brep, bob::Shape>(m, "Brep", "ValueError if the trims leave nothing.")
        .def("__init__", &init_brep, "faces"_a, "tolerance"_a, "colors"_a.noconvert().none() = nb::none(),
             "numbers"_a.noconvert().none() = nb::none())
        .def_prop_ro("is_coarse", [](const bob::Brep& s) { return s.pieces().is_coarse; })
        .def_prop_ro("patches", [](const bob::Brep& s) { return s.pieces().patches.size(); })
        .def_prop_ro("pieces", [](const bob::Brep& s) { return s.pieces().count; });
    nb::class_<bob::Tube, bob::Shape>(m, "Tube", "`control_points` (n, 5), each (x, y, z, radius, weight).")
        .def("__init__", &init_tube, "control_points"_a.noconvert(), "knots"_a.noconvert())
        .def_prop_ro("pieces", &bob::Tube::pieces);
}
