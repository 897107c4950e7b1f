/// Samples outlive their frame: what earlier pictures of a scene say about the next one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "picture/camera.h"
#include "picture/channels.h"

namespace bob {

/// The surfaces and the empty places that earlier pictures have seen. Where a camera moves, points of the surfaces are seen
/// elsewhere: not at the centres of pixels, and perhaps behind something new. So they say what to expect in the next picture,
/// never what is known. (Walter, Drettakis, Parker, "Interactive Rendering using the Render Cache", 1999.)
class History {
public:
    /// Of pictures with the mask, depth and normals; the layout's other channels are carried as they are.
    History(const Layout& layout, std::uint32_t height, std::uint32_t width);

    /// Takes over what was traced with a camera, planes of the layout. It takes the place of what was expected there; if that
    /// was for another camera, everything before is forgotten.
    void add(const Camera& camera, const float* planes);

    /// What is expected in the picture of a camera, in planes of the layout: the mask is 1 where something is. `off_center`,
    /// (height, width), says how far from the pixel's centre that was seen, in pixels; of emptiness, a half. Returns at how
    /// many pixels a surface is expected: 0 after a jump, of which all before says nothing and is forgotten.
    std::size_t expect(const Camera& camera, float* planes, float* off_center);

    /// Forgets everything.
    void clear();

    [[nodiscard]] const Layout& layout() const { return layout_; }
    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }
    /// Bytes in use.
    [[nodiscard]] std::size_t bytes() const;

private:
    static constexpr std::uint32_t none = 0xffffffff;

    struct Point {
        Vec3 position, normal;
        std::uint32_t reach;  // how many pixels the disc covers that it stands for: about as far as the samples around it are apart
    };
    /// A point where a camera sees it.
    struct Sight {
        std::uint32_t point, pixel;
        std::int32_t row, column;
        float depth, deeper_right, deeper_down;  // how the depth changes from pixel to pixel
        float off_center;                        // squared, in pixels
        float tolerance;                         // points whose depths differ by less belong to one surface

        [[nodiscard]] float depth_at(float right, float down) const { return depth + deeper_right * right + deeper_down * down; }
    };

    /// The number of the pixel, or none.
    [[nodiscard]] std::uint32_t pixel_at(const Projection::Seen& seen) const;
    /// Counts what is known in the blocks of the picture.
    void count(const float* mask);
    /// Whether pixels from the i-th on were neither traced, nor is a surface expected there.
    [[nodiscard]] bool is_nothing_known(const float* mask, std::size_t i, std::uint32_t count) const;
    /// Of discs there.
    [[nodiscard]] std::uint32_t reach_at(std::uint32_t row, std::uint32_t column) const;
    void keep(std::uint32_t point, std::uint32_t reach);

    /// The points in the picture; `at_` is which of these sights is the nearest at each pixel.
    void see(const Projection& projection);
    /// What discs say of each pixel: how near they are, and in which directions the centres of those of its surface lie.
    void cover();
    /// Whether these lie on several sides: at a silhouette they all lie on one.
    [[nodiscard]] bool is_inside(std::size_t covered) const;
    /// Which of the points that are not hidden is expected at each pixel.
    void choose(const Projection& before);
    /// Nothing is known to be empty any more where other parts of a point's surface may have come with it.
    void overrun(const Sight& sight, const Projection& before);
    /// Where nothing was in a row, moved along.
    void expect_emptiness(const Projection& before, const Projection& projection, std::uint32_t row);
    /// Whether no surface reaches pixels from the i-th on.
    [[nodiscard]] bool is_nothing_here(std::size_t i, const std::uint8_t* sides, std::uint32_t count) const;
    [[nodiscard]] std::size_t covered_at(std::int32_t row, std::int32_t column) const;

    Layout layout_;
    std::vector<std::size_t> carried_components_;
    std::uint32_t height_, width_;
    Camera camera_;  // of the last picture

    std::vector<Point> points_, kept_points_;
    std::vector<float> carried_, kept_carried_;  // (n, components)
    std::vector<std::uint32_t> at_;              // which point is expected at each pixel
    std::vector<float> off_center_, depth_;      // of that; the former squared
    std::vector<std::uint32_t> beside_;          // points that are seen, but lie in the pixels of others
    std::vector<std::uint8_t> empty_, was_empty_;  // of each pixel, and 0 of what is outside
    std::vector<std::uint8_t> overrun_;
    std::vector<std::uint8_t> counts_;            // of blocks: pixels of which something is known
    std::vector<Sight> sights_;
    std::size_t in_picture_ = 0;         // points, also those that are turned away
    std::vector<float> nearest_;         // depths of discs, at the pixels and a border around them
    std::vector<std::uint8_t> sides_;    // there, a bit for each eighth of all directions
    std::vector<std::int32_t> steps_;    // from a disc's centre to the pixels that it covers
};

}  // namespace bob
