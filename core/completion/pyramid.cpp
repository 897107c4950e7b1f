#include "completion/pyramid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "completion/needed.h"
#include "completion/pyramid_kernels.h"

namespace bob {
namespace {

constexpr int most_levels = 10;

// Channels of a level's inputs: gray and the features of traced pixels. Channels from the coarser level follow.
constexpr int known = 8;
// Channels of level 1's inputs: gray, normal x, normal y, and the phases of the mask and of the surprise.
constexpr int known_finest = 11, first_mask = 3, first_surprise = 7;

constexpr int known_at(int level) { return level == 1 ? known_finest : known; }

// Level 1 is completed in tiles of at most `tile_width` columns, a few rows at a time. The images between its layers
// stay in the second-level cache of a core: .6 MB for 320 columns.
constexpr int tile_width = 512, tile_rows = 4;
// Influence of pixels past a tile's edge: columns, in whole vectors, and rows that are computed twice.
constexpr int halo_columns = 16, halo_rows = 6;
// Minimum rows of a tile: with fewer, the overlap costs more than threads gain. Minimum rows of all tiles side by side:
// with fewer, the overlap costs more than the memory saved.
constexpr int least_tile_rows = 16, least_rows = 32;

/// Rows per convolution step of a level. Four where the bulk of the arithmetic is; two where rows are so high that four
/// would make pixels depend on distant ones.
constexpr int rows_at_once(int level) { return level <= 3 ? 4 : 2; }

/// Up to this level, only parts that the picture shows are convolved. Nearly everything is needed of coarser ones.
constexpr int last_in_parts = 3;

constexpr int rounded_up(int size, int multiple) { return (size + multiple - 1) / multiple * multiple; }

}  // namespace

/// Rows and columns of level 1, completed independently.
struct Pyramid::Tile {
    int top, bottom, left, right;
};

struct Pyramid::Pixels {
    const float* gbuffer;
    int height, width;

    /// The pixels of a row of level 1, from `column` on.
    [[nodiscard]] PixelRows rows(int y, int column = 0) const {
        const auto stride = static_cast<std::ptrdiff_t>(width);
        const int known_rows = std::clamp(height - 2 * y, 0, 2);
        return {{gbuffer + (known_rows > 0 ? 2 * y * stride : 0) + 2 * column, -stride, stride, static_cast<std::size_t>(height * stride)},
                known_rows, width - 2 * column};
    }
};

/// Progress of the steps of a level, in its rows.
struct Pyramid::Progress {
    int sums, known, features, finer;
};

/// Progress that level 2 and coarser need for `finished` rows of level 1, of `height`; level 2 first. Each step reads
/// the row below its own; convolutions take several rows at a time, and doubling takes two.
std::vector<Pyramid::Progress> Pyramid::needed(int finished, int height) const {
    std::vector<Progress> result;
    int asked = half(std::min(layers(1).features.whole(finished + 1, height) + 2, height));
    for (int level = 2; level <= levels(); ++level) {
        height = half(height);
        Progress p{};
        p.finer = layers(level).finer.whole(asked, height);
        p.features = layers(level).features.whole(p.finer + 1, height);
        p.known = std::min(rounded_up(p.features + 1, 2), height);
        p.sums = std::min(p.known + 1, height);
        asked = half(p.known);
        result.push_back(p);
    }
    return result;
}

/// First rows that the steps need for rows of level 1 from `begin` on; as `needed`.
std::vector<Pyramid::Progress> Pyramid::first_needed(int begin) const {
    std::vector<Progress> result;
    int handed = std::max(0, begin - halo_rows), coarsest = begin;
    for (int level = 2; level <= levels(); ++level) {
        const int at_once = rows_at_once(level);
        Progress p{};
        p.finer = handed / 2 / at_once * at_once;
        p.features = std::max(0, p.finer - 1) / at_once * at_once;
        // Doubling the finer level's picture reads three rows.
        p.known = std::max(0, std::min(p.features, handed / 2) - 1) / 2 * 2;
        p.sums = std::max(0, p.known - 1);
        coarsest = std::min(coarsest, p.sums >> (levels() - level));
        handed = p.known;
        result.push_back(p);
    }
    if (!result.empty()) result.back().sums = coarsest;  // computes the other levels too
    return result;
}

/// The images between the layers of level 1, in a tile.
struct Pyramid::Finest {
    int height, width;
    Planes known;       // of `features`, without the channels from the coarser level
    Planes features;
    Planes corrected;   // gray + surprise (1)
    Planes shown;       // (1)
    Planes surface;     // (1)
    Planes correction;  // to the pixels, in phases (4)

