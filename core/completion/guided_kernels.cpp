#include "completion/guided_kernels.h"

#include "base/simd.h"
#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

using Places = GuidedPlaces;

/// Ridge of the slopes, as a share of the weight: without it, slopes from few samples are extrapolated; a larger one flattens light.
constexpr float place_ridge = 3e-3f, normal_ridge = 3e-3f;

/// Minimum weight of samples on other surfaces, used where no sample is on the same one.
constexpr float least_likeness = 1e-5f;

F square(F a) { return a * a; }

float lowest(F a) {
    float result = a[0];
    for (int i = 1; i < lanes; ++i) result = a[i] < result ? a[i] : result;
    return result;
}
float highest(F a) { return -lowest(-a); }

/// Sums over samples: the upper triangle of a symmetric matrix, and its right-hand sides.
template <int C, int unknowns>
struct Sums {
    F matrix[unknowns][unknowns], right[C][unknowns];
};

/// Solves for the unknowns, (C, unknowns): they are eliminated from the last one on. Returns the part of the squared sums of luminance that
/// the fit explains.
template <int C, int unknowns>
inline F solve(Sums<C, unknowns>& s, F reach2, F (&light)[C][unknowns]) {
    const F total = s.matrix[0][0];
    F explained{}, inverses[unknowns];
    const auto explain = [&](int k) {
        F of_luminance = s.right[0][k];
        if constexpr (C == 3) of_luminance = constant(0.2126f) * s.right[0][k] + constant(0.7152f) * s.right[1][k] + constant(0.0722f) * s.right[2][k];
        inverses[k] = constant(1) / s.matrix[k][k];
        explained = fma(of_luminance * of_luminance, inverses[k], explained);
    };
    BOB_UNROLL
    for (int u = 1; u < unknowns; ++u) s.matrix[u][u] += total * (u < 3 ? reach2 * constant(place_ridge) : constant(normal_ridge));
    BOB_UNROLL
    for (int k = unknowns - 1; k > 0; --k) {
        explain(k);
        BOB_UNROLL
        for (int u = 0; u < k; ++u) {
            const F factor = s.matrix[u][k] * inverses[k];
            BOB_UNROLL
            for (int v = 0; v <= u; ++v) s.matrix[v][u] -= factor * s.matrix[v][k];
            BOB_UNROLL
            for (int c = 0; c < C; ++c) s.right[c][u] -= factor * s.right[c][k];
        }
    }
    explain(0);
    BOB_UNROLL
    for (int c = 0; c < C; ++c) {
        BOB_UNROLL
        for (int k = 0; k < unknowns; ++k) {
            F rest = s.right[c][k];
            BOB_UNROLL
            for (int u = 0; u < k; ++u) rest -= s.matrix[u][k] * light[c][u];
            light[c][k] = k > 0 ? rest * inverses[k] : rest / s.matrix[0][0];
        }
    }
    return explained;
}

