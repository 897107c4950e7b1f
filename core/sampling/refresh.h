/// A pixel order for a picture with reprojected samples: it refreshes the samples most likely to be wrong.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "sampling/contrast.h"

namespace bob {

/// Orders pixels by the expected error of the current picture.
///
/// The priority of a pixel with a reprojected sample is its contrast with its neighbours: a sample off the pixel's
/// centre may be wrong along an edge. The priority of a pixel without a sample is the contrast of the known pixels
/// around it. Blue noise thins pixels of equal priority. Walter et al. 1999 also assign each pixel a priority and dither it.
class RefreshOrder {
public:
    RefreshOrder(std::uint32_t height, std::uint32_t width);

    /// Begins another picture.
    void begin(std::uint64_t seed);

    /// The next round towards `wanted` pixels: half of them, or all if they are few.
    ///
    /// The results of each round guide the next; yet each round has the cost of a pass over the picture. Returns
    /// untraced pixels in order of priority; empty if all are traced. `traced` and `picture` are planes, (C, height,
    /// width), of a layout; `picture` has the reprojected samples, overwritten by traced ones. `off_center`: (height,
    /// width), as from `History::expect`.
    std::span<const Pixel> next(const Layout& layout, const float* traced, const float* picture, const float* off_center,
                                std::size_t wanted);

    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }

private:
    using Bytes = std::vector<std::uint8_t>;

    /// A `ShadeRange` at each place of a grid, as planes of bytes.
    struct ShadeRanges {
        std::uint32_t height = 0, width = 0;
        std::array<Bytes, 3> low, high;
        Bytes missed, hit;  // 255 or 0

        void resize(std::uint32_t height, std::uint32_t width);
        [[nodiscard]] std::size_t size() const { return hit.size(); }
        [[nodiscard]] bool is_known(std::size_t i) const { return (missed[i] | hit[i]) != 0; }
    };
    static void halve(const ShadeRanges& fine, ShadeRanges& coarse);
    /// The union of the ranges at each place and its eight neighbours.
    void unite_neighbours(const ShadeRanges& ranges, ShadeRanges& around);

    /// The contrast of each union.
    void contrast_around(const ShadeRanges& ranges);

    void read(const Layout& layout, const float* picture);
    void weigh(const float* traced, const float* off_center);
    void choose(std::size_t count);

    static constexpr int levels = 6;

    std::uint32_t height_, width_;
    std::array<float, 64 * 64> noise_;  // a tile of blue noise, 0..1
    std::array<ShadeRanges, levels> ranges_;   // of the pixels when the last round was chosen, then of blocks of 2 x 2, 4 x 4, ...
    ShadeRanges around_;
    Bytes row_, contrast_;
    std::vector<float> guesses_;  // priority of pixels without a sample, by blocks of 2 x 2 pixels
    std::vector<float> areas_;    // and the reciprocals of the areas that share it
    std::vector<float> coarser_guesses_, coarser_areas_, row_guesses_, row_areas_;
    std::vector<float> priorities_;
    std::vector<std::uint32_t> histogram_;
    std::vector<Pixel> round_;
};

}  // namespace bob
