/// The report's network; learn/networks/paper.py is the same in PyTorch, under the same names in the same order.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "complete/conv3x3.h"
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

private:
    struct Images;

    [[nodiscard]] std::unique_ptr<Images> take_images(int height, int width) const;
    void give_back(std::unique_ptr<Images> images) const;

    Conv3x3 encode1, encode2, encoded, decode1, decode2, output;

    // Kept from call to call, since fresh memory costs more than the arithmetic of a layer.
    mutable std::mutex mutex_;
    mutable std::unique_ptr<Images> spare_;
};

}  // namespace bob
