/// Prediction of the error of a completed picture.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "completion/error_predictor_kernels.h"
#include "completion/weights.h"
#include "picture/channels.h"

namespace bob {

/// Predicts the absolute error of completed gray for each pixel.
///
/// The features describe the nearest traced pixels: their distances, their contrast, and the network's own error there.
/// A network with one hidden layer, trained on many pictures (learn/calibrate.py), predicts the error's logarithm. It
/// sees only the output of the completing network, so it works for any.
class ErrorPredictor {
public:
    /// Tensors: hidden.weight (H, features), hidden.bias (H,), output.weight (1, H), output.bias (1,). Throws
    /// std::invalid_argument if one is missing or does not fit.
    explicit ErrorPredictor(const Weights& weights);

    /// planes: (layout.width(), height, width) of a G-buffer. gray: (height, width), a network's own output,
    /// interpolated here as for display. error: (height, width), at least 0, and 0 where traced. Throws
    /// std::invalid_argument if the layout lacks a channel.
    void operator()(const Layout& layout, const float* planes, const float* gray, int height, int width, float* error) const;

    /// The features of the prediction, (features, height, width), for training; 0 where traced.
    static void features(const Layout& layout, const float* planes, const float* gray, int height, int width, float* features);

private:
    std::vector<float> hidden_weights_, hidden_bias_, output_weights_;
    float output_bias_;
};

}  // namespace bob
