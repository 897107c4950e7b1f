/// The core as a Python module: convert and call. Arguments are checked by the Python package, in better words; here
/// only what would read or write out of bounds.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string_view.h>

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "bindings.h"
#include "complete/known.h"
#include "complete/paper.h"
#include "isa.h"
#include "parallel.h"
#include "shapes/mesh.h"
#include "trace/order.h"
#include "trace/trace.h"

using namespace nb::literals;

namespace {

using Points = Array<const float, -1, 3>;
using Pixels = Array<const std::int32_t, -1, 2>;
using Image = Array<float, -1, -1>;

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

void closest_hits(const bob::Mesh& mesh, const Points& origins, const Points& directions, Array<float, -1> t,
                  Array<std::int32_t, -1> triangle) {
    const std::size_t count = origins.shape(0);
    expect(directions.shape(0) == count && t.shape(0) == count && triangle.shape(0) == count,
           "closest_hits: expected arrays of one length");
    const auto origin = items<bob::Vec3>(origins), direction = items<bob::Vec3>(directions);
    interruptible([&](const auto& keep_going) {
        constexpr std::size_t grain = 512;
        bob::parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
            std::array<bob::Ray, grain> rays;
            std::array<bob::Hit, grain> hits;
            for (std::size_t i = begin; i < end; ++i) rays[i - begin] = {origin[i], direction[i]};
            mesh.closest_hits({rays.data(), end - begin}, {hits.data(), end - begin});
            for (std::size_t i = begin; i < end; ++i) {
                t.data()[i] = hits[i - begin].t;
                triangle.data()[i] = static_cast<std::int32_t>(hits[i - begin].triangle);
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

void trace(const bob::Mesh& mesh, float azimuth, float elevation, float roll, float zoom, int height, int width,
           const Pixels& pixels, const Array<float, -1>& gray, const Array<float, -1>& depth,
           const Array<float, -1, 2>& normal, const Array<bool, -1>& hit) {
    check_pixels(pixels, height, width);
    const bob::Samples out = samples(pixels, gray, depth, normal, hit);
    interruptible([&](const auto& keep_going) {
        bob::trace(mesh, {azimuth, elevation, roll, zoom}, height, width, items<bob::Pixel>(pixels), out, keep_going);
    });
}

void scatter(const Pixels& pixels, const Array<float, -1>& gray, const Array<float, -1>& depth,
             const Array<float, -1, 2>& normal, const Array<bool, -1>& hit, const Array<float, 5, -1, -1>& planes) {
    check_pixels(pixels, static_cast<int>(planes.shape(1)), static_cast<int>(planes.shape(2)));
    const bob::Samples from = samples(pixels, gray, depth, normal, hit);
    const nb::gil_scoped_release release;
    bob::scatter(items<bob::Pixel>(pixels), from, planes.data(), planes.shape(1), planes.shape(2));
}

void uniform_order(std::uint64_t seed, std::uint32_t height, std::uint32_t width, std::uint32_t start,
                   const Array<std::int32_t, -1, 2>& pixels) {
    expect(std::uint64_t{start} + pixels.shape(0) <= std::uint64_t{height} * width, "start: beyond the last pixel");
    const bob::UniformOrder order(seed, height * width);
    interruptible([&](const auto& keep_going) {
        bob::parallel_for(pixels.shape(0), 8192, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t pixel = order(start + static_cast<std::uint32_t>(i));
                pixels.data()[2 * i] = static_cast<std::int32_t>(pixel / width);
                pixels.data()[2 * i + 1] = static_cast<std::int32_t>(pixel % width);
            }
        }, keep_going);
    });
}

void init_paper(bob::Paper* self, const nb::dict& tensors) {
    bob::Weights weights;
    std::vector<nb::ndarray<const float, nb::c_contig, nb::device::cpu>> arrays;  // keeps converted values alive
    for (const auto& [key, value] : tensors) {
        arrays.push_back(nb::cast<nb::ndarray<const float, nb::c_contig, nb::device::cpu>>(value));
        const auto& array = arrays.back();
        bob::Tensor tensor{{}, {array.data(), array.size()}};
        for (std::size_t axis = 0; axis < array.ndim(); ++axis) {
            tensor.shape.push_back(static_cast<int>(array.shape(axis)));
        }
        weights.emplace(nb::cast<std::string_view>(key), std::move(tensor));
    }
    new (self) bob::Paper(weights);
}

void run_paper(const bob::Paper& network, const Array<const float, 5, -1, -1>& gbuffer, const Image& gray) {
    expect(gray.shape(0) == gbuffer.shape(1) && gray.shape(1) == gbuffer.shape(2), "gray: expected the input's size");
    const nb::gil_scoped_release release;
    network(gbuffer.data(), static_cast<int>(gray.shape(0)), static_cast<int>(gray.shape(1)), gray.data());
}

void keep_known(const Array<const float, 5, -1, -1>& gbuffer, const Image& gray) {
    expect(gray.shape(0) == gbuffer.shape(1) && gray.shape(1) == gbuffer.shape(2), "gray: expected the input's size");
    const nb::gil_scoped_release release;
    bob::keep_known(gbuffer.data(), gray.size(), gray.data());
}

bool set_isa(std::string_view name) {
    for (const bob::Isa isa : {bob::Isa::baseline, bob::Isa::avx2, bob::Isa::avx512}) {
        if (bob::name(isa) == name) return bob::set_isa(isa);
    }
    return false;
}

}  // namespace

NB_MODULE(_core, m) {
    m.doc() = "The C++ core of BobRossNet.";

    m.def("thread_count", &bob::thread_count);
    m.def("set_thread_count", &bob::set_thread_count, "count"_a);
    m.def("isa", [] { return bob::name(bob::isa()); });
    m.def("set_isa", &set_isa, "name"_a);

    nb::class_<bob::Mesh>(m, "Mesh")
        .def("__init__", &init_mesh, "vertices"_a.noconvert(), "triangles"_a.noconvert(),
             "normals"_a.noconvert().none())
        .def("closest_hits", &closest_hits, "origins"_a.noconvert(), "directions"_a.noconvert(), "t"_a.noconvert(),
             "triangle"_a.noconvert())
        .def("trace", &trace, "azimuth"_a, "elevation"_a, "roll"_a, "zoom"_a, "height"_a, "width"_a,
             "pixels"_a.noconvert(), "gray"_a.noconvert(), "depth"_a.noconvert(), "normal"_a.noconvert(),
             "hit"_a.noconvert())
        .def_prop_ro("bvh_bytes", [](const bob::Mesh& mesh) { return mesh.bvh().bytes(); })
        .def_prop_ro("bytes", &bob::Mesh::bytes);

    m.def("scatter", &scatter, "pixels"_a.noconvert(), "gray"_a.noconvert(), "depth"_a.noconvert(),
          "normal"_a.noconvert(), "hit"_a.noconvert(), "planes"_a.noconvert());
    m.def("uniform_order", &uniform_order, "seed"_a, "height"_a, "width"_a, "start"_a, "pixels"_a.noconvert());

    nb::class_<bob::Paper>(m, "Paper")
        .def("__init__", &init_paper, "tensors"_a)
        .def("__call__", &run_paper, "gbuffer"_a.noconvert(), "gray"_a.noconvert());
    m.def("keep_known", &keep_known, "gbuffer"_a.noconvert(), "gray"_a.noconvert());

    bind_formula(m);
    bind_modelling(m);
    bind_language(m);
}
