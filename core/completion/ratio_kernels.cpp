#include "completion/ratio_kernels.h"

#include <algorithm>

#include "completion/blocks.h"

namespace bob::BOB_ISA {
namespace {

/// Weight of the coarser level's mean, in pixels, against the sums gathered.
constexpr float prior = 0.02f;

/// Weight of a horizontal or vertical neighbour; a diagonal one has the square of it. Sums over 3 x 3 blocks at every
/// level weight pixels by about the fourth power of their distance, and are centred on the pixels; means of single
/// blocks are not.
constexpr float beside = 0.25f;

/// Colours are as saturated as their surroundings up to this multiple of the guide's mean there.
constexpr float brighter = 1.25f;

/// Loads the first `count` pixels of a row, the others as 0.
[[gnu::noinline]] F load_last(const float* p, int count) {
    float padded[lanes] = {};
    std::copy_n(p, std::max(count, 0), padded);
    return load<F>(padded);
}
[[gnu::noinline]] void store_last(float* p, F values, int count) {
    float padded[lanes];
    store(padded, values);
    std::copy_n(padded, std::max(count, 0), p);
}

/// Loads pixels; all exist if `whole`.
template <bool whole>
inline F load_pixels(const float* p, int count) {
    return whole || count >= lanes ? load<F>(p) : load_last(p, count);
}
template <bool whole>
inline void store_pixels(float* p, F values, int count) {
    if (whole || count >= lanes) store(p, values);
    else store_last(p, values, count);
}

/// Writes the sums of blocks, from `blocks_of(channel)`. Where the guide is 0 there is nothing to sum.
template <class BlocksOf>
inline void put_sums(const Rows& sums, int x, const RawBlocks& guide, BlocksOf blocks_of) {
    const bool any = guide.any();
    for (int c = 0; c < ratio_sums::channels; ++c) store(sums.at(c) + x, any ? total(blocks_of(c)) : F{});
}

Stretch lit(PixelRows guide, PixelRows known_guide) {
    const float* const rows[4] = {guide.from.at(0), guide.from.at(0, guide.rows - 1), known_guide.from.at(0), known_guide.from.at(0, guide.rows - 1)};
    const auto is_lit = [&](int x, int count) {
        M any{};
        BOB_KEEP_LOOP
        for (const float* row : rows) any |= load_pixels<false>(row + x, count) != F{};
        return bits(any) != 0;
    };
    Stretch result{0, guide.columns};
    while (!result.is_empty() && !is_lit(result.begin, guide.columns - result.begin)) result.begin += lanes;
    while (!result.is_empty()) {
        const int last = (result.end - 1) / lanes * lanes;
        if (is_lit(last, result.end - last)) break;
        result.end = last;
    }
    return result;
}

void pull_pixels(PixelRows guide, PixelRows color, Rows sums, Stretch some) {
    const F one = constant(1);
    for (int x = some.begin; x < some.end; x += lanes) {
        const RawBlocks weight = raw_blocks(guide, 0, x);
        put_sums(sums, x, weight, [&](int channel) {
            RawBlocks value = channel == ratio_sums::guide   ? weight
                              : channel == ratio_sums::count ? RawBlocks{{one, one}, {one, one}}
                                                             : raw_blocks(color, channel - ratio_sums::color, x);
            for (int i = 0; i < 2; ++i) {
                value.upper[i] = where(weight.upper[i] > F{}, value.upper[i]);
                value.lower[i] = where(weight.lower[i] > F{}, value.lower[i]);
            }
            return value;
        });
    }
}

void pull(ConstRows finer, Rows sums, Stretch some) {
    for (int x = some.begin; x < some.end; x += lanes) {
        const auto blocks_of = [&](int channel) { return raw_blocks(finer.at(channel), finer.at(channel, 1), x); };
        put_sums(sums, x, blocks_of(ratio_sums::guide), blocks_of);
    }
}

/// Sums down the columns of three rows, for each of two rows, and whether any is above 0.
struct Columns {
    F of[2][ratio_sums::channels];
    bool any;

    void clear() {
        for (auto& row : of) {
            for (F& sum : row) sum = F{};
        }
        any = false;
    }

