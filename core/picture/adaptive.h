/// A pixel order that goes where the picture needs it: the lattice, refined where its pixels differ.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "picture/order.h"

namespace bob {

/// Decides round by round which pixels come next. Rounds end at fixed shares of the pixels, and nothing within a round
/// depends on what its own pixels show: so the sequence is a function of the seed, the size and what was traced, never of
/// time, pace or threads, and a tracer is called a few times with many pixels.
///
/// A pixel of the lattice (`lattice_tile`) lies in the middle of four pixels of the levels before it, its corners. It is
/// worth as much as these differ, times the area that it stands for; what changes within a square and is not seen at its
/// corners is found by the pixels that follow the lattice whatever they show, and then followed from square to square.
/// (Refinement of squares by contrast is Akimoto et al., "Pixel-Selected Ray Tracing", 1991.)
class AdaptiveOrder {
public:
    AdaptiveOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width);

    /// The next round: at least one pixel, or none where all were decided. All pixels of the rounds before have been
    /// traced; what they show is taken from the planes, (C, height, width) of a layout.
    std::span<const Pixel> next(const Layout& layout, const float* planes);

    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }

    /// Bytes in use.
    [[nodiscard]] std::size_t bytes() const;

private:
    enum class State : std::uint8_t { open, chosen, traced };

    /// How a pixel lies in the lattice.
    struct Place {
        std::int32_t step;  // to its corners, along both axes or along one
        bool diagonal;
        [[nodiscard]] std::uint32_t area() const { return static_cast<std::uint32_t>(step * step) << diagonal; }
    };
    static Place place(Pixel pixel);

    /// What a pixel shows, in 256 steps each: gray, whether it was hit, normal x, normal y.
    using Look = std::uint8_t __attribute__((vector_size(4)));

    void read(const Layout& layout, const float* planes);
    void choose(std::uint32_t index);
    /// Looks anew at those of which this pixel is a corner; they differ at least by so much.
    void look_around(std::uint32_t index, std::uint32_t least);
    void consider(Pixel pixel, Place place, std::uint32_t least);
    /// Looks at the pixels around one that was traced, as if they were of its own level, if it differs from its corners:
    /// what passes there may go on into a larger square without being seen at any corner of that.
    void look_beside(std::uint32_t index);
    /// Puts an open pixel where those of its worth wait; `at_least` leaves it where it waits for more.
    void wait(std::uint32_t index, std::uint32_t worth, bool at_least);
    /// How much differs what is known at some places around a pixel.
    [[nodiscard]] std::uint32_t contrast(Pixel pixel, std::int32_t step, bool sides, bool corners) const;
    [[nodiscard]] std::uint32_t index_of(Pixel pixel) const {
        return static_cast<std::uint32_t>(pixel.row) * width_ + static_cast<std::uint32_t>(pixel.column);
    }
    [[nodiscard]] Pixel pixel_at(std::uint32_t index) const {
        return {static_cast<std::int32_t>(index / width_), static_cast<std::int32_t>(index % width_)};
    }
    [[nodiscard]] bool is_inside(Pixel pixel) const {
        return static_cast<std::uint32_t>(pixel.row) < height_ && static_cast<std::uint32_t>(pixel.column) < width_;
    }

    static constexpr std::size_t queues = 176;

    std::uint32_t height_, width_, total_;
    Order lattice_;
    std::uint32_t of_lattice_ = 0;  // how many of its pixels were come to
    std::size_t rounds_ = 0;
    std::uint32_t decided_ = 0;
    std::vector<Pixel> round_;

    std::vector<State> states_;
    std::vector<Look> looks_;            // of traced pixels
    std::vector<std::uint8_t> queue_of_;  // of open pixels, where they were put last; 0 for nowhere
    std::array<std::vector<std::uint32_t>, queues> waiting_;  // by worth, 8 queues to a doubling
};

}  // namespace bob
