/// A pixel order for cheap rays: squares whose pixels differ are divided, row by row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "sampling/contrast.h"
#include "sampling/rounds.h"

namespace bob {

/// Divides squares of pixels by the contrast of their corners.
///
/// The first round is every eighth pixel of every eighth row, the corners of squares. Further rounds divide squares
/// into four. Squares of the highest contrast come first, from the largest to the smallest, then squares of lower
/// contrast, then all others. By priority, the first round is every 16th pixel of every 16th row, and smaller squares
/// need more contrast to be divided as early.
///
/// The pixels of a round lie row by row, and one pass over the picture chooses them. Each pixel improves the picture
/// less than one of an `AdaptiveOrder`. Where rays are cheap, the larger number of pixels per second outweighs that. A
/// round cut short by time leaves the picture finer at the top.
///
/// After Akimoto et al., "Pixel-Selected Ray Tracing", 1991.
class SquaresOrder final : public RoundOrder {
public:
    /// Squares to divide first: by contrast, or by contrast times area.
    enum class First { contrast, priority };

    /// Final samples are read once, others before each division.
    enum class Samples { change, are_final };

    /// Pixels with a nonzero mask in `traced`, (height, width), are traced already; null if no pixel is, as it must be
    /// for final samples.
    SquaresOrder(std::uint32_t height, std::uint32_t width, const float* traced = nullptr, First first = First::contrast,
                 Samples samples = Samples::change);

    std::span<const Pixel> next(const Layout& layout, const float* planes) override;

    [[nodiscard]] std::size_t bytes() const override;

private:
    /// Squares of `side` pixels whose corners form a lattice.
    struct Squares {
        explicit Squares(std::uint32_t side);

        /// Number of rows, or columns, of the lattice in a picture. There is one more row of squares: the squares at
        /// the borders are cut, or empty.
        [[nodiscard]] std::uint32_t lines(std::uint32_t size) const { return (size + side - 1 - first) / side; }

        std::uint32_t side, first;
    };

    /// The squares of one size, row by row, with their traced corners.
    struct Level {
        Level(std::uint32_t side, std::uint32_t height, std::uint32_t width)
            : squares(side), down(squares.lines(height) + 1), across(squares.lines(width) + 1), corners(std::size_t{down} * across),
              contrasts(corners.size()), is_whole(corners.size(), 1) {}

        /// Adds a pixel to the squares that it is a corner of.
        void add(std::uint32_t row, std::uint32_t column, const ShadeRange& sample);

        Squares squares;
        std::uint32_t down, across;
        std::vector<ShadeRange> corners;
        std::vector<std::uint8_t> contrasts;
        std::vector<std::uint8_t> is_whole;  // 0 once divided: all pixels of it are decided then
    };

    /// Reads the samples of the last round, for all levels.
    void read_round(const ShadeReader& shades_at);
    /// Reads the samples of all rounds again.
    void read_all(Level& level, const ShadeReader& shades_at);
    /// Makes a round that divides all squares of a level of at least this contrast.
    void divide(Level& level, std::uint8_t contrast);
    /// Chooses the corners and the middles between them in a row of the picture, next to squares to be divided: those
    /// with a 1 in one of two rows of squares.
    void decide_row(const Level& level, std::uint32_t row, const std::uint8_t* above, const std::uint8_t* below);

    /// The squares that a round divides.
    struct Division {
        std::uint32_t side;
        std::uint8_t contrast;
    };
    static const Division by_contrast[], by_priority[];

    std::span<const Division> divisions_;  // the first round traces the corners of the first division
    std::size_t rounds_ = 0;
    Samples samples_;
    std::vector<std::uint8_t> is_decided_;  // of each pixel
    std::vector<Pixel> round_;
    std::vector<Level> levels_;  // by size, the smallest first
    std::vector<std::uint8_t> is_next_;  // squares of a level to be divided
    std::vector<Pixel> in_row_;
};

}  // namespace bob
