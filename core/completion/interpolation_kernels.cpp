#include "completion/interpolation_kernels.h"

#include <algorithm>
#include <limits>

#include "simd.h"

namespace bob::BOB_ISA {
namespace {

/// a where the condition holds, else b.
inline F select(M condition, F a, F b) { return (F)((condition & (M)a) | (~condition & (M)b)); }

inline F distance(F a, F b) { return max(a - b, b - a); }

/// Calls `use` for each vector of pixels, and for the rest, padded with zeros, with those of them that exist.
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

void begin(const float* mask, const float* traced, float* value, float* contrast, std::size_t pixels) {
    const F unknown = constant(std::numeric_limits<float>::infinity()), zero{};
    for_pixels<2, 2>({mask, traced}, {value, contrast}, pixels, [=](const F (&in)[2], F (&out)[2]) {
        const M is_traced = in[0] > zero;
        out[0] = select(is_traced, in[1], zero);
        out[1] = select(is_traced, zero, unknown);
    });
}

int between(const LatticeRow& row, int x, int end, int apart) {
    M ours{};
    for (int i = 0; i < lanes; i += apart) ours[i] = -1;
    const F zero{}, one = constant(1), two = constant(2), per_contrast = constant(row.weight_per_contrast);
    const F unknown = constant(std::numeric_limits<float>::infinity());
    for (; x + lanes <= end; x += lanes) {
        F value[4], contrast[4];
        for (int i = 0; i < 4; ++i) contrast[i] = load<F>(row.contrast + x + row.corners[i]);
        const M known = (max(max(contrast[0], contrast[1]), max(contrast[2], contrast[3])) < unknown) & ours;
        if (!bits(known)) continue;
        for (int i = 0; i < 4; ++i) value[i] = load<F>(row.value + x + row.corners[i]);
        const F means[2] = {(value[0] + value[1]) / two, (value[2] + value[3]) / two};
        const F contrasts[2] = {max(max(contrast[0], contrast[1]), distance(value[0], value[1])),
                                max(max(contrast[2], contrast[3]), distance(value[2], value[3]))};
        const M first = contrasts[0] <= contrasts[1];
        const F mean = select(first, means[0], means[1]);
        const F most = max(select(first, contrasts[0], contrasts[1]),
                           distance(means[0], means[1]) - select(first, contrasts[1], contrasts[0]) / two);
        const F weight = one - most * per_contrast;
        const M used = known & (weight > zero) & ~(load<F>(row.mask + x) > zero);
        store(row.value + x, select(used, mean, load<F>(row.value + x)));
        store(row.contrast + x, select(used, most, load<F>(row.contrast + x)));
        const F output = load<F>(row.output + x);
        store(row.output + x, select(used, output + (mean - output) * weight, output));
        if (row.weight) store(row.weight + x, select(used, weight, load<F>(row.weight + x)));
    }
    return x;
}

void keep(const float* mask, const float* traced, float low, float high, float* output, std::size_t pixels) {
    const F least = constant(low), most = constant(high), zero{};
    for_pixels<3, 1>({mask, traced, output}, {output}, pixels, [=](const F (&in)[3], F (&out)[1]) {
        const F clamped = select(in[2] > least, select(in[2] < most, in[2], most), least);
        out[0] = select(in[0] > zero, in[1], clamped);
    });
}

}  // namespace

const InterpolationKernels interpolation_kernels = {begin, between, keep};

}  // namespace bob::BOB_ISA