    void set(int channel, const F (&rows)[4]) {
        const F weight = constant(beside);
        for (int y = 0; y < 2; ++y) of[y][channel] = fma(weight, rows[y] + rows[y + 2], rows[y + 1]);
    }
};

/// Columns of a level's sums.
struct SummedColumns {
    const ConstRows &upper, &lower;
    int width;

    void operator()(int x, Columns& to) const {
        if (x < 0 || x >= width) return to.clear();
        F rows[4];
        const auto read = [&](int channel) {
            rows[0] = load<F>(upper.at(channel, -1) + x), rows[1] = load<F>(upper.at(channel) + x);
            rows[2] = load<F>(lower.at(channel) + x), rows[3] = load<F>(lower.at(channel, 1) + x);
        };
        read(ratio_sums::guide);
        to.any = bits((rows[0] > F{}) | (rows[1] > F{}) | (rows[2] > F{}) | (rows[3] > F{}));
        if (!to.any) return to.clear();
        to.set(ratio_sums::guide, rows);
        for (int c = ratio_sums::color; c < ratio_sums::channels; ++c) read(c), to.set(c, rows);
    }
};

/// Columns of pixels; if `whole`, all exist except to the left of the picture.
template <bool whole>
struct PixelColumns {
    const GuidedRows from;

    void operator()(int x, Columns& to) const {
        const int count = from.columns - x;
        if (x < 0 || count <= 0) return to.clear();
        const auto read = [&](const float* row) { return whole || row ? load_pixels<whole>(row + x, count) : F{}; };
        F guide[4], rows[4];
        M counts[4], any{};
        for (int y = 0; y < 4; ++y) {
            guide[y] = read(from.guide[y]);
            any |= counts[y] = guide[y] > F{};
        }
        to.any = bits(any);
        if (!to.any) return to.clear();
        const auto set = [&](int channel, auto value) {
            for (int y = 0; y < 4; ++y) rows[y] = where(counts[y], value(y));
            to.set(channel, rows);
        };
        set(ratio_sums::guide, [&](int y) { return guide[y]; });
        set(ratio_sums::count, [&](int) { return constant(1); });
        for (int k = 0; k < ratio_components; ++k) {
            set(ratio_sums::color + k, [&](int y) { return whole || from.color[y] ? read(from.color[y] + k * from.plane_stride) : F{}; });
        }
    }
};

/// The columns of two vectors, and their neighbours, moving along two rows.
template <class From>
class Around {
public:
    explicit Around(const From& from, int first) : from_(from), made_(first - 1) {}

    /// Moves to a vector, by number, and the next one.
    void move(int vector) {
        for (made_ = std::max(made_, vector - 1); made_ < vector + 3; ++made_) from_(made_ * lanes, ring_[made_ & 3]);
    }

    /// Corrects the predicted means of row y; where the sums are 0, the prediction stays.
    void correct(int vector, int y, float unit, F (&means)[ratio_means::channels]) const {
        const Columns &left = ring_[(vector - 1) & 3], &here = ring_[vector & 3], &right = ring_[(vector + 1) & 3];
        if (!left.any && !here.any && !right.any) return;
        F sums[ratio_sums::channels];
        for (int c = 0; c < ratio_sums::channels; ++c) {
            const F middle = here.of[y][c], around = window<lanes - 1>(left.of[y][c], middle) + window<1>(middle, right.of[y][c]);
            sums[c] = fma(constant(beside), around, middle);
        }
        const F one = constant(1), of_guide = constant(prior * unit), of_count = constant(prior);
        const F per_guide = one / (sums[ratio_sums::guide] + of_guide), per_count = one / (sums[ratio_sums::count] + of_count);
        for (int k = 0; k < ratio_components; ++k) {
            means[ratio_means::color + k] = fma(of_guide, means[ratio_means::color + k], sums[ratio_sums::color + k]) * per_guide;
        }
        means[ratio_means::guide] = fma(of_count, means[ratio_means::guide], sums[ratio_sums::guide]) * per_count;
    }

private:
    const From from_;
    int made_;  // vectors so far
    Columns ring_[4];
};

/// The coarser level's prediction for two pairs of vectors of the finer one.
struct Expected {
    Phases of[ratio_means::channels];

