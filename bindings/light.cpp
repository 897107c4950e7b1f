/// Light: discs, skies, and their use in a scene.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "base/color.h"
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
                 std::shared_ptr<bob::Environment> environment, float turn, bool has_ground, double radius, int bounces) {
    new (self) bob::Lights{discs, {vector_of(top), vector_of(bottom), std::move(environment), std::cos(turn), std::sin(turn)},
                           has_ground, radius, bounces};
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
    auto hits = make_array<float, -1, -1, -1>(found.size(), side * side, bob::first_hit::count);
    interruptible([&] { lighting.first_hits_within(camera, height, width, found, side, hits.data()); });
    return {pixel_array(found), std::move(hits)};
}

void smooth_edges(const Pixels& pixels, const ConstPlanes& hits, const ConstPlanes& guides, const std::optional<ConstPlane>& ground, const Planes& color,
                  const Plane& alpha) {
    const int height = static_cast<int>(alpha.shape(0)), width = static_cast<int>(alpha.shape(1));
    check_pixels(pixels, height, width);
    expect(hits.shape(0) == pixels.shape(0) && hits.shape(2) == bob::first_hit::count, "hits: expected 10 numbers for each of a pixel's");
    expect(guides.shape(0) == 7 && color.shape(0) == 3, "planes: expected 7 of guides and 3 of color");
    expect(same_size(guides, alpha) && same_size(color, alpha) && (!ground || same_size(*ground, alpha)), "planes: expected alpha's size");
    interruptible([&] {
        bob::smooth_edges(items<bob::Pixel>(pixels), hits.data(), hits.shape(1), guides.data(), ground ? ground->data() : nullptr, height, width,
                          color.data(), alpha.data());
    });
}

/// The first hits of a picture, (10, H, W); its pixels at edges, (n, 2), and their first hits, (n, k, 10).
std::tuple<Array<float, -1, -1, -1>, Array<std::int32_t, -1, 2>, Array<float, -1, -1, -1>> first_hits_of(const bob::MovingLight& light) {
    auto planes = make_array<float, -1, -1, -1>(bob::first_hit::count, light.height(), light.width());
    auto hits = make_array<float, -1, -1, -1>(light.edges().size(), light.hits_of_edge(), bob::first_hit::count);
    std::ranges::copy(light.first_hits(), planes.data());
    std::ranges::copy(light.hits_at_edges(), hits.data());
    return {std::move(planes), pixel_array(light.edges()), std::move(hits)};
}

void expect_camera(const bob::MovingLight& light) { expect(light.height() > 0, "move: expected before all else"); }

void expect_size(const bob::MovingLight& light, const Planes& planes, std::size_t count) {
    expect_camera(light);
    expect(planes.shape(0) == count && planes.shape(1) == static_cast<std::size_t>(light.height()) &&
               planes.shape(2) == static_cast<std::size_t>(light.width()), "planes: expected the layout's, of the picture's size");
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
        .def("__init__", &init_lights, "discs"_a, "top"_a, "bottom"_a, "environment"_a.none(), "turn"_a, "has_ground"_a, "radius"_a, "bounces"_a);
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
    m.def("studio_lights", [](double azimuth) {
        std::vector<std::tuple<std::array<double, 3>, double, std::array<double, 3>, double>> all;
        for (const bob::StudioLight& light : bob::studio_lights) all.emplace_back(light.direction(azimuth), light.angle, light.color, light.intensity);
        return all;
    }, "azimuth"_a, "Direction, angle, colour and intensity of each disc, for a camera of this azimuth; angles in degrees.");
    m.def("studio_sky", [] { return std::tuple(bob::studio_sky.top, bob::studio_sky.bottom, bob::studio_sky.intensity); });
    m.attr("MIN_ALBEDO") = bob::min_albedo;
    m.attr("LIGHT_PATHS") = bob::MovingLight::paths;
    m.attr("NOISY_PASSES") = bob::MovingLight::noisy_passes;
    m.attr("VISIBLE_NOISE") = bob::MovingLight::visible_noise;
    m.attr("EDGE_RAYS") = bob::MovingLight::edge_rays;
    m.attr("MOVING_EDGE_RAYS") = bob::MovingLight::moving_edge_rays;
    nb::class_<bob::LightPace>(m, "LightPace", "Size of a frame of moving light, and number of its pixels that get paths.")
        .def(nb::init<>())
        .def("scale", &bob::LightPace::scale, "total"_a, "time"_a,
             "The divisor of a moving frame's height and width, for so many pixels at 1 and the time for the frame.")
        .def("shown", &bob::LightPace::shown, "pixels"_a, "time"_a, "Time for first hits and completing.")
        .def("pixels", &bob::LightPace::pixels, "total"_a, "left"_a,
             "For a picture of so many pixels, and the time left after its first hits.")
        .def("traced", &bob::LightPace::traced, "pixels"_a, "time"_a)
        .def("completed", &bob::LightPace::completed, "time"_a);
    nb::class_<bob::MovingLight>(m, "MovingLight", "The light of a scene under a moving camera, as core/frame/moving_light.h describes it.")
        .def(nb::init<const bob::Scene&, bob::Lights, std::uint64_t>(), "scene"_a, "lights"_a, "seed"_a, nb::keep_alive<1, 2>())
        .def_prop_ro_static("layout", [](nb::handle) { return bob::LightHistory::layout(); })
        .def("move", [](bob::MovingLight& self, const bob::Camera& camera, int height, int width) {
            expect(height >= 1 && width >= 1, "size: expected at least 1");
            interruptible([&] { self.move(camera, height, width); });
        }, "camera"_a, "height"_a, "width"_a, "Turns to a camera, whose first hits are found.")
        .def("rest", [](bob::MovingLight& self) {
            expect_camera(self);
            interruptible([&] { self.rest(); });
        }, "The camera rests: each pixel waits for paths from this camera.")
        .def_prop_ro("is_at_rest", &bob::MovingLight::is_at_rest)
        .def_prop_ro("size", [](const bob::MovingLight& self) { return std::tuple(self.height(), self.width()); }, "(height, width) of its picture.")
        .def("first_hits", &first_hits_of, "At pixels' centres, (10, H, W); the pixels at edges, (n, 2), and their first hits, (n, k, 10).")
        .def("trace_next", [](bob::MovingLight& self, std::size_t count) {
            expect_camera(self);
            std::size_t traced = 0;
            interruptible([&] { traced = self.trace_next(count); });
            return traced;
        }, "count"_a, "Chooses and traces at most `count` pixels; returns their number.")
        .def("write", [](const bob::MovingLight& self, const Planes& planes) {
            expect_size(self, planes, bob::LightHistory::plane_count);
            without_gil([&] { self.write(planes.data()); });
        }, "planes"_a.noconvert(), "Writes all samples to planes (C, H, W) of zeros, in the layout.")
        .def("write_mask", [](const bob::MovingLight& self, const Planes& mask) {
            expect_size(self, mask, 1);
            self.write_mask(mask.data());
        }, "mask"_a.noconvert(), "Writes 1 where a pixel has, or needs no, paths of this camera, (1, H, W).")
        .def("complete", [](bob::MovingLight& self, bool is_smooth, const Planes& picture) {
            expect_size(self, picture, 4);
            const std::size_t pixels = picture.shape(1) * picture.shape(2);
            interruptible([&] { self.complete(is_smooth, picture.data(), picture.data() + 3 * pixels); });
        }, "is_smooth"_a, "picture"_a.noconvert(), "Writes (4, H, W): linear RGB times coverage, and coverage by surfaces and shadows.");
}
