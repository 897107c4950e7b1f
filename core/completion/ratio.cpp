#include "completion/ratio.h"

#include <algorithm>
#include <vector>

#include "parallel.h"

namespace bob {
namespace {

/// What a coarser level counts against the means of a block: as much of a pixel.
constexpr float prior = 0.02f;

/// Of the guide and the components over blocks of pixels: sums, then means of the guide where it is not 0, and ratios to it; and
/// in the last plane, how many pixels the means are of.
struct Level {
    int height, width;
    std::vector<float> values;

    Level(int planes, int height, int width)
        : height(height), width(width), values(static_cast<std::size_t>(planes) * static_cast<std::size_t>(height) *
                                               static_cast<std::size_t>(width)) {}

    [[nodiscard]] float* row(int plane, int y) {
        return values.data() + (static_cast<std::size_t>(plane) * static_cast<std::size_t>(height) + static_cast<std::size_t>(y)) *
                                   static_cast<std::size_t>(width);
    }
    [[nodiscard]] const float* row(int plane, int y) const { return const_cast<Level*>(this)->row(plane, y); }
};

/// Adds two rows in pairs of pixels; `below` may be null.
void pull(const float* above, const float* below, int width, float* sums) {
    const int pairs = width / 2;
    if (below) {
        for (int x = 0; x < pairs; ++x) sums[x] = (above[2 * x] + above[2 * x + 1]) + (below[2 * x] + below[2 * x + 1]);
    } else {
        for (int x = 0; x < pairs; ++x) sums[x] = above[2 * x] + above[2 * x + 1];
    }
    if (width % 2) sums[pairs] = above[width - 1] + (below ? below[width - 1] : 0);
}

/// How many of two rows' pixels are not 0, in the same pairs.
void count_pairs(const float* above, const float* below, int width, float* counts) {
    for (int x = 0; x < (width + 1) / 2; ++x) counts[x] = 0;
    for (const float* const row : {above, below}) {
        if (!row) continue;
        for (int x = 0; x < width / 2; ++x) counts[x] += (row[2 * x] > 0 ? 1.f : 0.f) + (row[2 * x + 1] > 0 ? 1.f : 0.f);
        if (width % 2) counts[width / 2] += row[width - 1] > 0 ? 1.f : 0.f;
    }
}

/// A row of the next finer level, bilinear between blocks; `between` has room for a row of this one.
void push(const Level& level, int plane, int y, int finer_width, float* between, float* finer) {
    const int near = y / 2, far = std::clamp(near + (y % 2 ? 1 : -1), 0, level.height - 1), width = level.width;
    const float *const a = level.row(plane, near), *const b = level.row(plane, far);
    for (int x = 0; x < width; ++x) between[x] = 0.75f * a[x] + 0.25f * b[x];
    finer[0] = between[0];
    for (int x = 1; 2 * x < finer_width; ++x) finer[2 * x] = 0.75f * between[x] + 0.25f * between[x - 1];
    for (int x = 0; 2 * x + 1 < finer_width && x + 1 < width; ++x) finer[2 * x + 1] = 0.75f * between[x] + 0.25f * between[x + 1];
    if (finer_width % 2 == 0) finer[finer_width - 1] = between[width - 1];
}

}  // namespace

void complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                       int height, int width, float* output) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const int components = channel.components, count = components + 1;
    const float* const values = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    const auto row_of = [&](int plane, int y) {
        const float* const from = plane == 0 ? known_guide : values + static_cast<std::size_t>(plane - 1) * pixels;
        return from + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    };
    std::vector<Level> levels;
    for (int h = height, w = width; levels.empty() || h > 1 || w > 1;) {
        const int finer_height = h, finer_width = w;
        h = (h + 1) / 2, w = (w + 1) / 2;
        Level coarser(count + 1, h, w);
        for_rows(0, h, finer_width, [&](int y) {
            if (levels.empty()) {
                count_pairs(row_of(0, 2 * y), 2 * y + 1 < height ? row_of(0, 2 * y + 1) : nullptr, width, coarser.row(count, y));
            }
            for (int plane = 0; plane <= components + !levels.empty(); ++plane) {
                const auto finer_row = [&](int row) { return levels.empty() ? row_of(plane, row) : levels.back().row(plane, row); };
                const float* const below = 2 * y + 1 < finer_height ? finer_row(2 * y + 1) : nullptr;
                pull(finer_row(2 * y), below, finer_width, coarser.row(plane, y));
            }
        });
        levels.push_back(std::move(coarser));
    }
    for (std::size_t n = levels.size(); n-- > 0;) {
        Level& level = levels[n];
        for_rows(0, level.height, level.width, [&](int y) {
            thread_local std::vector<float> memory;
            memory.resize(2 * static_cast<std::size_t>(level.width) + 2);
            float *const expected = memory.data(), *const between = expected + level.width + 1;
            for (int plane = components; plane >= 0; --plane) {  // the guide last: its sums are the others' weights
                if (n + 1 < levels.size()) {
                    push(levels[n + 1], plane, y, level.width, between, expected);
                } else {
                    std::fill_n(expected, level.width, 1.f);
                }
                const float* const weight = level.row(plane > 0 ? 0 : count, y);
                float* const mean = level.row(plane, y);
                for (int x = 0; x < level.width; ++x) mean[x] = (mean[x] + prior * expected[x]) / (weight[x] + prior);
            }
        });
    }
    for_rows(0, height, width, [&](int y) {
        thread_local std::vector<float> memory;
        memory.resize(2 * static_cast<std::size_t>(width));
        float *const between = memory.data(), *const mean = between + width;
        const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        const float* const wanted = guide + first;
        push(levels[0], 0, y, width, between, mean);
        for (int plane = 1; plane <= components; ++plane) {
            float* const to = output + static_cast<std::size_t>(plane - 1) * pixels + first;
            push(levels[0], plane, y, width, between, to);
            for (int x = 0; x < width; ++x) {
                const float darker = std::min(wanted[x], mean[x]);
                to[x] = to[x] * darker + (wanted[x] - darker);
            }
        }
    });
}

}  // namespace bob
