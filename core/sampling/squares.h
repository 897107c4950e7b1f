/// A pixel order for rays that cost little: squares whose pixels differ are divided, row by row.
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

/// The first round is every eighth pixel of every eighth row, the corners of squares. Further rounds divide squares into four: first
/// those of which what is known differs most, from the largest to the smallest, then those that differ less, then all others. By
/// priority, the first round is every 16th pixel of every 16th row, and smaller squares must differ more to be divided as early. The
/// pixels of a round lie row by row, and one pass over the picture decides on them: where rays cost little, so many more of them
/// fit into a time than of an `AdaptiveOrder` that they show more, though each of these is worth more. Where time ends within
/// a round, the picture is finer above than below. (Akimoto et al., "Pixel-Selected Ray Tracing", 1991.)
class SquaresOrder final : public RoundOrder {
public:
    /// Which squares are divided first: those that differ most, or those of the largest difference times area.
    enum class First { contrast, priority };

    /// Of a picture of which the pixels whose mask is not 0, (height, width), are traced already; of none where that is null.
    SquaresOrder(std::uint32_t height, std::uint32_t width, const float* traced = nullptr, First first = First::contrast);

    std::span<const Pixel> next(const Layout& layout, const float* planes) override;

    [[nodiscard]] std::size_t bytes() const override;

private:
    /// Squares of so many pixels a side, whose corners are a lattice.
    struct Squares {
        explicit Squares(std::uint32_t side);

        /// How many rows, or columns, of the lattice a picture has. There is one row of squares more: those at its borders
        /// are cut, or empty.
        [[nodiscard]] std::uint32_t lines(std::uint32_t size) const { return (size + side - 1 - first) / side; }

        std::uint32_t side, first;
    };

    /// The round is what divides squares that differ by so much at least.
    void divide(const Squares& squares, std::uint32_t contrast, const Layout& layout, const float* planes);
    /// Whether each of a row of squares differs by so much at least.
    void compare(const Squares& squares, std::uint32_t y, std::uint32_t contrast, const LookReader& look_at);
    /// Corners and the middles between them, of a row of the picture, where squares beside them are to be divided.
    void decide_row(const Squares& squares, std::uint32_t row, const std::vector<std::uint8_t>& divided);

    void decide(std::uint32_t row, std::uint32_t column);

    /// Which squares a round divides.
    struct Division {
        std::uint32_t side, contrast;
    };
    static const Division by_contrast[], by_priority[];

    std::span<const Division> divisions_;  // the first pixels are the corners of the first one's
    std::size_t rounds_ = 0;
    std::vector<std::uint8_t> is_decided_;  // of each pixel
    std::vector<Pixel> round_;
    std::vector<Look> corners_above_, corners_below_;              // of a row of squares, an unknown one on either side
    std::vector<std::uint8_t> differs_, differs_above_, either_;  // of a row of squares, of that above it, and of both
};

}  // namespace bob
