#include "completion/filling.h"

#include <algorithm>
#include <array>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "completion/filling_kernels.h"
#include "completion/planes.h"

namespace bob {
namespace {

// Minimum number of block rows that a thread completes at a time; rows next to a piece are compared twice.
constexpr int min_band_rows = 16;

DoubledPair doubled(const Planes& filled, int y) {
    return {doubled_rows(filled, filled::coverage, y), doubled_rows(filled, filled::gray, y)};
}

}  // namespace

/// Refines the pictures of the coarser level by the traced pixels of a level's blocks, two rows at a time.
class Filling::Correction {
public:
    /// `counts_of(y)` returns the counts of the rows 2y and 2y + 1.
    Correction(const Planes& coarse, std::function<ConstRows(int)> counts_of)
        : coarse_(coarse), counts_of_(std::move(counts_of)), surprise_(surprise::channels, coarse.height(), coarse.width(), 3) {}

    /// Writes the rows 2y and 2y + 1; y is one more than in the last call.
    void operator()(int y, Planes& filled) {
        const auto& kernels = best_filling_kernels();
        const int height = coarse_.height(), width = coarse_.width();
        if (compared_ < 0) compared_ = std::max(y - 1, 0);
        for (; compared_ < std::min(y + 2, height); ++compared_) {
            kernels.compare(doubled(coarse_, compared_), counts_of_(compared_), rows_of(surprise_, 0, compared_), width);
        }
        kernels.correct(doubled(coarse_, y), rows_of(std::as_const(surprise_), 0, y), rows_of(filled, 0, 2 * y), width);
        for (int channel = 0; channel < filled::channels; ++channel) {
            for (int finer = 2 * y; finer < std::min(2 * y + 2, filled.height()); ++finer) {
                repeat_edges(filled.row(channel, finer), filled.width());
            }
        }
    }

private:
    const Planes& coarse_;
    std::function<ConstRows(int)> counts_of_;
    Planes surprise_;    // a window of rows
    int compared_ = -1;  // rows so far
};

struct Filling::Pixels {
    const float* planes;
    int height, width;

    [[nodiscard]] PixelRows rows(int y) const {
        const auto stride = static_cast<std::ptrdiff_t>(width);
        const int known_rows = std::clamp(height - 2 * y, 0, 2);
        return {{planes + (known_rows > 0 ? 2 * y * stride : 0), -stride, stride, static_cast<std::size_t>(height * stride)}, known_rows, width};
    }
};

/// The images of level 2 and coarser. Level 1 is computed in bands, together with the pixels.
struct Filling::Images {
    struct Level {
        Planes counts;  // counts::channels
        Planes filled;  // filled::channels
    };

    int height, width;
    std::vector<Level> of;  // level 2 first; the last is a level of zeros, coarser than all

    Images(int height, int width) : height(height), width(width) {
        height = half(height), width = half(width);
        for (int level = 2; level <= levels + 1; ++level) {
            height = half(height), width = half(width);
            of.push_back({{level <= levels ? counts::channels : 0, height, width}, {filled::channels, height, width}});
        }
        for (int channel = 0; channel < filled::channels; ++channel) {
            for (int y = 0; y < height; ++y) std::fill_n(at(levels + 1).filled.row(channel, y), width, 0.f);
        }
    }

