/// The report's network; learn/networks/paper.py is the same in PyTorch, under the same names in the same order.
#pragma once

#include <cstddef>
#include <functional>

#include "completion/conv3x3.h"
#include "completion/spare.h"
#include "completion/weights.h"

namespace bob {

class Paper {
public:
    /// What lies between the layers is kept in windows of rows that move down a large picture, so that at most `memory` bytes
    /// are needed; very wide pictures need more. Throws std::invalid_argument if a tensor is missing or does not fit.
    explicit Paper(const Weights& weights, std::size_t memory = spare_memory());
    ~Paper();

    /// gbuffer: (5, height, width), mask, gray, depth, normal x, normal y; gray: (height, width), the network's own
    /// output at every pixel, the same for any `memory`. Any size; from several threads at once. `keep_going` as in
    /// `parallel_for`: once it says no, the rest of `gray` is left as it is and false returned.
    bool operator()(const float* gbuffer, int height, int width, float* gray,
                    const std::function<bool()>& keep_going = nullptr) const;

    /// How many pixels away a pixel can make a difference.
    [[nodiscard]] static int reach() { return 20; }
    /// From multiples of which on all pixels are treated as from the first on: pairs of rows of a quarter of the picture's.
    [[nodiscard]] static int grid() { return 8; }

private:
    struct Images;

    Conv3x3 encode1, encode2, encoded, decode1, decode2, output;

    std::size_t memory_;
    mutable Spare<Images> spare_;
};

}  // namespace bob
