#include "completion/guided_kernels.h"

#include "base/simd.h"
#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

/// Unknowns: 1, the position in the picture, and the normal unless all are on one plane.
constexpr int on_surfaces = 6, on_plane = 3;

/// Ridge of the slopes, as a share of the weight: without it, slopes from few samples are extrapolated; a larger one flattens light.
constexpr float place_ridge = 3e-3f, normal_ridge = 3e-3f;

/// Minimum weight of samples on other surfaces, used where no sample is on the same one.
constexpr float least_likeness = 1e-5f;

F square(F a) { return a * a; }

/// Sums over samples: the upper triangle of a symmetric matrix, and its right-hand sides.
template <int C, int unknowns>
struct Sums {
    F matrix[unknowns][unknowns], right[C][unknowns];
};

/// Light at the pixel, the first unknown; the others are eliminated from the last one on. Returns the part of the squared sums of
/// luminance that the fit explains.
template <int C, int unknowns>
inline F solve(Sums<C, unknowns>& s, F reach2, F* light) {
    const F total = s.matrix[0][0];
    F explained{};
    const auto explain = [&](int k, F inverse) {
        F of_luminance = s.right[0][k];
        if constexpr (C == 3) of_luminance = constant(0.2126f) * s.right[0][k] + constant(0.7152f) * s.right[1][k] + constant(0.0722f) * s.right[2][k];
        explained = fma(of_luminance * of_luminance, inverse, explained);
    };
    BOB_UNROLL
    for (int u = 1; u < unknowns; ++u) s.matrix[u][u] += total * (u < 3 ? reach2 * constant(place_ridge) : constant(normal_ridge));
    BOB_UNROLL
    for (int k = unknowns - 1; k > 0; --k) {
        const F inverse = constant(1) / s.matrix[k][k];
        explain(k, inverse);
        BOB_UNROLL
        for (int u = 0; u < k; ++u) {
            const F factor = s.matrix[u][k] * inverse;
            BOB_UNROLL
            for (int v = 0; v <= u; ++v) s.matrix[v][u] -= factor * s.matrix[v][k];
            BOB_UNROLL
            for (int c = 0; c < C; ++c) s.right[c][u] -= factor * s.right[c][k];
        }
    }
    BOB_UNROLL
    for (int c = 0; c < C; ++c) light[c] = s.right[c][0] / s.matrix[0][0];
    explain(0, constant(1) / s.matrix[0][0]);
    return explained;
}

template <int C, int unknowns>
void fit(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
         const GuidedRow& row, int count, bool is_noisy) {
    F place;
    for (int i = 0; i < lanes; ++i) place[i] = static_cast<float>(i);
    const F one = constant(1), none{};
    for (int x = 0; x < count; x += lanes) {
        const F along = place + constant(static_cast<float>(x)), column = fma(along, constant(row.column_step), constant(row.column));
        const F reach = fma(along, constant(row.reach_right), constant(row.reach)), reach2 = reach * reach, inverse_reach2 = one / reach2;
        const F sharpness = fma(along, constant(row.sharpness_right), constant(row.sharpness));
        F depth, right, down, normal[3], albedo[3], coverage, inverse_tolerance2;
        if constexpr (unknowns == on_surfaces) {
            depth = load<F>(row.depth + x), right = load<F>(row.depth_right + x), down = load<F>(row.depth_down + x);
            for (int k = 0; k < 3; ++k) normal[k] = load<F>(row.normal[k] + x), albedo[k] = load<F>(row.albedo[k] + x);
            coverage = load<F>(row.coverage + x);
            inverse_tolerance2 = one / square(depth_tolerance(likeness, absolute(right), absolute(down)));
        }
        float widest = 0;
        for (int i = 0; i < lanes; ++i) widest = reach2[i] > widest ? reach2[i] : widest;

        Sums<C, unknowns> s{};
        F total{}, shade2{}, variance{}, low[C], high[C];
        for (int c = 0; c < C; ++c) low[c] = constant(3.4e38f), high[c] = none;
        for (std::size_t r = 0; r < range_count; ++r) {
            const float down_to = ranges[r].row - row.row;
            if (down_to * down_to >= widest) continue;
            const F dy = constant(down_to);
            for (int n = ranges[r].begin; n < ranges[r].end; n += step) {
                const GuidedSample& q = samples[n];
                const F dx = constant(q.column) - column, distance2 = fma(dx, dx, dy * dy);
                const F near = max(one - distance2 * inverse_reach2, none);
                if (bits(near > none) == 0) continue;
                F unknown[unknowns] = {one, dx, dy}, like = near * near;
                if constexpr (unknowns == on_surfaces) {
                    const F tilt[] = {constant(q.normal[0]) - normal[0], constant(q.normal[1]) - normal[1], constant(q.normal[2]) - normal[2]};
                    const F off_plane = constant(q.depth) - fma(right, dx, fma(down, dy, depth));
                    const F tint[] = {constant(q.albedo[0]) - albedo[0], constant(q.albedo[1]) - albedo[1], constant(q.albedo[2]) - albedo[2]};
                    const F unlike = unlikeness(likeness, tilt, off_plane, inverse_tolerance2, distance2, tint, constant(q.coverage) - coverage,
                                                [](F a, F b, F c) { return fma(a, b, c); });
                    like *= max(likeness_of(unlike), constant(least_likeness));
                    BOB_UNROLL
                    for (int k = 0; k < 3; ++k) unknown[3 + k] = tilt[k];
                }
                const F weight = like / (distance2 + sharpness);
                total += like;

                F weighted[unknowns];
                BOB_UNROLL
                for (int u = 0; u < unknowns; ++u) weighted[u] = weight * unknown[u];
                BOB_UNROLL
                for (int u = 0; u < unknowns; ++u) {
                    BOB_UNROLL
                    for (int v = u; v < unknowns; ++v) s.matrix[u][v] = fma(weighted[u], unknown[v], s.matrix[u][v]);
                }
                BOB_UNROLL
                for (int c = 0; c < C; ++c) {
                    const F light = constant(q.light[c]);
                    BOB_UNROLL
                    for (int u = 0; u < unknowns; ++u) s.right[c][u] = fma(weighted[u], light, s.right[c][u]);
                    low[c] = near > none ? min(low[c], light) : low[c];
                    high[c] = near > none ? max(high[c], light) : high[c];
                }
                if (is_noisy) {
                    const F brightness = constant(q.shade);
                    shade2 = fma(weight * brightness, brightness, shade2);
                    variance = fma(weight, constant(q.variance), variance);
                }
            }
        }
        const F inverse = one / max(s.matrix[0][0], constant(1e-30f));
        F light[C];
        const F explained = solve(s, reach2, light);
        BOB_UNROLL
        for (int c = 0; c < C; ++c) store(row.light[c] + x, max(min(light[c], high[c]), low[c]));  // clamped to the samples' range, since planes extrapolate
        store(row.weight + x, total);
        if (is_noisy) {
            store(row.noise + x, variance * inverse);
            store(row.detail + x, max((shade2 - explained) * inverse, none));
        }
    }
}

}  // namespace

const GuidedKernels guided_kernels = {fit<1, on_surfaces>, fit<3, on_surfaces>, fit<1, on_plane>};

}  // namespace bob::BOB_ISA
