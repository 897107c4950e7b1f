#include "sampling/refresh.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <tuple>
#include <utility>

#include "sampling/order.h"

namespace bob {
namespace {

// Evidence: SSIM of orbits of 10 to 12 models at 320x240, 2 and 10 degrees a frame, means over 2, 5 and 10 % new pixels.

/// Increase of the weight of a reprojected sample's contrast per pixel of distance from the pixel's centre. SSIM falls by
/// .0003 with 1, by .0002 with 4; with 0, by .0018 over 10 models.
constexpr float off_center_by_one = 2;

/// Contrast of a pixel without any, in steps of 255. It must be above 0, so that all pixels are traced; 8 changes SSIM by
/// less than .0001, 32 lowers it by .0003.
constexpr float min_contrast = 1;

/// One round has all wanted pixels if these are at most one in `few` of the picture. With 32, SSIM falls by .0004, and
/// with a single round for any number by .0035; with 128 it rises by .0001, and with two rounds for any number orbits
/// take 1.5 times the processor time.
constexpr std::size_t few = 64;

/// Priorities are sorted without their lowest bits: by sixteenths of an octave. By quarters, SSIM falls by .0001.
constexpr int dropped_bits = 19;
std::uint32_t bin(float priority) { return std::bit_cast<std::uint32_t>(priority) >> dropped_bits; }

constexpr auto smaller = [](std::uint8_t a, std::uint8_t b) { return a < b ? a : b; };
constexpr auto larger = [](std::uint8_t a, std::uint8_t b) { return a > b ? a : b; };

/// Combines each place of a plane with its eight neighbours.
template <class Combine>
void around_each(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, std::vector<std::uint8_t>& row,
                 std::uint32_t height, std::uint32_t width, Combine combine) {
    row.resize(width);
    std::uint8_t* __restrict const column = row.data();  // without __restrict, each write might alias a read
    for (std::uint32_t r = 0; r < height; ++r) {
        const std::uint8_t* __restrict const here = from.data() + std::size_t{r} * width;
        const std::uint8_t* __restrict const above = r > 0 ? here - width : here;
        const std::uint8_t* __restrict const below = r + 1 < height ? here + width : here;
        for (std::uint32_t c = 0; c < width; ++c) column[c] = combine(combine(above[c], here[c]), below[c]);
        std::uint8_t* __restrict const result = to.data() + std::size_t{r} * width;
        result[0] = combine(column[0], column[width > 1 ? 1 : 0]);
        for (std::uint32_t c = 1; c + 1 < width; ++c) result[c] = combine(combine(column[c - 1], column[c]), column[c + 1]);
        if (width > 1) result[width - 1] = combine(column[width - 2], column[width - 1]);
    }
}

/// Combines blocks of 2 x 2 places.
template <class Combine>
void halve_each(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, std::uint32_t height, std::uint32_t width,
                Combine combine) {
    const std::uint32_t across = (width + 1) / 2;
    for (std::uint32_t r = 0; r < height; r += 2) {
        const std::uint8_t* __restrict const upper = from.data() + std::size_t{r} * width;
        const std::uint8_t* __restrict const lower = r + 1 < height ? upper + width : upper;
        std::uint8_t* __restrict const result = to.data() + std::size_t{r / 2} * across;
        for (std::uint32_t c = 0; c < width / 2; ++c) {
            result[c] = combine(combine(upper[2 * c], upper[2 * c + 1]), combine(lower[2 * c], lower[2 * c + 1]));
        }
        if (width % 2) result[width / 2] = combine(upper[width - 1], lower[width - 1]);
    }
}

}  // namespace

RefreshOrder::RefreshOrder(std::uint32_t height, std::uint32_t width)
    : height_(height), width_(width), noise_(), priorities_(std::size_t{height} * width) {
    static_assert(std::tuple_size_v<decltype(noise_)> == Tile::area);
    for (ShadeRanges& ranges : ranges_) {
        ranges.resize(height, width);
        height = (height + 1) / 2, width = (width + 1) / 2;
    }
    begin(0);
}

void RefreshOrder::begin(std::uint64_t seed) {
    const auto shift = static_cast<std::uint32_t>(seed * 0x9e3779b97f4a7c15 >> 40);
    for (std::uint32_t rank = 0; rank < Tile::area; ++rank) {
        const Tile::Place place = blue_noise_tile().places[rank];
        const std::uint32_t row = (place.row + shift) % Tile::side, column = (place.column + (shift >> Tile::bits)) % Tile::side;
        noise_[row * Tile::side + column] = (static_cast<float>(rank) + 0.5f) / static_cast<float>(Tile::area);
    }
    round_.clear();
}

void RefreshOrder::ShadeRanges::resize(std::uint32_t new_height, std::uint32_t new_width) {
    height = new_height, width = new_width;
    for (Bytes* const plane : {&low[0], &low[1], &low[2], &high[0], &high[1], &high[2], &missed, &hit}) {
        plane->resize(std::size_t{height} * width);
    }
}

void RefreshOrder::halve(const ShadeRanges& fine, ShadeRanges& coarse) {
    for (std::size_t k = 0; k < 3; ++k) {
        halve_each(fine.low[k], coarse.low[k], fine.height, fine.width, smaller);
        halve_each(fine.high[k], coarse.high[k], fine.height, fine.width, larger);
    }
    halve_each(fine.missed, coarse.missed, fine.height, fine.width, larger);
    halve_each(fine.hit, coarse.hit, fine.height, fine.width, larger);
}

void RefreshOrder::unite_neighbours(const ShadeRanges& ranges, ShadeRanges& around) {
    around.resize(ranges.height, ranges.width);
    for (std::size_t k = 0; k < 3; ++k) {
        around_each(ranges.low[k], around.low[k], row_, ranges.height, ranges.width, smaller);
        around_each(ranges.high[k], around.high[k], row_, ranges.height, ranges.width, larger);
    }
    around_each(ranges.missed, around.missed, row_, ranges.height, ranges.width, larger);
    around_each(ranges.hit, around.hit, row_, ranges.height, ranges.width, larger);
}

std::span<const Pixel> RefreshOrder::next(const Layout& layout, const float* traced, const float* picture, const float* off_center,
                                          std::size_t wanted) {
    read(layout, picture);
    weigh(traced, off_center);
    choose(wanted <= priorities_.size() / few ? wanted : (wanted + 1) / 2);
    return round_;
}

void RefreshOrder::read(const Layout& layout, const float* picture) {
    ShadeRanges& ranges = ranges_[0];
    std::uint8_t *const low[] = {ranges.low[0].data(), ranges.low[1].data(), ranges.low[2].data()},
                 *const high[] = {ranges.high[0].data(), ranges.high[1].data(), ranges.high[2].data()};
    ShadeReader(layout, picture, ranges.size()).read_all(picture, low, high, ranges.missed.data(), ranges.hit.data());
    for (std::size_t level = 1; level < levels; ++level) halve(ranges_[level - 1], ranges_[level]);
}

void RefreshOrder::contrast_around(const ShadeRanges& ranges) {
    unite_neighbours(ranges, around_);
    contrast_.resize(around_.size());
    // ShadeRange::contrast of all places at once; without __restrict, each write might alias a read.
    const std::uint8_t *const low0 = around_.low[0].data(), *const low1 = around_.low[1].data(), *const low2 = around_.low[2].data(),
                       *const high0 = around_.high[0].data(), *const high1 = around_.high[1].data(),
                       *const high2 = around_.high[2].data(), *const missed = around_.missed.data(), *const hit = around_.hit.data();
    std::uint8_t* __restrict const contrast = contrast_.data();
    const auto range = [](std::uint8_t low, std::uint8_t high) { return static_cast<std::uint16_t>(high > low ? high - low : 0); };
    for (std::size_t i = 0, size = around_.size(); i < size; ++i) {
        const std::uint8_t shades = ShadeRange::contrast_of(range(low0[i], high0[i]), range(low1[i], high1[i]), range(low2[i], high2[i]));
        contrast[i] = static_cast<std::uint8_t>(shades | (missed[i] & hit[i]));
    }
}

void RefreshOrder::weigh(const float* traced, const float* off_center) {
    // From the coarsest squares to the squares of 2 x 2 pixels. An unknown square inherits the estimate of its parent.
    guesses_.assign(1, min_contrast), areas_.assign(1, 0.f);
    std::uint32_t coarser_width = 1;
    for (std::size_t level = levels - 1; level > 0; --level) {
        contrast_around(ranges_[level]);
        coarser_guesses_.swap(guesses_), coarser_areas_.swap(areas_);
        guesses_.resize(around_.size()), areas_.resize(around_.size());
        const float area = 1 / static_cast<float>(std::uint32_t{1} << 2 * level);
        const bool is_coarsest = level == levels - 1;
        for (std::uint32_t row = 0, i = 0; row < around_.height; ++row) {
            for (std::uint32_t column = 0; column < around_.width; ++column, ++i) {
                const std::size_t coarser = is_coarsest ? 0 : std::size_t{row / 2} * coarser_width + column / 2;
                const bool is_known = around_.is_known(i);
                guesses_[i] = is_known ? min_contrast + static_cast<float>(contrast_[i]) : coarser_guesses_[coarser];
                areas_[i] = is_known ? area : coarser_areas_[coarser];
            }
        }
        coarser_width = around_.width;
    }

    contrast_around(ranges_[0]);
    row_guesses_.resize(width_ + 1), row_areas_.resize(width_ + 1);
    for (std::uint32_t row = 0; row < height_; ++row) {
        const std::size_t first = std::size_t{row} * width_, coarser = std::size_t{row / 2} * coarser_width;
        for (std::uint32_t k = 0; 2 * k < width_; ++k) {
            row_guesses_[2 * k] = row_guesses_[2 * k + 1] = guesses_[coarser + k];
            row_areas_[2 * k] = row_areas_[2 * k + 1] = areas_[coarser + k];
        }
        for (std::uint32_t begin = 0; begin < width_; begin += Tile::side) {
            const std::size_t from = first + begin;
            const float *const guess = row_guesses_.data() + begin, *const area = row_areas_.data() + begin,
                        *const noise = noise_.data() + std::size_t{row % Tile::side} * Tile::side, *const mask = traced + from,
                        *const off = off_center + from;
            const std::uint8_t *const missed = ranges_[0].missed.data() + from, *const hit = ranges_[0].hit.data() + from,
                               *const contrast = contrast_.data() + from;
            float* __restrict const priority = priorities_.data() + from;
            for (std::uint32_t k = 0, count = std::min(Tile::side, width_ - begin); k < count; ++k) {
                const bool is_known = (missed[k] | hit[k]) != 0;
                const float expected = min_contrast + static_cast<float>(contrast[k]) * (1 + off_center_by_one * off[k]);
                // The noise numbers the pixels of an area. The first gets its full priority, the second half of it, and
                // so on.
                const float shared = (is_known ? expected : guess[k]) / ((is_known ? 1.f : area[k]) + noise[k]);
                priority[k] = mask[k] != 0 ? 0.f : shared;
            }
        }
    }
}

void RefreshOrder::choose(std::size_t count) {
    histogram_.assign(bin(std::numeric_limits<float>::infinity()) + 1, 0);
    for (const float priority : priorities_) ++histogram_[bin(priority)];
    histogram_[0] = 0;  // already traced
    std::uint32_t last = static_cast<std::uint32_t>(histogram_.size());
    std::size_t above = 0;
    while (last > 1 && above + histogram_[last - 1] <= count) above += histogram_[--last];
    // All bins from `last` on; the rest of the round is spread evenly over the bin before.
    const std::size_t left = last > 1 ? count - above : 0, there = last > 1 ? histogram_[last - 1] : 0;
    std::size_t met = 0, size = 0;
    for (std::size_t k = histogram_.size(); k-- > last;) size += std::exchange(histogram_[k], static_cast<std::uint32_t>(size));
    if (last > 1) histogram_[last - 1] = static_cast<std::uint32_t>(size);
    round_.resize(size + left);
    for (std::uint32_t row = 0, i = 0; row < height_; ++row) {
        for (std::uint32_t column = 0; column < width_; ++column, ++i) {
            const std::uint32_t in = bin(priorities_[i]);
            if (in + 1 < last || in == 0) continue;
            if (in + 1 == last) {
                ++met;
                if (met * left / there == (met - 1) * left / there) continue;
            }
            round_[histogram_[in]++] = {static_cast<std::int32_t>(row), static_cast<std::int32_t>(column)};
        }
    }
}

}  // namespace bob