template <int C, int unknowns>
void fit(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
         GuidedPlaces& places, bool is_noisy) {
    const F one = constant(1), none{};
    for (int first = 0; first < places.count; first += lanes) {
        const auto of = [&](int value) { return load<F>(places.of[value] + first); };
        const F row = of(Places::row), column = of(Places::column), sharpness = of(Places::sharpness);
        const F reach = of(Places::reach), reach2 = reach * reach, inverse_reach2 = one / reach2;
        F depth, right, down, normal[3], albedo[3], coverage, inverse_tolerance2;
        if constexpr (unknowns == Places::on_surfaces) {
            const auto guide = [&](int plane) { return of(Places::guide(plane)); };
            depth = guide(Guides::depth), right = guide(Guides::depth_right), down = guide(Guides::depth_down);
            for (int k = 0; k < 3; ++k) normal[k] = guide(Guides::normal_x + k), albedo[k] = guide(Guides::red + k);
            coverage = guide(Guides::coverage);
            inverse_tolerance2 = one / square(depth_tolerance(likeness, absolute(right), absolute(down)));
        }
        const float top = lowest(row), bottom = highest(row), widest = highest(reach2);

        Sums<C, unknowns> s{};
        F total{}, shade2{}, variance{}, low[C], high[C];
        for (int c = 0; c < C; ++c) low[c] = constant(3.4e38f), high[c] = none;
        for (std::size_t r = 0; r < range_count; ++r) {
            const float above = top - ranges[r].row, below = ranges[r].row - bottom, away = above > 0 ? above : below > 0 ? below : 0;
            if (away * away >= widest) continue;
            const F dy = constant(ranges[r].row) - row;
            for (int n = ranges[r].begin; n < ranges[r].end; n += step) {
                const GuidedSample& q = samples[n];
                const F dx = constant(q.column) - column, distance2 = fma(dx, dx, dy * dy);
                const F near = max(one - distance2 * inverse_reach2, none);
                if (bits(near > none) == 0) continue;
                F unknown[unknowns] = {one, dx, dy}, like = near * near;
                if constexpr (unknowns == Places::on_surfaces) {
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
        const auto set = [&](int value, F to) { store(places.of[value] + first, to); };
        const F inverse = one / max(s.matrix[0][0], constant(1e-30f));
        F light[C][unknowns];
        const F explained = solve(s, reach2, light);
        BOB_UNROLL
        for (int c = 0; c < C; ++c) {
            set(Places::light_of(c, 0), max(min(light[c][0], high[c]), low[c]));
            BOB_UNROLL
            for (int u = 1; u < unknowns; ++u) set(Places::light_of(c, u), light[c][u]);
            set(Places::low + c, low[c]), set(Places::high + c, high[c]);
        }
        set(Places::weight, total);
        if (is_noisy) {
            set(Places::noise, variance * inverse);
            set(Places::detail, max((shade2 - explained) * inverse, none));
        }
    }
}

/// The values of one of the four places around each pixel; 0 if it is not fitted.
struct Corner {
    F of[Places::values];
    F inverse_tolerance2;
};

template <int unknowns>
void blend(const GuidedPlaces& places, const GuidedGrid& grid, const GuidedLikeness& likeness, const GuidedPixels& pixels, int components,
           bool is_noisy) {
    const F one = constant(1), none{};
    for (int left = 0; left < pixels.width; left += lanes) {
        int columns[2][lanes];
        F along;
        for (int lane = 0, before = 0; lane < lanes; ++lane) {
            const int x = left + lane < pixels.width ? left + lane : pixels.width - 1;
            while (before + 2 < grid.columns && grid.column[before + 1] <= x) ++before;
            const int after = before + 1 < grid.columns ? before + 1 : before, from = grid.column[before], to = grid.column[after];
            columns[0][lane] = before, columns[1][lane] = after;
            along[lane] = to > from ? static_cast<float>(x - from) / static_cast<float>(to - from) : 0;
        }
        const F x = constant(static_cast<float>(pixels.left + left)) + to_floats(lane_numbers());
        const auto find = [&](int row, int side, Corner& corner) {
            BOB_KEEP_LOOP
            for (int value = 0; value < Places::values; ++value) {
                BOB_KEEP_LOOP
                for (int lane = 0; lane < lanes; ++lane) {
                    const int place = grid.place[row][columns[side][lane]];
                    corner.of[value][lane] = place < 0 ? 0 : places.of[value][place];
                }
            }
            const F right = corner.of[Places::guide(Guides::depth_right)], down = corner.of[Places::guide(Guides::depth_down)];
            corner.inverse_tolerance2 = one / square(depth_tolerance(likeness, absolute(right), absolute(down)));
        };
        Corner corners[2][2];
        find(0, 0, corners[1][0]), find(0, 1, corners[1][1]);
        for (int row = 0; row == 0 || row + 1 < grid.rows; ++row) {
            const int below = row + 1 < grid.rows ? row + 1 : row;
            corners[0][0] = corners[1][0], corners[0][1] = corners[1][1];
            find(below, 0, corners[1][0]), find(below, 1, corners[1][1]);
            const int begin = grid.row[row], end = below + 1 < grid.rows ? grid.row[below] : pixels.height;
            for (int y = begin; y < end; ++y) {
                const F down = constant(below > row ? static_cast<float>(y - begin) / static_cast<float>(grid.row[below] - begin) : 0);
                const auto guide = [&](int plane) { return load<F>(pixels.guides[plane] + static_cast<std::size_t>(y) * pixels.guides_stride + left); };
                F weights{}, light[3]{}, detail{}, noise{};
                BOB_KEEP_LOOP
                for (int i = 0; i < 4; ++i) {
                    const Corner& corner = corners[i / 2][i % 2];
                    const auto of = [&](int value) { return corner.of[value]; };
                    const F dx = x - of(Places::column), dy = constant(static_cast<float>(pixels.top + y)) - of(Places::row);
                    F unknown[unknowns] = {one, dx, dy};
                    F weight = (i / 2 ? down : one - down) * (i % 2 ? along : one - along);
                    if constexpr (unknowns == Places::on_surfaces) {
                        const auto differs = [&](int plane) { return guide(plane) - of(Places::guide(plane)); };
                        const F slope = fma(of(Places::guide(Guides::depth_right)), dx, of(Places::guide(Guides::depth_down)) * dy);
                        F tilt[3], tint[3];
                        for (int k = 0; k < 3; ++k) unknown[3 + k] = tilt[k] = differs(Guides::normal_x + k), tint[k] = differs(Guides::red + k);
                        weight *= likeness_of(unlikeness(likeness, tilt, differs(Guides::depth) - slope, corner.inverse_tolerance2, fma(dx, dx, dy * dy),
                                                         tint, differs(Guides::coverage), [](F a, F b, F c) { return fma(a, b, c); }));
                    }
                    weight = of(Places::weight) >= constant(least_weight) ? weight : none;
                    weights += weight;
                    BOB_KEEP_LOOP
                    for (int c = 0; c < components; ++c) {
                        F value = of(Places::light_of(c, 0));
                        BOB_UNROLL
                        for (int u = 1; u < unknowns; ++u) value = fma(of(Places::light_of(c, u)), unknown[u], value);
                        value = max(min(value, of(Places::high + c)), of(Places::low + c));
                        light[c] += weight > none ? weight * value : none;
                    }
                    if (is_noisy) detail = fma(weight, of(Places::detail), detail), noise = fma(weight, of(Places::noise), noise);
                }
                const F inverse = one / max(weights, constant(1e-30f));
                const auto at = static_cast<std::size_t>(y) * pixels.output_stride + static_cast<std::size_t>(left);
                for (int c = 0; c < components; ++c) store(pixels.light[c] + at, light[c] * inverse);
                store(pixels.weight + at, weights);
                if (is_noisy) store(pixels.detail + at, detail * inverse), store(pixels.noise + at, noise * inverse);
            }
        }
    }
}

}  // namespace

const GuidedKernels guided_kernels = {fit<1, Places::on_surfaces>, fit<3, Places::on_surfaces>, fit<1, Places::on_plane>, blend<Places::on_surfaces>,
                                      blend<Places::on_plane>};

}  // namespace bob::BOB_ISA
