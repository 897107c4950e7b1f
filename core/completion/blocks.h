/// Blocks of 2x2 pixels in vectors, for networks that halve and double pictures.
///
/// "Phases" are four vectors or channels with the pixels of each block, row by row.
#pragma once

#include <algorithm>

#include "base/simd.h"
#include "completion/rows.h"

namespace bob::BOB_ISA {

inline F absolute(F a) { return max(a, -a); }

/// a where the condition holds, else 0.
inline F where(M condition, F a) { return (F)(condition & (M)a); }
/// a where the condition holds, else b.
inline F select(M condition, F a, F b) { return (F)((condition & (M)a) | (~condition & (M)b)); }

/// The four pixels of each block.
struct Phases {
    F at[4];
};

inline F total(const Phases& p) { return (p.at[0] + p.at[1]) + (p.at[2] + p.at[3]); }

/// The blocks of a vector, as two rows of pixels in memory order.
struct RawBlocks {
    F upper[2], lower[2];

    [[nodiscard]] Phases phases() const {
        return {{even(upper[0], upper[1]), odd(upper[0], upper[1]), even(lower[0], lower[1]), odd(lower[0], lower[1])}};
    }
    /// Whether any pixel is above 0.
    [[nodiscard]] bool any() const { return bits(max(max(upper[0], upper[1]), max(lower[0], lower[1])) > F{}); }
};

/// Takes half the shuffles of `Phases::total`.
inline F total(const RawBlocks& raw) {
    const F left = raw.upper[0] + raw.lower[0], right = raw.upper[1] + raw.lower[1];
    return even(left, right) + odd(left, right);
}

/// Loads the blocks from column x on.
inline RawBlocks raw_blocks(const float* upper, const float* lower, int x) {
    return {{load<F>(upper + 2 * x), load<F>(upper + 2 * x + lanes)}, {load<F>(lower + 2 * x), load<F>(lower + 2 * x + lanes)}};
}
/// Loads the blocks of a channel of the G-buffer; 0 outside the picture.
inline RawBlocks raw_blocks(const PixelRows& pixels, int channel, int x) {
    const int known = std::clamp(pixels.columns - 2 * x, 0, 2 * lanes);
    if (pixels.rows == 2 && known == 2 * lanes) return raw_blocks(pixels.from.at(channel), pixels.from.at(channel, 1), x);
    float padded[2][2 * lanes] = {};
    for (int y = 0; y < pixels.rows; ++y) std::copy_n(pixels.from.at(channel, y) + 2 * x, known, padded[y]);
    return raw_blocks(padded[0], padded[1], 0);
}

inline Phases blocks(const float* upper, const float* lower, int x) { return raw_blocks(upper, lower, x).phases(); }
inline Phases blocks(const PixelRows& pixels, int channel, int x) { return raw_blocks(pixels, channel, x).phases(); }

/// The phases of the doubled picture. Bilinear weights: 3/4 for a pixel and 1/4 for the nearer neighbour in each
/// direction.
inline Phases doubled(const Doubled& coarse, int x) {
    const F near = constant(0.75f), far = constant(0.25f);
    F upper[3], lower[3];
    for (int i = 0; i < 3; ++i) {
        const F here = near * load<F>(coarse.here + x + i - 1);
        upper[i] = fma(far, load<F>(coarse.above + x + i - 1), here);
        lower[i] = fma(far, load<F>(coarse.below + x + i - 1), here);
    }
    return {{fma(far, upper[0], near * upper[1]), fma(far, upper[2], near * upper[1]),
             fma(far, lower[0], near * lower[1]), fma(far, lower[2], near * lower[1])}};
}

/// 3x3 sums in phases, from channel `first` on, with the Gaussian weights 1, 2, 1 in each direction. Not divided by 16.
inline Phases gaussian_sums(const ConstRows& phases, int x, int first = 0) {
    F upper[4], lower[4];  // down the columns 2x - 1, 2x, 2x + 1 and 2x + 2
    for (int i = 0; i < 4; ++i) {
        const int column = first + 1 - i % 2, at = x + (i + 1) / 2 - 1;
        const F above = load<F>(phases.at(2 + column, -1) + at), a = load<F>(phases.at(column) + at);
        const F b = load<F>(phases.at(2 + column) + at), below = load<F>(phases.at(column, 1) + at);
        const F both = a + b;
        upper[i] = (above + a) + both;
        lower[i] = both + (b + below);
    }
    const auto across = [](F left, F here, F right) { return (left + here) + (here + right); };
    return {{across(upper[0], upper[1], upper[2]), across(upper[1], upper[2], upper[3]),
             across(lower[0], lower[1], lower[2]), across(lower[1], lower[2], lower[3])}};
}

/// Stores the blocks from column x on.
inline void store_blocks(const PictureRows& picture, int x, const F (&phases)[4]) {
    for (int y = 0; y < picture.rows; ++y) {
        float* to = picture.row + picture.stride * y + 2 * x;
        const F first = zip_low(phases[2 * y], phases[2 * y + 1]), second = zip_high(phases[2 * y], phases[2 * y + 1]);
        if (2 * x + 2 * lanes <= picture.columns) {
            store(to, first);
            store(to + lanes, second);
        } else {
            float pixels[2 * lanes];
            store(pixels, first);
            store(pixels + lanes, second);
            std::copy_n(pixels, std::max(picture.columns - 2 * x, 0), to);
        }
    }
}

}  // namespace bob::BOB_ISA
