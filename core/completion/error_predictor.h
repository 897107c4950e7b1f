/// How wrong a completed picture is expected to be.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "completion/error_predictor_kernels.h"
#include "completion/weights.h"
#include "picture/channels.h"

namespace bob {

/// Predicts the absolute error of completed gray, pixel by pixel, from the nearest traced pixels around it: how far they
/// are, how much they differ, and how well the network repeats what it was told there.
///
/// Learned on many pictures (learn/calibrate.py), as a network of one hidden layer whose output is the error's logarithm. It
/// knows nothing of the network that completed the picture but its output, so that it does for any.
class ErrorPredictor {
public:
    /// Tensors: hidden.weight (H, features), hidden.bias (H,), output.weight (1, H), output.bias (1,). Throws
    /// std::invalid_argument if one is missing or does not fit.
    explicit ErrorPredictor(const Weights& weights);

    /// planes: (layout.width(), height, width) of a G-buffer; gray: (height, width), a network's own output, which is
    /// interpolated here as where it is shown; error: (height, width), at least 0, and 0 where traced. Throws
    /// std::invalid_argument if the layout lacks a channel.
    void operator()(const Layout& layout, const float* planes, const float* gray, int height, int width, float* error) const;

    /// What the prediction is made from, (features, height, width), for those who learn; 0 where traced.
    static void features(const Layout& layout, const float* planes, const float* gray, int height, int width, float* features);

private:
    std::vector<float> hidden_weights_, hidden_bias_, output_weights_;
    float output_bias_;
};

}  // namespace bob