    Finest(int height, int width, const Layers& layers)
        : height(height), width(width), known(known_finest, height, width, window), features(layers.features.out(), height, width, window),
          corrected(1, height, width, window), shown(1, height, width, window), surface(1, height, width, tile_rows),
          correction(4, height, width, tile_rows) {}

    static std::size_t bytes(int width, const Layers& layers) {
        const int rows = window * (known_finest + layers.features.out() + 2) + 2 * tile_rows * 5;
        return sizeof(float) * static_cast<std::size_t>(rows) * static_cast<std::size_t>(width + 32);
    }

private:
    static constexpr int window = halo_rows + tile_rows + halo_rows;
};

/// The images between the layers of the coarser levels.
struct Pyramid::Images {
    struct Level {
        Planes sums;       // sums::channels
        Planes known;      // of `features`: gray, and the features of traced pixels
        Planes features;
        Planes handed;     // to the finer level, in its size
        Planes corrected;  // gray + surprise (1)
        Planes surface;    // (1)
    };
    /// Rows kept at a time, of a level and of its output to the finer level.
    struct Windows {
        int sums = 0, handed = 0, others = 0;
    };

    int height, width;
    int rows;                   // of level 1, finished at a time
    int tiles, tile_columns;    // side by side
    std::vector<Level> levels;  // level 2 first
    Planes everywhere;          // ones: the surface of a level coarser than all (1)
    /// Needed outputs of the layers, level 1 first.
    std::vector<Needed> needed, needed_features;
    mutable Spare<Finest> finest;

    Images(int height, int width, const Pyramid& network)
        : height(height), width(width), tiles((half(width) + tile_width - 1) / tile_width),
          tile_columns(rounded_up((half(width) + tiles - 1) / tiles, halo_columns)),
          everywhere(1, 1, (half(width) >> network.levels()) + 1), finest(static_cast<std::size_t>(thread_count())) {
        std::fill_n(everywhere.row(0, 0), everywhere.width(), 1.f);
        const auto windows = plan(network);
        height = half(height), width = half(width);
        for (int level = 2; level <= network.levels(); ++level) {
            const Layers& layers = network.layers(level);
            const auto [sum_rows, handed_rows, rows] = windows[static_cast<std::size_t>(level - 2)];
            Planes handed(layers.finer.out() / 4, height, width, handed_rows);
            height = half(height), width = half(width);
            levels.push_back({{sums::channels, height, width, sum_rows}, {bob::known, height, width, rows},
                              {layers.features.out(), height, width, rows}, std::move(handed),
                              {1, height, width, rows}, {1, height, width, rows}});
        }
    }

    Level& level(int number) { return levels[static_cast<std::size_t>(number - 2)]; }
    const Level& level(int number) const { return levels[static_cast<std::size_t>(number - 2)]; }

    void need_all(int levels) {
        needed.clear();
        for (int level = 1, h = half(height), w = half(width); level <= std::min(levels, last_in_parts); ++level, h = half(h), w = half(w)) {
            needed.emplace_back(h, w);
        }
        needed_features = needed;
    }
    [[nodiscard]] Wanted wanted(int level, int column = 0) const { return part(needed, level, column); }
    [[nodiscard]] Wanted wanted_features(int level, int column = 0) const { return part(needed_features, level, column); }

    /// Columns of a tile and its halo.
    [[nodiscard]] int columns() const {
        const int all = half(width);
        return std::min(all, tile_columns + 2 * halo_columns + all % 2);  // rounds to an even number
    }

private:
    static Wanted part(const std::vector<Needed>& parts, int level, int column) {
        const auto index = static_cast<std::size_t>(level - 1);
        return index < parts.size() ? Wanted{&parts[index], column} : Wanted{};
    }

