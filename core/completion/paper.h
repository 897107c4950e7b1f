/// The report's network; learn/networks/paper.py is the same in PyTorch, with the same names in the same order.
#pragma once

#include <cstddef>

#include "completion/conv3x3.h"
#include "completion/network.h"
#include "completion/spare.h"
#include "completion/weights.h"

namespace bob {

class Paper : public Network {
public:
    /// Images between layers are windows of rows that move down a large picture, within `memory` bytes. Very wide
    /// pictures need more.
    ///
    /// The output is the same for any `memory`; at 640x480 so is the time from 4 to 12 MB. Throws std::invalid_argument
    /// if a tensor is missing or does not fit.
    explicit Paper(const Weights& weights, std::size_t memory = 6 << 20);
    ~Paper() override;

    using Network::operator();
    void operator()(const float* gbuffer, int height, int width, float* gray, Band band) const override;

private:
    struct Images;

    Conv3x3 encode1, encode2, encoded, decode1, decode2, output;

    std::size_t memory_;
    mutable Spare<Images> spare_;
};

}  // namespace bob
