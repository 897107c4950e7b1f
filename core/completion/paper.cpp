#include "completion/paper.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"

namespace bob {
namespace {

/// Positions of a grouped layer's output channels, as in ShuffleNet. Every group of the next layer sees channels of all
/// groups.
std::vector<int> shuffled(int channels, int groups) {
    std::vector<int> position(static_cast<std::size_t>(channels));
    const int size = channels / groups;
    for (int c = 0; c < channels; ++c) position[static_cast<std::size_t>(c)] = c % size * groups + c / size;
    return position;
}

/// Progress of each layer, in rows of its input, and of the input itself.
struct Progress {
    int input, encode1, encode2, encoded, decode1, decode2, output;
};

constexpr int at_once = 4;  // rows per convolution step

/// Progress that the layers need for `output` rows of a picture. Each reads the row below its own and takes four rows
/// at a time; pooling halves the rows, upsampling doubles them.
Progress needed(int output, int height) {
    const auto whole = [](int rows, int height) { return std::min((rows + at_once - 1) / at_once * at_once, height); };
    Progress p{};
    p.output = output;
    p.decode2 = whole((p.output + 2) / 2, height / 2);
    p.decode1 = whole((p.decode2 + 2) / 2, height / 4);
    p.encoded = whole(p.decode1 + 1, height / 4);
    p.encode2 = whole(2 * (p.encoded + 1), height / 2);
    p.encode1 = whole(2 * (p.encode2 + 1), height);
    p.input = std::min(p.encode1 + 1, height);
    return p;
}

constexpr int row_step = 2 * at_once;
constexpr int period = 4 * at_once;  // rows after which all layers have taken whole fours

}  // namespace

/// The images between the layers.
struct Paper::Images {
    /// Rows of each image kept at a time.
    struct Windows {
        int input = 0, encoded1 = 0, encoded2 = 0, code = 0, decoded1 = 0, decoded2 = 0;

        /// Windows for a picture of any height, finished in bands of `rows` rows.
        explicit Windows(int rows) {
            const int all = 4 * std::max(rows, period);  // then the pattern repeats
            Progress done{};
            for (int finished = rows; finished <= all; finished += rows) {
                const Progress next = needed(finished, 2 * all);
                add(done, next);
                done = next;
            }
        }

    private:
        /// Extends each window from the row above the next one read to the last row written.
        void add(const Progress& done, const Progress& next) {
            input = std::max(input, next.input - (done.output - 1));
            encoded1 = std::max(encoded1, next.encode1 / 2 - (done.decode2 - 1));
            encoded2 = std::max(encoded2, next.encode2 / 2 - (done.encoded - 1));
            code = std::max(code, next.encoded - (done.decode1 - 1));
            decoded1 = std::max(decoded1, 2 * next.decode1 - (done.decode2 - 1));
            decoded2 = std::max(decoded2, 2 * next.decode2 - (done.output - 1));
        }
    };

    int height, width;
    int rows;         // of the output at a time
    Planes input;
    Planes encoded1;  // pooled (20)
    Planes encoded2;  // pooled and shuffled (80)
    Planes code;      // encoded (20)
    Planes decoded1;  // upsampled (5)
    Planes decoded2;  // upsampled (5)
    Planes result;    // output (1)

    Images(int height, int width, int inputs, std::size_t memory)
        : Images(height, width, inputs, rows_within(memory, height, width, inputs)) {}

private:
    Images(int height, int width, int inputs, int rows, const Windows& windows)
        : height(height),
          width(width),
          rows(rows),
          input(inputs, height, width, windows.input),
          encoded1(20, height / 2, width / 2, windows.encoded1),
          encoded2(80, height / 4, width / 4, windows.encoded2),
          code(20, height / 4, width / 4, windows.code),
          decoded1(5, height / 2, width / 2, windows.decoded1),
          decoded2(5, height, width, windows.decoded2),
          result(1, height, width, rows) {}
    Images(int height, int width, int inputs, int rows) : Images(height, width, inputs, rows, Windows(rows)) {}

    static int rows_within(std::size_t memory, int height, int width, int inputs) {
        const auto bytes = [&](int rows) {
            const Windows of(rows);
            const auto image = [&](int channels, int window, int scale) {
                return sizeof(float) * static_cast<std::size_t>(channels * window) * static_cast<std::size_t>(width / scale + 48);
            };
            return image(inputs, of.input, 1) + image(20, of.encoded1, 2) + image(80, of.encoded2, 4) + image(20, of.code, 4) +
                   image(5, of.decoded1, 2) + image(5, of.decoded2, 1) + image(1, rows, 1);
        };
        int rows = row_step;
        while (rows < height && bytes(rows + row_step) <= memory) rows += row_step;
        return rows;
    }
};

Paper::Paper(const Weights& weights, std::size_t memory)
    : Network(weights, weights.inputs, {channels::gray}),
      encode1(conv3x3(weights, "encode1", inputs().width(), 20, at_once)),
      encode2(conv3x3(weights, "encode2", 20, 80, at_once)),
      encoded(conv3x3(weights, "encoded", 80, 20, at_once)),
      decode1(conv3x3(weights, "decode1", 20, 5, at_once)),
      decode2(conv3x3(weights, "decode2", 20 + 5, 5, at_once)),
      output(conv3x3(weights, "output", 5 + inputs().width(), 1, at_once)),
      memory_(memory) {}

Paper::~Paper() = default;

void Paper::operator()(const float* gbuffer, int height, int width, float* gray, Band) const {
    auto images = spare_.take((height + 3) / 4 * 4, (width + 3) / 4 * 4, inputs().width(), memory_);  // zeros below and to the right
    auto& [padded_height, padded_width, step, input, encoded1, encoded2, code, decoded1, decoded2, result] = *images;
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    const auto shuffle = shuffled(80, encode2.groups());

    Progress done{};
    while (done.output < height) {
        const Progress next = needed(std::min(done.output + step, padded_height), padded_height);

        for_rows(done.input, next.input, padded_width, [&](int y) {
            for (int c = 0; c < inputs().width(); ++c) {
                float* to = input.row(c, y);
                const std::size_t known = y < height ? columns : 0;
                if (known) std::copy_n(gbuffer + (static_cast<std::size_t>(c) * rows + static_cast<std::size_t>(y)) * columns, known, to);
                std::fill(to + known, to + padded_width, 0.f);
            }
        });
        encode1(input, 0, encoded1, 0, Then::relu_pool, done.encode1, next.encode1);
        encode2({encoded1, 0, 20}, {encoded1, 0, 0}, encoded2, shuffle, Then::relu_pool, done.encode2, next.encode2);
        encoded(encoded2, 0, code, 0, Then::relu, done.encoded, next.encoded);
        decode1(code, 0, decoded1, 0, Then::relu_upsample, done.decode1, next.decode1);
        decode2({decoded1, 0, 5}, {encoded1, 0, 20}, decoded2, 0, Then::relu_upsample, done.decode2, next.decode2);
        output({decoded2, 0, 5}, {input, 0, inputs().width()}, result, 0, Then::nothing, done.output, next.output);
        for_rows(done.output, std::min(next.output, height), padded_width, [&](int y) {
            std::copy_n(result.row(0, y), columns, gray + static_cast<std::size_t>(y) * columns);
        });
        done = next;
    }
    spare_.give_back(std::move(images));
}

}  // namespace bob
