#include "completion/conv3x3.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "base/parallel.h"

namespace bob {
namespace {

/// Winograd's transform of the three taps of a column, for two or four rows: the factors for the kernels' differences.
std::vector<double> winograd_taps(int rows, double g0, double g1, double g2) {
    if (rows == 2) return {g0, (g0 + g1 + g2) / 2, (g0 - g1 + g2) / 2, g2};
    constexpr double a = winograd_near, b = winograd_far;
    const auto at = [&](double x, double other) {
        return (g0 + x * g1 + x * x * g2) / (2 * x * x * (x * x - other * other));
    };
    return {g0 / (a * a * b * b), at(a, b), at(-a, b), at(b, a), at(-b, a), g2};
}

}  // namespace

Conv3x3::Conv3x3(std::span<const float> weight, std::span<const float> bias, int in, int groups, int rows)
    : in_(in), out_(static_cast<int>(bias.size())), groups_(groups), rows_(rows), bias_(bias.begin(), bias.end()) {
    const int inputs = in / groups, outputs = out_ / groups;
    if (inputs * groups != in || outputs * groups != out_ ||
        weight.size() != static_cast<std::size_t>(out_ * inputs * 9)) {
        throw std::invalid_argument("Conv3x3: weight and bias do not fit the channels and groups");
    }
    block_ = outputs % 4 == 0 ? 4 : outputs % 5 == 0 ? 5 : 1;
    if (rows == 2 && block_ != 4) throw std::invalid_argument("Conv3x3: two rows at once need a multiple of four channels in each group");
    if (block_ == 1) {
        weight_.assign(weight.begin(), weight.end());
        return;
    }
    const auto products = static_cast<std::size_t>(rows + 2);
    weight_.resize(weight.size() / 3 * products);
    const auto tap = [&](int channel, int input, int ky, int kx) {
        return double{weight[static_cast<std::size_t>(((channel * inputs + input) * 3 + ky) * 3 + kx)]};
    };
    for (int c = 0; c < out_; ++c) {
        for (int i = 0; i < inputs; ++i) {
            for (int kx = 0; kx < 3; ++kx) {
                const auto taps = winograd_taps(rows, tap(c, i, 0, kx), tap(c, i, 1, kx), tap(c, i, 2, kx));
                for (std::size_t k = 0; k < products; ++k) {
                    const std::size_t row = static_cast<std::size_t>(c / block_) * products + k;
                    weight_[((row * static_cast<std::size_t>(inputs) + static_cast<std::size_t>(i)) * 3 + static_cast<std::size_t>(kx)) *
                                static_cast<std::size_t>(block_) + static_cast<std::size_t>(c % block_)] = static_cast<float>(taps[k]);
                }
            }
        }
    }
}

void Conv3x3::operator()(const Channels& input, const Channels& more, Planes& output, std::span<const int> output_channel,
                         Then then, int begin, int end, Wanted wanted) const {
    const int inputs = in_ / groups_, outputs = out_ / groups_;
    const auto& kernels = best_conv_kernels();
    const auto kernel = rows_ == 2 ? kernels.two_rows : block_ == 5 ? kernels.five : block_ == 4 ? kernels.four : kernels.one;
    const bool enlarged = then == Then::relu_upsample || then == Then::shuffle;
    const int merged = then == Then::shuffle ? 4 : 1;  // convolution channels per output channel
    const auto channels_of = [&](const Channels& from, int first, int count, int y) {
        ConvInput result{from.planes.row(from.first + first, y) + from.column, {}, from.planes.plane_stride(), count};
        for (int i = 0; i < rows_ + 2; ++i) result.rows[i] = from.planes.offset(y, y - 1 + i);
        return result;
    };
    const int width = input.planes.width();
    const auto convolve = [&](int y, int left, int right, float** rows_written, float* scratch, int* used) {
        const int rows = std::min(rows_, end - y);
        const int out_y = then == Then::relu_pool ? y / 2 : enlarged ? 2 * y : y;
        const int out_rows = then == Then::relu_pool ? rows / 2 : enlarged ? 2 * rows : rows;
        for (int first = 0; first < out_; first += outputs) {
            const auto channels = output_channel.subspan(static_cast<std::size_t>(first / merged),
                                                         static_cast<std::size_t>(outputs / merged));
            std::transform(channels.begin(), channels.end(), rows_written, [&](int c) { return output.row(c, out_y); });
            const int group = first / outputs, first_input = group * inputs;
            const float* const weight = weight_.data() + weight_.size() / static_cast<std::size_t>(groups_) * static_cast<std::size_t>(group);
            const auto column = [&](int x) { return then == Then::relu_pool ? x / 2 : enlarged ? 2 * x : x; };
            for (Stretch some = wanted.first(y, {left, right}); !some.is_empty(); some = wanted.first(y, {some.end, right})) {
                kernel({{channels_of(input, first_input, inputs - more.count, y), channels_of(more, 0, more.count, y)}, some.begin, some.end,
                        rows, outputs / block_, weight, bias_.data() + first, rows_written, output.row_stride(), scratch, used}, then);
                for (const int c : channels) {
                    for (int r = 0; r < out_rows; ++r) output.clear_tail(c, out_y + r, column(some.begin), column(some.end));
                }
            }
        }
    };
    // Pieces of some tens of microseconds balance the threads at little overhead. For few rows, the pieces are parts of
    // rows.
    constexpr std::int64_t worthwhile = 500'000;  // products per piece
    const std::int64_t products = std::int64_t{9} * rows_ * inputs * out_ * width;
    const int times = (end - begin + rows_ - 1) / rows_, tiles = (width + conv_tile - 1) / conv_tile;
    const int most = static_cast<int>(std::min<std::int64_t>(tiles, products / worthwhile));
    const int parts = std::clamp(2 * thread_count() / std::max(times, 1), 1, std::max(most, 1));
    parallel_for(static_cast<std::size_t>(times * parts), static_cast<std::size_t>(1 + worthwhile * parts / products), [&](std::size_t first, std::size_t last) {
        std::vector<float*> rows_written(static_cast<std::size_t>(outputs / merged));
        const AlignedFloats scratch = aligned_floats(static_cast<std::size_t>((rows_ + 2) * inputs * conv_scratch));
        std::vector<int> used(static_cast<std::size_t>(conv_steps * inputs));
        for (int i = static_cast<int>(first); i < static_cast<int>(last); ++i) {
            const auto column = [&](int part) { return std::min(tiles * part / parts * conv_tile, width); };
            convolve(begin + rows_ * (i / parts), column(i % parts), column(i % parts + 1), rows_written.data(), scratch.get(), used.data());
        }
    });
}

void Conv3x3::operator()(const Channels& input, const Channels& more, Planes& output, int first_output, Then then, int begin,
                         int end, Wanted wanted) const {
    std::vector<int> channels(static_cast<std::size_t>(then == Then::shuffle ? out_ / 4 : out_));
    std::iota(channels.begin(), channels.end(), first_output);
    (*this)(input, more, output, channels, then, begin, end, wanted);
}

}  // namespace bob
