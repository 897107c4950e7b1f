/// Light that outlives its frame: it lies on surfaces, and most of it looks the same from everywhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"

namespace bob {

/// First hits at pixels' centres: (7, height, width) with mask, depth, normal and albedo, and (2, height, width) with mask and depth of
/// the ground, or null.
struct SeenSurfaces {
    const float* planes;
    const float* ground;
};

/// Samples of light at points of surfaces and of the ground, at most one for each pixel.
///
/// A sample is reprojected as a point, so that it never drifts. Where the new camera's first hits show another surface, it is dropped; so it is
/// where its view-dependent part may have changed visibly. Light of surfaces is kept divided by their albedo.
class LightHistory {
public:
    LightHistory(int height, int width);

    struct Traced {
        Vec3 color;
        float shadow, variance;
        float change;  // of the luminance for each radian that the eye turns by, at most
        std::uint32_t paths;
    };

    /// Moves all samples to the pixels of another camera.
    void move(const Camera& camera, const SeenSurfaces& surfaces);

    /// Adds paths to the samples at pixels. Of a camera at rest, the first ones take the place of what was reprojected.
    void add(std::span<const Pixel> pixels, std::span<const Traced> traced, bool at_rest, const SeenSurfaces& surfaces);

    /// The pixels that need paths most, at most `count`: those around which no sample is near, then noisy and old samples. At rest all
    /// pixels that this camera has not traced come first, then the noisy ones.
    [[nodiscard]] std::vector<Pixel> next(std::size_t count, std::uint32_t seed, bool at_rest, const SeenSurfaces& surfaces) const;

    /// Writes what is known to planes of its layout that are 0.
    enum Plane : std::size_t { mask, gray, depth, normal_x, normal_y, red, green, blue, shadow, variance, plane_count };
    void write(const SeenSurfaces& surfaces, float* planes) const;

    static const Layout& layout() {
        static const Layout all{channels::mask, channels::gray, channels::depth, channels::normal, channels::color, channels::shadow, channels::variance};
        return all;
    }

    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] std::size_t size() const { return samples_.size(); }

private:
    struct Sample {
        Vec3 position, normal, toward;  // the latter to the eye that saw it
        Vec3 light;                     // of surfaces over their albedo
        float shadow, variance, change;
        float paths;
        std::int32_t pixel;
        std::uint16_t age;  // moves since paths were last added
        bool on_ground, is_reprojected;
    };

    [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(height_) * static_cast<std::size_t>(width_); }
    static void merge(Sample& sample, const Sample& other);

    int height_, width_;
    Camera camera_;
    std::vector<Sample> samples_;
    std::vector<std::int32_t> at_;  // the sample of each pixel, or -1
};

}  // namespace bob