    Expected(const DoubledMeans& coarse, int x) {
        for (int c = 0; c < ratio_means::channels; ++c) of[c] = doubled(coarse.of[c], x);
    }

    /// The means of row y, to the left or to the right.
    void get(int y, int right, F (&means)[ratio_means::channels]) const {
        for (int c = 0; c < ratio_means::channels; ++c) {
            const F even = of[c].at[2 * y], odd = of[c].at[2 * y + 1];
            means[c] = right ? zip_high(even, odd) : zip_low(even, odd);
        }
    }
};

void mean(DoubledMeans coarse, ConstRows sums, ConstRows sums_below, Rows to, float unit, int width, Stretch some) {
    const SummedColumns from{sums, sums_below, width};
    Around around(from, 2 * some.begin / lanes);
    for (int x = some.begin; x < some.end; x += lanes) {
        const Expected expected(coarse, x);
        const int vector = 2 * x / lanes;
        around.move(vector);
        for (int right = 0; right < 2; ++right) {
            for (int y = 0; y < 2; ++y) {
                F means[ratio_means::channels];
                expected.get(y, right, means);
                around.correct(vector + right, y, unit, means);
                for (int c = 0; c < ratio_means::channels; ++c) store(to.at(c, y) + 2 * x + right * lanes, means[c]);
            }
        }
    }
}

/// Blocks `begin` to `end`; `whole` if all pixels in them, next to them, and in the rows above and below exist.
template <bool whole>
inline void finish_some(DoubledMeans coarse, GuidedRows traced, ColoredRows picture, float unit, int begin, int end) {
    const PixelColumns<whole> from{traced};
    Around around(from, 2 * begin / lanes);
    const F most = constant(brighter), low = constant(picture.low), high = constant(picture.high), black = min(max(F{}, low), high);
    const int rows = whole ? 2 : picture.rows;
    for (int x = begin; x < end; x += lanes) {
        F guide[2][2];
        M is_lit{};
        for (int y = 0; y < rows; ++y) {
            for (int right = 0; right < 2; ++right) {
                const int column = 2 * x + right * lanes, count = traced.columns - column;
                guide[y][right] = load_pixels<whole>(picture.guide + y * picture.stride + column, count);
                is_lit |= guide[y][right] != F{};
            }
        }
        const auto put = [&](int y, int right, const F (&values)[ratio_components]) {
            const int column = 2 * x + right * lanes;
            for (int k = 0; k < ratio_components; ++k) {
                store_pixels<whole>(picture.row + k * picture.plane_stride + y * picture.stride + column, values[k], traced.columns - column);
            }
        };
        if (!bits(is_lit)) {  // black at any ratio
            for (int y = 0; y < rows; ++y) {
                for (int right = 0; right < 2; ++right) put(y, right, {black, black, black});
            }
            continue;
        }
        const Expected expected(coarse, x);
        const int vector = 2 * x / lanes;
        around.move(vector);
        for (int y = 0; y < rows; ++y) {
            for (int right = 0; right < 2; ++right) {
                F means[ratio_means::channels], values[ratio_components];
                expected.get(y, right, means);
                around.correct(vector + right, y, unit, means);
                const F wanted = guide[y][right], colored = min(wanted, most * means[ratio_means::guide]), white = wanted - colored;
                for (int k = 0; k < ratio_components; ++k) {
                    values[k] = min(max(fma(means[ratio_means::color + k], colored, white), low), high);
                }
                put(y, right, values);
            }
        }
    }
}

void finish(DoubledMeans coarse, GuidedRows traced, ColoredRows picture, float unit, Stretch some) {
    const bool inside = traced.guide[0] && traced.guide[3];
    const int whole = inside ? std::max(traced.columns / lanes - 1, 0) / 2 * lanes : 0;
    finish_some<true>(coarse, traced, picture, unit, some.begin, std::min(whole, some.end));
    finish_some<false>(coarse, traced, picture, unit, std::max(whole, some.begin), some.end);
}

}  // namespace

const RatioKernels ratio_kernels = {lit, pull_pixels, pull, mean, finish};

}  // namespace bob::BOB_ISA
