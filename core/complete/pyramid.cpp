#include "complete/pyramid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "complete/pyramid_kernels.h"
#include "parallel.h"

namespace bob {
namespace {

constexpr int most_levels = 10;

// Channels of a level's inputs: gray, and what is known; what the coarser level hands on follows.
constexpr int known = 8;
// Of level 1's: gray, normal x, normal y, and the phases of the mask and of the surprise.
constexpr int known_finest = 11, first_mask = 3, first_surprise = 7;

constexpr int known_at(int level) { return level == 1 ? known_finest : known; }

/// Blocks of two in so many pixels; the last one may have one alone.
constexpr int half(int size) { return (size + 1) / 2; }

ConstRows rows_of(const Planes& planes, int channel, int y) {
    return {planes.row(channel, y), planes.row_stride(), planes.plane_stride()};
}
Rows rows_of(Planes& planes, int channel, int y) {
    return {planes.row(channel, y), planes.row_stride(), planes.plane_stride()};
}

Doubled doubled(const Planes& planes, int y) {
    return {planes.row(0, std::max(y - 1, 0)), planes.row(0, y), planes.row(0, std::min(y + 1, planes.height() - 1))};
}

void repeat_edges(float* row, int width) {
    row[-1] = row[0];
    row[width] = row[width - 1];
}

/// Calls body(y) for each row of an image, with all threads if there are enough pixels to be worth it.
template <class Body>
void for_rows(int height, int width, Body body) {
    const int grain = std::max(1, 8192 / width);
    parallel_for(static_cast<std::size_t>(height), static_cast<std::size_t>(grain), [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) body(static_cast<int>(y));
    });
}

}  // namespace

struct Pyramid::Images {
    struct Level {
        Planes sums;       // sums::channels
        Planes inputs;     // of `features`: gray, known | handed on
        Planes features;
        Planes corrected;  // gray + surprise (1)
        Planes surface;    // (1)
    };

    int height, width;
    std::vector<Level> levels;  // level 1 first
    Planes everywhere;          // ones: the surface of a level coarser than all (1)
    Planes correction;          // finer, of level 1, in phases (4)

    Images(int height, int width, const std::vector<Layers>& layers)
        : height(height),
          width(width),
          everywhere(1, (height >> layers.size()) / 2 + 1, (width >> layers.size()) / 2 + 1),
          correction(4, half(height), half(width)) {
        levels.reserve(layers.size());
        for (const auto& [features, finer] : layers) {
            height = half(height), width = half(width);
            levels.push_back({{sums::channels, height, width}, {features.in(), height, width},
                              {features.out(), height, width}, {1, height, width}, {1, height, width}});
        }
        for (int y = 0; y < everywhere.height(); ++y) std::fill_n(everywhere.row(0, y), everywhere.width(), 1.f);
    }

    Level& level(int number) { return levels[static_cast<std::size_t>(number - 1)]; }
    const Level& level(int number) const { return levels[static_cast<std::size_t>(number - 1)]; }
};

Pyramid::Pyramid(const Weights& weights) {
    int count = 1;
    while (weights.contains("features" + std::to_string(count + 1) + ".weight")) ++count;
    if (count > most_levels) {
        throw std::invalid_argument("features" + std::to_string(count) + ".weight: expected at most " +
                                    std::to_string(most_levels) + " levels");
    }
    int handed = 0;
    for (int level = count; level >= 1; --level) {
        const std::string number = std::to_string(level);
        auto features = conv3x3(weights, "features" + number, known_at(level) + handed);
        auto finer = level > 1 ? conv3x3(weights, "finer" + number, features.out())
                               : conv3x3(weights, "finer" + number, features.out(), 4);
        handed = finer.out() / 4;
        layers_.push_back({std::move(features), std::move(finer)});
    }
    std::reverse(layers_.begin(), layers_.end());
}

Pyramid::~Pyramid() = default;

void Pyramid::operator()(const float* gbuffer, int height, int width, float* gray) const {
    auto images = spare_.take(height, width, layers_);

    pull(gbuffer, height, width, *images);
    for (int level = levels(); level >= 1; --level) {
        auto& [sums, inputs, features, corrected, surface] = images->level(level);
        const Layers& layers = layers_[static_cast<std::size_t>(level - 1)];
        know(level, *images);
        if (level == 1) compare_pixels(*images);
        layers.features(inputs, 0, features, 0, Then::relu);
        if (level > 1) {
            layers.finer(features, 0, images->level(level - 1).inputs, known_at(level - 1), Then::shuffle);
        } else {
            layers.finer(features, 0, images->correction, 0, Then::nothing);
        }
    }
    finish(*images, height, width, gray);
    spare_.give_back(std::move(images));
}

