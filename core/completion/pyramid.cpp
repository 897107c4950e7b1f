#include "completion/pyramid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "completion/pyramid_kernels.h"
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
    return {planes.row(channel, y), planes.offset(y, y - 1), planes.offset(y, y + 1), planes.plane_stride()};
}
Rows rows_of(Planes& planes, int channel, int y) {
    return {planes.row(channel, y), planes.offset(y, y - 1), planes.offset(y, y + 1), planes.plane_stride()};
}

Doubled doubled(const Planes& planes, int y) {
    return {planes.row(0, std::max(y - 1, 0)), planes.row(0, y), planes.row(0, std::min(y + 1, planes.height() - 1))};
}

void repeat_edges(float* row, int width) {
    row[-1] = row[0];
    row[width] = row[width - 1];
}

}  // namespace

struct Pyramid::Pixels {
    const float* gbuffer;
    int height, width;

    /// The pixels of a row of level 1.
    [[nodiscard]] PixelRows rows(int y) const {
        const auto stride = static_cast<std::ptrdiff_t>(width);
        const int known_rows = std::clamp(height - 2 * y, 0, 2);
        return {{gbuffer + (known_rows > 0 ? 2 * y * stride : 0), -stride, stride, static_cast<std::size_t>(height * stride)},
                known_rows, width};
    }
};

/// How far the steps of a level have come, in its rows.
struct Pyramid::Progress {
    int sums, known;
    int compared;  // of level 1: pixels
    int features, finer;
};

/// How far the steps of all levels must come for `finished` rows of level 1, of `height`; of level 1 first. A step sees the row
/// below those that it makes; convolutions take rows in pairs, and so does what doubles the coarser picture.
std::vector<Pyramid::Progress> Pyramid::needed(int finished, int height, int levels) {
    std::vector<Progress> result;
    for (int level = 1, asked = finished; level <= levels; ++level, height = half(height)) {
        const auto pairs = [&](int rows) { return std::min((rows + 1) / 2 * 2, height); };
        Progress p{};
        p.finer = pairs(asked);
        p.features = pairs(p.finer + 1);
        p.compared = std::min(p.features + 1, height);
        p.known = pairs(level == 1 ? p.compared + 1 : p.compared);
        p.sums = std::min(p.known + 1, height);
        asked = half(p.known);
        result.push_back(p);
    }
    return result;
}

struct Pyramid::Images {
    struct Level {
        Planes sums;       // sums::channels
        Planes inputs;     // of `features`: gray, known | handed on
        Planes features;
        Planes corrected;  // gray + surprise (1)
        Planes surface;    // (1)
    };
    /// Rows of a level that must be kept at once.
    struct Windows {
        int sums = 0, others = 0;
    };

    int height, width;
    int rows;                   // of level 1 that are finished at once
    std::vector<Level> levels;  // level 1 first
    Planes everywhere;          // ones: the surface of a level coarser than all (1)
    Planes correction;          // finer, of level 1, in phases (4)

    Images(int height, int width, const std::vector<Layers>& layers, std::size_t memory)
        : Images(height, width, layers, rows_within(memory, half(height), half(width), layers), 0) {}

    Level& level(int number) { return levels[static_cast<std::size_t>(number - 1)]; }
    const Level& level(int number) const { return levels[static_cast<std::size_t>(number - 1)]; }

private:
    Images(int height, int width, const std::vector<Layers>& layers, int rows, int)
        : height(height),
          width(width),
          rows(rows),
          everywhere(1, 1, (width >> layers.size()) + 1),
          correction(4, half(height), half(width), rows + 2) {
        levels.reserve(layers.size());
        const auto windows = windows_of(rows, half(height), static_cast<int>(layers.size()));
        for (std::size_t i = 0; i < layers.size(); ++i) {
            height = half(height), width = half(width);
            const int in = layers[i].features.in(), out = layers[i].features.out();
            levels.push_back({{sums::channels, height, width, windows[i].sums}, {in, height, width, windows[i].others},
                              {out, height, width, windows[i].others}, {1, height, width, windows[i].others},
                              {1, height, width, windows[i].others}});
        }
        std::fill_n(everywhere.row(0, 0), everywhere.width(), 1.f);
    }

    /// The windows of each level if `rows` rows of level 1, of `height`, are finished at once.
    static std::vector<Windows> windows_of(int rows, int height, int levels) {
        std::vector<Windows> result(static_cast<std::size_t>(levels));
        std::vector<Progress> done(result.size(), Progress{});
        for (int finished = 0; finished < height; finished += rows) {
            const auto next = needed(std::min(finished + rows, height), height, levels);
            int seen = finished - 1;  // the first row that the finer level still looks at
            for (std::size_t i = 0; i < next.size(); ++i) {
                const int pulled = i == 0 ? next[0].sums : next.back().sums << (next.size() - 1 - i);
                const int handed = i + 1 < next.size() ? 2 * next[i + 1].finer : 0;
                result[i].sums = std::max(result[i].sums, pulled - (done[i].known - 1));
                result[i].others = std::max(result[i].others, std::max(next[i].known, handed) - seen);
                seen = half(done[i].known) - 1;
            }
            done = next;
        }
        return result;
    }

    /// As many rows of level 1 as fit.
    static int rows_within(std::size_t memory, int height, int width, const std::vector<Layers>& layers) {
        const auto bytes = [&](int rows) {
            const auto windows = windows_of(rows, height, static_cast<int>(layers.size()));
            std::size_t floats = 0;
            for (std::size_t i = 0; i < layers.size(); ++i) {
                const int others = layers[i].features.in() + layers[i].features.out() + (i == 0 ? 4 + 2 : 2);
                floats += static_cast<std::size_t>(sums::channels * windows[i].sums + others * windows[i].others) *
                          static_cast<std::size_t>((width >> i) + 64);
            }
            return 4 * floats;
        };
        int rows = 4;
        while (rows < height && bytes(2 * rows) <= memory) rows *= 2;
        return rows;
    }
};

