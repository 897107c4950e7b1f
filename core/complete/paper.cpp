#include "complete/paper.h"

#include <algorithm>
#include <utility>

#include "parallel.h"

namespace bob {
namespace {

constexpr int input_channels = 5;

/// Where each output channel of a layer in groups goes: as ShuffleNet, so that every group of the next layer sees
/// channels of all groups of this one.
std::vector<int> shuffled(int channels, int groups) {
    std::vector<int> position(static_cast<std::size_t>(channels));
    const int size = channels / groups;
    for (int c = 0; c < channels; ++c) position[static_cast<std::size_t>(c)] = c % size * groups + c / size;
    return position;
}

}  // namespace

/// What lies between the layers. Skip connections are channels of one image that two layers write.
struct Paper::Images {
    int height, width;
    Planes full;     // decode2, upsampled (5) | input (5)
    Planes half;     // decode1, upsampled (5) | encode1, pooled (20)
    Planes quarter;  // encode2, pooled and shuffled (80)
    Planes code;     // encoded (20)
    Planes result;   // output (1)

    Images(int height, int width)
        : height(height),
          width(width),
          full(5 + input_channels, height, width),
          half(5 + 20, height / 2, width / 2),
          quarter(80, height / 4, width / 4),
          code(20, height / 4, width / 4),
          result(1, height, width) {}
};

Paper::Paper(const Weights& weights)
    : encode1(conv3x3(weights, "encode1", input_channels, 20)),
      encode2(conv3x3(weights, "encode2", 20, 80)),
      encoded(conv3x3(weights, "encoded", 80, 20)),
      decode1(conv3x3(weights, "decode1", 20, 5)),
      decode2(conv3x3(weights, "decode2", 20 + 5, 5)),
      output(conv3x3(weights, "output", 5 + input_channels, 1)) {}

Paper::~Paper() = default;

void Paper::operator()(const float* gbuffer, int height, int width, float* gray) const {
    auto images = spare_.take((height + 3) / 4 * 4, (width + 3) / 4 * 4);  // zeros below and to the right
    auto& [padded_height, padded_width, full, half, quarter, code, result] = *images;
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    parallel_for(static_cast<std::size_t>(padded_height), 32, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            for (int c = 0; c < input_channels; ++c) {
                float* to = full.row(5 + c, static_cast<int>(y));
                const std::size_t known = y < rows ? columns : 0;
                std::copy_n(gbuffer + (static_cast<std::size_t>(c) * rows + std::min(y, rows - 1)) * columns, known, to);
                std::fill(to + known, to + padded_width, 0.f);
            }
        }
    });

    encode1(full, 5, half, 5, Then::relu_pool);
    encode2(half, 5, quarter, shuffled(80, encode2.groups()), Then::relu_pool);
    encoded(quarter, 0, code, 0, Then::relu);
    decode1(code, 0, half, 0, Then::relu_upsample);
    decode2(half, 0, full, 0, Then::relu_upsample);
    output(full, 0, result, 0, Then::nothing);

    parallel_for(rows, 32, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            std::copy_n(result.row(0, static_cast<int>(y)), columns, gray + y * columns);
        }
    });
    spare_.give_back(std::move(images));
}

}  // namespace bob
