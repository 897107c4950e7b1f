#include "completion/interpolation_kernels.h"

#include <algorithm>
#include <limits>

#include "base/simd.h"
#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

/// Calls `use` for each whole vector of pixels. The last pixels are padded with zeros, and only existing ones are
/// stored.
template <int Inputs, int Outputs, class Use>
inline void for_pixels(const float* const (&from)[Inputs], float* const (&to)[Outputs], std::size_t pixels, Use use) {
    F in[Inputs], out[Outputs];
    std::size_t i = 0;
    for (; i + lanes <= pixels; i += lanes) {
        for (int k = 0; k < Inputs; ++k) in[k] = load<F>(from[k] + i);
        use(in, out);
        for (int k = 0; k < Outputs; ++k) store(to[k] + i, out[k]);
    }
    if (i == pixels) return;
    float padded[lanes] = {};
    for (int k = 0; k < Inputs; ++k) {
        std::copy_n(from[k] + i, pixels - i, padded);
        in[k] = load<F>(padded);
    }
    use(in, out);
    for (int k = 0; k < Outputs; ++k) {
        store(padded, out[k]);
        std::copy_n(padded, pixels - i, to[k] + i);
    }
}

/// Two vectors of pixels from column x on, 0 past the end of the row.
struct Pair {
    F first, second;

    Pair(const float* from, int columns, int x) {
        if (columns - x >= 2 * lanes) {
            first = load<F>(from + x), second = load<F>(from + x + lanes);
        } else {
            load_last(from + x, columns - x);
        }
    }

    [[nodiscard]] F phase(int odd_ones) const { return odd_ones ? odd(first, second) : even(first, second); }

private:
    [[gnu::noinline]] void load_last(const float* from, int count) {
        float padded[2 * lanes] = {};
        std::copy_n(from, count, padded);
        first = load<F>(padded), second = load<F>(padded + lanes);
    }
};

void halve(const TracedRow& whole, int components, int phase, float* to, std::size_t plane, Stretch some) {
    const TracedRow from = whole;  // a copy, which no store can alias
    for (int x = some.begin; x < some.end && 2 * x < from.columns; x += lanes) {
        const F mask = Pair(from.mask, from.columns, 2 * x).phase(phase);
        store(to + x, mask);
        if (!bits(mask > F{})) continue;
        BOB_KEEP_LOOP
        for (int c = 0; c < components; ++c) {
            const F value = Pair(from.value + static_cast<std::size_t>(c) * from.plane, from.columns, 2 * x).phase(phase);
            store(to + static_cast<std::size_t>(c + 1) * plane + x, value);
        }
    }
}

/// The mean of the four corners, and their contrast in `most` if that is larger. Not inlined, since few nodes need it.
[[gnu::noinline]] F mean_of_all(const NodesBetween& row, int component, int x, F& most) {
    F sum = load<F>(row.corners[0].value(component) + x), low = sum, high = sum;
    BOB_KEEP_LOOP
    for (int i = 1; i < 4; ++i) {
        const F corner = load<F>(row.corners[i].value(component) + x);
        sum += corner, low = min(low, corner), high = max(high, corner);
    }
    most = max(most, high - low);
    return sum * constant(0.25f);
}

template <int Components>
void make_nodes(const NodesBetween& given, Stretch some) {
    const NodesBetween row = given;
    const F zero{}, one = constant(1), half = constant(0.5f), per_contrast = constant(row.weight_per_contrast);
    const F unknown = constant(std::numeric_limits<float>::infinity());
    const TracedRow from = row.traced;
    for (int x = some.begin; x < some.end; x += lanes) {
        const M traced = Pair(from.mask, from.columns, 2 * x).phase(row.phase) > zero;
        F contrasts[2];  // of both pairs
        for (int i = 0; i < 2; ++i) contrasts[i] = max(load<F>(row.corners[2 * i].contrast + x), load<F>(row.corners[2 * i + 1].contrast + x));
        const F worst = max(contrasts[0], contrasts[1]);
        if (!bits(traced | (worst >= zero))) {
            store(row.to.contrast + x, constant(black));
            for (int c = 0; c < Components; ++c) store(row.to.value(c) + x, zero);
            continue;
        }
        const M known = (worst < unknown) & ~traced;
        F contrast = select(traced, zero, unknown), values[Components] = {};
        if (bits(known)) {
            F most = worst;
            if (row.by_pairs) {
                F means[2][Components], off{};
                for (int c = 0; c < Components; ++c) {
                    for (int i = 0; i < 2; ++i) {
                        const F a = load<F>(row.corners[2 * i].value(c) + x), b = load<F>(row.corners[2 * i + 1].value(c) + x);
                        contrasts[i] = max(contrasts[i], absolute(a - b));
                        means[i][c] = (a + b) * half;
                    }
                    off = max(off, absolute(means[0][c] - means[1][c]));
                }
                const M first = contrasts[0] <= contrasts[1];
                most = max(select(first, contrasts[0], contrasts[1]), off - select(first, contrasts[1], contrasts[0]) * half);
                for (int c = 0; c < Components; ++c) values[c] = select(first, means[0][c], means[1][c]);
            } else {
                BOB_KEEP_LOOP
                for (int c = 0; c < Components; ++c) values[c] = mean_of_all(row, c, x, most);
            }
            const M used = known & (one - most * per_contrast > zero);
            contrast = select(used, most, contrast);
            for (int c = 0; c < Components; ++c) values[c] = where(used, values[c]);
        }
        if (bits(traced)) {
            M shown{};
            for (int c = 0; c < Components; ++c) {
                const F value = Pair(from.value + static_cast<std::size_t>(c) * from.plane, from.columns, 2 * x).phase(row.phase);
                values[c] = select(traced, value, values[c]);
                shown |= values[c] != zero;
            }
            contrast = select(traced & ~shown, constant(black), contrast);
        }
        store(row.to.contrast + x, select(~traced & (worst < zero), constant(black), contrast));
        for (int c = 0; c < Components; ++c) store(row.to.value(c) + x, values[c]);
    }
}

