/// The inner loops of 3x3 convolutions, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "base/isa.h"

namespace bob {

/// What follows a convolution, in the same pass over the image.
enum class Then {
    nothing,
    relu,
    relu_pool,      // 2x2 maxima: half the height and width, both even
    relu_upsample,  // each pixel becomes 2x2
    shuffle,        // each four channels become the 2x2 pixels of one, row by row
};

/// Winograd's F(4, 3) evaluates polynomials at 0, infinity and, of either sign, these. They are numbers that float32 holds, and
/// near enough to 1 that rounding costs no more than summing in turn does: over 51 channels both err by 2.2e-7 (root mean
/// square); from the usual 1 and 2 it would be 3.1e-7.
constexpr float winograd_near = 0.75f, winograd_far = 1.5f;

/// Channels that a convolution reads from one image.
struct ConvInput {
    const float* row;        // first pixel of the first row of the results, in the first channel
    std::ptrdiff_t rows[6];  // from there to the row above, itself and those below: as many as the results have, and one more
    std::size_t plane_stride;
    int channels;
};

/// The output channels of a group over the rows that are computed at once. They are computed in blocks.
struct ConvRows {
    ConvInput inputs[2];  // the second may have no channels
    int begin, end;       // columns
    int rows;  // of the results, which the image has: at the end fewer than are computed
    int blocks;
    const float* weight;   // (blocks, products, inputs, 3, block): see `winograd_taps`; of a single channel (blocks, inputs, 3, 3)
    const float* bias;     // (blocks, block)
    float* const* output;  // first pixel of the first row written of each channel, or shuffled of each four
    std::size_t output_row_stride;
    float* scratch;  // conv_scratch floats for each product and input
    int* used;       // conv_steps numbers for each input
};

/// Pixels of a row whose differences are kept to be used for all output channels, and what that takes.
constexpr int conv_tile = 160;
constexpr int conv_scratch = conv_tile + 16;
/// Parts of that, at most, in each of which the inputs that are not 0 are found.
constexpr int conv_steps = 20;

using ConvKernel = void (*)(const ConvRows& rows, Then then);

/// They write whole vectors, beyond the last column if need be.
struct ConvKernels {
    /// Four rows at once, in blocks of one channel, of four and of five. `Then::shuffle` needs blocks of four.
    ConvKernel one, four, five;
    /// Two rows at once, in blocks of four channels.
    ConvKernel two_rows;
};

BOB_DECLARE_KERNELS(ConvKernels, conv_kernels)

}  // namespace bob
