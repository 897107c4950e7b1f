/// Pixel orders: sequences in which the pixels of an image are traced.
///
/// Each order is a function of the seed and the image's size, any part of which can be computed on its own, so that the
/// first pixels of an order cost only themselves.
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
/// A Feistel network over a grid of about sqrt(n) x sqrt(n) for the n pixels, numbered row by row; a number that falls
/// outside 0..n-1 is sent through again until it falls inside (Black and Rogaway, "Ciphers with Arbitrary Finite Domains",
/// 2002).
class UniformOrder {
public:
    UniformOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width);

    /// Writes the pixels that are traced as the start-th and after.
    void operator()(std::uint32_t start, std::span<Pixel> pixels) const;

    /// The pixel, row by row from the top left, that is traced as the index-th.
    [[nodiscard]] std::uint32_t operator()(std::uint32_t index) const;

private:
    static constexpr int rounds = 6;

    std::uint32_t width_, size_, columns_, rows_;
    std::uint32_t keys_[rounds];
};

/// The pixels of a tile of 64 x 64 that repeats without seams, in the sequence in which they are traced: the place of a
/// pixel in it is its rank.
struct Tile {
    static constexpr int bits = 6;
    static constexpr std::uint32_t side = 1u << bits, area = side * side;

    struct Place {
        std::uint8_t row, column;
    };
    std::array<Place, area> places;
    bool seeded;  ///< the seed shifts the tile
};

/// The row and the column from which the lattices go. Never at the corner of a block of 64, 32, 16, ... pixels but near its
/// third: 21 is 5 mod 16 and mod 8, 1 mod 4 and mod 2.
inline constexpr int lattice_first = 21;

/// Square lattices, each the half of the next one, every second of them turned by 45 degrees: quincunx refinement. The
/// seed does not shift it, so that a completing network can know where its pixels are.
const Tile& lattice_tile();

/// Ulichney, "The void-and-cluster method for dither array generation", 1993: each further pixel is the one farthest from
/// those before. Made when first asked for, in well under 0.3 s.
const Tile& blue_noise_tile();

/// An image covered by copies of a tile: pixels of lower rank come first; those of the same rank go from tile to tile in
/// far steps, from one that the seed chooses for each rank.
class TiledOrder {
public:
    TiledOrder(const Tile& tile, std::uint64_t seed, std::uint32_t height, std::uint32_t width);

    /// Writes the pixels that are traced as the start-th and after.
    void operator()(std::uint32_t start, std::span<Pixel> pixels) const;

private:
    /// How to go once through rows x columns tiles: each step goes on by that many, row by row and then from the start.
    struct Walk {
        std::uint32_t rows, columns, step;
    };

    [[nodiscard]] Tile::Place place(std::uint32_t rank) const;
    [[nodiscard]] const Walk& walk(Tile::Place place) const;

    const Tile& tile_;
    std::uint32_t key_, height_, width_;
    Tile::Place shift_{};
    Walk walks_[2][2];                   // in how many tiles a place lies within the image depends on the place
    std::vector<std::uint32_t> starts_;  // of each rank, and the end
};

/// Writes the pixels that are traced as the start-th and after; from several threads at once.
using Order = std::function<void(std::uint32_t start, std::span<Pixel> pixels)>;

/// The order of a name: "uniform" or "lattice". Throws std::invalid_argument if there is no such order.
[[nodiscard]] Order make_order(std::string_view name, std::uint64_t seed, std::uint32_t height, std::uint32_t width);

}  // namespace bob
