#include "completion/ratio.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "completion/interpolation.h"
#include "completion/planes.h"
#include "completion/ratio_kernels.h"
#include "completion/spare.h"
#include "parallel.h"

namespace bob {
namespace {

struct Level {
    Planes sums;   // ratio_sums::channels
    Planes means;  // ratio_means::channels
};

/// Coarser and coarser levels down to one block, and one of means alone that is coarser than all: white, and bright.
struct Images {
    int height, width;
    std::vector<Level> levels;

    Images(int height, int width) : height(height), width(width) {
        for (bool last = false; !last;) {
            last = height == 1 && width == 1 && !levels.empty();
            height = half(height), width = half(width);
            levels.push_back({{last ? 0 : ratio_sums::channels, height, width}, {ratio_means::channels, height, width}});
        }
        for (int c = 0; c < ratio_means::channels; ++c) std::fill_n(levels.back().means.row(c, 0) - 1, 3, 1.f);
    }
};

/// Of small pictures alone, for which fresh memory costs more than the arithmetic.
constexpr std::size_t kept_pixels = 1 << 20;

Spare<Images> spare;

DoubledMeans doubled(const Planes& means, int y) {
    DoubledMeans result{};
    for (int c = 0; c < ratio_means::channels; ++c) {
        result.of[c] = doubled_rows(means, c, y);
    }
    return result;
}

}  // namespace

void complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                       std::optional<float> unit, int height, int width, float* output) {
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
    for_rows(0, finest.height(), 2 * width, [&](int y) {
        const int rows = std::min(height - 2 * y, 2);
        const auto pair = [&](const float* plane) { return PixelRows{{plane + 2 * y * stride, -stride, stride, pixels}, rows, width}; };
        kernels.pull_pixels(pair(known_guide), pair(color), rows_of(finest, 0, y), finest.width());
    });
    const std::size_t coarsest = levels.size() - 1;
    for (std::size_t n = 1; n < coarsest; ++n) {
        const Planes& finer = levels[n - 1].sums;
        Planes& sums = levels[n].sums;
        for_rows(0, sums.height(), 2 * sums.width(), [&](int y) {
            kernels.pull(rows_of(finer, 0, 2 * y), rows_of(sums, 0, y), sums.width());
        });
    }
    const float one = unit.value_or(1);
    for (std::size_t n = coarsest; n-- > 0;) {
        const Planes &coarse = levels[n + 1].means, &sums = levels[n].sums;
        Planes& means = levels[n].means;
        for_rows(0, coarse.height(), 2 * means.width(), [&](int y) {
            kernels.mean(doubled(coarse, y), rows_of(sums, 0, 2 * y), rows_of(sums, 0, 2 * y + 1), rows_of(means, 0, 2 * y), one, coarse.width());
            for (int finer = 2 * y; finer < std::min(2 * y + 2, means.height()); ++finer) {
                for (int c = 0; c < ratio_means::channels; ++c) {
                    repeat_edges(means.row(c, finer), means.width());
                }
            }
        });
    }
    const float high = unit ? std::numeric_limits<float>::infinity() : channel.high;
    for_rows(0, finest.height(), 2 * width, [&](int y) {
        const std::ptrdiff_t first = 2 * y * stride;
        GuidedRows traced{{}, {}, pixels, width};
        for (int i = 0; i < 4; ++i) {
            const int row = 2 * y + i - 1;
            if (row < 0 || row >= height) continue;
            traced.guide[i] = known_guide + row * stride, traced.color[i] = color + row * stride;
        }
        kernels.finish(doubled(levels[0].means, y), traced,
                       {output + first, planes + first, guide + first, pixels, stride, std::min(height - 2 * y, 2), channel.low, high}, one,
                       finest.width());
    });
    if (pixels <= kept_pixels) spare.give_back(std::move(images));
}

void complete_along(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                    std::optional<float> unit, int height, int width, float* output) {
    complete_by_ratio(known, planes, channel, known_guide, guide, unit, height, width, output);
    interpolate_lattice(known, planes, channel, unit.value_or(1), output, nullptr, height, width);
}

}  // namespace bob
