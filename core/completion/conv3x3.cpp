#include "completion/conv3x3.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include "parallel.h"

namespace bob {
namespace {

/// Winograd's F(2, 3): the three taps of a column as four factors. With pixels d0..d3 of the column and the products m0..m3
/// of these factors and d0 - d2, d1 + d2, d2 - d1, d1 - d3, the two results are m0 + m1 + m2 and m1 - m2 - m3.
std::array<float, 4> winograd_taps(const float (&g)[3]) {
    return {g[0], (g[0] + g[1] + g[2]) / 2, (g[0] - g[1] + g[2]) / 2, g[2]};
}

}  // namespace

Conv3x3::Conv3x3(std::span<const float> weight, std::span<const float> bias, int in, int groups)
    : in_(in), out_(static_cast<int>(bias.size())), groups_(groups), bias_(bias.begin(), bias.end()) {
    const int inputs = in / groups, outputs = out_ / groups;
    if (inputs * groups != in || outputs * groups != out_ ||
        weight.size() != static_cast<std::size_t>(out_ * inputs * 9)) {
        throw std::invalid_argument("Conv3x3: weight and bias do not fit the channels and groups");
    }
    block_ = outputs % 4 == 0 ? 4 : outputs % 5 == 0 ? 5 : 1;
    weight_.reserve(weight.size());
    weight_pair_.reserve(weight.size() / 9 * 12);
    const auto tap = [&](int channel, int input, int ky, int kx) {
        return weight[static_cast<std::size_t>(((channel * inputs + input) * 3 + ky) * 3 + kx)];
    };
    for (int first = 0; first < out_; first += block_) {
        for (int input = 0; input < inputs; ++input) {
            for (int k = 0; k < 9; ++k) {
                for (int c = first; c < first + block_; ++c) weight_.push_back(tap(c, input, k / 3, k % 3));
            }
            for (int k = 0; k < 12; ++k) {
                for (int c = first; c < first + block_; ++c) {
                    const float g[3] = {tap(c, input, 0, k / 4), tap(c, input, 1, k / 4), tap(c, input, 2, k / 4)};
                    weight_pair_.push_back(winograd_taps(g)[static_cast<std::size_t>(k % 4)]);
                }
            }
        }
    }
}

void Conv3x3::operator()(const Planes& input, int first_input, Planes& output, std::span<const int> output_channel,
                         Then then, int begin, int end) const {
    const int inputs = in_ / groups_, outputs = out_ / groups_;
    const auto& kernels = best_conv_kernels();
    const auto kernel = block_ == 5 ? kernels.conv5 : block_ == 4 ? kernels.conv4 : kernels.conv1;
    const bool enlarged = then == Then::relu_upsample || then == Then::shuffle;
    const int merged = then == Then::shuffle ? 4 : 1;  // channels of the convolution in one of the output
    const auto pair = [&](int y, float** rows_written, float* scratch) {
        const int rows = std::min(2, end - y);
        const int out_y = then == Then::relu_pool ? y / 2 : enlarged ? 2 * y : y;
        const int out_rows = then == Then::relu_pool ? 1 : enlarged ? 2 * rows : rows;
        for (int first = 0; first < out_; first += outputs) {
            ConvRow row{};
            row.input = input.row(first_input + first / outputs * inputs, y);
            for (int i = 0; i < rows + 2; ++i) row.rows[i] = input.offset(y, y - 1 + i);
            row.plane_stride = input.plane_stride();
            row.inputs = inputs;
            row.width = input.width();
            row.blocks = outputs / block_;
            row.weight = weight_.data() + first * inputs * 9;
            row.weight_pair = weight_pair_.data() + first * inputs * 12;
            row.bias = bias_.data() + first;
            row.output_row_stride = output.row_stride();
            row.output = rows_written;
            row.scratch = scratch;
            const auto channels = output_channel.subspan(static_cast<std::size_t>(first / merged),
                                                         static_cast<std::size_t>(outputs / merged));
            std::transform(channels.begin(), channels.end(), rows_written, [&](int c) { return output.row(c, out_y); });
            kernel(row, rows, then);
            for (const int c : channels) {
                for (int r = 0; r < out_rows; ++r) output.clear_tail(c, out_y + r);
            }
        }
    };
    // Pieces of some tens of microseconds: enough for the threads to share, few enough to hand out.
    const auto grain = static_cast<std::size_t>(1 + 1'000'000 / (std::int64_t{36} * inputs * out_ * input.width()));
    parallel_for(static_cast<std::size_t>((end - begin + 1) / 2), grain, [&](std::size_t first, std::size_t last) {
        std::vector<float*> rows_written(static_cast<std::size_t>(outputs / merged));
        std::vector<float> scratch(static_cast<std::size_t>(inputs * conv_scratch));
        for (std::size_t i = first; i < last; ++i) {
            pair(begin + 2 * static_cast<int>(i), rows_written.data(), scratch.data());
        }
    });
}

void Conv3x3::operator()(const Planes& input, int first_input, Planes& output, int first_output, Then then, int begin,
                         int end) const {
    std::vector<int> channels(static_cast<std::size_t>(then == Then::shuffle ? out_ / 4 : out_));
    std::iota(channels.begin(), channels.end(), first_output);
    (*this)(input, first_input, output, channels, then, begin, end);
}

}  // namespace bob