void between(const NodesBetween& row, Stretch some) { (row.components == 1 ? make_nodes<1> : make_nodes<3>)(row, some); }

void zip(const float* even, const float* odd, float* to, Stretch some) {
    for (int x = some.begin; x < some.end; x += lanes) {
        const F left = load<F>(even + x), right = load<F>(odd + x);
        store(to + 2 * x, zip_low(left, right));
        store(to + 2 * x + lanes, zip_high(left, right));
    }
}

void improve(const ImprovedRow& given, Stretch some) {
    const ImprovedRow row = given;
    const F zero{}, one = constant(1), per_contrast = constant(row.weight_per_contrast);
    const F unknown = constant(std::numeric_limits<float>::infinity());
    for (int x = some.begin / 2; 2 * x < some.end; x += lanes) {
        const F even = load<F>(row.nodes[0].contrast + x), odd = load<F>(row.nodes[1].contrast + x);
        if (!bits((even < unknown) | (odd < unknown))) continue;
        const Pair mask(row.mask, row.columns, 2 * x);
        const bool is_whole = row.columns - 2 * x >= 2 * lanes;
        if (is_whole && !row.weight && !bits((even >= zero) | (odd >= zero) | (mask.first > zero) | (mask.second > zero))) {
            for (int c = 0; c < row.components; ++c) {
                float* const to = row.output + static_cast<std::size_t>(c) * row.plane + 2 * x;
                store(to, zero), store(to + lanes, zero);
            }
            continue;
        }
        const F contrasts[2] = {zip_low(even, odd), zip_high(even, odd)};
        const M traced[2] = {mask.first > zero, mask.second > zero};
        const M used[2] = {(contrasts[0] < unknown) & ~traced[0], (contrasts[1] < unknown) & ~traced[1]};
        const M put_back = row.put_back ? ~M{} : M{}, kept[2] = {traced[0] & put_back, traced[1] & put_back};
        const F weights[2] = {one - max(contrasts[0], zero) * per_contrast, one - max(contrasts[1], zero) * per_contrast};
        /// Stores only the pixels that exist.
        const auto set = [&](float* to, const M (&those)[2], auto value_of) {
            const Pair before(to, row.columns, 2 * x);
            const F first = select(those[0], value_of(0, before.first), before.first);
            const F second = select(those[1], value_of(1, before.second), before.second);
            if (is_whole) {
                store(to + 2 * x, first), store(to + 2 * x + lanes, second);
                return;
            }
            float padded[2 * lanes];
            store(padded, first), store(padded + lanes, second);
            std::copy_n(padded, row.columns - 2 * x, to + 2 * x);
        };
        if (row.weight) set(row.weight, used, [&](int i, F) { return weights[i]; });
        const M changed[2] = {used[0] | kept[0], used[1] | kept[1]};
        BOB_KEEP_LOOP
        for (int c = 0; c < row.components; ++c) {
            const F left = load<F>(row.nodes[0].value(c) + x), right = load<F>(row.nodes[1].value(c) + x);
            const F values[2] = {zip_low(left, right), zip_high(left, right)};
            set(row.output + static_cast<std::size_t>(c) * row.plane, changed,
                [&](int i, F output) { return select(kept[i], values[i], output + (values[i] - output) * weights[i]); });
        }
    }
}

void put_back(const TracedRow& traced, int components, float* output, std::size_t plane) {
    for (int x = 0; x < traced.columns; x += lanes) {
        const int count = std::min(traced.columns - x, lanes);
        if (count == lanes && !bits(load<F>(traced.mask + x) > F{})) continue;
        BOB_KEEP_LOOP
        for (int i = x; i < x + count; ++i) {
            if (!(traced.mask[i] > 0)) continue;
            BOB_KEEP_LOOP
            for (int c = 0; c < components; ++c) {
                output[static_cast<std::size_t>(c) * plane + i] = traced.value[static_cast<std::size_t>(c) * traced.plane + i];
            }
        }
    }
}

void keep(const float* mask, const float* traced, float low, float high, float* output, std::size_t pixels) {
    const F least = constant(low), most = constant(high), zero{};
    for_pixels<3, 1>({mask, traced, output}, {output}, pixels, [=](const F (&in)[3], F (&out)[1]) {
        const F clamped = select(in[2] > least, select(in[2] < most, in[2], most), least);
        out[0] = select(in[0] > zero, in[1], clamped);
    });
}

}  // namespace

const InterpolationKernels interpolation_kernels = {halve, between, zip, improve, put_back, keep};

}  // namespace bob::BOB_ISA
