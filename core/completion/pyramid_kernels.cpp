#include "completion/pyramid_kernels.h"

#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

constexpr float softness = 0.05f;  // SOFTNESS in pyramid.py

/// Offset of the phases' sum to the right of the block's centre, in halves of the phases' distance.
inline F rightwards(const Phases& p) { return (p.at[1] + p.at[3]) - (p.at[0] + p.at[2]); }
inline F downwards(const Phases& p) { return (p.at[2] + p.at[3]) - (p.at[0] + p.at[1]); }

/// 0 if all traced pixels of a block are background, else 1.
inline F shown_where(F count, F gray) { return where((count <= F{}) | (gray != F{}), constant(1)); }

inline void write_sums(const Rows& sums, int x, const F (&sum)[sums::shown]) {
    for (int c = 0; c < sums::shown; ++c) store(sums.at(c) + x, sum[c]);
    store(sums.at(sums::shown) + x, shown_where(sum[sums::count], sum[sums::gray]));
}

void pull_pixels(PixelRows pixels, Rows sums, int width) {
    const F half = constant(0.5f);
    for (int x = 0; x < width; x += lanes) {
        const RawBlocks mask = raw_blocks(pixels, 0, x);
        if (!mask.any()) {
            write_sums(sums, x, {});
            continue;
        }
        const auto sum = [&](int channel) { return total(raw_blocks(pixels, channel, x)); };
        const Phases count = mask.phases();
        write_sums(sums, x, {total(count), sum(1), sum(2), sum(3), sum(4), half * rightwards(count), half * downwards(count)});
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

/// For a vector of blocks: the reciprocal of the number of traced pixels, and their mean gray minus the current gray.
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
        const F guess = load<F>(inputs.at(0) + x);
        const RawBlocks raw_mask = raw_blocks(pixels, 0, x);
        if (!raw_mask.any()) {
            for (int c = 1; c < 7; ++c) store(inputs.at(c) + x, F{});
            store(corrected + x, guess);
            store(shown + x, constant(1));
            continue;
        }
        const auto sum = [&](int channel) { return total(raw_blocks(pixels, channel, x)); };
        const Phases mask = raw_mask.phases();
        const F count = total(mask), gray = sum(1);
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

void finish(Doubled coarse, ConstRows mask, ConstRows surprise, ConstRows correction, const float* surface,
            PictureRows picture, int begin, int end) {
    const F least = constant(16 * softness);
    for (int x = begin; x < end; x += lanes) {
        const M present = load<F>(surface + x) > F{};
        F value[4] = {};
        if (bits(present)) {
            const Phases start = doubled(coarse, x);
            const Phases total = gaussian_sums(surprise, x), weight = gaussian_sums(mask, x);
            for (int i = 0; i < 4; ++i) {
                value[i] = where(present, start.at[i] + total.at[i] / (weight.at[i] + least) + load<F>(correction.at(i) + x));
            }
        }
        store_blocks(picture, x, value);
    }
}

}  // namespace

const PyramidKernels pyramid_kernels = {pull_pixels, pull, enlarge, know, know_finest, spread, compare, finish};

}  // namespace bob::BOB_ISA