    /// Chooses the largest `rows` that fit the network's memory and divide the picture evenly. Returns the windows of
    /// each level.
    std::vector<Windows> plan(const Pyramid& network) {
        std::vector<Windows> windows;
        const std::size_t of_tiles = static_cast<std::size_t>(thread_count()) * Finest::bytes(columns(), network.layers(1));
        int parts = 1;
        do {
            rows = rounded_up(std::max(half(height) / parts, least_rows), tile_rows);
            windows = windows_of(rows, half(height), network);
        } while (rows > least_rows && ++parts && of_tiles + bytes(windows, half(width), network) > network.memory_);
        return windows;
    }

    /// The windows of each level for `rows` rows of level 1, of `height`, at a time, wherever a band begins.
    static std::vector<Windows> windows_of(int rows, int height, const Pyramid& network) {
        std::vector<Windows> result(network.layers_.size() - 1);
        for (int finished = 0; finished < height; finished += rows_at_once(1)) {
            const auto next = network.needed(std::min(finished + rows, height), height), first = network.first_needed(finished);
            for (std::size_t i = 0; i < next.size(); ++i) {
                const int pulled = next.back().sums << (next.size() - 1 - i);
                result[i].sums = std::max(result[i].sums, pulled - std::max(0, first[i].known - 1));
                result[i].handed = std::max(result[i].handed, 2 * (next[i].finer - first[i].finer));
                result[i].others = std::max(result[i].others, next[i].known - first[i].known);
            }
        }
        return result;
    }

