#include "completion/ratio.h"

#include <algorithm>
#include <vector>

#include "completion/ratio_kernels.h"
#include "completion/spare.h"
#include "parallel.h"

namespace bob {
namespace {

/// What a coarser level counts against what is gathered: as much of a pixel.
constexpr float prior = 0.02f;

/// What a neighbour above, below or beside counts; one across has the square of it. Sums over 3 x 3 blocks at every level weigh pixels
/// nearly by the fourth power of their distance, and lie where the pixels do, which the means of single blocks do not.
constexpr float beside = 0.25f;

/// Times the mean of the guide around up to which colours may be as saturated as there.
constexpr float brighter = 1.25f;

/// Planes of a size.
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

/// What completing takes, for so many components.
struct Memory {
    int height, width, components;
    Level counts;
    std::vector<Level> sums;   // coarser and coarser, down to one block: of the guide, the components, and the pixels that count
    std::vector<Level> means;  // of the guide, and the components' ratios to it

    Memory(int height, int width, int components)
        : height(height), width(width), components(components), counts(1, height, width) {
        while (sums.empty() || height > 1 || width > 1) {
            height = (height + 1) / 2, width = (width + 1) / 2;
            sums.emplace_back(components + 2, height, width);
            means.emplace_back(components + 1, height, width);
        }
    }
};

/// Of small pictures alone, for which fresh memory costs more than the arithmetic.
constexpr std::size_t kept_pixels = 1 << 20;

Spare<Memory> spare;

/// A row of a plane as the next coarser level expects it; `between` has room for a row of that.
void push(const Level& level, int plane, int y, int finer_width, float* between, float* finer) {
    const int near = y / 2, far = std::clamp(near + (y % 2 ? 1 : -1), 0, level.height - 1);
    best_ratio_kernels().push(level.row(plane, near), level.row(plane, far), level.width, finer_width, between, finer);
}

/// A level's sums of the guide (plane 0), of the components, and of how many pixels have a guide above 0 (the last), turned to means
/// of the guide and ratios to it: row by row, `row_of(plane, y)`, null beyond the picture.
template <class RowOf>
class Means {
public:
    Means(RowOf row_of, int components, int width) : row_of_(row_of), components_(components), width_(width) {}

    /// Mean and ratios of a row from those that the coarser level expects, in its `row(plane)`.
    template <class Expected>
    void operator()(int y, Expected row) const {
        const auto& kernels = best_ratio_kernels();
        thread_local std::vector<float> memory;
        const auto width = static_cast<std::size_t>(width_);
        memory.resize(4 * width + 2);
        float *const guides = memory.data(), *const weights = guides + width, *const sums = weights + width, *const between = sums + width;
        const auto gathered = [&](int plane, float* to) {
            kernels.gather({row_of_(plane, y - 1), row_of_(plane, y), row_of_(plane, y + 1)}, beside, width_, between, to);
        };
        gathered(0, guides);
        kernels.inverse(guides, prior, width_, weights);
        for (int plane = 1; plane <= components_; ++plane) {
            gathered(plane, sums);
            kernels.mean(sums, weights, prior, width_, row(plane));
        }
        gathered(components_ + 1, sums);
        kernels.inverse(sums, prior, width_, weights);
        kernels.mean(guides, weights, prior, width_, row(0));
    }

private:
    RowOf row_of_;
    int components_, width_;
};

}  // namespace

void complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                       int height, int width, float* output) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const int components = channel.components, counts = components + 1;
    const float* const values = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    const auto& kernels = best_ratio_kernels();
    auto memory = spare.take(height, width, components);
    if (memory->components != components) memory = std::make_unique<Memory>(height, width, components);
    for_rows(0, height, width, [&](int y) {
        kernels.count(known_guide + static_cast<std::size_t>(y) * static_cast<std::size_t>(width), width, memory->counts.row(0, y));
    });
    const auto pixel_row = [&](int plane, int y) -> const float* {
        if (y < 0 || y >= height) return nullptr;
        if (plane == counts) return memory->counts.row(0, y);
        const float* const from = plane == 0 ? known_guide : values + static_cast<std::size_t>(plane - 1) * pixels;
        return from + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    };
    const Level* finer = nullptr;
    for (Level& level : memory->sums) {
        const int finer_height = finer ? finer->height : height, finer_width = finer ? finer->width : width;
        for_rows(0, level.height, finer_width, [&](int y) {
            for (int plane = 0; plane <= counts; ++plane) {
                const auto finer_row = [&](int row) { return finer ? finer->row(plane, row) : pixel_row(plane, row); };
                const float* const below = 2 * y + 1 < finer_height ? finer_row(2 * y + 1) : nullptr;
                kernels.pull(finer_row(2 * y), below, finer_width, level.row(plane, y));
            }
        });
        finer = &level;
    }
    for (std::size_t n = memory->sums.size(); n-- > 0;) {
        const Level& sums = memory->sums[n];
        Level& level = memory->means[n];
        const Level* const coarser = n + 1 < memory->means.size() ? &memory->means[n + 1] : nullptr;
        const Means means([&](int plane, int y) { return y >= 0 && y < sums.height ? sums.row(plane, y) : nullptr; }, components,
                          sums.width);
        for_rows(0, level.height, level.width, [&](int y) {
            thread_local std::vector<float> between;
            if (coarser) between.resize(static_cast<std::size_t>(coarser->width));
            for (int plane = 0; plane <= components; ++plane) {
                float* const row = level.row(plane, y);
                if (coarser) {
                    push(*coarser, plane, y, level.width, between.data(), row);
                } else {
                    std::fill_n(row, level.width, 1.f);
                }
            }
            means(y, [&](int plane) { return level.row(plane, y); });
        });
    }
    const Means means(pixel_row, components, width);
    for_rows(0, height, width, [&](int y) {
        thread_local std::vector<float> rows;
        rows.resize(2 * static_cast<std::size_t>(width));
        float *const between = rows.data(), *const mean = between + width;
        const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        const auto row = [&](int plane) { return plane == 0 ? mean : output + static_cast<std::size_t>(plane - 1) * pixels + first; };
        for (int plane = 0; plane <= components; ++plane) push(memory->means[0], plane, y, width, between, row(plane));
        means(y, row);
        for (int plane = 1; plane <= components; ++plane) kernels.shade(guide + first, mean, brighter, width, row(plane));
    });
    if (pixels <= kept_pixels) spare.give_back(std::move(memory));
}

}  // namespace bob
