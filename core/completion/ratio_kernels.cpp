#include "completion/ratio_kernels.h"

#include <algorithm>

#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

/// What a coarser level counts against what is gathered: as much of a pixel.
constexpr float prior = 0.02f;

/// What a neighbour above, below or beside counts; one across has the square of it. Sums over 3 x 3 blocks at every level weigh pixels
/// nearly by the fourth power of their distance, and lie where the pixels do, which the means of single blocks do not.
constexpr float beside = 0.25f;

/// Times the mean of the guide around up to which colours may be as saturated as there.
constexpr float brighter = 1.25f;

void pull_pixels(PixelRows guide, PixelRows color, Rows sums, int width) {
    for (int x = 0; x < width; x += lanes) {
        const Phases weight = blocks(guide, 0, x);
        M counts[4], any{};
        for (int i = 0; i < 4; ++i) any |= counts[i] = weight.at[i] > F{};
        const auto put = [&](int channel, const Phases& value) {
            Phases counted;
            for (int i = 0; i < 4; ++i) counted.at[i] = where(counts[i], value.at[i]);
            store(sums.at(channel) + x, total(counted));
        };
        if (!bits(any)) {
            for (int c = 0; c < ratio_sums::channels; ++c) store(sums.at(c) + x, F{});
            continue;
        }
        const F one = constant(1);
        put(ratio_sums::guide, weight);
        put(ratio_sums::count, {{one, one, one, one}});
        for (int k = 0; k < ratio_components; ++k) put(ratio_sums::color + k, blocks(color, k, x));
    }
}

void pull(ConstRows finer, Rows sums, int width) {
    for (int x = 0; x < width; x += lanes) {
        for (int c = 0; c < ratio_sums::channels; ++c) store(sums.at(c) + x, total(blocks(finer.at(c), finer.at(c, 1), x)));
    }
}

/// Sums down the columns of three rows, for each of two rows; all are 0 unless `any`.
struct Columns {
    F of[2][ratio_sums::channels];
    bool any;

    void set(int channel, const F (&rows)[4]) {
        const F weight = constant(beside);
        for (int y = 0; y < 2; ++y) of[y][channel] = fma(weight, rows[y] + rows[y + 2], rows[y + 1]);
    }
};

/// Those of a level's sums.
struct SummedColumns {
    const ConstRows *upper, *lower;
    int width;

    void operator()(int x, Columns& to) const {
        to.any = false;
        if (x >= width) return;
        F rows[4];
        const auto read = [&](int channel) {
            rows[0] = load<F>(upper->at(channel, -1) + x), rows[1] = load<F>(upper->at(channel) + x);
            rows[2] = load<F>(lower->at(channel) + x), rows[3] = load<F>(lower->at(channel, 1) + x);
        };
        read(ratio_sums::guide);
        to.any = bits((rows[0] > F{}) | (rows[1] > F{}) | (rows[2] > F{}) | (rows[3] > F{}));
        if (!to.any) return;
        to.set(ratio_sums::guide, rows);
        for (int c = ratio_sums::color; c < ratio_sums::channels; ++c) read(c), to.set(c, rows);
    }
};

/// Some of a row's pixels, and zeros.
inline F load_some(const float* p, int count) {
    if (count >= lanes) return load<F>(p);
    float padded[lanes] = {};
    std::copy_n(p, std::max(count, 0), padded);
    return load<F>(padded);
}
inline void store_some(float* p, F values, int count) {
    if (count >= lanes) return store(p, values);
    float padded[lanes];
    store(padded, values);
    std::copy_n(padded, std::max(count, 0), p);
}

/// Those of pixels.
struct PixelColumns {
    const GuidedRows& from;

    void operator()(int x, Columns& to) const {
        to.any = false;
        const int count = from.columns - x;
        if (count <= 0) return;
        F rows[4];
        M counts[4], any{};
        for (int y = 0; y < 4; ++y) {
            rows[y] = from.guide[y] ? load_some(from.guide[y] + x, count) : F{};
            any |= counts[y] = rows[y] > F{};
        }
        to.any = bits(any);
        if (!to.any) return;
        const auto set = [&](int channel, auto value) {
            for (int y = 0; y < 4; ++y) rows[y] = from.guide[y] ? where(counts[y], value(y)) : F{};
            to.set(channel, rows);
        };
        set(ratio_sums::guide, [&](int y) { return rows[y]; });
        set(ratio_sums::count, [&](int) { return constant(1); });
        for (std::size_t k = 0; k < ratio_components; ++k) {
            set(ratio_sums::color + static_cast<int>(k),
                [&](int y) { return load_some(from.color[y] + k * from.plane_stride + x, count); });
        }
    }
};

/// The columns of three vectors, of which the middle one moves along two rows.
template <class From>
class Around {
public:
    explicit Around(const From& from) : from_(from) {
        from_(0, ring_[1]);
        from_(lanes, ring_[2]);
    }

    void next() {
        x_ += lanes, middle_ = after();
        from_(x_ + lanes, ring_[after()]);
    }

