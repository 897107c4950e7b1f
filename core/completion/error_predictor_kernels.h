/// The inner loop of the error predictor, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "base/isa.h"

namespace bob {

/// Features of an untraced pixel, from the nearest traced pixel in each of its four quadrants. An empty quadrant adds
/// only the maximum distance.
namespace error_features {
enum : int {
    nearest,  // binary logarithm of the distances in pixels, in ascending order
    second,
    third,
    farthest,
    gray_range,    // maximum minus minimum
    hit_range,     // 1 if some hit and some missed
    normal_range,  // sum over x and y
    depth_range,   // of the hits
    any_hit,
    residual,        // mean error of the network at them, weighted by 1 / distance^2
    greatest_change,  // from them to the completed gray
    mean_change,      // with the same weights
    gray,             // completed
    agreement,        // weight of the interpolation (`interpolate_lattice`)
    count
};
}

/// A network of one hidden layer.
struct ErrorLayers {
    const float *hidden_weights;  // (hidden, error_features::count)
    const float *hidden_bias;     // (hidden,)
    const float *output_weights;  // (hidden,)
    float output_bias;
    int hidden;
};

struct ErrorPredictorKernels {
    /// Predicts the logarithms of the errors of `width` pixels, a multiple of 16, from features that are `stride`
    /// floats apart.
    void (*predict)(const ErrorLayers& layers, const float* features, std::size_t stride, int width, float* logarithms);
};

BOB_DECLARE_KERNELS(ErrorPredictorKernels, error_predictor_kernels)

}  // namespace bob
