#include "completion/ratio.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "completion/interpolation.h"
#include "completion/planes.h"
#include "completion/ratio_kernels.h"
#include "completion/spare.h"

namespace bob {
namespace {

struct Level {
    Planes sums;                // ratio_sums::channels
    Planes means;               // ratio_means::channels
    std::vector<Stretch> lit;   // per row: the range where the guide is not 0
    std::vector<Stretch> made;  // per two rows: the range of means needed, in columns of the coarser level
};

/// Successively coarser levels down to one block, and a coarsest level of constant means: white, and bright.
struct Images {
    int height, width;
    std::vector<Level> levels;

    Images(int height, int width) : height(height), width(width) {
        for (bool last = false; !last;) {
            last = height == 1 && width == 1 && !levels.empty();
            height = half(height), width = half(width);
            const auto rows = static_cast<std::size_t>(height);
            levels.push_back({{last ? 0 : ratio_sums::channels, height, width}, {ratio_means::channels, height, width},
                              std::vector<Stretch>(rows), std::vector<Stretch>((rows + 1) / 2)});
        }
        for (int c = 0; c < ratio_means::channels; ++c) std::fill_n(levels.back().means.row(c, 0) - 1, 3, 1.f);
    }
};

/// Only small pictures: there fresh memory costs more than the arithmetic.
constexpr std::size_t kept_pixels = 1 << 20;

Spare<Images> spare;

/// Rounds to whole vectors of a row `width` wide.
Stretch vectors(Stretch some, int width) { return some.is_empty() ? Stretch{} : within(aligned(some), width); }
Stretch halved(Stretch some) { return {some.begin / 2, half(some.end)}; }

/// The range that doubling reads for the computed columns of a row.
Stretch around(const std::vector<Stretch>& made, int y, int width) {
    const Stretch some = joined(made, y - 1, y + 2);
    return some.is_empty() ? some : Stretch{std::max(0, some.begin - 1), std::min(width, some.end + 1)};
}

/// Derives from the lit range of the finest level the lit ranges of the others, and the means needed.
void find_needed(std::vector<Level>& levels) {
    const std::vector<Stretch>* finer = &levels[0].lit;
    for (std::size_t n = 0; n + 1 < levels.size(); ++n) {
        Level &level = levels[n], &coarser = levels[n + 1];
        const int width = level.means.width(), height = level.means.height(), half_width = coarser.means.width();
        for (int y = 0; y < static_cast<int>(level.made.size()); ++y) {
            Stretch read = around(*finer, 2 * y, width);
            if (2 * y + 1 < height) read = joined(read, around(*finer, 2 * y + 1, width));
            level.made[static_cast<std::size_t>(y)] = vectors(halved(read), half_width);
            coarser.lit[static_cast<std::size_t>(y)] = vectors(halved(joined(level.lit, 2 * y, 2 * y + 2)), half_width);
        }
        finer = &level.made;
    }
}

/// Zeroes the sums that are read next to the lit range.
void clear_beside(Level& level, int y) {
    const Stretch lit = level.lit[static_cast<std::size_t>(y)], made = joined(level.made, (y - 1) / 2, (y + 1) / 2 + 1);
    const Stretch read = vectors(joined(lit, {std::max(0, 2 * made.begin - max_lanes), 2 * made.end + max_lanes}), level.sums.width());
    for (int c = 0; c < ratio_sums::channels; ++c) {
        float* const row = level.sums.row(c, y);
        std::fill(row + read.begin, row + std::max(read.begin, lit.begin), 0.f);
        std::fill(row + std::max(read.begin, lit.end), row + read.end, 0.f);
    }
}

DoubledMeans doubled(const Planes& means, int y) {
    DoubledMeans result{};
    for (int c = 0; c < ratio_means::channels; ++c) {
        result.of[c] = doubled_rows(means, c, y);
    }
    return result;
}

}  // namespace

std::vector<Stretch> complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide,
                                       const float* guide, std::optional<float> unit, int height, int width, float* output) {
    if (channel.components != ratio_components) {
        throw std::invalid_argument(std::string(channel.name) + ": expected " + std::to_string(ratio_components) + " components");
    }
    const auto& kernels = best_ratio_kernels();
    const auto stride = static_cast<std::ptrdiff_t>(width);
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const float* const color = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    auto images = spare.take(height, width);
    auto& levels = images->levels;

    Planes& finest = levels[0].sums;
    const auto pair = [&](const float* plane, int y) {
        return PixelRows{{plane + 2 * y * stride, -stride, stride, pixels}, std::min(height - 2 * y, 2), width};
    };
    for_rows(0, finest.height(), 2 * width, [&](int y) {
        levels[0].lit[static_cast<std::size_t>(y)] = vectors(halved(kernels.lit(pair(guide, y), pair(known_guide, y))), finest.width());
    });
    find_needed(levels);
    for_rows(0, finest.height(), 2 * width, [&](int y) {
        kernels.pull_pixels(pair(known_guide, y), pair(color, y), rows_of(finest, 0, y), levels[0].lit[static_cast<std::size_t>(y)]);
        clear_beside(levels[0], y);
    });
    const std::size_t coarsest = levels.size() - 1;
    for (std::size_t n = 1; n < coarsest; ++n) {
        const Planes& finer = levels[n - 1].sums;
        Planes& sums = levels[n].sums;
        for_rows(0, sums.height(), 2 * sums.width(), [&](int y) {
            kernels.pull(rows_of(finer, 0, 2 * y), rows_of(sums, 0, y), levels[n].lit[static_cast<std::size_t>(y)]);
            clear_beside(levels[n], y);
        });
    }
    const float one = unit.value_or(1);
    for (std::size_t n = coarsest; n-- > 0;) {
        const Planes &coarse = levels[n + 1].means, &sums = levels[n].sums;
        Planes& means = levels[n].means;
        for_rows(0, coarse.height(), 2 * means.width(), [&](int y) {
            kernels.mean(doubled(coarse, y), rows_of(sums, 0, 2 * y), rows_of(sums, 0, 2 * y + 1), rows_of(means, 0, 2 * y), one, means.width(),
                         levels[n].made[static_cast<std::size_t>(y)]);
            for (int finer = 2 * y; finer < std::min(2 * y + 2, means.height()); ++finer) {
                for (int c = 0; c < ratio_means::channels; ++c) {
                    repeat_edges(means.row(c, finer), means.width());
                }
            }
        });
    }
    const float high = unit ? std::numeric_limits<float>::infinity() : channel.high, black = std::clamp(0.f, channel.low, high);
    for_rows(0, finest.height(), 2 * width, [&](int y) {
        const std::ptrdiff_t first = 2 * y * stride;
        GuidedRows traced{{}, {}, pixels, width};
        for (int i = 0; i < 4; ++i) {
            const int row = 2 * y + i - 1;
            if (row < 0 || row >= height) continue;
            traced.guide[i] = known_guide + row * stride, traced.color[i] = color + row * stride;
        }
        const Stretch lit = levels[0].lit[static_cast<std::size_t>(y)];
        const int rows = std::min(height - 2 * y, 2);
        kernels.finish(doubled(levels[0].means, y), traced, {output + first, guide + first, pixels, stride, rows, channel.low, high}, one, lit);
        for (int k = 0; k < ratio_components * rows; ++k) {
            float* const row = output + static_cast<std::size_t>(k / rows) * pixels + first + k % rows * stride;
            std::fill(row, row + std::min(2 * lit.begin, width), black);
            std::fill(row + std::min(2 * lit.end, width), row + width, black);
        }
    });
    std::vector<Stretch> lit = levels[0].lit;
    for (Stretch& some : lit) some = {2 * some.begin, std::min(2 * some.end, width)};
    if (pixels <= kept_pixels) spare.give_back(std::move(images));
    return lit;
}

void complete_along(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                    std::optional<float> unit, int height, int width, float* output) {
    const std::vector<Stretch> lit = complete_by_ratio(known, planes, channel, known_guide, guide, unit, height, width, output);
    interpolate_lattice(known, planes, channel, unit.value_or(1), lit, output, height, width);
}

}  // namespace bob
