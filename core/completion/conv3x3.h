/// 3x3 convolutions with zero padding, shared by all networks.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "completion/conv3x3_kernels.h"
#include "completion/needed.h"
#include "completion/planes.h"

namespace bob {

/// Channels of an image that a convolution reads, from `column` on.
struct Channels {
    const Planes& planes;
    int first, count, column = 0;
};

/// Parts of a convolution's output to compute, from column `column` of `parts` on; all if it is null.
struct Wanted {
    const Needed* parts = nullptr;
    int column = 0;

    /// The first stretch of a row within some columns, maybe empty.
    [[nodiscard]] Stretch first(int y, Stretch columns) const { return parts ? parts->first(y, columns, column) : columns; }
};

/// Weights of a grouped convolution, as PyTorch's Conv2d has them, rearranged for the kernels.
class Conv3x3 {
public:
    /// weight: (out, in / groups, 3, 3); bias: (out,).
    ///
    /// The kernels compute `rows` rows at a time, 2 or 4, starting at multiples of it. Four are faster. Two need a
    /// multiple of four channels in each group and depend on fewer neighbouring rows.
    Conv3x3(std::span<const float> weight, std::span<const float> bias, int in, int groups, int rows);

    /// Convolves the rows `begin` to `end` of one image's channels followed by another's. The second may be empty, and
    /// must be with groups.
    ///
    /// The images are as high as the output and, from their columns on, at least as wide as the first. `begin` is a
    /// multiple of `rows`; `end` is one too, or the height. Output channel c is written to channel `output_channel[c]`
    /// of `output`; with `Then::shuffle`, channels 4c to 4c + 3 are. Columns that are not wanted keep arbitrary values.
    /// Uses all threads.
    void operator()(const Channels& input, const Channels& more, Planes& output, std::span<const int> output_channel, Then then,
                    int begin, int end, Wanted wanted = {}) const;
    /// Writes the output channels in order, from `first_output` on.
    void operator()(const Channels& input, const Channels& more, Planes& output, int first_output, Then then, int begin,
                    int end, Wanted wanted = {}) const;
    void operator()(const Planes& input, int first_input, Planes& output, int first_output, Then then, int begin,
                    int end, Wanted wanted = {}) const {
        (*this)({input, first_input, in_}, {input, 0, 0}, output, first_output, then, begin, end, wanted);
    }

    [[nodiscard]] int in() const { return in_; }
    [[nodiscard]] int out() const { return out_; }
    [[nodiscard]] int groups() const { return groups_; }
    [[nodiscard]] int rows() const { return rows_; }
    /// Rounds up to whole groups of `rows`, up to the height of the image.
    [[nodiscard]] int whole(int rows, int height) const { return std::min((rows + rows_ - 1) / rows_ * rows_, height); }

private:
    int in_, out_, groups_, rows_;
    int block_;                  // output channels per kernel call: 4, 5 or 1
    std::vector<float> weight_;  // (out / block, rows + 2, in / groups, 3, block); for blocks of one (out, in / groups, 3, 3)
    std::vector<float> bias_;    // (out,)
};

}  // namespace bob