    /// Of row y, what is expected of means made so: where sums are 0 it stays.
    void correct(int y, float unit, F (&means)[ratio_means::channels]) const {
        const Columns &left = ring_[before()], &here = ring_[middle_], &right = ring_[after()];
        if (!left.any && !here.any && !right.any) return;
        F sums[ratio_sums::channels];
        for (int c = 0; c < ratio_sums::channels; ++c) {
            const F middle = here.any ? here.of[y][c] : F{};
            const F beside_it = window<lanes - 1>(left.any ? left.of[y][c] : F{}, middle) + window<1>(middle, right.any ? right.of[y][c] : F{});
            sums[c] = fma(constant(beside), beside_it, middle);
        }
        const F one = constant(1), of_guide = constant(prior * unit), of_count = constant(prior);
        const F per_guide = one / (sums[ratio_sums::guide] + of_guide), per_count = one / (sums[ratio_sums::count] + of_count);
        for (int k = 0; k < ratio_components; ++k) {
            means[ratio_means::color + k] = fma(of_guide, means[ratio_means::color + k], sums[ratio_sums::color + k]) * per_guide;
        }
        means[ratio_means::guide] = fma(of_count, means[ratio_means::guide], sums[ratio_sums::guide]) * per_count;
    }

private:
    [[nodiscard]] int before() const { return middle_ == 0 ? 2 : middle_ - 1; }
    [[nodiscard]] int after() const { return middle_ == 2 ? 0 : middle_ + 1; }

    const From& from_;
    int x_ = 0, middle_ = 1;
    Columns ring_[3] = {};
};

/// What a coarser level expects of twice two vectors of the next finer one.
struct Expected {
    Phases of[ratio_means::channels];

    Expected(const DoubledMeans& coarse, int x) {
        for (int c = 0; c < ratio_means::channels; ++c) of[c] = doubled(coarse.of[c], x);
    }

    /// Those of row y, to the left or to the right.
    void get(int y, int right, F (&means)[ratio_means::channels]) const {
        for (int c = 0; c < ratio_means::channels; ++c) {
            const F even = of[c].at[2 * y], odd = of[c].at[2 * y + 1];
            means[c] = right ? zip_high(even, odd) : zip_low(even, odd);
        }
    }
};

void mean(DoubledMeans coarse, ConstRows sums, ConstRows sums_below, Rows to, float unit, int width) {
    const SummedColumns from{&sums, &sums_below, 2 * width};
    Around around(from);
    for (int x = 0; x < width; x += lanes) {
        const Expected expected(coarse, x);
        for (int right = 0; right < 2; ++right, around.next()) {
            for (int y = 0; y < 2; ++y) {
                F means[ratio_means::channels];
                expected.get(y, right, means);
                around.correct(y, unit, means);
                for (int c = 0; c < ratio_means::channels; ++c) store(to.at(c, y) + 2 * x + right * lanes, means[c]);
            }
        }
    }
}

void finish(DoubledMeans coarse, GuidedRows traced, ColoredRows picture, float unit, int width) {
    const PixelColumns from{traced};
    Around around(from);
    const F most = constant(brighter), low = constant(picture.low), high = constant(picture.high);
    for (int x = 0; x < width; x += lanes) {
        F wanted[2][2];
        M known[2][2], any{};
        for (int y = 0; y < picture.rows; ++y) {
            for (int right = 0; right < 2; ++right) {
                const int column = 2 * x + right * lanes, count = traced.columns - column;
                wanted[y][right] = load_some(picture.guide + y * picture.stride + column, count);
                known[y][right] = load_some(picture.mask + y * picture.stride + column, count) > F{};
                any |= known[y][right] | (wanted[y][right] != F{});
            }
        }
        const auto put = [&](int y, int column, std::size_t k, F value) {
            store_some(picture.row + y * picture.stride + k * picture.plane_stride + column, value, traced.columns - column);
        };
        if (!bits(any)) {  // black, whatever the ratios are
            for (int right = 0; right < 2; ++right, around.next()) {
                for (int y = 0; y < picture.rows; ++y) {
                    for (std::size_t k = 0; k < ratio_components; ++k) put(y, 2 * x + right * lanes, k, min(max(F{}, low), high));
                }
            }
            continue;
        }
        const Expected expected(coarse, x);
        for (int right = 0; right < 2; ++right, around.next()) {
            const int column = 2 * x + right * lanes;
            for (int y = 0; y < picture.rows; ++y) {
                F means[ratio_means::channels];
                expected.get(y, right, means);
                around.correct(y, unit, means);
                const F shade = wanted[y][right], colored = min(shade, most * means[ratio_means::guide]), white = shade - colored;
                const M is_known = known[y][right];
                for (std::size_t k = 0; k < ratio_components; ++k) {
                    F value = min(max(fma(means[ratio_means::color + static_cast<int>(k)], colored, white), low), high);
                    if (bits(is_known)) {
                        const F color = load_some(traced.color[y + 1] + k * traced.plane_stride + column, traced.columns - column);
                        value = select(is_known, color, value);
                    }
                    put(y, column, k, value);
                }
            }
        }
    }
}

}  // namespace

const RatioKernels ratio_kernels = {pull_pixels, pull, mean, finish};

}  // namespace bob::BOB_ISA
