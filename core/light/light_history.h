/// Reprojection of light. Light is stored on surfaces; its diffuse part is the same from every direction.
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
/// A sample is reprojected as a point, so it never drifts. It is dropped if the new camera sees another surface there,
/// or if its view-dependent part may have changed visibly. Light of surfaces is stored divided by their albedo.
class LightHistory {
public:
    LightHistory(int height, int width);

    struct Traced {
        Vec3 color;
        float shadow, variance;
        float change;  // maximum change of luminance per radian of view direction
        std::uint32_t paths;

        /// Makes a pixel from the means of its paths, in the layout's order.
        static Traced of(const float* means, float change, std::uint32_t paths);
    };

    /// Moves all samples to the pixels of another camera, and of a picture of another size.
    void move(const Camera& camera, int height, int width, const SeenSurfaces& surfaces);

    /// Takes all samples for reprojected ones: a camera at rest replaces them by its own.
    void age();

    /// Adds paths to the samples at pixels. With a camera at rest, a pixel's first paths replace its reprojected sample.
    void add(std::span<const Pixel> pixels, std::span<const Traced> traced, bool at_rest, const SeenSurfaces& surfaces);

    /// At most `count` pixels in order of priority: those without a sample nearby, then noisy and old samples. At rest, pixels not yet
    /// traced by this camera come first, then noisy ones.
    [[nodiscard]] std::vector<Pixel> next(std::size_t count, std::uint32_t seed, bool at_rest, const SeenSurfaces& surfaces) const;

    /// Writes all samples to planes of its layout, which must be 0.
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
        Vec3 position, normal, toward;  // `toward` points to the eye
        Vec3 light;                     // divided by the surface's albedo
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
