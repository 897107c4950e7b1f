/// Pixel orders: sequences of the pixels of an image for tracing.
///
/// An order is a function of the seed and the size of the image. Any part is computed on its own, at a cost
/// proportional to its length.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "picture/gbuffer.h"

namespace bob {

/// A seeded random permutation of the pixels.
///
/// A Feistel network over a grid of about sqrt(n) x sqrt(n) for the n pixels, numbered row by row. A result outside
/// 0..n-1 is sent through again until it falls inside (Black and Rogaway, "Ciphers with Arbitrary Finite Domains",
/// 2002).
class UniformOrder {
public:
    UniformOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width);

    /// Writes the pixels at position `start` of the order and after.
    void operator()(std::uint32_t start, std::span<Pixel> pixels) const;

    /// The pixel at this position of the order, numbered row by row from the top left.
    [[nodiscard]] std::uint32_t operator()(std::uint32_t index) const;

private:
    static constexpr int rounds = 6;

    std::uint32_t width_, size_, columns_, rows_;
    std::uint32_t keys_[rounds];
};

/// The pixels of a tile of 64 x 64 that repeats without seams, in tracing order. A pixel's position in this order is
/// its rank.
struct Tile {
    static constexpr int bits = 6;
    static constexpr std::uint32_t side = 1u << bits, area = side * side;

    struct Place {
        std::uint8_t row, column;
    };
    std::array<Place, area> places;
    bool seeded;  ///< the seed shifts the tile
};

/// The row and column of the lattice's origin. It is about a third into each block of 64, 32, 16, ... pixels, never at
/// its corner: 21 is 5 mod 16 and mod 8, 1 mod 4 and mod 2.
inline constexpr int lattice_first = 21;

/// Nested square lattices, each half of the next and every second one turned by 45 degrees: quincunx refinement. The
/// seed does not shift it, so that a completion network can rely on its positions.
const Tile& lattice_tile();

/// Void and cluster: each further pixel is the one farthest from all earlier pixels (Ulichney, "The void-and-cluster
/// method for dither array generation", 1993). Computed on first use, in well under 0.3 s.
const Tile& blue_noise_tile();

/// An image covered by copies of a tile. Pixels of lower rank come first. Pixels of equal rank visit the tiles in long
/// steps from a first tile that the seed chooses for each rank.
class TiledOrder {
public:
    TiledOrder(const Tile& tile, std::uint64_t seed, std::uint32_t height, std::uint32_t width);

    /// Writes the pixels at position `start` of the order and after.
    void operator()(std::uint32_t start, std::span<Pixel> pixels) const;

private:
    /// A walk through rows x columns tiles, each once. It advances by `step` tiles, numbered row by row, and wraps
    /// around.
    struct Walk {
        std::uint32_t rows, columns, step;
    };

    [[nodiscard]] Tile::Place place(std::uint32_t rank) const;
    [[nodiscard]] const Walk& walk(Tile::Place place) const;

    const Tile& tile_;
    std::uint32_t key_, height_, width_;
    Tile::Place shift_{};
    Walk walks_[2][2];                   // indexed by place: the number of tiles whose place lies inside the image varies
    std::vector<std::uint32_t> starts_;  // of each rank, and the end
};

/// Writes the pixels at position `start` of the order and after; safe to call from several threads.
using Order = std::function<void(std::uint32_t start, std::span<Pixel> pixels)>;

/// The order named "uniform" or "lattice". Throws std::invalid_argument for any other name.
[[nodiscard]] Order make_order(std::string_view name, std::uint64_t seed, std::uint32_t height, std::uint32_t width);

}  // namespace bob
