#include "sampling/order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace bob {
namespace {

/// A bijective mix: each bit of the input affects every bit of the output. Wellons, "Prospecting for Hash Functions",
/// 2018: the two-round function of lowest bias.
std::uint32_t mix(std::uint32_t x) {
    x = (x ^ x >> 16) * 0x21f0aaad;
    x = (x ^ x >> 15) * 0xd35a2d97;
    return x ^ x >> 15;
}

/// A number in 0..size-1 from 32 random bits (Lemire, "Fast Random Integer Generation in an Interval", 2019).
std::uint32_t scale(std::uint32_t bits, std::uint32_t size) {
    return static_cast<std::uint32_t>(std::uint64_t{bits} * size >> 32);
}

std::uint32_t rotate(std::uint32_t value, std::uint32_t by, std::uint32_t size) {
    const std::uint32_t sum = value + by;
    return sum >= size ? sum - size : sum;
}

std::uint32_t key(std::uint64_t seed) {
    return mix(static_cast<std::uint32_t>(seed)) ^ static_cast<std::uint32_t>(seed >> 32);
}

/// A place in a tile, numbered row by row; rows past the last wrap to the top.
Tile::Place place_at(std::uint32_t index) {
    return {static_cast<std::uint8_t>(index / Tile::side % Tile::side), static_cast<std::uint8_t>(index % Tile::side)};
}

Tile make_lattice_tile() {
    Tile tile{{}, false};
    tile.places[0] = {lattice_first, lattice_first};
    std::uint32_t count = 1;
    const auto repeat = [&](std::uint32_t rows, std::uint32_t columns) {
        for (std::uint32_t i = 0; i < count; ++i) {
            const auto [row, column] = tile.places[i];
            tile.places[count + i] = {static_cast<std::uint8_t>((row + rows) % Tile::side),
                                      static_cast<std::uint8_t>((column + columns) % Tile::side)};
        }
        count *= 2;
    };
    for (std::uint32_t half = Tile::side / 2; half; half /= 2) {
        repeat(half, half);  // centres of the squares
        repeat(half, 0);     // middles of the sides, again centres of squares
    }
    return tile;
}

/// The chosen places of a tile and the energy at each place.
///
/// Energies are integers: additions are undone exactly, and every machine makes the same tile. They fall with the sixth
/// power of the distance. Ulichney's Gaussian orders places at one distance only; an order has to be even from the
/// first 0.1 % to the last.
class Crowd {
public:
    Crowd() {
        for (std::uint32_t i = 0; i < 2 * Tile::area; ++i) {
            const std::uint32_t row = i / (2 * Tile::side), column = i % Tile::side;
            const std::uint64_t y = std::min(row, Tile::side - row), x = std::min(column, Tile::side - column);
            const std::uint64_t d = y * y + x * x + 1;
            kernel_[i] = (std::uint64_t{1} << 48) / (d * d * d);
        }
    }

    void add(std::uint32_t place) {
        chosen_[place] = true;
        change(place, [](std::uint64_t energy, std::uint64_t by) { return energy + by; });
    }
    void remove(std::uint32_t place) {
        chosen_[place] = false;
        change(place, [](std::uint64_t energy, std::uint64_t by) { return energy - by; });
    }

    /// The chosen place of highest energy, and the free place of lowest energy.
    [[nodiscard]] std::uint32_t tightest_cluster() const {
        std::uint32_t best = 0;
        std::uint64_t max_energy = 0;
        for (std::uint32_t i = 0; i < Tile::area; ++i) {
            if (chosen_[i] && energy_[i] > max_energy) max_energy = energy_[best = i];
        }
        return best;
    }
    [[nodiscard]] std::uint32_t largest_void() const {
        std::uint32_t best = 0;
        std::uint64_t min_energy = ~std::uint64_t{0};
        for (std::uint32_t i = 0; i < Tile::area; ++i) {
            if (!chosen_[i] && energy_[i] < min_energy) min_energy = energy_[best = i];
        }
        return best;
    }

private:
    template <class Change>
    void change(std::uint32_t place, Change changed) {
        const std::uint32_t row = place / Tile::side, column = place % Tile::side;
        for (std::uint32_t r = 0; r < Tile::side; ++r) {
            const std::uint64_t* from = &kernel_[(r - row) % Tile::side * 2 * Tile::side + (Tile::side - column)];
            std::uint64_t* to = &energy_[r * Tile::side];
            for (std::uint32_t c = 0; c < Tile::side; ++c) to[c] = changed(to[c], from[c]);
        }
    }

    std::array<std::uint64_t, 2 * Tile::area> kernel_;  // rows of double length, so that they begin at any column
    std::array<std::uint64_t, Tile::area> energy_{};
    std::array<bool, Tile::area> chosen_{};
};

Tile make_blue_noise_tile() {
    constexpr std::uint32_t initial = Tile::area / 10;
    Crowd crowd;
    const UniformOrder random(0, Tile::side, Tile::side);
    for (std::uint32_t i = 0; i < initial; ++i) crowd.add(random(i));
    for (std::uint32_t from, to = Tile::area;; to = from) {  // from clusters to voids, until nothing changes
        crowd.remove(from = crowd.tightest_cluster());
        crowd.add(to = crowd.largest_void());
        if (from == to) break;
    }
    Tile tile{{}, true};
    Crowd rest = crowd;
    for (std::uint32_t i = initial; i-- > 0;) {
        const std::uint32_t place = rest.tightest_cluster();
        rest.remove(place);
        tile.places[i] = place_at(place);
    }
    for (std::uint32_t i = initial; i < Tile::area; ++i) {
        const std::uint32_t place = crowd.largest_void();
        crowd.add(place);
        tile.places[i] = place_at(place);
    }
    return tile;
}

}  // namespace