    Level& at(int level) { return of[static_cast<std::size_t>(level - 2)]; }
};

Filling::Filling(const Weights& weights) : Network(weights, {channels::mask, channels::gray}, {channels::gray}) {
    if (!weights.tensors.empty()) throw std::invalid_argument(weights.tensors.begin()->first + ": expected no tensors");
}

Filling::~Filling() = default;

std::array<Band, Filling::levels> Filling::needed(Band band) {
    std::array<Band, levels> result;
    result[0] = {band.begin / 2, half(band.end)};
    // A result depends on two rows on either side in its own level 1 and in all coarser corrected levels.
    const auto coarser = [](Band rows) { return Band{std::max(0, rows.begin - 2) / 2, half(rows.end + 2)}; };
    Band corrected = coarser(result[0]);
    for (std::size_t i = 1; i < result.size(); ++i) result[i] = corrected = coarser(corrected);
    return result;
}

void Filling::operator()(const float* planes, int height, int width, float* gray, Band band) const {
    auto images = spare_.take(height, width);
    const Pixels pixels{planes, height, width};
    parallel_for(static_cast<std::size_t>(images->at(levels).counts.height()), 1, [&](std::size_t begin, std::size_t end) {
        pull(pixels, *images, static_cast<int>(begin), static_cast<int>(end));
    });
    const auto parts = needed(band);
    for (int level = levels; level >= 1; --level) {
        const Band& part = parts[static_cast<std::size_t>(level - 1)];
        const int all = level > 1 ? images->at(level + 1).filled.height() : half(height);
        const int top = part.begin, rows = std::min(part.end, all) - top;
        const int bands = std::clamp(rows / min_band_rows, 1, thread_count());
        parallel_for(static_cast<std::size_t>(bands), 1, [&](std::size_t first, std::size_t last) {
            const int begin = top + static_cast<int>(first) * rows / bands, end = top + static_cast<int>(last) * rows / bands;
            if (level > 1) {
                push(level, *images, begin, end);
            } else {
                finish(pixels, *images, gray, begin, end);
            }
        });
    }
    spare_.give_back(std::move(images));
}

void Filling::pull(const Pixels& pixels, Images& images, int begin, int end) {
    const auto& kernels = best_filling_kernels();
    // Pulls all levels of one row of coarsest blocks while they are in the cache.
    const int width = half(images.width);
    Planes finest(counts::channels, 2, width);
    for (int coarsest = begin; coarsest < end; ++coarsest) {
        for (int level = 2; level <= levels; ++level) {
            Planes& to = images.at(level).counts;
            const int per_block = 1 << (levels - level);
            for (int y = coarsest * per_block; y < std::min((coarsest + 1) * per_block, to.height()); ++y) {
                if (level == 2) {
                    for (int i = 0; i < 2; ++i) kernels.pull_pixels(pixels.rows(2 * y + i), rows_of(finest, 0, i), width);
                }
                const Planes& finer = level == 2 ? finest : images.at(level - 1).counts;
                kernels.pull(rows_of(finer, 0, level == 2 ? 0 : 2 * y), rows_of(to, 0, y), to.width());
            }
        }
    }
}

void Filling::push(int level, Images& images, int begin, int end) {
    const Planes& coarse = images.at(level + 1).filled;
    const Planes& counts = images.at(level).counts;
    Correction correction(coarse, [&](int y) { return rows_of(counts, 0, 2 * y); });
    for (int y = begin; y < end; ++y) correction(y, images.at(level).filled);
}

void Filling::finish(const Pixels& pixels, Images& images, float* gray, int begin, int end) {
    const auto& kernels = best_filling_kernels();
    const int height = half(pixels.height), width = half(pixels.width);
    // Windows of a few rows of level 1.
    Planes counts(counts::channels, height, width, 2), filled(filled::channels, height, width, 6);
    Correction correction(images.at(2).filled, [&](int y) {
        for (int finer = 2 * y; finer < std::min(2 * y + 2, height); ++finer) {
            kernels.pull_pixels(pixels.rows(finer), rows_of(counts, 0, finer), width);
        }
        return rows_of(std::as_const(counts), 0, 2 * y);
    });
    Planes surprise(surprise::channels, height, width, 3);
    int made = std::max(begin - 2, 0) / 2;  // pairs of rows
    for (int y = std::max(begin - 1, 0), compared = y; y < end; ++y) {
        for (; compared < std::min(y + 2, height); ++compared) {
            for (; 2 * made < std::min(compared + 2, height); ++made) correction(made, filled);
            kernels.compare_pixels(doubled(filled, compared), pixels.rows(compared), rows_of(surprise, 0, compared), width);
        }
        if (y < begin) continue;
        const std::ptrdiff_t stride = pixels.width;
        kernels.finish(doubled(filled, y), rows_of(std::as_const(surprise), 0, y),
                       {gray + 2 * y * stride, stride, std::min(2, pixels.height - 2 * y), pixels.width}, width);
    }
}

}  // namespace bob