    static std::size_t bytes(const std::vector<Windows>& windows, int width, const Pyramid& network) {
        std::size_t floats = 0;
        for (std::size_t i = 0; i < windows.size(); ++i) {
            const Layers& layers = network.layers_[i + 1];
            const auto row = [&](int level) { return static_cast<std::size_t>((width >> level) + 48); };
            floats += static_cast<std::size_t>(layers.finer.out() / 4 * windows[i].handed) * row(static_cast<int>(i)) +
                      static_cast<std::size_t>(sums::channels * windows[i].sums + (bob::known + layers.features.out() + 2) * windows[i].others) *
                          row(static_cast<int>(i) + 1);
        }
        return sizeof(float) * floats;
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
        const int rows = rows_at_once(level);
        auto features = conv3x3(weights, "features" + number, known_at(level) + handed, rows);
        auto finer = level > 1 ? conv3x3(weights, "finer" + number, features.out(), rows)
                               : conv3x3(weights, "finer" + number, features.out(), 4, rows);
        handed = finer.out() / 4;
        layers_.push_back({std::move(features), std::move(finer)});
    }
    std::reverse(layers_.begin(), layers_.end());
}

Pyramid::~Pyramid() = default;

void Pyramid::operator()(const float* gbuffer, int height, int width, float* gray, Band band) const {
    auto images = spare_.take(height, width, *this);
    const Pixels pixels{gbuffer, height, width};
    const int all_rows = half(height), columns = half(width);
    // The convolution step's first row of level 1.
    const int begin = band.begin / 2 / rows_at_once(1) * rows_at_once(1), rows = std::min(half(band.end), all_rows);

    const auto index = [](int level) { return static_cast<std::size_t>(level - 2); };
    images->need_all(levels());
    std::vector<Progress> done = first_needed(begin);
    for (int finished = begin; finished < rows; finished += images->rows) {
        const int until = std::min(finished + images->rows, rows);
        const auto next = needed(until, all_rows);
        if (levels() > 1) {
            pull(pixels, *images, done.back().sums, next.back().sums);
            for (int level = levels(); level >= 2; --level) find_surface(level, *images, done[index(level)], next[index(level)]);
            find_needed(*images, done.front().known, next.front().known);
        }
        for (int level = levels(); level >= 2; --level) {
            const Progress &from = done[index(level)], &to = next[index(level)];
            auto& here = images->level(level);
            know(level, *images, from, to);
            const Planes& handed = level < levels() ? images->level(level + 1).handed : here.known;
            layers(level).features({here.known, 0, bob::known}, {handed, 0, layers(level).features.in() - bob::known},
                                   here.features, 0, Then::relu, from.features, to.features, images->wanted_features(level));
            layers(level).finer(here.features, 0, here.handed, 0, Then::shuffle, from.finer, to.finer, images->wanted(level));
        }
        done = next;

        // An equal number of tiles for each thread.
        int bands = 1;
        while (images->tiles * bands % thread_count() != 0 && (bands + 1) * least_tile_rows <= until - finished) ++bands;
        const int tile_height = rounded_up((until - finished + bands - 1) / bands, rows_at_once(1));
        parallel_for(static_cast<std::size_t>(images->tiles * bands), 1, [&](std::size_t first, std::size_t last) {
            for (int i = static_cast<int>(first); i < static_cast<int>(last); ++i) {
                const int top = finished + i / images->tiles * tile_height, left = i % images->tiles * images->tile_columns;
                complete({top, std::min(top + tile_height, until), left, std::min(left + images->tile_columns, columns)}, pixels,
                         *images, gray);
            }
        });
    }
    spare_.give_back(std::move(images));
}

void Pyramid::pull(const Pixels& pixels, Images& images, int begin, int end) const {
    const auto& kernels = best_pyramid_kernels();
    const int width = half(images.width);
    // Pulls all levels of one row of coarsest blocks while they are in the cache.
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

void Pyramid::know(int level, Images& images, const Progress& done, const Progress& next) const {
    const auto& kernels = best_pyramid_kernels();
    auto& here = images.level(level);
    const int height = here.sums.height(), width = here.sums.width();
    const bool coarsest = level == levels();
    for_rows(half(done.known), half(next.known), 2 * width, [&](int pair) {
        if (coarsest) {
            for (int y = 2 * pair; y < std::min(2 * pair + 2, height); ++y) std::fill_n(here.known.row(0, y), width, 0.f);
        } else {
            const auto& coarser = images.level(level + 1);
            kernels.enlarge(doubled_rows(coarser.corrected, 0, pair), rows_of(coarser.handed, 0, 2 * pair), rows_of(here.known, 0, 2 * pair),
                            half(width));
            if (2 * pair + 1 == height) here.known.clear_tail(0, height);
        }
        for (int y = 2 * pair; y < std::min(2 * pair + 2, next.known); ++y) {
            const ConstRows sums = rows_of(std::as_const(here.sums), 0, y);
            float* const corrected = here.corrected.row(0, y);
            kernels.know(sums, rows_of(here.known, 0, y), corrected, static_cast<float>(1 << level), width);
            repeat_edges(corrected, width);
            for (int c = 0; c < bob::known; ++c) here.known.clear_tail(c, y);
        }
    });
}

void Pyramid::find_surface(int level, Images& images, const Progress& done, const Progress& next) const {
    const auto& kernels = best_pyramid_kernels();
    auto& here = images.level(level);
    const int width = here.sums.width();
    for_rows(done.known, next.known, width, [&](int y) {
        const float* const coarser = level == levels() ? images.everywhere.row(0, 0) : images.level(level + 1).surface.row(0, y / 2);
        kernels.spread(rows_of(std::as_const(here.sums), sums::shown, y), coarser, here.surface.row(0, y), width);
    });
}

void Pyramid::find_needed(Images& images, int done, int next) {
    constexpr int rows = Needed::block_rows / 2;  // of level 2; its columns are blocks of level 1
    const auto& surface = images.level(2).surface;
    Needed& finest = images.needed.front();
    for (int y = (done + rows - 1) / rows; y < finest.down() && rows * y < next; ++y) {
        const bool is_whole = rows * y + rows <= next || next == surface.height();
        if (!is_whole) break;
        std::uint8_t* const to = finest.row(y);
        std::fill_n(to, finest.across(), std::uint8_t{0});
        for (int i = rows * y; i < std::min(rows * y + rows, surface.height()); ++i) {
            const float* const from = surface.row(0, i);
            for (int x = 0; x < finest.across(); ++x) to[x] |= from[x] != 0;
        }
    }
    for (std::size_t i = 0;; ++i) {
        images.needed_features[i] = images.needed[i].with_neighbours();
        if (i + 1 == images.needed.size()) break;
        // The inputs of the features, and the pixels around them that a surprise reads, are within two blocks.
        images.needed[i + 1] = images.needed_features[i].with_neighbours().halved();
    }
}

void Pyramid::complete(const Tile& tile, const Pixels& pixels, const Images& images, float* gray) const {
    const auto& kernels = best_pyramid_kernels();
    const Images::Level* const coarser = levels() > 1 ? &images.level(2) : nullptr;
    const int height = half(images.height), width = images.columns();
    const int column = std::min(std::max(0, tile.left - halo_columns), half(images.width) - width);  // the first column computed
    auto finest = images.finest.take(height, width, layers(1));
    auto& [finest_height, finest_width, known, features, corrected, shown, surface, correction] = *finest;

    // Progress of the steps. A tile recomputes its dependencies above it: four rows of features, from the rows around
    // them.
    struct { int known, compared, features; } done{std::max(0, tile.top - halo_rows), std::max(0, tile.top - 5), std::max(0, tile.top - 4)};
    for (int finished = tile.top; finished < tile.bottom; finished += tile_rows) {
        const int until = std::min(finished + tile_rows, tile.bottom);
        auto next = done;
        next.features = layers(1).features.whole(until + 1, height);
        next.compared = std::min(next.features + 1, height);
        next.known = std::min(next.compared + 1, height);

        for (int y = done.known; y < next.known; ++y) {
            if (!coarser) {
                std::fill_n(known.row(0, y), width, 0.f);
            } else if (y % 2 == 0) {
                ConstRows handed = rows_of(coarser->handed, 0, y);
                handed.row += column;
                kernels.enlarge(doubled_rows(coarser->corrected, 0, y / 2, column / 2), handed, rows_of(known, 0, y), half(width));
                if (y + 1 == height) known.clear_tail(0, height);
            }
            kernels.know_finest(pixels.rows(y, column), rows_of(known, 0, y), corrected.row(0, y), shown.row(0, y), width);
            repeat_edges(corrected.row(0, y), width);
            shown.clear_tail(0, y);
            for (int c = 0; c < first_surprise; ++c) known.clear_tail(c, y);
        }
        for (int y = done.compared; y < next.compared; ++y) {
            kernels.compare(doubled_rows(corrected, 0, y), pixels.rows(y, column), rows_of(std::as_const(known), first_mask, y),
                            rows_of(known, first_surprise, y), width);
            for (int c = first_surprise; c < known_finest; ++c) known.clear_tail(c, y);
        }
        layers(1).features({known, 0, known_finest},
                           {coarser ? coarser->handed : known, 0, layers(1).features.in() - known_finest, coarser ? column : 0}, features, 0,
                           Then::relu, done.features, next.features, images.wanted_features(1, column));
        layers(1).finer(features, 0, correction, 0, Then::nothing, finished, until, images.wanted(1, column));
        for (int y = finished; y < until; ++y) {
            const float* const of_coarser = coarser ? coarser->surface.row(0, y / 2) + column / 2 : images.everywhere.row(0, 0) + column / 2;
            kernels.spread(rows_of(std::as_const(shown), 0, y), of_coarser, surface.row(0, y), width);
            const std::ptrdiff_t stride = images.width;
            kernels.finish(doubled_rows(corrected, 0, y), rows_of(std::as_const(known), first_mask, y),
                           rows_of(std::as_const(known), first_surprise, y), rows_of(std::as_const(correction), 0, y), surface.row(0, y),
                           {gray + 2 * y * stride + 2 * column, stride, std::min(2, images.height - 2 * y), images.width - 2 * column},
                           tile.left - column, tile.right - column);
        }
        done = next;
    }
    images.finest.give_back(std::move(finest));
}

}  // namespace bob