int Pyramid::bytes_per_pixel() const {
    double floats = 1, area = 1;  // the correction's; of a pixel of the level
    for (const auto& [features, finer] : layers_) {
        area *= 4;
        floats += (sums::channels + features.in() + features.out() + 2) / area;
    }
    return static_cast<int>(std::ceil(4 * floats));
}

void Pyramid::pull(const float* gbuffer, int height, int width, Images& images) const {
    const auto& kernels = best_pyramid_kernels();
    const auto stride = static_cast<std::size_t>(width);
    const auto pull_row = [&](int level, int y) {
        auto& to = images.level(level);
        const Rows sums = rows_of(to.sums, 0, y);
        if (level == 1) {
            const int known_rows = std::clamp(height - 2 * y, 0, 2);
            const int top = known_rows > 0 ? 2 * y : 0;
            kernels.pull_pixels({gbuffer + static_cast<std::size_t>(top) * stride, stride,
                                 stride * static_cast<std::size_t>(height)},
                                known_rows, width, sums, rows_of(to.inputs, first_mask, y),
                                rows_of(to.inputs, first_surprise, y), to.sums.width());
            for (int c = first_mask; c < known_finest; ++c) to.inputs.clear_tail(c, y);
        } else {
            const Planes& finer = images.level(level - 1).sums;
            kernels.pull(rows_of(finer, 0, 2 * y), sums, static_cast<float>(1 << level) / 4, to.sums.width());
        }
        to.sums.clear_tail(sums::shown, y);
    };
    // All levels of a row of the coarsest level's blocks, while they are in the cache.
    const int blocks = images.level(levels()).sums.height();
    parallel_for(static_cast<std::size_t>(blocks), 1, [&](std::size_t begin, std::size_t end) {
        for (int level = 1; level <= levels(); ++level) {
            const int per_block = 1 << (levels() - level);
            const int last = std::min(static_cast<int>(end) * per_block, images.level(level).sums.height());
            for (int y = static_cast<int>(begin) * per_block; y < last; ++y) pull_row(level, y);
        }
    });
}

void Pyramid::know(int level, Images& images) const {
    const auto& kernels = best_pyramid_kernels();
    auto& to = images.level(level);
    const int height = to.sums.height(), width = to.sums.width();
    const bool coarsest = level == levels();
    const auto know_row = [&](int y) {
        const ConstRows sums = rows_of(std::as_const(to.sums), 0, y);
        const Rows inputs = rows_of(to.inputs, 0, y);
        float* corrected = to.corrected.row(0, y);
        if (level > 1) {
            kernels.know(sums, inputs, corrected, static_cast<float>(1 << level), width);
        } else {
            kernels.know_finest(sums, inputs, corrected, width);
        }
        repeat_edges(corrected, width);
        for (int c = 0; c < (level > 1 ? known : first_mask); ++c) to.inputs.clear_tail(c, y);
        const Planes& coarser = coarsest ? images.everywhere : images.level(level + 1).surface;
        kernels.spread(rows_of(std::as_const(to.sums), sums::shown, y), coarser.row(0, y / 2), to.surface.row(0, y), width);
    };
    for_rows(half(height), 2 * width, [&](int y) {
        if (!coarsest) {
            kernels.enlarge(doubled(images.level(level + 1).corrected, y),
                            rows_of(std::as_const(to.inputs), known_at(level), 2 * y), rows_of(to.inputs, 0, 2 * y), half(width));
            if (2 * y + 1 == height) to.inputs.clear_tail(0, height);
        }
        for (int i = 2 * y; i < std::min(2 * y + 2, height); ++i) know_row(i);
    });
}

void Pyramid::compare_pixels(Images& images) const {
    auto& [sums, inputs, features, corrected, surface] = images.level(1);
    for_rows(inputs.height(), 4 * inputs.width(), [&](int y) {
        best_pyramid_kernels().compare(doubled(corrected, y), rows_of(std::as_const(inputs), first_mask, y),
                                       rows_of(inputs, first_surprise, y), inputs.width());
        for (int i = 0; i < 4; ++i) inputs.clear_tail(first_surprise + i, y);
    });
}

void Pyramid::finish(const Images& images, int height, int width, float* gray) const {
    const auto& [sums, inputs, features, corrected, surface] = images.level(1);
    for_rows(half(height), 4 * inputs.width(), [&](int y) {
        best_pyramid_kernels().finish(doubled(corrected, y), rows_of(inputs, first_mask, y), rows_of(inputs, first_surprise, y),
                                      rows_of(images.correction, 0, y), surface.row(0, y),
                                      gray + static_cast<std::size_t>(2 * y) * static_cast<std::size_t>(width),
                                      std::min(2, height - 2 * y), width);
    });
}

}  // namespace bob
