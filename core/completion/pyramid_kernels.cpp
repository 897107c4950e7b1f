#include "completion/pyramid_kernels.h"

#include <algorithm>

#include "simd.h"

namespace bob::BOB_ISA {
namespace {

constexpr float softness = 0.05f;  // SOFTNESS in pyramid.py

/// a where the condition holds, else 0.
inline F where(M condition, F a) { return (F)(condition & (M)a); }

/// The four pixels of each block.
struct Phases {
    F at[4];
};

inline F total(const Phases& p) { return (p.at[0] + p.at[1]) + (p.at[2] + p.at[3]); }

/// How far the phases' sum lies to the right of the middle, in halves of their distance.
inline F rightwards(const Phases& p) { return (p.at[1] + p.at[3]) - (p.at[0] + p.at[2]); }
inline F downwards(const Phases& p) { return (p.at[2] + p.at[3]) - (p.at[0] + p.at[1]); }

/// The blocks from column x on of two rows of pixels.
inline Phases blocks(const float* upper, const float* lower, int x) {
    const F a = load<F>(upper + 2 * x), b = load<F>(upper + 2 * x + lanes);
    const F c = load<F>(lower + 2 * x), d = load<F>(lower + 2 * x + lanes);
    return {{even(a, b), odd(a, b), even(c, d), odd(c, d)}};
}

/// 0 where all traced pixels of a block are background, else 1.
inline F shown_where(F count, F gray) { return where((count <= F{}) | (gray != F{}), constant(1)); }

inline void write_sums(const Rows& sums, int x, const F (&sum)[sums::shown]) {
    for (int c = 0; c < sums::shown; ++c) store(sums.at(c) + x, sum[c]);
    store(sums.at(sums::shown) + x, shown_where(sum[sums::count], sum[sums::gray]));
}

/// The same of a channel of the G-buffer, 0 where there are no pixels.
inline Phases blocks(const PixelRows& pixels, int channel, int x) {
    const int known = std::clamp(pixels.columns - 2 * x, 0, 2 * lanes);
    if (pixels.rows == 2 && known == 2 * lanes) return blocks(pixels.from.at(channel), pixels.from.at(channel, 1), x);
    float padded[2][2 * lanes] = {};
    for (int y = 0; y < pixels.rows; ++y) std::copy_n(pixels.from.at(channel, y) + 2 * x, known, padded[y]);
    return blocks(padded[0], padded[1], 0);
}

void pull_pixels(PixelRows pixels, Rows sums, int width) {
    const F half = constant(0.5f);
    for (int x = 0; x < width; x += lanes) {
        const auto block = [&](int channel) { return blocks(pixels, channel, x); };
        const Phases count = block(0);
        write_sums(sums, x, {total(count), total(block(1)), total(block(2)), total(block(3)), total(block(4)),
                             half * rightwards(count), half * downwards(count)});
    }
}

void pull(ConstRows finer, Rows sums, float quarter, int width) {
    const F q = constant(quarter);
    for (int x = 0; x < width; x += lanes) {
        const auto block = [&](int channel) { return blocks(finer.at(channel, 0), finer.at(channel, 1), x); };
        const Phases count = block(sums::count);
        F sum[sums::shown] = {total(count)};
        for (int c = sums::gray; c < sums::shown; ++c) sum[c] = total(block(c));
        sum[sums::right] = fma(q, rightwards(count), sum[sums::right]);
        sum[sums::down] = fma(q, downwards(count), sum[sums::down]);
        write_sums(sums, x, sum);
    }
}

/// The doubled picture's phases. Weights are 3/4 for a pixel and 1/4 for the nearer neighbour, in each direction.
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

void enlarge(Doubled coarse, ConstRows added, Rows gray, int width) {
    for (int x = 0; x < width; x += lanes) {
        const Phases p = doubled(coarse, x);
        for (int y = 0; y < 2; ++y) {
            const F left = p.at[2 * y], right = p.at[2 * y + 1];
            const float* from = added.at(0, y) + 2 * x;
            float* to = gray.at(0, y) + 2 * x;
            store(to, zip_low(left, right) + load<F>(from));
            store(to + lanes, zip_high(left, right) + load<F>(from + lanes));
        }
    }
}

/// Of a vector of blocks: one over the number of traced pixels, and what their mean gray is more than the gray so far.
struct Known {
    F per_pixel, surprise;
};

inline Known compare_blocks(F count, F sum, F gray) {
    const F one = constant(1), per_pixel = one / max(count, one);
    return {per_pixel, where(count > F{}, sum * per_pixel - gray)};
}

void know(ConstRows sums, Rows inputs, float* corrected, float side, int width) {
    const F per_side = constant(1 / side), one = constant(1);
    for (int x = 0; x < width; x += lanes) {
        const F gray = load<F>(inputs.at(0) + x);
        const F count = load<F>(sums.at(sums::count) + x);
        const auto [per_pixel, surprise] = compare_blocks(count, load<F>(sums.at(sums::gray) + x), gray);
        const auto mean = [&](int channel) { return load<F>(sums.at(channel) + x) * per_pixel; };
        const F known[] = {surprise, mean(sums::depth), mean(sums::normal_x), mean(sums::normal_y), count / (count + one),
                           mean(sums::right) * per_side, mean(sums::down) * per_side};
        int channel = 1;
        for (const F& v : known) store(inputs.at(channel++) + x, v);
        store(corrected + x, gray + surprise);
    }
}

void know_finest(PixelRows pixels, Rows inputs, float* corrected, float* shown, int width) {
    for (int x = 0; x < width; x += lanes) {
        const auto sum = [&](int channel) { return total(blocks(pixels, channel, x)); };
        const Phases mask = blocks(pixels, 0, x);
        const F count = total(mask), gray = sum(1), guess = load<F>(inputs.at(0) + x);
        const auto [per_pixel, surprise] = compare_blocks(count, gray, guess);
        store(inputs.at(1) + x, sum(3) * per_pixel);
        store(inputs.at(2) + x, sum(4) * per_pixel);
        for (int i = 0; i < 4; ++i) store(inputs.at(3 + i) + x, mask.at[i]);
        store(corrected + x, guess + surprise);
        store(shown + x, shown_where(count, gray));
    }
}

void spread(ConstRows shown, const float* coarser, float* surface, int width) {
    const auto maximum = [&](int x) {
        F result{};
        for (int y = -1; y <= 1; ++y) {
            for (int i = -1; i <= 1; ++i) result = max(result, load<F>(shown.at(0, y) + x + i));
        }
        return result;
    };
    for (int x = 0; x < width; x += 2 * lanes) {
        const F above = load<F>(coarser + x / 2);
        store(surface + x, twice_low(above) * maximum(x));
        store(surface + x + lanes, twice_high(above) * maximum(x + lanes));
    }
}

void compare(Doubled coarse, PixelRows pixels, ConstRows mask, Rows surprise, int width) {
    for (int x = 0; x < width; x += lanes) {
        const Phases expected = doubled(coarse, x), gray = blocks(pixels, 1, x);
        for (int i = 0; i < 4; ++i) {
            store(surprise.at(i) + x, load<F>(mask.at(i) + x) * (gray.at[i] - expected.at[i]));
        }
    }
}

/// 3x3 sums in phases by the Gaussian's weights 1, 2, 1 in each direction, not divided by 16.
inline Phases gaussian_sums(const ConstRows& phases, int x) {
    F upper[4], lower[4];  // down the columns 2x - 1, 2x, 2x + 1 and 2x + 2
    for (int i = 0; i < 4; ++i) {
        const int column = 1 - i % 2, at = x + (i + 1) / 2 - 1;
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

void finish(Doubled coarse, ConstRows mask, ConstRows surprise, ConstRows correction, const float* surface,
            PictureRows picture, int begin, int end) {
    const F least = constant(16 * softness);
    for (int x = begin; x < end; x += lanes) {
        const Phases start = doubled(coarse, x);
        const Phases total = gaussian_sums(surprise, x), weight = gaussian_sums(mask, x);
        const F present = load<F>(surface + x);
        F value[4];
        for (int i = 0; i < 4; ++i) {
            value[i] = start.at[i] + total.at[i] / (weight.at[i] + least) + load<F>(correction.at(i) + x);
            value[i] *= present;
        }
        for (int y = 0; y < picture.rows; ++y) {
            float* to = picture.row + picture.stride * y + 2 * x;
            const F first = zip_low(value[2 * y], value[2 * y + 1]), second = zip_high(value[2 * y], value[2 * y + 1]);
            if (2 * x + 2 * lanes <= picture.columns) {
                store(to, first);
                store(to + lanes, second);
            } else {
                float pixels[2 * lanes];
                store(pixels, first);
                store(pixels + lanes, second);
                std::copy_n(pixels, picture.columns - 2 * x, to);
            }
        }
    }
}

}  // namespace

const PyramidKernels pyramid_kernels = {pull_pixels, pull, enlarge, know, know_finest, spread, compare, finish};

}  // namespace bob::BOB_ISA
