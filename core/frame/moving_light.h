/// The light of a scene under a moving camera, picture by picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "light/edges.h"
#include "light/light_history.h"
#include "light/lighting.h"
#include "picture/camera.h"
#include "picture/gbuffer.h"

namespace bob {

/// Each picture finds the first hits of all pixels, reprojects earlier paths to them, traces new paths where these are missing, noisy or
/// old, and is completed along its surfaces. At rest, every pixel gets paths from this camera, then more where noise is visible. The last
/// picture does not depend on earlier cameras.
class MovingLight {
public:
    /// Paths of a pixel each time it is traced in motion. Orbits of 5 scenes, with the same number of paths in all: at 2 % of the
    /// pixels, SSIM is .9672 with 4, .9693 with 8, .9697 with 16, .9589 with 32; at 8 %, .9672, .9720, .9752 and .9758.
    static constexpr std::uint32_t paths = 16;
    /// Times that a pixel at rest is traced if more than this standard deviation of noise is left in it, in displayed sRGB 0..1. Mean square
    /// errors of three pictures fall by 20 to 34 % in 5 to 30 % more time; with 8 times, by another 4 to 9 %.
    static constexpr std::uint32_t noisy_passes = 4;
    static constexpr float visible_noise = 1 / 255.f;
    /// Rays of first hits at edges, down and across a pixel, and the same until the camera rests. SSIM of 5 scenes: of a first
    /// picture .9580 with 1, .9659 with 2, .9674 with 4, .9672 with 8; moving .9617 with 1, .9697 with 2, .9712 with 4, in 1.8, 1.9
    /// and 2.2 s of processor time.
    static constexpr int edge_rays = 4, moving_edge_rays = 2;

    /// The scene lives longer.
    MovingLight(const Scene& scene, Lights lights, std::uint64_t seed) : lighting_(scene, std::move(lights)), seed_(seed) {}

    /// Turns to a camera and a size, whose first hits are found.
    void move(const Camera& camera, int height, int width);

    /// The camera rests: each pixel waits for paths from this camera.
    void rest();

    /// A pixel, and the number of paths that it had from this camera.
    struct Wanted {
        Pixel pixel;
        std::uint32_t drawn;
    };
    /// The pixels to trace next, at most `count`. At rest, waiting ones come first, then noisy ones.
    [[nodiscard]] std::vector<Wanted> next(std::size_t count);

    /// The seed of this camera's paths.
    [[nodiscard]] std::uint64_t seed() const { return is_at_rest_ ? seed_ : seed_ + moves_; }

    /// Traces paths through pixels of a picture; their light is passed to `add`, possibly in another module.
    static void trace(const Lighting& lighting, const Camera& camera, int height, int width, std::span<const Wanted> wanted, std::uint32_t paths,
                      std::uint64_t seed, LightHistory::Traced* traced);
    void add(std::span<const Wanted> wanted, std::span<const LightHistory::Traced> traced);

    /// The three above for at most `count` pixels; returns their number.
    std::size_t trace_next(std::size_t count);

    /// Number of pixels that wait for paths from this camera.
    [[nodiscard]] std::size_t left() const { return left_; }

    /// Writes all samples, new and reprojected, to planes of LightHistory's layout, which must be 0.
    void write(float* planes) const;

    /// Writes the picture, completed along first hits. color: (3, height, width), linear RGB times coverage. alpha: (height, width), the
    /// coverage by surfaces and shadows. is_smooth: pixels at edges are means over their first hits. At rest, the first picture whose pixels
    /// all have paths tells which pixels wait for more.
    void complete(bool is_smooth, float* color, float* alpha);

    /// 1 where a pixel has paths of this camera, or shows nothing that needs any, (height, width).
    void write_mask(float* mask) const;

    [[nodiscard]] bool is_at_rest() const { return is_at_rest_; }
    [[nodiscard]] const Lighting& lighting() const { return lighting_; }

    /// First hits: at pixels' centres, (first_hit::count, height, width); of pixels at edges, (edges, hits_of_edge, first_hit::count).
    [[nodiscard]] std::span<const float> first_hits() const { return planes_; }
    [[nodiscard]] std::span<const Pixel> edges() const { return edges_; }
    [[nodiscard]] std::span<const float> hits_at_edges() const { return hits_; }
    [[nodiscard]] std::size_t hits_of_edge() const { return static_cast<std::size_t>(rays_) * static_cast<std::size_t>(rays_); }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }

private:
    [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(height_) * static_cast<std::size_t>(width_); }
    [[nodiscard]] SeenSurfaces surfaces() const { return {planes_.data(), planes_.data() + first_hit::ground * pixels()}; }
    [[nodiscard]] bool shows_something(std::size_t i) const { return planes_[i] > 0 || planes_[first_hit::ground * pixels() + i] > 0; }
    void look_at_edges(int rays);
    void begin_drawing();
    void wait_for_more(const std::vector<float>& noise);
    [[nodiscard]] bool waits(std::size_t i) const { return drawn_[i] < wanted_[i]; }

    Lighting lighting_;
    std::uint64_t seed_, moves_ = 0;
    std::uint32_t frames_ = 0;
    Camera camera_{};
    int height_ = 0, width_ = 0;
    bool is_at_rest_ = false;
    std::optional<LightHistory> history_;
    std::vector<float> planes_;  // (first_hit::count, height, width)
    std::vector<Pixel> edges_;
    int rays_ = 0;                     // of first hits at edges, down and across
    std::vector<float> hits_;          // (edges, hits_of_edge, first_hit::count)
    std::vector<std::uint32_t> drawn_, wanted_; // paths of each pixel from this camera
    std::size_t left_ = 0;
    bool is_noise_known_ = false;
};

}  // namespace bob
