#include "completion/filling_kernels.h"

#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

constexpr float softness = 0.05f;   // SOFTNESS in filling.py
constexpr float sharpness = 2.0f;   // SHARPNESS

/// The pixels of two rows, as counts of one pixel each.
struct Counts {
    Phases of[counts::channels];
};

inline Counts counts_of(const PixelRows& pixels, int x) {
    const Phases mask = blocks(pixels, 0, x), gray = blocks(pixels, 1, x);
    Counts result{{mask, {}, gray}};
    for (int i = 0; i < 4; ++i) result.of[counts::shown].at[i] = where(gray.at[i] != F{}, mask.at[i]);
    return result;
}

inline Counts counts_of(const ConstRows& finer, int x) {
    Counts result;
    for (int c = 0; c < counts::channels; ++c) result.of[c] = blocks(finer.at(c), finer.at(c, 1), x);
    return result;
}

template <class From>
inline void pull_from(const From& from, const Rows& sums, int width) {
    for (int x = 0; x < width; x += lanes) {
        const Counts finer = counts_of(from, x);
        for (int c = 0; c < counts::channels; ++c) store(sums.at(c) + x, total(finer.of[c]));
    }
}

void pull_pixels(PixelRows pixels, Rows sums, int width) { pull_from(pixels, sums, width); }
void pull(ConstRows finer, Rows sums, int width) { pull_from(finer, sums, width); }

template <class From>
inline void compare_with(const DoubledPair& coarse, const From& from, const Rows& to, int width) {
    for (int x = 0; x < width; x += lanes) {
        const Counts finer = counts_of(from, x);
        const auto compare = [&](const Doubled& expected, const Phases& count, const Phases& sum, int count_to, int sum_to) {
            const Phases mean = doubled(expected, x);
            for (int i = 0; i < 4; ++i) {
                store(to.at(count_to + i) + x, count.at[i]);
                store(to.at(sum_to + i) + x, sum.at[i] - count.at[i] * mean.at[i]);
            }
        };
        compare(coarse.coverage, finer.of[counts::traced], finer.of[counts::shown], surprise::traced, surprise::coverage);
        compare(coarse.gray, finer.of[counts::shown], finer.of[counts::gray], surprise::shown, surprise::gray);
    }
}

void compare(DoubledPair coarse, ConstRows finer, Rows to, int width) { compare_with(coarse, finer, to, width); }
void compare_pixels(DoubledPair coarse, PixelRows pixels, Rows to, int width) { compare_with(coarse, pixels, to, width); }

/// The doubled picture plus the surprise of a block's traced pixels. Without traced pixels, the mean surprise of its
/// neighbours.
inline Phases corrected(const Doubled& coarse, const ConstRows& from, int count, int sum, int x) {
    const F least = constant(16 * softness);
    Phases result = doubled(coarse, x);
    const Phases around = gaussian_sums(from, x, count), total = gaussian_sums(from, x, sum);
    for (int i = 0; i < 4; ++i) {
        const F here = load<F>(from.at(count + i) + x);
        const M known = here > F{};
        result.at[i] += select(known, load<F>(from.at(sum + i) + x), total.at[i]) / select(known, here, around.at[i] + least);
    }
    return result;
}

void correct(DoubledPair coarse, ConstRows from, Rows to, int width) {
    for (int x = 0; x < width; x += lanes) {
        const auto put = [&](int channel, const Phases& p) {
            for (int y = 0; y < 2; ++y) {
                float* row = to.at(channel, y) + 2 * x;
                store(row, zip_low(p.at[2 * y], p.at[2 * y + 1]));
                store(row + lanes, zip_high(p.at[2 * y], p.at[2 * y + 1]));
            }
        };
        put(filled::coverage, corrected(coarse.coverage, from, surprise::traced, surprise::coverage, x));
        put(filled::gray, corrected(coarse.gray, from, surprise::shown, surprise::gray, x));
    }
}

void finish(DoubledPair coarse, ConstRows from, PictureRows picture, int width) {
    const F zero{}, one = constant(1), slope = constant(sharpness), start = constant(0.5f - 0.5f * sharpness);
    for (int x = 0; x < width; x += lanes) {
        const Phases coverage = corrected(coarse.coverage, from, surprise::traced, surprise::coverage, x);
        Phases gray = corrected(coarse.gray, from, surprise::shown, surprise::gray, x);
        for (int i = 0; i < 4; ++i) gray.at[i] *= min(max(fma(slope, coverage.at[i], start), zero), one);
        store_blocks(picture, x, gray.at);
    }
}

}  // namespace

const FillingKernels filling_kernels = {pull_pixels, pull, compare, compare_pixels, correct, finish};

}  // namespace bob::BOB_ISA
