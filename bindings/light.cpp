/// Light: discs, skies, and their use in a scene.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "bindings.h"
#include "frame/light_pace.h"
#include "frame/moving_light.h"
#include "light/edges.h"
#include "light/light_history.h"
#include "light/lighting.h"
#include "light/studio.h"

using namespace nb::literals;

namespace {

bob::Vec3 vector_of(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

std::shared_ptr<bob::Environment> environment(const Array<const float, -1, -1, 3>& texels) {
    const std::span<const bob::Vec3> values{reinterpret_cast<const bob::Vec3*>(texels.data()), texels.shape(0) * texels.shape(1)};
    const int height = static_cast<int>(texels.shape(0)), width = static_cast<int>(texels.shape(1));
    return without_gil([&] { return std::make_shared<bob::Environment>(values, height, width); });
}

void init_lights(bob::Lights* self, const std::vector<bob::DiscLight>& discs, const std::array<float, 3>& top, const std::array<float, 3>& bottom,
                 std::shared_ptr<bob::Environment> environment, float turn, std::optional<float> ground, float radius, int bounces) {
    new (self) bob::Lights{discs, {vector_of(top), vector_of(bottom), std::move(environment), std::cos(turn), std::sin(turn)},
                           ground.value_or(-std::numeric_limits<float>::infinity()), radius, bounces};
}

void trace(const bob::Lighting& lighting, const bob::Camera& camera, int height, int width, const Pixels& pixels, const Array<const std::uint32_t, -1>& first,
           std::uint32_t count, std::uint64_t seed, bool apart, const bob::Layout& layout, const Samples& samples) {
    check_pixels(pixels, height, width);
    check_width(layout, pixels.shape(0), samples);
    expect(first.shape(0) == pixels.shape(0), "first: expected one for each pixel");
    expect(count >= 1, "count: expected at least 1");
    interruptible([&] {
        lighting.trace(camera, height, width, items<bob::Pixel>(pixels), {items<std::uint32_t>(first), count, seed, apart}, layout, samples.data());
    });
}

void first_hits(const bob::Lighting& lighting, const bob::Camera& camera, const Planes& planes) {
    expect(planes.shape(0) == bob::first_hit::count, "planes: expected 10 for each pixel");
    interruptible([&] { lighting.first_hits(camera, static_cast<int>(planes.shape(1)), static_cast<int>(planes.shape(2)), planes.data()); });
}

std::tuple<Array<std::int32_t, -1, 2>, Array<float, -1, -1, -1>> hits_at_edges(const bob::Lighting& lighting, const bob::Camera& camera, const ConstPlanes& planes, int side) {
    expect(planes.shape(0) == bob::first_hit::count, "planes: expected 10 for each pixel");
    expect(side >= 1, "side: expected at least 1");
    const int height = static_cast<int>(planes.shape(1)), width = static_cast<int>(planes.shape(2));
    std::vector<bob::Pixel> found;
    interruptible([&] { found = bob::edges_between_surfaces(planes.data(), height, width); });
    auto pixels = make_array<std::int32_t, -1, 2>(found.size(), 2);
    std::memcpy(pixels.data(), found.data(), found.size() * sizeof(bob::Pixel));
    auto hits = make_array<float, -1, -1, -1>(found.size(), side * side, bob::first_hit::count);
    interruptible([&] { lighting.first_hits_within(camera, height, width, found, side, hits.data()); });
    return {std::move(pixels), std::move(hits)};
}

void smooth_edges(const Pixels& pixels, const ConstPlanes& hits, const ConstPlanes& guides, const std::optional<ConstPlane>& ground, const Planes& color,
                  const Array<float, -1, -1>& alpha) {
    const int height = static_cast<int>(alpha.shape(0)), width = static_cast<int>(alpha.shape(1));
    check_pixels(pixels, height, width);
    expect(hits.shape(0) == pixels.shape(0) && hits.shape(2) == bob::first_hit::count, "hits: expected 10 numbers for each of a pixel's");
    expect(guides.shape(0) == 7 && color.shape(0) == 3, "planes: expected 7 of guides and 3 of color");
    const auto has_size = [&](const auto& a, std::size_t first) { return a.shape(first) == alpha.shape(0) && a.shape(first + 1) == alpha.shape(1); };
    expect(has_size(guides, 1) && has_size(color, 1) && (!ground || has_size(*ground, 0)), "planes: expected alpha's size");
    interruptible([&] {
        bob::smooth_edges(items<bob::Pixel>(pixels), hits.data(), hits.shape(1), guides.data(), ground ? ground->data() : nullptr, height, width,
                          color.data(), alpha.data());
    });
}

bob::SeenSurfaces seen_surfaces(const bob::LightHistory& history, const ConstPlanes& guides, const std::optional<ConstPlanes>& ground) {
    const auto has_size = [&](const ConstPlanes& planes, std::size_t count) {
        return planes.shape(0) == count && planes.shape(1) == static_cast<std::size_t>(history.height()) &&
               planes.shape(2) == static_cast<std::size_t>(history.width());
    };
    expect(has_size(guides, 7) && (!ground || has_size(*ground, 7)), "guides: expected 7 planes of the picture's size");
    return {guides.data(), ground ? ground->data() : nullptr};
}

/// Traces paths through pixels, adds them to the history, and returns the samples, (n, 11) in the order of its planes.
auto trace_into(bob::LightHistory& history, const bob::Lighting& lighting, const bob::Camera& camera, const Pixels& pixels,
                const Array<const std::uint32_t, -1>& first, std::uint32_t count, std::uint64_t seed, bool at_rest, const ConstPlanes& guides,
                const std::optional<ConstPlanes>& ground) {
    check_pixels(pixels, history.height(), history.width());
    expect(first.shape(0) == pixels.shape(0) && count >= 1, "first: expected one for each pixel, and paths");
    const bob::SeenSurfaces surfaces = seen_surfaces(history, guides, ground);
    const std::size_t n = pixels.shape(0);
    const bob::Layout& layout = bob::LightHistory::layout();
    auto samples = make_array<float, -1, -1>(n, layout.width());
    interruptible([&] {
        std::vector<float> changes(n);
        lighting.trace(camera, history.height(), history.width(), items<bob::Pixel>(pixels), {items<std::uint32_t>(first), count, seed}, layout, samples.data(),
                       changes.data());
        std::vector<bob::LightHistory::Traced> traced(n);
        for (std::size_t i = 0; i < n; ++i) {
            traced[i] = bob::LightHistory::Traced::of(samples.data() + i * bob::LightHistory::plane_count, changes[i], count);
        }
        history.add(items<bob::Pixel>(pixels), traced, at_rest, surfaces);
    });
    return samples;
}

auto next_pixels(const bob::LightHistory& history, std::size_t count, std::uint32_t seed, bool at_rest, const ConstPlanes& guides,
                 const std::optional<ConstPlanes>& ground) {
    const bob::SeenSurfaces surfaces = seen_surfaces(history, guides, ground);
    std::vector<bob::Pixel> found;
    without_gil([&] { found = history.next(count, seed, at_rest, surfaces); });
    auto pixels = make_array<std::int32_t, -1, 2>(found.size(), 2);
    std::memcpy(pixels.data(), found.data(), found.size() * sizeof(bob::Pixel));
    return pixels;
}

}  // namespace

void bind_light(nb::module_& m) {
    nb::class_<bob::DiscLight>(m, "DiscLight",
        "`height` is that of its cap of the unit sphere, `color` the reflection of a white, rough surface that faces it.")
        .def("__init__", [](bob::DiscLight* self, const std::array<float, 3>& direction, float height, const std::array<float, 3>& color) {
            new (self) bob::DiscLight{vector_of(direction), height, vector_of(color)};
        }, "direction"_a, "height"_a, "color"_a);
    nb::class_<bob::Environment>(m, "Environment");
    m.def("environment", &environment, "texels"_a.noconvert(), "Of (H, W, 3), equirectangular. ValueError if it is too large.");
    nb::class_<bob::Lights>(m, "Lights")
        .def("__init__", &init_lights, "discs"_a, "top"_a, "bottom"_a, "environment"_a.none(), "turn"_a, "ground"_a.none(), "radius"_a, "bounces"_a);
    nb::class_<bob::Lighting>(m, "Lighting")
        .def(nb::init<const bob::Scene&, bob::Lights>(), "scene"_a, "lights"_a, nb::keep_alive<1, 2>())
        .def("trace", &trace, "camera"_a, "height"_a, "width"_a, "pixels"_a.noconvert(), "first"_a.noconvert(), "count"_a, "seed"_a, "apart"_a, "layout"_a,
             "samples"_a.noconvert(), "Writes samples (n, C), means of `count` paths from the one numbered `first` (n,) on.")
        .def("first_hits", &first_hits, "camera"_a, "planes"_a.noconvert(),
             "Writes (10, H, W): mask, depth, normal and albedo of the scene, mask and depth of the ground, `behind`.")
        .def("hits_at_edges", &hits_at_edges, "camera"_a, "planes"_a.noconvert(), "side"_a,
             "Pixels of first hits (10, H, W) whose neighbours differ, (n, 2), and the hits in them, (n, side**2, 10).");
    m.def("smooth_edges", &smooth_edges, "pixels"_a.noconvert(), "hits"_a.noconvert(), "guides"_a.noconvert(), "ground"_a.noconvert().none(),
          "color"_a.noconvert(), "alpha"_a.noconvert(),
          "Replaces color (3, H, W) and alpha (H, W) at edges by means over their hits, (n, k, 10).");
    m.def("studio_lights", [] {
        std::vector<std::tuple<double, double, double, std::array<double, 3>, double>> all;
        for (const bob::StudioLight& light : bob::studio_lights) all.emplace_back(light.azimuth, light.elevation, light.angle, light.color, light.intensity);
        return all;
    }, "Azimuth from the camera's, elevation, angle, colour and intensity of each disc.");
    m.def("studio_sky", [] { return std::tuple(bob::studio_sky.top, bob::studio_sky.bottom, bob::studio_sky.intensity); });
    m.attr("LIGHT_PATHS") = bob::MovingLight::paths;
    m.attr("EDGE_RAYS") = bob::MovingLight::edge_rays;
    m.attr("MOVING_EDGE_RAYS") = bob::MovingLight::moving_edge_rays;
    nb::class_<bob::LightPace>(m, "LightPace", "Number of pixels in a frame of moving light.")
        .def(nb::init<>())
        .def("pixels", &bob::LightPace::pixels, "total"_a, "left"_a,
             "For a picture of so many pixels, and the time left after its first hits.")
        .def("traced", &bob::LightPace::traced, "pixels"_a, "time"_a)
        .def("completed", &bob::LightPace::completed, "time"_a);
    nb::class_<bob::LightHistory>(m, "LightHistory",
        "Paths on surfaces, at most one mean for each pixel. `guides` and `ground` are (7, H, W).")
        .def("__init__", [](bob::LightHistory* self, int height, int width) {
            expect(height >= 1 && width >= 1, "size: expected at least 1");
            new (self) bob::LightHistory(height, width);
        }, "height"_a, "width"_a)
        .def_prop_ro_static("layout", [](nb::handle) { return bob::LightHistory::layout(); })
        .def("__len__", &bob::LightHistory::size)
        .def("move", [](bob::LightHistory& self, const bob::Camera& camera, const ConstPlanes& guides, const std::optional<ConstPlanes>& ground) {
            const bob::SeenSurfaces surfaces = seen_surfaces(self, guides, ground);
            without_gil([&] { self.move(camera, self.height(), self.width(), surfaces); });
        }, "camera"_a, "guides"_a.noconvert(), "ground"_a.noconvert().none(), "Reprojects all samples for another camera.")
        .def("trace", &trace_into, "lighting"_a, "camera"_a, "pixels"_a.noconvert(), "first"_a.noconvert(), "count"_a, "seed"_a, "at_rest"_a,
             "guides"_a.noconvert(), "ground"_a.noconvert().none(),
             "Adds `count` paths to each pixel, and returns their means, (n, C) of the layout.")
        .def("next", &next_pixels, "count"_a, "seed"_a, "at_rest"_a, "guides"_a.noconvert(), "ground"_a.noconvert().none(),
             "The pixels that need paths most, (n, 2).")
        .def("write", [](const bob::LightHistory& self, const ConstPlanes& guides, const std::optional<ConstPlanes>& ground, const Planes& planes) {
            const bob::SeenSurfaces surfaces = seen_surfaces(self, guides, ground);
            expect(planes.shape(0) == bob::LightHistory::plane_count && planes.shape(1) == guides.shape(1) && planes.shape(2) == guides.shape(2),
                   "planes: expected the layout's, of the picture's size");
            without_gil([&] { self.write(surfaces, planes.data()); });
        }, "guides"_a.noconvert(), "ground"_a.noconvert().none(), "planes"_a.noconvert(),
             "Writes all samples to planes (C, H, W) of zeros.");
}
