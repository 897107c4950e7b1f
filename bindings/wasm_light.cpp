/// Light in the WebAssembly modules: the studio or a scene's own lights around it, and its pictures.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "frame/light_pace.h"
#include "frame/moving_light.h"
#include "light/studio.h"
#include "wasm.h"

namespace {

struct PageLight {
    bob::Lights lights;
    std::optional<bob::MovingLight> moving;
    /// In milliseconds. Pages take 0.2 to 1 µs for a pixel's first hit and its completing, and fill windows of any size.
    bob::LightPace pace{7e-4, bob::MovingScale::scales.back()};

    void begin(const bob::Scene& scene) { moving.emplace(scene, lights, 0); }
    [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(moving->height()) * static_cast<std::size_t>(moving->width()); }
};

PageLight* light_in(const bob::Scene& scene, bob::Lights lights, bool has_ground, double radius) {
    lights.has_ground = has_ground, lights.radius = radius;
    auto light = std::make_unique<PageLight>(PageLight{std::move(lights)});
    light->begin(scene);
    return light.release();
}

/// A sky's numbers, in order; `turn` in radians.
struct PageSky {
    bob::Vec3 top, bottom;
    float turn;
};

using Wanted = bob::MovingLight::Wanted;
using Traced = bob::LightHistory::Traced;
static_assert(sizeof(Wanted) == 3 * sizeof(std::int32_t) && sizeof(Traced) == 7 * sizeof(float));
static_assert(sizeof(bob::DiscLight) == 7 * sizeof(float) && sizeof(PageSky) == 7 * sizeof(float));

}  // namespace

/// The studio, set up for a camera of this azimuth, in degrees. The scene lives longer; radius: of the scene, in its units.
EXPORT(make_studio) PageLight* make_studio(const bob::Scene* scene, double azimuth, bool has_ground, double radius) {
    return attempt([&] { return light_in(*scene, bob::studio(azimuth), has_ground, radius); });
}
/// A scene's own lights: `count` discs and a sky, whose environment is (height, width, 3) linear radiance, or has no rows.
EXPORT(make_lights)
PageLight* make_lights(const bob::Scene* scene, const bob::DiscLight* discs, std::size_t count, const PageSky* sky, const float* environment,
                       std::int32_t height, std::int32_t width, bool has_ground, double radius) {
    return attempt([&] {
        bob::Lights lights{{discs, discs + count}, {sky->top, sky->bottom, {}, std::cos(sky->turn), std::sin(sky->turn)}};
        if (height > 0) {
            const std::size_t texels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
            lights.sky.environment = std::make_shared<bob::Environment>(std::span(reinterpret_cast<const bob::Vec3*>(environment), texels), height, width);
        }
        return light_in(*scene, std::move(lights), has_ground, radius);
    });
}
EXPORT(free_light) void free_light(PageLight* light) { delete light; }
/// Forgets its pictures, for another scene; measurements stay.
EXPORT(renew_light) bool renew_light(PageLight* light, const bob::Scene* scene) {
    return attempt([&] {
        light->begin(*scene);
        return true;
    });
}

/// Finds the first hits of a camera, and reprojects earlier light.
EXPORT(move_light) bool move_light(PageLight* light, const float* camera, std::int32_t height, std::int32_t width) {
    return attempt([&] {
        light->moving->move(camera_of(camera), height, width);
        return true;
    });
}
/// The camera rests: each pixel waits for paths from this camera.
EXPORT(rest_light) bool rest_light(PageLight* light) {
    return attempt([&] {
        light->moving->rest();
        return true;
    });
}

/// Number of pixels for a picture with these milliseconds left after its first hits; at rest, for paths alone.
EXPORT(light_pixels) double light_pixels(const PageLight* light, double milliseconds) {
    const double completing = light->moving->is_at_rest() ? light->pace.for_completing() : 0;
    return static_cast<double>(light->pace.pixels(light->pixels(), milliseconds + completing));
}
EXPORT(light_traced) void light_traced(PageLight* light, double pixels, double milliseconds) {
    light->pace.traced(static_cast<std::size_t>(pixels), milliseconds);
}
/// The divisor of a moving picture's height and width, of `pixels` at 1.
EXPORT(light_scale) double light_scale(PageLight* light, double pixels, double milliseconds) {
    return light->pace.scale(static_cast<std::size_t>(pixels), milliseconds);
}
/// hits: milliseconds for first hits.
EXPORT(light_completed) void light_completed(PageLight* light, double hits, double milliseconds) {
    light->pace.completed(milliseconds);
    if (!light->moving->is_at_rest()) light->pace.shown(light->pixels(), hits + milliseconds);
}
/// Milliseconds for a pixel's paths; 0 before the first.
EXPORT(light_pixel_time) double light_pixel_time(const PageLight* light) { return light->pace.for_pixel(); }

/// The next pixels, (n, 3): row, column, and the number of paths before; valid until the next call. Writes n to `count`.
EXPORT(next_light) const Wanted* next_light(PageLight* light, double at_most, std::uint32_t* count) {
    return attempt([&] {
        static std::vector<Wanted> wanted;
        wanted = light->moving->next(static_cast<std::size_t>(at_most));
        *count = static_cast<std::uint32_t>(wanted.size());
        wanted.reserve(1);  // 0 would be a failure
        return wanted.data();
    });
}

/// Traces paths through pixels, (count, 3) of next_light, of any picture; traced: (count, 7), for add_light.
EXPORT(trace_light)
bool trace_light(const PageLight* light, const float* camera, std::int32_t height, std::int32_t width, const Wanted* wanted, std::size_t count,
                 std::uint32_t paths, double seed, Traced* traced) {
    return attempt([&] {
        bob::MovingLight::trace(light->moving->lighting(), camera_of(camera), height, width, {wanted, count}, paths, static_cast<std::uint64_t>(seed), traced);
        return true;
    });
}
EXPORT(light_seed) double light_seed(const PageLight* light) { return static_cast<double>(light->moving->seed()); }
EXPORT(light_paths) std::uint32_t light_paths() { return bob::MovingLight::paths; }

EXPORT(add_light) bool add_light(PageLight* light, const Wanted* wanted, std::size_t count, const Traced* traced) {
    return attempt([&] {
        light->moving->add({wanted, count}, {traced, count});
        return true;
    });
}
/// Number of pixels that wait for paths from this camera.
EXPORT(light_left) double light_left(const PageLight* light) { return static_cast<double>(light->moving->left()); }

/// Writes the completed picture: (4, height, width), linear RGB times coverage, and coverage.
EXPORT(complete_light) bool complete_light(PageLight* light, bool is_smooth, float* planes) {
    return attempt([&] {
        light->moving->complete(is_smooth, planes, planes + 3 * light->pixels());
        return true;
    });
}
/// Writes 1 where a pixel has, or needs no, paths of this camera, (height, width).
EXPORT(light_mask) void light_mask(const PageLight* light, float* mask) { light->moving->write_mask(mask); }