Pyramid::Pyramid(const Weights& weights, std::size_t memory)
    : Network(weights, {channels::mask, channels::gray, channels::depth, channels::normal}, {channels::gray}),
      memory_(memory) {
    int count = 1;
    while (weights.tensors.contains("features" + std::to_string(count + 1) + ".weight")) ++count;
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
    auto images = spare_.take(height, width, layers_, memory_);
    const Pixels pixels{gbuffer, height, width};

    std::vector<Progress> done(layers_.size(), Progress{});
    int finished = 0;
    while (finished < half(height)) {
        const int until = std::min(finished + images->rows, half(height));
        const auto next = needed(until, half(height), levels());
        pull(pixels, *images, done.back().sums, next.back().sums);
        for (int level = levels(); level >= 1; --level) {
            auto& [sums, inputs, features, corrected, surface] = images->level(level);
            const auto index = static_cast<std::size_t>(level - 1);
            const Layers& layers = layers_[index];
            const Progress &from = done[index], &to = next[index];
            know(level, pixels, *images, from, to);
            if (level == 1) compare_pixels(pixels, *images, from.compared, to.compared);
            layers.features(inputs, 0, features, 0, Then::relu, from.features, to.features);
            if (level > 1) {
                layers.finer(features, 0, images->level(level - 1).inputs, known_at(level - 1), Then::shuffle, from.finer,
                             to.finer);
            } else {
                layers.finer(features, 0, images->correction, 0, Then::nothing, from.finer, to.finer);
            }
        }
        finish(*images, finished, until, height, width, gray);
        finished = until;
        done = next;
    }
    spare_.give_back(std::move(images));
}

void Pyramid::pull(const Pixels& pixels, Images& images, int begin, int end) const {
    if (levels() == 1) return;
    const auto& kernels = best_pyramid_kernels();
    const int width = half(images.width);
    // All levels of a row of the coarsest level's blocks, while they are in the cache.
    parallel_for(static_cast<std::size_t>(end - begin), 1, [&](std::size_t first, std::size_t last) {
        Planes finest(sums::channels, 2, width);
        for (int level = 2; level <= levels(); ++level) {
            Planes& to = images.level(level).sums;
            const int per_block = 1 << (levels() - level);
            const int end_row = std::min((begin + static_cast<int>(last)) * per_block, to.height());
            for (int y = (begin + static_cast<int>(first)) * per_block; y < end_row; ++y) {
                if (level == 2) {
                    for (int i = 0; i < 2; ++i) kernels.pull_pixels(pixels.rows(2 * y + i), rows_of(finest, 0, i), width);
                }
                const Planes& finer = level == 2 ? finest : images.level(level - 1).sums;
                kernels.pull(rows_of(finer, 0, level == 2 ? 0 : 2 * y), rows_of(to, 0, y), static_cast<float>(1 << level) / 4,
                             to.width());
                to.clear_tail(sums::shown, y);
            }
        }
    });
}

void Pyramid::know(int level, const Pixels& pixels, Images& images, const Progress& done, const Progress& next) const {
    const auto& kernels = best_pyramid_kernels();
    auto& to = images.level(level);
    const int height = to.sums.height(), width = to.sums.width();
    const bool coarsest = level == levels();
    if (level == 1) {  // cheaper to sum again than to keep since `pull`
        for_rows(done.sums, next.sums, 2 * width, [&](int y) {
            kernels.pull_pixels(pixels.rows(y), rows_of(to.sums, 0, y), width);
            to.sums.clear_tail(sums::shown, y);
        });
    }
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
        const float* coarser = coarsest ? images.everywhere.row(0, 0) : images.level(level + 1).surface.row(0, y / 2);
        kernels.spread(rows_of(std::as_const(to.sums), sums::shown, y), coarser, to.surface.row(0, y), width);
    };
    for_rows(half(done.known), half(next.known), 2 * width, [&](int y) {
        if (!coarsest) {
            kernels.enlarge(doubled(images.level(level + 1).corrected, y),
                            rows_of(std::as_const(to.inputs), known_at(level), 2 * y), rows_of(to.inputs, 0, 2 * y), half(width));
            if (2 * y + 1 == height) to.inputs.clear_tail(0, height);
        }
        for (int i = 2 * y; i < std::min(2 * y + 2, next.known); ++i) know_row(i);
    });
}

void Pyramid::compare_pixels(const Pixels& pixels, Images& images, int begin, int end) const {
    auto& [sums, inputs, features, corrected, surface] = images.level(1);
    for_rows(begin, end, 4 * inputs.width(), [&](int y) {
        best_pyramid_kernels().compare(doubled(corrected, y), pixels.rows(y), rows_of(inputs, first_mask, y),
                                       rows_of(inputs, first_surprise, y), inputs.width());
        for (int c = first_mask; c < known_finest; ++c) inputs.clear_tail(c, y);
    });
}

void Pyramid::finish(const Images& images, int begin, int end, int height, int width, float* gray) const {
    const auto& [sums, inputs, features, corrected, surface] = images.level(1);
    for_rows(begin, end, 4 * inputs.width(), [&](int y) {
        best_pyramid_kernels().finish(doubled(corrected, y), rows_of(inputs, first_mask, y), rows_of(inputs, first_surprise, y),
                                      rows_of(images.correction, 0, y), surface.row(0, y),
                                      gray + static_cast<std::size_t>(2 * y) * static_cast<std::size_t>(width),
                                      std::min(2, height - 2 * y), width);
    });
}

}  // namespace bob
