#include "completion/interpolation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

#include "completion/interpolation_kernels.h"
#include "completion/spare.h"
#include "parallel.h"
#include "picture/order.h"

namespace bob {
namespace {

/// Corners that differ by more of a channel's range say nothing about what lies between them.
constexpr float most_contrast = 0.15f;

constexpr float unknown = std::numeric_limits<float>::infinity();

/// The smaller of two, and the larger; b where either is NaN, as in vectors.
float least(float a, float b) { return a < b ? a : b; }
float most(float a, float b) { return a > b ? a : b; }

/// What each pixel is taken for, and by how much the corners that it was made of differ at most: 0 where traced.
struct Nodes {
    int height, width;
    std::unique_ptr<float[]> value, contrast;

    Nodes(int height, int width)
        : height(height), width(width), value(new float[pixels()]), contrast(new float[pixels()]) {}

    [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }
};

Spare<Nodes> spare;
constexpr std::size_t most_spare = 1 << 20;  // pixels of those kept from call to call

class Interpolation {
public:
    /// `weights` may be null.
    Interpolation(const float* mask, const float* traced, float range, float* output, float* weights, int height, int width)
        : mask_(mask), output_(output), weights_(weights), height_(height), width_(width),
          weight_per_contrast_(1 / (most_contrast * range)), nodes_(spare.take(height, width)) {
        parallel_for(nodes_->pixels(), 65536, [&](std::size_t begin, std::size_t end) {
            best_interpolation_kernels().begin(mask + begin, traced + begin, nodes_->value.get() + begin,
                                               nodes_->contrast.get() + begin, end - begin);
        });
    }
    ~Interpolation() {
        if (nodes_->pixels() <= most_spare) spare.give_back(std::move(nodes_));
    }
    Interpolation(const Interpolation&) = delete;
    Interpolation& operator=(const Interpolation&) = delete;

    /// From the coarsest squares to the finest. First the rows in which the middles of squares lie: those pixels, and then those
    /// between them and the corners above and below. Then the other rows, so that none is written that another thread reads.
    void operator()() {
        for (int step = static_cast<int>(Tile::side) / 2; step > 0; step /= 2) {
            for (const bool middles : {true, false}) {
                const int lattice = lattice_first % step;  // rows and columns of the lattices so far lie at multiples of the step from there
                const int even = lattice + (is_odd(lattice, step) ? step : 0), odd = lattice + (is_odd(lattice, step) ? 0 : step);
                const int first = middles ? odd : even;
                const int count = height_ > first ? (height_ - first - 1) / (2 * step) + 1 : 0;
                for_rows(0, count, width_ / step + 1, [&](int k) {
                    if (middles) row(first + 2 * step * k, odd, step, true);
                    row(first + 2 * step * k, middles ? even : odd, step, false);
                });
            }
        }
    }

private:
    /// Every other pixel of a row, from a column on, of which the corners lie at a step along both axes, or along one.
    void row(int row, int column, int step, bool diagonal) {
        const auto at_border = [&] {
            if (mask_[index(row, column)] > 0) return;
            use(index(row, column), diagonal ? mean_inside({{{row - step, column - step}, {row - step, column + step},
                                                             {row + step, column - step}, {row + step, column + step}}})
                                             : mean_inside({{{row - step, column}, {row + step, column},
                                                             {row, column - step}, {row, column + step}}}));
        };
        if (row >= step && row + step < height_) {
            for (; column < width_ && column < step; column += 2 * step) at_border();
            const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(step) * width_;
            const LatticeRow lattice{mask_ + index(row, 0), nodes_->value.get() + index(row, 0), nodes_->contrast.get() + index(row, 0),
                                     {diagonal ? -down - step : -down, diagonal ? -down + step : down,
                                      diagonal ? down - step : -step, diagonal ? down + step : step},
                                     weight_per_contrast_, output_ + index(row, 0), weights_ ? weights_ + index(row, 0) : nullptr};
            // Pixels that lie farther apart leave too little of a vector to use.
            if (step <= 2) column = best_interpolation_kernels().between(lattice, column, width_ - step, 2 * step);
            for (; column + step < width_; column += 2 * step) {
                const std::size_t i = index(row, column);
                if (!(mask_[i] > 0)) use(i, mean(i, lattice.corners));
            }
        }
        for (; column < width_; column += 2 * step) at_border();
    }

    struct Node {
        float value, contrast;
    };

    /// Takes pixel i for a node, unless its corners differ too much.
    void use(std::size_t i, const Node& node) {
        const float weight = 1 - node.contrast * weight_per_contrast_;
        if (!(weight > 0)) return;
        nodes_->value[i] = node.value, nodes_->contrast[i] = node.contrast;
        output_[i] += (node.value - output_[i]) * weight;
        if (weights_) weights_[i] = weight;
    }

    /// Whether a place lies an odd number of steps from the lattice's first.
    static bool is_odd(int place, int step) { return ((place - lattice_first) / step) % 2 != 0; }

    /// Of the four corners of pixel i.
    [[nodiscard]] Node mean(std::size_t i, const std::ptrdiff_t (&corners)[4]) const {
        const float *const value = nodes_->value.get() + i, *const contrast = nodes_->contrast.get() + i;
        const float a = value[corners[0]], b = value[corners[1]], c = value[corners[2]], d = value[corners[3]];
        const float contrasts = most(most(contrast[corners[0]], contrast[corners[1]]), most(contrast[corners[2]], contrast[corners[3]]));
        return {(((a + b) + c) + d) / 4, most(contrasts, most(most(a, b), most(c, d)) - least(least(a, b), least(c, d)))};
    }

    /// The same of those corners that lie inside the picture.
    [[nodiscard]] Node mean_inside(const std::array<Pixel, 4>& corners) const {
        float sum = 0, low = unknown, high = -unknown, contrast = 0;
        int count = 0;
        for (const auto [row, column] : corners) {
            if (row < 0 || row >= height_ || column < 0 || column >= width_) continue;
            const std::size_t i = index(row, column);
            sum += nodes_->value[i], ++count;
            low = least(low, nodes_->value[i]), high = most(high, nodes_->value[i]);
            contrast = most(contrast, nodes_->contrast[i]);
        }
        return {sum / static_cast<float>(count), count == 0 ? unknown : most(contrast, high - low)};
    }

    [[nodiscard]] std::size_t index(int row, int column) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    }

    const float* mask_;
    float *output_, *weights_;
    int height_, width_;
    float weight_per_contrast_;
    std::unique_ptr<Nodes> nodes_;
};

}  // namespace

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width) {
    interpolate_lattice(known, planes, completed, output, height, width, {0, height});
}

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    // A pixel sees two steps of each lattice above and below, less than two tiles; tiles keep their places.
    constexpr int side = static_cast<int>(Tile::side);
    const int first = std::max(0, band.begin / side - 2) * side, rows = std::min(height, band.end + 2 * side) - first;
    const std::size_t begin = static_cast<std::size_t>(first) * static_cast<std::size_t>(width);
    for (const Channel& channel : completed) {
        const int place = known.place_of(channel);
        for (int component = 0; component < channel.components; ++component, output += pixels) {
            const float* const traced = planes + static_cast<std::size_t>(place + component) * pixels;
            Interpolation(planes + begin, traced + begin, channel.high - channel.low, output + begin, nullptr, rows, width)();
        }
    }
}

void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float* output, float* weights,
                         int height, int width) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    std::fill_n(weights, pixels, 0.f);
    const float* const traced = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    Interpolation(planes, traced, channel.high - channel.low, output, weights, height, width)();
}

}  // namespace bob