UniformOrder::UniformOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width)
    : width_(width), size_(height * width) {
    columns_ = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(size_))));
    columns_ = columns_ ? columns_ : 1;
    rows_ = (size_ + columns_ - 1) / columns_;
    std::uint32_t state = key(seed);
    for (auto& key : keys_) key = state = mix(state + 0x9e3779b9);
}

void UniformOrder::operator()(std::uint32_t start, std::span<Pixel> pixels) const {
    for (Pixel& pixel : pixels) {
        const std::uint32_t index = (*this)(start++);
        pixel = {static_cast<std::int32_t>(index / width_), static_cast<std::int32_t>(index % width_)};
    }
}

std::uint32_t UniformOrder::operator()(std::uint32_t index) const {
    do {
        std::uint32_t row = index / columns_, column = index % columns_;
        for (int round = 0; round < rounds; round += 2) {
            row = rotate(row, scale(mix(column ^ keys_[round]), rows_), rows_);
            column = rotate(column, scale(mix(row ^ keys_[round + 1]), columns_), columns_);
        }
        index = row * columns_ + column;
    } while (index >= size_);
    return index;
}

const Tile& lattice_tile() {
    static const Tile tile = make_lattice_tile();
    return tile;
}

const Tile& blue_noise_tile() {
    static const Tile tile = make_blue_noise_tile();
    return tile;
}

TiledOrder::TiledOrder(const Tile& tile, std::uint64_t seed, std::uint32_t height, std::uint32_t width)
    : tile_(tile), key_(mix(key(seed) + 0x9e3779b9)), height_(height), width_(width), starts_(Tile::area + 1) {
    if (tile.seeded) shift_ = place_at(key_);
    for (std::uint32_t i = 0; i < 2; ++i) {
        for (std::uint32_t j = 0; j < 2; ++j) {
            Walk& walk = walks_[i][j];
            walk = {height / Tile::side + i, width / Tile::side + j, 0};
            const std::uint32_t count = walk.rows * walk.columns;
            if (count == 0) continue;
            // Roberts' steps in both directions, if that walk visits all tiles.
            walk.step = static_cast<std::uint32_t>(0.7548776662 * walk.rows) * walk.columns +
                        static_cast<std::uint32_t>(0.5698402910 * walk.columns);
            while (std::gcd(walk.step, count) != 1) ++walk.step;
            walk.step %= count;
        }
    }
    for (std::uint32_t rank = 0; rank < Tile::area; ++rank) {
        const Walk& tiles = walk(place(rank));
        starts_[rank + 1] = starts_[rank] + tiles.rows * tiles.columns;
    }
}

void TiledOrder::operator()(std::uint32_t start, std::span<Pixel> pixels) const {
    auto rank = static_cast<std::uint32_t>(std::upper_bound(starts_.begin(), starts_.end(), start) - starts_.begin()) - 1;
    for (std::size_t done = 0; done < pixels.size(); ++rank) {
        const auto [rows, columns, step] = walk(place(rank));
        const std::uint32_t tiles = rows * columns;
        if (tiles == 0) continue;
        const auto skipped = static_cast<std::uint32_t>(start + done - starts_[rank]);
        const std::uint64_t first = scale(mix(key_ + rank * 0x9e3779b9), tiles);
        const auto tile = static_cast<std::uint32_t>((first + std::uint64_t{skipped} * step) % tiles);
        const Tile::Place within = place(rank);
        std::uint32_t row = tile / columns, column = tile % columns;
        const std::uint32_t row_step = step / columns, column_step = step % columns;
        for (Pixel& pixel : pixels.subspan(done, std::min<std::size_t>(tiles - skipped, pixels.size() - done))) {
            pixel = {static_cast<std::int32_t>(row * Tile::side + within.row),
                     static_cast<std::int32_t>(column * Tile::side + within.column)};
            column += column_step;
            const bool wraps = column >= columns;
            column -= wraps ? columns : 0;
            row += row_step + wraps;
            row -= row >= rows ? rows : 0;
        }
        done += std::min<std::size_t>(tiles - skipped, pixels.size() - done);
    }
}

Tile::Place TiledOrder::place(std::uint32_t rank) const {
    const auto [row, column] = tile_.places[rank];
    return {static_cast<std::uint8_t>((row + shift_.row) % Tile::side),
            static_cast<std::uint8_t>((column + shift_.column) % Tile::side)};
}

const TiledOrder::Walk& TiledOrder::walk(Tile::Place place) const {
    return walks_[place.row < height_ % Tile::side][place.column < width_ % Tile::side];
}

Order make_order(std::string_view name, std::uint64_t seed, std::uint32_t height, std::uint32_t width) {
    if (name == "uniform") return UniformOrder(seed, height, width);
    if (name == "lattice") return TiledOrder(lattice_tile(), seed, height, width);
    throw std::invalid_argument("order: expected one of uniform, lattice");
}

}  // namespace bob
