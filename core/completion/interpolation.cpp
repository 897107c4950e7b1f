#include "completion/interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
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

/// Over longer ways two corners agree that have a highlight between them: there all four have to.
constexpr int longest_pair = 4;

constexpr float unknown = std::numeric_limits<float>::infinity();

/// The smaller of two, and the larger; b where either is NaN, as in vectors.
float least(float a, float b) { return a < b ? a : b; }
float most(float a, float b) { return a > b ? a : b; }

/// What each pixel is taken for, (components, height, width), and by how much what it was made of differs at most: 0 where traced.
struct Nodes {
    int height, width;
    std::unique_ptr<float[]> value, contrast;

    Nodes(int height, int width, int components)
        : height(height), width(width), value(new float[static_cast<std::size_t>(components) * pixels()]),
          contrast(new float[pixels()]) {}

    [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }
};

std::array<Spare<Nodes>, 2> spare;  // of one component, and of three
constexpr std::size_t most_spare = 1 << 20;  // pixels of those kept from call to call

/// Rows of a picture: its mask, what a channel showed where it was traced, and what is made of it.
struct Picture {
    const float *mask, *traced;
    float *output, *weights;  // weights may be null
    std::size_t plane;        // floats from a component to the next, of what was traced and of the output
    int height, width;
};

/// Of one component, or of a colour's three, which agree or differ together.
template <int Components>
class Interpolation {
public:
    Interpolation(const Picture& picture, float range)
        : mask_(picture.mask), output_(picture.output), weights_(picture.weights), height_(picture.height), width_(picture.width),
          weight_per_contrast_(1 / (most_contrast * range)), plane_(picture.plane),
          nodes_(spare[Components / 2].take(height_, width_, Components)), pixels_(nodes_->pixels()) {
        parallel_for(pixels_, 65536, [&](std::size_t begin, std::size_t end) {
            const auto& kernels = best_interpolation_kernels();
            kernels.begin_contrast(mask_ + begin, nodes_->contrast.get() + begin, end - begin);
            for (std::size_t c = 0; c < Components; ++c) {
                kernels.begin(mask_ + begin, picture.traced + c * plane_ + begin, nodes_->value.get() + c * pixels_ + begin, end - begin);
            }
        });
    }
    ~Interpolation() {
        if (pixels_ <= most_spare) spare[Components / 2].give_back(std::move(nodes_));
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
        const auto use_all = [&] {
            if (mask_[index(row, column)] > 0) return;
            use(index(row, column), diagonal ? mean_inside({{{row - step, column - step}, {row + step, column + step},
                                                             {row - step, column + step}, {row + step, column - step}}})
                                             : mean_inside({{{row - step, column}, {row + step, column},
                                                             {row, column - step}, {row, column + step}}}));
        };
        if (step <= longest_pair && row >= step && row + step < height_) {
            for (; column < width_ && column < step; column += 2 * step) use_all();
            const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(step) * width_;
            const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(row) * width_;
            const LatticeRow lattice{.components = Components,
                                     .value_plane = static_cast<std::ptrdiff_t>(pixels_),
                                     .output_plane = static_cast<std::ptrdiff_t>(plane_),
                                     .mask = mask_ + first,
                                     .value = nodes_->value.get() + first,
                                     .contrast = nodes_->contrast.get() + first,
                                     .corners = {diagonal ? -down - step : -down, diagonal ? down + step : down,
                                                 diagonal ? -down + step : -step, diagonal ? down - step : step},
                                     .weight_per_contrast = weight_per_contrast_,
                                     .output = output_ + first,
                                     .weight = weights_ ? weights_ + first : nullptr};
            // Pixels that lie farther apart leave too little of a vector to use.
            if (step <= 2) column = best_interpolation_kernels().between(lattice, column, width_ - step, 2 * step);
            for (; column + step < width_; column += 2 * step) {
                const std::size_t i = index(row, column);
                if (!(mask_[i] > 0)) use(i, between(i, lattice.corners));
            }
        }
        for (; column < width_; column += 2 * step) use_all();
    }

    struct Node {
        std::array<float, Components> value;
        float contrast;
    };

    /// Takes pixel i for a node, unless its corners differ too much.
    void use(std::size_t i, const Node& node) {
        const float weight = 1 - node.contrast * weight_per_contrast_;
        if (!(weight > 0)) return;
        nodes_->contrast[i] = node.contrast;
        if (weights_) weights_[i] = weight;
        for (std::size_t c = 0; c < Components; ++c) {
            float& output = output_[c * plane_ + i];
            nodes_->value[c * pixels_ + i] = node.value[c];
            output += (node.value[c] - output) * weight;
        }
    }

