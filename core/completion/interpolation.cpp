#include "completion/interpolation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "parallel.h"
#include "picture/order.h"

namespace bob {
namespace {

/// Corners that differ by more of a channel's range say nothing about what lies between them.
constexpr float most_contrast = 0.15f;

constexpr float unknown = std::numeric_limits<float>::infinity();

/// What a pixel is taken for, and by how much the corners that it was made of differ at most: 0 where traced.
struct Node {
    float value, contrast;
};

class Interpolation {
public:
    Interpolation(const float* mask, const float* traced, float range, int height, int width)
        : traced_(mask), height_(height), width_(width), weight_per_contrast_(1 / (most_contrast * range)),
          nodes_(static_cast<std::size_t>(height) * static_cast<std::size_t>(width)) {
        parallel_for(nodes_.size(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) nodes_[i] = mask[i] > 0 ? Node{traced[i], 0} : Node{0, unknown};
        });
    }

    /// Calls use(i, mean, weight) for each pixel i that lies between corners that agree.
    template <class Use>
    void operator()(Use use) {
        for (int step = static_cast<int>(Tile::side) / 2; step > 0; step /= 2) {
            for (const bool diagonal : {true, false}) level(step, diagonal, use);
        }
    }

private:
    /// The pixels of which the corners lie at a step along both axes, or along one.
    template <class Use>
    void level(int step, bool diagonal, Use use) {
        const int first = lattice_first % step;  // rows and columns of the lattices so far lie at multiples from there
        const int rows = height_ > first ? (height_ - first - 1) / step + 1 : 0;
        for_rows(0, rows, width_ / step + 1, [&](int k) {
            const int row = first + k * step;
            const bool odd_row = is_odd(row, step);
            if (diagonal && !odd_row) return;
            const bool odd_column = diagonal || !odd_row;
            const int begin = first + (is_odd(first, step) == odd_column ? 0 : step);
            const auto pixel = [&](int column, const Node& node) {
                const float weight = 1 - node.contrast * weight_per_contrast_;
                if (!(weight > 0)) return;
                nodes_[index(row, column)] = node;
                use(index(row, column), node.value, weight);
            };
            const auto at_border = [&](int column) {
                if (traced_[index(row, column)] > 0) return;
                pixel(column, diagonal ? mean_inside({{{row - step, column - step}, {row - step, column + step},
                                                       {row + step, column - step}, {row + step, column + step}}})
                                       : mean_inside({{{row - step, column}, {row + step, column},
                                                       {row, column - step}, {row, column + step}}}));
            };
            int column = begin;
            if (row >= step && row + step < height_) {
                for (; column < width_ && column < step; column += 2 * step) at_border(column);
                const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(step) * width_;
                const std::ptrdiff_t corners[] = {diagonal ? -down - step : -down, diagonal ? -down + step : down,
                                                  diagonal ? down - step : -step, diagonal ? down + step : step};
                for (; column + step < width_; column += 2 * step) {
                    const std::size_t i = index(row, column);
                    if (traced_[i] > 0) continue;
                    const Node* const here = nodes_.data() + i;
                    pixel(column, mean(here[corners[0]], here[corners[1]], here[corners[2]], here[corners[3]]));
                }
            }
            for (; column < width_; column += 2 * step) at_border(column);
        });
    }

    /// Whether a place lies an odd number of steps from the lattice's first.
    static bool is_odd(int place, int step) { return ((place - lattice_first) / step) % 2 != 0; }

    static Node mean(const Node& a, const Node& b, const Node& c, const Node& d) {
        const float low = std::min(std::min(a.value, b.value), std::min(c.value, d.value));
        const float high = std::max(std::max(a.value, b.value), std::max(c.value, d.value));
        const float contrast = std::max(std::max(a.contrast, b.contrast), std::max(c.contrast, d.contrast));
        return {(((a.value + b.value) + c.value) + d.value) / 4, std::max(contrast, high - low)};
    }

    /// The same of those corners that lie inside the picture.
    [[nodiscard]] Node mean_inside(const std::array<Pixel, 4>& corners) const {
        float sum = 0, low = unknown, high = -unknown, contrast = 0;
        int count = 0;
        for (const auto [row, column] : corners) {
            if (row < 0 || row >= height_ || column < 0 || column >= width_) continue;
            const Node& corner = nodes_[index(row, column)];
            sum += corner.value, ++count;
            low = std::min(low, corner.value), high = std::max(high, corner.value);
            contrast = std::max(contrast, corner.contrast);
        }
        return {sum / static_cast<float>(count), count == 0 ? unknown : std::max(contrast, high - low)};
    }

    [[nodiscard]] std::size_t index(int row, int column) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    }

    const float* traced_;
    int height_, width_;
    float weight_per_contrast_;
    std::vector<Node> nodes_;
};

}  // namespace

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    for (const Channel& channel : completed) {
        const int place = known.place_of(channel);
        for (int component = 0; component < channel.components; ++component, output += pixels) {
            const float* const traced = planes + static_cast<std::size_t>(place + component) * pixels;
            Interpolation(planes, traced, channel.high - channel.low, height, width)(
                [=](std::size_t i, float mean, float weight) { output[i] += (mean - output[i]) * weight; });
        }
    }
}

void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float* output, float* weights,
                         int height, int width) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    std::fill_n(weights, pixels, 0.f);
    const float* const traced = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    Interpolation(planes, traced, channel.high - channel.low, height, width)(
        [=](std::size_t i, float mean, float weight) {
            output[i] += (mean - output[i]) * weight;
            weights[i] = weight;
        });
}

}  // namespace bob
