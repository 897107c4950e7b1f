/// A pixel order that goes where the picture needs it: the lattice, refined where its pixels differ.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "sampling/contrast.h"
#include "sampling/order.h"
#include "sampling/rounds.h"

namespace bob {

/// Rounds end at fixed shares of the pixels.
///
/// A pixel of the lattice (`lattice_tile`) lies in the middle of four pixels of the levels before it, its corners. It is
/// worth as much as these differ, times the area that it stands for; what changes within a square and is not seen at its
/// corners is found by the pixels that follow the lattice whatever they show, and then followed from square to square.
/// Where surfaces are known of all pixels, one that is like none of its corners is worth as much as a silhouette.
/// (Refinement of squares by contrast is Akimoto et al., "Pixel-Selected Ray Tracing", 1991.)
class AdaptiveOrder final : public RoundOrder {
public:
    /// How alike the surface of another pixel is to a pixel's own: 1 where nothing differs, down to 0.
    using Likeness = std::function<float(Pixel own, Pixel other)>;

    /// `likeness` is of any two pixels of the picture, traced or not; without it, only what was traced decides.
    AdaptiveOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width, Likeness likeness = {});

    std::span<const Pixel> next(const Layout& layout, const float* planes) override;

    [[nodiscard]] std::size_t bytes() const override;

private:
    /// How a pixel lies in the lattice: 2^octave away from its corners, along both axes or along one.
    struct Place {
        int octave;
        bool diagonal;
        [[nodiscard]] std::int32_t step() const { return 1 << octave; }
        [[nodiscard]] int octave_of_area() const { return 2 * octave + diagonal; }
    };
    static Place place(Pixel pixel);

    /// The pixels of which one is a corner, some of them outside the picture, and how they lie; at octave -1 there are none.
    struct Children {
        std::array<Pixel, 4> pixels;
        Place place;
    };
    static Children children(Pixel pixel);

    /// Where a pixel is, or else in which queue it waits.
    static constexpr std::uint8_t nowhere = 0, chosen = 254, traced = 255;

    /// Takes what the last round shows.
    void read(const Layout& layout, const float* planes);
    /// Fills the round up to so many pixels from the lattice.
    void follow_lattice(std::size_t until);
    /// Looks anew at those of which this pixel is a corner: they have seen what it shows, or, before that is known, differ
    /// at least by so much.
    void look_around(Pixel pixel, const Look* look, std::uint32_t least);
    template <class AddCorners>
    void look_at(std::uint32_t index, Place at, const Look* look, std::uint32_t least, AddCorners add_corners);
    /// From the index of a pixel that lies so in the lattice to those of its corners.
    [[nodiscard]] std::array<std::uint32_t, 4> distances_around(Place at) const;
    /// Looks at the pixels around one that differs by so much from its corners, as if they were of its own level: what
    /// passes there may go on into a larger square without being seen at any corner of that.
    void look_beside(Pixel pixel, std::uint32_t contrast);
    /// The queue of pixels that differ by so much, and stand for so large an area.
    static std::uint8_t queue_of(std::uint32_t contrast, int octave_of_area);
    /// Puts an open pixel into a queue.
    void wait(std::uint32_t index, std::uint8_t queue);
    void add_corner(Look& known, std::uint32_t index) const;
    /// How much the surface of a pixel is unlike those of all corners that are traced or were chosen.
    [[nodiscard]] std::uint32_t unlike_corners(Pixel pixel, Place at) const;
    void prefetch(std::uint32_t index) const;
    void prefetch_children(Pixel pixel) const;
    [[nodiscard]] std::uint32_t index_of(Pixel pixel) const {
        return static_cast<std::uint32_t>(pixel.row) * width_ + static_cast<std::uint32_t>(pixel.column);
    }
    [[nodiscard]] Pixel pixel_at(std::uint32_t index) const {
        return {static_cast<std::int32_t>(index / width_), static_cast<std::int32_t>(index % width_)};
    }
    [[nodiscard]] bool is_inside(Pixel pixel) const {
        return static_cast<std::uint32_t>(pixel.row) < height_ && static_cast<std::uint32_t>(pixel.column) < width_;
    }
    /// And so far from the picture's borders.
    [[nodiscard]] bool is_inside(Pixel pixel, std::int32_t by) const {
        return is_inside({pixel.row - by, pixel.column - by}) && is_inside({pixel.row + by, pixel.column + by});
    }

    /// Pixels that wait, the first come first.
    struct Queue {
        std::vector<std::uint32_t> pixels;
        std::size_t taken = 0;
    };
    static constexpr std::size_t queues = 176;

    std::uint32_t total_;
    Likeness likeness_;
    TiledOrder lattice_;
    std::vector<Pixel> of_lattice_;  // its next pixels
    std::uint32_t lattice_done_ = 0;
    std::size_t rounds_ = 0;
    std::uint32_t decided_ = 0;
    std::vector<Pixel> round_;
    std::vector<std::uint32_t> surprises_;  // by how much each pixel of the round differs from its corners

    std::vector<Look> looks_;  // of a traced pixel what it shows, of others the range of their corners, as far as they were looked at
    std::vector<std::uint8_t> where_;
    std::array<Queue, queues> waiting_;  // by worth, 8 queues to a doubling
};

}  // namespace bob