    /// Whether a place lies an odd number of steps from the lattice's first.
    static bool is_odd(int place, int step) { return ((place - lattice_first) / step) % 2 != 0; }

    /// Of the two opposite corners of pixel i that differ less. Where both others lie off on the same side, as along a thin line,
    /// nothing says which of the two pairs it resembles.
    [[nodiscard]] Node between(std::size_t i, const std::ptrdiff_t (&corners)[4]) const {
        const float *value = nodes_->value.get() + i, *const contrast = nodes_->contrast.get() + i;
        Node pairs[2] = {{{}, most(contrast[corners[0]], contrast[corners[1]])}, {{}, most(contrast[corners[2]], contrast[corners[3]])}};
        if (!(most(pairs[0].contrast, pairs[1].contrast) < unknown)) return {{}, unknown};
        float off = 0;
        for (std::size_t c = 0; c < Components; ++c, value += pixels_) {
            for (std::size_t k = 0; k < 2; ++k) {
                const float a = value[corners[2 * k]], b = value[corners[2 * k + 1]];
                pairs[k].value[c] = (a + b) / 2;
                pairs[k].contrast = most(pairs[k].contrast, std::abs(a - b));
            }
            off = most(off, std::abs(pairs[0].value[c] - pairs[1].value[c]));
        }
        const bool first = pairs[0].contrast <= pairs[1].contrast;
        const Node &used = pairs[first ? 0 : 1], &other = pairs[first ? 1 : 0];
        return {used.value, most(used.contrast, off - other.contrast / 2)};
    }

    /// Of all corners, of which some may lie outside.
    [[nodiscard]] Node mean_inside(const std::array<Pixel, 4>& corners) const {
        std::array<std::size_t, 4> inside;
        std::size_t count = 0;
        float contrast = 0;
        for (const auto [row, column] : corners) {
            if (row < 0 || row >= height_ || column < 0 || column >= width_) continue;
            inside[count] = index(row, column);
            contrast = most(contrast, nodes_->contrast[inside[count++]]);
        }
        if (count == 0 || !(contrast < unknown)) return {{}, unknown};
        Node mean{{}, contrast};
        for (std::size_t c = 0; c < Components; ++c) {
            float sum = 0, low = unknown, high = -unknown;
            for (std::size_t k = 0; k < count; ++k) {
                const float value = nodes_->value[inside[k] + c * pixels_];
                sum += value, low = least(low, value), high = most(high, value);
            }
            mean.value[c] = sum / static_cast<float>(count);
            mean.contrast = most(mean.contrast, high - low);
        }
        return mean;
    }

    [[nodiscard]] std::size_t index(int row, int column) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    }

    const float* mask_;
    float *output_, *weights_;
    int height_, width_;
    float weight_per_contrast_;
    std::size_t plane_;
    std::unique_ptr<Nodes> nodes_;
    std::size_t pixels_;
};

/// Of one channel, some rows of which are looked at and written: all of a picture, or those around a band.
void interpolate(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                 int height, int width, Band rows) {
    const std::size_t line = static_cast<std::size_t>(width), pixels = static_cast<std::size_t>(height) * line;
    const std::size_t first = static_cast<std::size_t>(rows.begin) * line;
    Picture picture{planes + first, planes + static_cast<std::size_t>(known.place_of(channel)) * pixels + first, output + first,
                    weights ? weights + first : nullptr, pixels, rows.end - rows.begin, width};
    const float range = (channel.high - channel.low) * unit;
    if (channel.components == 3) return Interpolation<3>(picture, range)();
    for (int component = 0; component < channel.components; ++component) {
        Interpolation<1>(picture, range)();
        picture.traced += pixels, picture.output += pixels;
    }
}

}  // namespace

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width) {
    interpolate_lattice(known, planes, completed, output, height, width, {0, height});
}

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band) {
    // A pixel sees two steps of each lattice above and below, less than two tiles; tiles keep their places.
    constexpr int side = static_cast<int>(Tile::side);
    const Band rows{std::max(0, band.begin / side - 2) * side, std::min(height, band.end + 2 * side)};
    for (const Channel& channel : completed) {
        interpolate(known, planes, channel, 1, output, nullptr, height, width, rows);
        output += static_cast<std::size_t>(channel.components * height) * static_cast<std::size_t>(width);
    }
}

void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                         int height, int width) {
    if (weights) std::fill_n(weights, static_cast<std::size_t>(height) * static_cast<std::size_t>(width), 0.f);
    interpolate(known, planes, channel, unit, output, weights, height, width, {0, height});
}

}  // namespace bob
