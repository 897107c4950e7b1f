#include "completion/interpolation_kernels.h"

#include <algorithm>
#include <limits>

#include "completion/blocks.h"
#include "simd.h"

namespace bob::BOB_ISA {
namespace {

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

void begin(const float* mask, const float* traced, float* value, std::size_t pixels) {
    const F zero{};
    for_pixels<2, 1>({mask, traced}, {value}, pixels, [=](const F (&in)[2], F (&out)[1]) { out[0] = select(in[0] > zero, in[1], zero); });
}

void begin_contrast(const float* mask, float* contrast, std::size_t pixels) {
    const F unknown = constant(std::numeric_limits<float>::infinity()), zero{};
    for_pixels<1, 1>({mask}, {contrast}, pixels, [=](const F (&in)[1], F (&out)[1]) { out[0] = select(in[0] > zero, zero, unknown); });
}

template <int Components>
int between_pixels(const LatticeRow& row, int x, int end, int apart) {
    M ours{};
    for (int i = 0; i < lanes; i += apart) ours[i] = -1;
    const F zero{}, one = constant(1), two = constant(2), per_contrast = constant(row.weight_per_contrast);
    const F unknown = constant(std::numeric_limits<float>::infinity());
    for (; x + lanes <= end; x += lanes) {
        F contrast[4];
        for (int i = 0; i < 4; ++i) contrast[i] = load<F>(row.contrast + x + row.corners[i]);
        const M known = (max(max(contrast[0], contrast[1]), max(contrast[2], contrast[3])) < unknown) & ours;
        if (!bits(known)) continue;
        F contrasts[2] = {max(contrast[0], contrast[1]), max(contrast[2], contrast[3])}, means[2][Components], off{};
        for (int c = 0; c < Components; ++c) {
            F value[4];
            for (int i = 0; i < 4; ++i) value[i] = load<F>(row.value + c * row.value_plane + x + row.corners[i]);
            for (int i = 0; i < 2; ++i) {
                contrasts[i] = max(contrasts[i], absolute(value[2 * i] - value[2 * i + 1]));
                means[i][c] = (value[2 * i] + value[2 * i + 1]) / two;
            }
            off = max(off, absolute(means[0][c] - means[1][c]));
        }
        const M first = contrasts[0] <= contrasts[1];
        const F most = max(select(first, contrasts[0], contrasts[1]), off - select(first, contrasts[1], contrasts[0]) / two);
        const F weight = one - most * per_contrast;
        const M used = known & (weight > zero) & ~(load<F>(row.mask + x) > zero);
        if (!bits(used)) continue;
        store(row.contrast + x, select(used, most, load<F>(row.contrast + x)));
        if (row.weight) store(row.weight + x, select(used, weight, load<F>(row.weight + x)));
        for (int c = 0; c < Components; ++c) {
            float *const value = row.value + c * row.value_plane + x, *const to = row.output + c * row.output_plane + x;
            const F mean = select(first, means[0][c], means[1][c]), output = load<F>(to);
            store(value, select(used, mean, load<F>(value)));
            store(to, select(used, output + (mean - output) * weight, output));
        }
    }
    return x;
}

int between(const LatticeRow& row, int x, int end, int apart) {
    return (row.components == 1 ? between_pixels<1> : between_pixels<3>)(row, x, end, apart);
}

void keep(const float* mask, const float* traced, float low, float high, float* output, std::size_t pixels) {
    const F least = constant(low), most = constant(high), zero{};
    for_pixels<3, 1>({mask, traced, output}, {output}, pixels, [=](const F (&in)[3], F (&out)[1]) {
        const F clamped = select(in[2] > least, select(in[2] < most, in[2], most), least);
        out[0] = select(in[0] > zero, in[1], clamped);
    });
}

}  // namespace

const InterpolationKernels interpolation_kernels = {begin, begin_contrast, between, keep};

}  // namespace bob::BOB_ISA
