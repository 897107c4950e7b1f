/// Shapes, scenes of them, and what tracing these gives.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "bindings.h"
#include "parallel.h"
#include "shapes/implicit.h"
#include "shapes/mesh.h"
#include "trace/scene.h"
#include "trace/trace.h"

using namespace nb::literals;

namespace {

using Points = Array<const float, -1, 3>;
using Pixels = Array<const std::int32_t, -1, 2>;

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

/// A coordinate of a point of the shape's own space, after a map.
double mapped(const double* row, bob::Vec3 p) { return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3]; }

Array<double, 2, 3> placed_bounds(const bob::Implicit& shape, const Matrix& map) {
    auto result = make_array<double, 2, 3>(2, 3);
    double* out = result.data();
    const nb::gil_scoped_release release;
    bob::parallel_for(6, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double* row = map.data() + 4 * (i % 3);
            const double sign = i < 3 ? -1 : 1;
            out[i] = sign * shape.cells().maximum([=](bob::Vec3 p) { return sign * mapped(row, p); });
        }
    });
    return result;
}

double placed_radius(const bob::Implicit& shape, const Matrix& map, const Array<const double, 3>& center) {
    const double *rows = map.data(), *c = center.data();
    const nb::gil_scoped_release release;
    return shape.cells().maximum([&](bob::Vec3 p) {
        return std::hypot(mapped(rows, p) - c[0], mapped(rows + 4, p) - c[1], mapped(rows + 8, p) - c[2]);
    });
}

void init_scene(bob::Scene* self, const std::vector<std::shared_ptr<bob::Shape>>& shapes,
                const Array<const double, -1, 3, 4>& to_shape, const Array<const float, -1, 2, 3>& boxes,
                const Array<const float, -1, 7>& materials) {
    const std::size_t count = shapes.size();
    expect(to_shape.shape(0) == count && boxes.shape(0) == count && materials.shape(0) == count,
           "scene: expected arrays of one length");
    std::vector<bob::Instance> instances;
    for (std::size_t i = 0; i < count; ++i) {
        const float* m = materials.data() + 7 * i;
        instances.push_back({shapes[i], items<bob::AffineMap>(to_shape)[i], items<bob::Vec3[2]>(boxes)[i][0],
                             items<bob::Vec3[2]>(boxes)[i][1], {{m[0], m[1], m[2]}, m[3], m[4], m[5], m[6]}});
    }
    new (self) bob::Scene(std::move(instances));
}

void closest_hits(const bob::Scene& scene, const Points& origins, const Points& directions,
                  const Array<float, -1>& t, const Array<std::int32_t, -1>& instance,
                  const Array<std::int32_t, -1>& primitive) {
    const std::size_t count = origins.shape(0);
    expect(directions.shape(0) == count && t.shape(0) == count && instance.shape(0) == count &&
               primitive.shape(0) == count,
           "closest_hits: expected arrays of one length");
    const auto origin = items<bob::Vec3>(origins), direction = items<bob::Vec3>(directions);
    interruptible([&](const auto& keep_going) {
        bob::parallel_for(count, bob::batch_size(count), [&](std::size_t begin, std::size_t end) {
            thread_local std::vector<bob::Ray> rays;  // kept from call to call
            thread_local std::vector<bob::SceneHit> hits;
            rays.resize(end - begin), hits.resize(end - begin);
            for (std::size_t i = begin; i < end; ++i) rays[i - begin] = {origin[i], direction[i]};
            scene.closest_hits(rays, hits);
            for (std::size_t i = begin; i < end; ++i) {
                const bob::SceneHit& hit = hits[i - begin];
                t.data()[i] = hit.t;
                instance.data()[i] = static_cast<std::int32_t>(hit.instance);
                primitive.data()[i] = static_cast<std::int32_t>(hit.in_shape.primitive);
            }
        }, keep_going);
    });
}

void check_pixels(const Pixels& pixels, int height, int width) {
    for (const bob::Pixel p : items<bob::Pixel>(pixels)) {
        expect(p.row >= 0 && p.row < height && p.column >= 0 && p.column < width, "pixels: outside the image");
    }
}

