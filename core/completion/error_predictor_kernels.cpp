#include "completion/error_predictor_kernels.h"

#include "base/simd.h"

namespace bob::BOB_ISA {
namespace {

void predict(const ErrorLayers& layers, const float* features, std::size_t stride, int width, float* logarithms) {
    constexpr int count = error_features::count;
    for (int x = 0; x < width; x += lanes) {
        F of_pixels[count];
        BOB_UNROLL
        for (int k = 0; k < count; ++k) of_pixels[k] = load<F>(features + static_cast<std::size_t>(k) * stride + x);
        F sum = constant(layers.output_bias);
        for (int j = 0; j < layers.hidden; ++j) {
            const float* const weights = layers.hidden_weights + count * j;
            F hidden = constant(layers.hidden_bias[j]);
            BOB_UNROLL
            for (int k = 0; k < count; ++k) hidden = fma(constant(weights[k]), of_pixels[k], hidden);
            sum = fma(constant(layers.output_weights[j]), max(hidden, F{}), sum);
        }
        store(logarithms + x, sum);
    }
}

}  // namespace

const ErrorPredictorKernels error_predictor_kernels = {predict};

}  // namespace bob::BOB_ISA
