/// The inner loops of 3x3 convolutions, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "isa.h"

namespace bob {

/// What follows a convolution, in the same pass over the image.
enum class Then {
    nothing,
    relu,
    relu_pool,      // 2x2 maxima: half the height and width, both even
    relu_upsample,  // each pixel becomes 2x2
    shuffle,        // each four channels become the 2x2 pixels of one, row by row
};

/// The output channels of a group over a pair of rows, or over the last row alone. They are computed in blocks.
struct ConvRow {
    const float* input;  // first pixel of the upper row in the first input channel of the group
    std::ptrdiff_t rows[4];  // from there to the row above, itself, the lower row and the one below
    std::size_t plane_stride;
    int inputs;  // channels
    int width;
    int blocks;
    const float* weight;       // (blocks, inputs, 3, 3, block)
    const float* weight_pair;  // (blocks, inputs, 3, 4, block): for two rows at once, see `winograd_taps`
    const float* bias;         // (blocks, block)
    float* const* output;      // first pixel of the first row written of each channel, or shuffled of each four
    std::size_t output_row_stride;
    float* scratch;  // conv_scratch floats for each input
};

/// Pixels of a row whose differences are kept to be used for all output channels: those of 32 channels fit the cache.
constexpr int conv_tile = 96;
constexpr int conv_scratch = 4 * (conv_tile + 16);

struct ConvKernels {
    /// Computes in blocks of five channels, of four and of one; writes whole vectors, beyond the width if need be. `rows` is
    /// 2, or 1 at the image's end. `Then::shuffle` needs blocks of four.
    void (*conv5)(const ConvRow& row, int rows, Then then);
    void (*conv4)(const ConvRow& row, int rows, Then then);
    void (*conv1)(const ConvRow& row, int rows, Then then);
};

BOB_DECLARE_KERNELS(ConvKernels, conv_kernels)

}  // namespace bob
