/// 3x3 convolutions with zero padding: the arithmetic of every network here.
#pragma once

#include <span>
#include <vector>

#include "completion/conv3x3_kernels.h"
#include "completion/planes.h"

namespace bob {

/// The weights of a convolution in groups, as PyTorch's Conv2d has them, rearranged for the kernels.
class Conv3x3 {
public:
    /// weight: (out, in / groups, 3, 3); bias: (out,).
    Conv3x3(std::span<const float> weight, std::span<const float> bias, int in, int groups);

    /// Convolves the rows `begin` to `end` of `input`, in its channels from `first_input` on; `begin` is even, `end` too or
    /// the height. Output channel c is written to the channel `output_channel[c]` of `output`; shuffled, channels 4c to
    /// 4c + 3 are. Uses all threads.
    void operator()(const Planes& input, int first_input, Planes& output, std::span<const int> output_channel, Then then,
                    int begin, int end) const;
    /// The same with the output's channels in order, from `first_output` on.
    void operator()(const Planes& input, int first_input, Planes& output, int first_output, Then then, int begin,
                    int end) const;

    [[nodiscard]] int in() const { return in_; }
    [[nodiscard]] int out() const { return out_; }
    [[nodiscard]] int groups() const { return groups_; }

private:
    int in_, out_, groups_;
    int block_;                  // output channels that a kernel computes at once: 4, 5 or 1
    std::vector<float> weight_;       // (out / block, in / groups, 3, 3, block)
    std::vector<float> weight_pair_;  // (out / block, in / groups, 3, 4, block)
    std::vector<float> bias_;         // (out,)
};

}  // namespace bob
