/// The report's network; learn/networks/paper.py is the same in PyTorch, under the same names in the same order.
#pragma once

#include "complete/conv3x3.h"
#include "complete/spare.h"
#include "complete/weights.h"

namespace bob {

class Paper {
public:
    /// Throws std::invalid_argument if a tensor is missing or does not fit.
    explicit Paper(const Weights& weights);
    ~Paper();

    /// gbuffer: (5, height, width), mask, gray, depth, normal x, normal y; gray: (height, width), the network's own
    /// output at every pixel. Any size; from several threads at once.
    void operator()(const float* gbuffer, int height, int width, float* gray) const;

    /// Bands of a picture that start at a multiple of so many rows give the same sums in the same order: rows are computed
    /// in pairs, also at 1/4 of the resolution.
    [[nodiscard]] int rows() const { return 8; }
    /// How many rows away, at most, an input can change the output, rounded up to a multiple of `rows`: the 3x3 kernels at
    /// 1, 1/2, 1/4, 1/4, 1/2 and 1 of the resolution reach 1 + 2 + 4 + 4 + 2 + 1 = 14, and blocks of 4 pixels share what
    /// they see.
    [[nodiscard]] int reach() const { return 24; }
    /// Of memory while it runs: 11 channels, 25 at half and 100 at a quarter of the resolution.
    [[nodiscard]] int bytes_per_pixel() const { return 4 * (16 * 11 + 4 * 25 + 100) / 16; }

private:
    struct Images;

    Conv3x3 encode1, encode2, encoded, decode1, decode2, output;

    mutable Spare<Images> spare_;
};

}  // namespace bob
