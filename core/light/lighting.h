/// Light in a scene: paths from the camera to the lights, some for each pixel.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "light/dielectric.h"
#include "light/lights.h"
#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "tracing/scene.h"

namespace bob {

/// A run of each pixel's sequence.
struct Draws {
    std::span<const std::uint32_t> first;  // of each pixel: how many it had before
    std::uint32_t count;                   // at least 1
    std::uint64_t seed;                    // of the picture
    bool apart = false;                    // each through another point of the pixel, rather than all through its centre
};

class Lighting {
public:
    /// The scene must be in the unit sphere, and outlive this object.
    Lighting(const Scene& scene, Lights lights);

    /// Writes the means of `draws.count` paths through each pixel. `samples` is (n,
    /// layout.width()) of the channels mask, gray, depth, normal, color, albedo, shadow and variance; gray and color are of any range.
    /// A pixel's sample does not depend on the thread that traces it, nor on the other pixels. `changes`, one for each
    /// pixel or null, bounds the change of luminance per radian by which the eye turns: light of mirrors and highlights.
    /// Throws std::invalid_argument if there is another channel.
    void trace(const Camera& camera, int height, int width, std::span<const Pixel> pixels, const Draws& draws, const Layout& layout, float* samples,
               float* changes = nullptr) const;

    /// Writes the first hits through all pixels' centres, without their light: (first_hit::count, height, width). The ground's depth goes on
    /// below 0 behind the unit sphere.
    void first_hits(const Camera& camera, int height, int width, float* planes) const;

    /// Writes the first hits through the centres of side x side parts of some pixels, (pixels, side * side, first_hit::count).
    void first_hits_within(const Camera& camera, int height, int width, std::span<const Pixel> pixels, int side, float* hits) const;

private:
    struct Met;
    struct Memory;
    struct Place;
    class Paths;

    /// The ray through a place in the picture; false where it can meet nothing.
    bool sees(const Projection& projection, float row, float column, Ray& ray) const;

    /// Finds the first surface, the ground or the sky of each ray. Rays that don't want surfaces only learn whether there is one,
    /// or about a sheet.
    void meet(std::span<const Ray> rays, std::span<const float> widths, std::span<const std::uint8_t> wants, Memory& memory) const;

    /// Writes the first hits through places in the picture, whose rays are so wide a share of a pixel.
    void see(const Projection& projection, std::span<const Place> places, float share, float* hits) const;

    /// Replaces the first hits of smooth mirrors and glass by the first surfaces behind them that are neither.
    void look_behind(const Projection& projection, std::span<const Place> places, std::span<const std::size_t> number, std::span<const Ray> first,
                     std::span<const float> widths, Memory& memory, float* hits) const;

    [[nodiscard]] bool has_ground() const { return std::isfinite(ground_); }

    /// The index of refraction there, and the solids of glass around a camera.
    [[nodiscard]] float index(const Media& media) const;
    [[nodiscard]] Media media_around(const Projection& projection) const;

    const Scene& scene_;
    Lights lights_;
    bool has_glass_ = false, shows_things_ = false;
    std::vector<float> errors_;         // of each instance: how far above its surfaces rays start
    std::vector<std::uint8_t> sheets_;  // of each instance: whether it is a smooth sheet of glass
    float ground_;                      // its height; infinite without one
    float ground_light_;                // luminance of a white, rough, empty ground
    float radius_;                      // of the unit sphere, in the scene's units
};

}  // namespace bob