bob::Samples samples(const Pixels& pixels, const Array<float, -1>& gray, const Array<float, -1>& depth,
                     const Array<float, -1, 2>& normal, const Array<bool, -1>& hit) {
    const std::size_t count = pixels.shape(0);
    expect(gray.shape(0) == count && depth.shape(0) == count && normal.shape(0) == count && hit.shape(0) == count,
           "samples: expected one for each pixel");
    return {gray.data(), depth.data(), normal.data(), hit.data()};
}

void trace(const bob::Scene& scene, float azimuth, float elevation, float roll, float zoom, int height, int width,
           const Pixels& pixels, const Array<float, -1>& gray, const Array<float, -1>& depth,
           const Array<float, -1, 2>& normal, const Array<bool, -1>& hit) {
    check_pixels(pixels, height, width);
    const bob::Samples out = samples(pixels, gray, depth, normal, hit);
    interruptible([&](const auto& keep_going) {
        bob::trace(scene, {azimuth, elevation, roll, zoom}, height, width, items<bob::Pixel>(pixels), out, keep_going);
    });
}

void scatter(const Pixels& pixels, const Array<float, -1>& gray, const Array<float, -1>& depth,
             const Array<float, -1, 2>& normal, const Array<bool, -1>& hit, const Array<float, 5, -1, -1>& planes) {
    check_pixels(pixels, static_cast<int>(planes.shape(1)), static_cast<int>(planes.shape(2)));
    const bob::Samples from = samples(pixels, gray, depth, normal, hit);
    const nb::gil_scoped_release release;
    bob::scatter(items<bob::Pixel>(pixels), from, planes.data(), planes.shape(1), planes.shape(2));
}

}  // namespace

void bind_scene(nb::module_& m) {
    nb::class_<bob::Shape>(m, "Shape").def_prop_ro("bytes", &bob::Shape::bytes);

    nb::class_<bob::Mesh, bob::Shape>(m, "Mesh")
        .def("__init__", &init_mesh, "vertices"_a.noconvert(), "triangles"_a.noconvert(),
             "normals"_a.noconvert().none())
        .def_prop_ro("bvh_bytes", [](const bob::Mesh& mesh) { return mesh.bvh().bytes(); });

    nb::class_<bob::Implicit, bob::Shape>(m, "Implicit")
        .def("__init__", &init_implicit, "formula"_a, "bounds"_a.noconvert())
        .def("bounds", &placed_bounds, "map"_a.noconvert())
        .def("radius", &placed_radius, "map"_a.noconvert(), "center"_a.noconvert())
        .def_prop_ro("center", [](const bob::Implicit& s) { return nb::make_tuple(s.center()[0], s.center()[1], s.center()[2]); })
        .def_prop_ro("half_side", &bob::Implicit::half_side)
        .def_prop_ro("cells", [](const bob::Implicit& s) { return s.cells().cells().size(); })
        .def_prop_ro("unresolved_rays", &bob::Implicit::unresolved_rays);
    m.def("find_bounds", &find_bounds, "formula"_a);

    nb::class_<bob::Scene>(m, "Scene")
        .def("__init__", &init_scene, "shapes"_a, "to_shape"_a.noconvert(), "boxes"_a.noconvert(),
             "materials"_a.noconvert())
        .def("closest_hits", &closest_hits, "origins"_a.noconvert(), "directions"_a.noconvert(), "t"_a.noconvert(),
             "instance"_a.noconvert(), "primitive"_a.noconvert())
        .def("trace", &trace, "azimuth"_a, "elevation"_a, "roll"_a, "zoom"_a, "height"_a, "width"_a,
             "pixels"_a.noconvert(), "gray"_a.noconvert(), "depth"_a.noconvert(), "normal"_a.noconvert(),
             "hit"_a.noconvert())
        .def_prop_ro("bytes", &bob::Scene::bytes);

    m.def("scatter", &scatter, "pixels"_a.noconvert(), "gray"_a.noconvert(), "depth"_a.noconvert(),
          "normal"_a.noconvert(), "hit"_a.noconvert(), "planes"_a.noconvert());
}
