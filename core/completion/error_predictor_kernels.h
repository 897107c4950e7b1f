/// The inner loop of the error predictor, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "base/isa.h"

namespace bob {

/// What is known of a pixel that was not traced, from the nearest traced pixel in each of the four quadrants around it. Of a
/// quadrant without one, only the distance counts, the greatest.
namespace error_features {
enum : int {
    nearest,  // binary logarithm of the distances in pixels, from the least to the greatest
    second,
    third,
    farthest,
    gray_range,    // the greatest less the least
    hit_range,     // 1 where some hit and some missed
    normal_range,  // of x and y, added
    depth_range,   // of those that hit
    any_hit,
    residual,        // how wrong the network is at them: mean, weighted by 1 / distance^2
    greatest_change,  // from them to the completed gray
    mean_change,      // weighted likewise
    gray,             // completed
    agreement,        // how far it was interpolated (`interpolate_lattice`)
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
    /// The logarithms of the errors of `width` pixels, a multiple of 16, from features that lie `stride` floats apart.
    void (*predict)(const ErrorLayers& layers, const float* features, std::size_t stride, int width, float* logarithms);
};

BOB_DECLARE_KERNELS(ErrorPredictorKernels, error_predictor_kernels)

}  // namespace bob
