/// An adaptive pixel order: the lattice, refined where the traced pixels differ.
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

/// An adaptive pixel order in rounds that end at fixed shares of the pixels.
///
/// Each pixel of the lattice (`lattice_tile`) is the centre of four pixels of earlier levels, its corners. Its priority
/// is the contrast of its corners, plus a step, times its area. A detail inside a square may miss all four corners.
/// Large squares of equal corners are divided before small ones of little contrast, and find such details; their
/// neighbours are then queued from square to square. Where the surfaces of all pixels are known, a pixel unlike all its
/// corners has the priority of a silhouette.
///
/// Refinement of squares by contrast is from Akimoto et al., "Pixel-Selected Ray Tracing", 1991.
class AdaptiveOrder final : public RoundOrder {
public:
    /// Similarity of the surfaces of two pixels: 1 if equal, down to 0.
    using Likeness = std::function<float(Pixel own, Pixel other)>;

    /// `likeness` accepts any two pixels of the picture, traced or not. If omitted, only traced samples decide.
    AdaptiveOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width, Likeness likeness = {});

    std::span<const Pixel> next(const Layout& layout, const float* planes) override;

    [[nodiscard]] std::size_t bytes() const override;

private:
    /// Position of a pixel in the lattice: 2^octave pixels from its corners, along both axes or along one.
    struct Place {
        int octave;
        bool diagonal;
        [[nodiscard]] std::int32_t step() const { return 1 << octave; }
        [[nodiscard]] int octave_of_area() const { return 2 * octave + diagonal; }
    };
    static Place place(Pixel pixel);

    /// The pixels that have a given pixel as a corner, and their place; some lie outside the picture. Empty if the
    /// octave is -1.
    struct Children {
        std::array<Pixel, 4> pixels;
        Place place;
    };
    static Children children(Pixel pixel);

    /// State of a pixel; any other value is the number of its queue.
    static constexpr std::uint8_t nowhere = 0, chosen = 254, traced = 255;

    /// Reads the samples of the last round.
    void read(const Layout& layout, const float* planes);
    /// Appends pixels of the lattice until the round has `until` pixels.
    void follow_lattice(std::size_t until);
    /// Updates the priority of the pixel's children. `sample` is the pixel's sample, or null before it is traced; then
    /// the children get at least the contrast `min_contrast`.
    void queue_children(Pixel pixel, const ShadeRange* sample, std::uint32_t min_contrast);
    template <class AddCorners>
    void queue_child(std::uint32_t index, Place at, const ShadeRange* sample, std::uint32_t min_contrast, AddCorners add_corners);
    /// Index offsets from a pixel at this place to its four corners.
    [[nodiscard]] std::array<std::uint32_t, 4> distances_around(Place at) const;
    /// Queues the neighbours of a surprising pixel at its own level. An edge found here may continue into a larger
    /// square and miss all its corners.
    void queue_neighbours(Pixel pixel, std::uint32_t contrast);
    /// The queue for this contrast and area.
    static std::uint8_t queue_of(std::uint32_t contrast, int octave_of_area);
    /// Moves an open pixel to a queue.
    void wait(std::uint32_t index, std::uint8_t queue);
    void add_corner(ShadeRange& known, std::uint32_t index) const;
    /// Difference, 0..255, of the pixel's surface from the most similar corner that is traced or chosen.
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
    /// Whether the pixel is in the picture and at least `by` pixels from its border.
    [[nodiscard]] bool is_inside(Pixel pixel, std::int32_t by) const {
        return is_inside({pixel.row - by, pixel.column - by}) && is_inside({pixel.row + by, pixel.column + by});
    }

    /// Waiting pixels, first in, first out.
    struct Queue {
        std::vector<std::uint32_t> pixels;
        std::size_t taken = 0;
    };
    static constexpr std::size_t queues = 176;

    std::uint32_t total_;
    Likeness likeness_;
    TiledOrder lattice_;
    std::vector<Pixel> of_lattice_;  // next pixels of the lattice
    std::uint32_t lattice_done_ = 0;
    std::size_t rounds_ = 0;
    std::uint32_t decided_ = 0;
    std::vector<Pixel> round_;
    std::vector<std::uint32_t> surprises_;  // contrast of each pixel of the round with its corners

    std::vector<ShadeRange> ranges_;  // the sample of a traced pixel; for others, the range of the corners read so far
    std::vector<std::uint8_t> where_;
    std::array<Queue, queues> waiting_;  // by priority, 8 queues per octave
};

}  // namespace bob
