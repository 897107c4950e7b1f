/// A pixel order for a picture of which something is expected: it goes where that may be wrong.
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

/// A pixel of which something is expected is worth as much as that differs from its neighbours, since what was seen beside a
/// pixel's centre may be wrong along an edge; one of which nothing is, as much as what is known around it differs; and both are
/// worth more where a ray has just found something else nearby. The most valuable come first; where they are worth the same,
/// a blue noise thins them out. (Walter et al. 1999 have such a priority for each pixel, and dither it.)
class RefreshOrder {
public:
    RefreshOrder(std::uint32_t height, std::uint32_t width);

    /// Begins another picture.
    void begin(std::uint64_t seed);

    /// The next round, where so many pixels are wanted: about half of these, or all where they are few, since what the first of
    /// them find says where the others go, but each round looks at all of the picture. Pixels that were not traced yet, the
    /// most valuable first; none where all were. `traced` and `picture` are planes, (C, height, width), of a layout: the latter has what is
    /// expected, and over it what was traced. `off_center`: (height, width), as of `History::expect`.
    std::span<const Pixel> next(const Layout& layout, const float* traced, const float* picture, const float* off_center,
                                std::size_t wanted);

    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }

private:
    using Bytes = std::vector<std::uint8_t>;

    /// A `Look` at each place of a grid, as planes of bytes.
    struct Looks {
        std::uint32_t height = 0, width = 0;
        std::array<Bytes, 3> low, high;
        Bytes missed, hit;  // 255 or 0

        void resize(std::uint32_t height, std::uint32_t width);
        [[nodiscard]] std::size_t size() const { return hit.size(); }
        [[nodiscard]] bool is_known(std::size_t i) const { return (missed[i] | hit[i]) != 0; }
        [[nodiscard]] Look at(std::size_t i) const;
    };
    static void halve(const Looks& fine, Looks& coarse);
    /// What is known at each place and the eight around it.
    void look_around(const Looks& looks, Looks& around);

    /// How much that differs.
    void contrast_around(const Looks& looks);

    void compare(const Layout& layout, const float* picture);
    void look(const Layout& layout, const float* picture);
    void weigh(const float* traced, const float* off_center);
    void choose(std::size_t count);

    static constexpr int levels = 6;

    std::uint32_t height_, width_;
    std::array<float, 64 * 64> noise_;  // 0..1, of a tile
    std::array<Looks, levels> looks_;   // of pixels, as they were when the last round was chosen, and of squares twice as large each
    Looks around_;
    Bytes row_, contrast_;
    Bytes surprises_;             // how much what was found nearby differs from what was expected
    std::vector<float> guesses_;  // of squares of two pixels a side: what pixels are worth of which nothing is expected
    std::vector<float> areas_;    // and the reciprocals of how many of these stand together
    std::vector<float> coarser_guesses_, coarser_areas_, row_guesses_, row_areas_;
    std::vector<float> worth_;
    std::vector<std::uint32_t> histogram_;
    std::vector<Pixel> round_;
};

}  // namespace bob
