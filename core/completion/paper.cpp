#include "completion/paper.h"

#include <algorithm>
#include <utility>

#include "parallel.h"

namespace bob {
namespace {

/// Where each output channel of a layer in groups goes: as ShuffleNet, so that every group of the next layer sees
/// channels of all groups of this one.
std::vector<int> shuffled(int channels, int groups) {
    std::vector<int> position(static_cast<std::size_t>(channels));
    const int size = channels / groups;
    for (int c = 0; c < channels; ++c) position[static_cast<std::size_t>(c)] = c % size * groups + c / size;
    return position;
}

/// How far each layer has come, in rows of its input, and the input itself.
struct Progress {
    int input, encode1, encode2, encoded, decode1, decode2, output;
};

// Rows that convolutions compute at once: four where most of the arithmetic is, two where four would keep many more waiting.
constexpr int pair = 2, quad = 4;

/// How far the layers must come for `output` rows of a picture. Each sees the row below those that it convolves, and takes
/// several rows at once; pooling halves the rows, upsampling doubles them.
Progress needed(int output, int height) {
    const auto rounded_up = [](int rows, int multiple, int height) { return std::min((rows + multiple - 1) / multiple * multiple, height); };
    Progress p{};
    p.output = output;
    p.decode2 = rounded_up((p.output + 2) / 2, pair, height / 2);
    p.decode1 = rounded_up((p.decode2 + 2) / 2, pair, height / 4);
    p.encoded = rounded_up(p.decode1 + 1, pair, height / 4);
    p.encode2 = rounded_up(2 * (p.encoded + 1), quad, height / 2);
    p.encode1 = rounded_up(2 * (p.encode2 + 1), quad, height);
    p.input = std::min(p.encode1 + 1, height);
    return p;
}

constexpr int least_rows = 8;  // so that all layers take whole pairs and quads
constexpr int ahead = 30;      // rows that the input is ahead of the output, and one behind

}  // namespace

/// What lies between the layers. Skip connections are channels of one image that two layers write.
struct Paper::Images {
    int height, width;
    int rows;        // of the output at once
    Planes full;     // decode2, upsampled (5) | input
    Planes half;     // decode1, upsampled (5) | encode1, pooled (20)
    Planes quarter;  // encode2, pooled and shuffled (80)
    Planes code;     // encoded (20)
    Planes result;   // output (1)

    Images(int height, int width, int inputs, std::size_t memory)
        : height(height),
          width(width),
          rows(rows_within(memory, width, inputs)),
          full(5 + inputs, height, width, rows + ahead),
          half(5 + 20, height / 2, width / 2, (rows + ahead) / 2),
          quarter(80, height / 4, width / 4, (rows + ahead) / 4),
          code(20, height / 4, width / 4, (rows + ahead) / 4),
          result(1, height, width, rows) {}

    static int rows_within(std::size_t memory, int width, int inputs) {
        // Of a pixel: channels of the images, rounded up.
        const std::size_t floats = 6 + static_cast<std::size_t>(inputs) + 25 / 4 + 100 / 16 + 2;
        const std::size_t rows = memory / (4 * floats * static_cast<std::size_t>(width + 64));
        return std::max(least_rows, (static_cast<int>(std::min<std::size_t>(rows, 1 << 20)) - ahead) / least_rows * least_rows);
    }
};

Paper::Paper(const Weights& weights, std::size_t memory)
    : Network(weights, weights.inputs, {channels::gray}),
      encode1(conv3x3(weights, "encode1", inputs().width(), 20, quad)),
      encode2(conv3x3(weights, "encode2", 20, 80, quad)),
      encoded(conv3x3(weights, "encoded", 80, 20, pair)),
      decode1(conv3x3(weights, "decode1", 20, 5, pair)),
      decode2(conv3x3(weights, "decode2", 20 + 5, 5, pair)),
      output(conv3x3(weights, "output", 5 + inputs().width(), 1, quad)),
      memory_(memory) {}

Paper::~Paper() = default;

void Paper::operator()(const float* gbuffer, int height, int width, float* gray, Band) const {
    auto images = spare_.take((height + 3) / 4 * 4, (width + 3) / 4 * 4, inputs().width(), memory_);  // zeros below and to the right
    auto& [padded_height, padded_width, step, full, half, quarter, code, result] = *images;
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    const auto shuffle = shuffled(80, encode2.groups());

    Progress done{};
    while (done.output < height) {
        const Progress next = needed(std::min(done.output + step, padded_height), padded_height);

        for_rows(done.input, next.input, padded_width, [&](int y) {
            for (int c = 0; c < inputs().width(); ++c) {
                float* to = full.row(5 + c, y);
                const std::size_t known = y < height ? columns : 0;
                if (known) std::copy_n(gbuffer + (static_cast<std::size_t>(c) * rows + static_cast<std::size_t>(y)) * columns, known, to);
                std::fill(to + known, to + padded_width, 0.f);
            }
        });
        encode1(full, 5, half, 5, Then::relu_pool, done.encode1, next.encode1);
        encode2({half, 5, 20}, {half, 0, 0}, quarter, shuffle, Then::relu_pool, done.encode2, next.encode2);
        encoded(quarter, 0, code, 0, Then::relu, done.encoded, next.encoded);
        decode1(code, 0, half, 0, Then::relu_upsample, done.decode1, next.decode1);
        decode2(half, 0, full, 0, Then::relu_upsample, done.decode2, next.decode2);
        output(full, 0, result, 0, Then::nothing, done.output, next.output);
        for_rows(done.output, std::min(next.output, height), padded_width, [&](int y) {
            std::copy_n(result.row(0, y), columns, gray + static_cast<std::size_t>(y) * columns);
        });
        done = next;
    }
    spare_.give_back(std::move(images));
}

}  // namespace bob
