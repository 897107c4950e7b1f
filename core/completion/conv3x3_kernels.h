/// The inner loops of 3x3 convolutions, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "base/isa.h"

namespace bob {

/// The operation after a convolution, in the same pass over the image.
enum class Then {
    nothing,
    relu,
    relu_pool,      // 2x2 maxima: half the height and width, both even
    relu_upsample,  // each pixel becomes 2x2
    shuffle,        // each four channels become the 2x2 pixels of one, row by row
};

/// Winograd's F(4, 3) evaluates polynomials at 0, at infinity, and at plus and minus these two points. Both are exact
/// in float32 and near enough to 1: over 51 channels the error is 2.2e-7 (root mean square), as with direct summation.
/// The usual points 1 and 2 give 3.1e-7.
constexpr float winograd_near = 0.75f, winograd_far = 1.5f;

/// Channels of one image that a convolution reads.
struct ConvInput {
    const float* row;        // first pixel of the first result row, in the first channel
    std::ptrdiff_t rows[6];  // offsets to the row above, the result rows, and the row below
    std::size_t plane_stride;
    int channels;
};

/// The output channels of a group for the rows computed together, in blocks.
struct ConvRows {
    ConvInput inputs[2];  // the second may be empty
    int begin, end;       // columns
    int rows;  // result rows inside the image; at its end fewer than are computed
    int blocks;
    const float* weight;   // (blocks, products, inputs, 3, block): see `winograd_taps`; for a single channel (blocks, inputs, 3, 3)
    const float* bias;     // (blocks, block)
    float* const* output;  // first pixel of the first row written, for each channel or each shuffled four
    std::size_t output_row_stride;
    float* scratch;  // conv_scratch floats for each product and input
    int* used;       // conv_steps numbers for each input
};

/// Pixels of a row whose transforms are kept for all output channels, and the scratch memory for them.
constexpr int conv_tile = 160;
constexpr int conv_scratch = conv_tile + 16;
/// Maximum number of parts of a tile; nonzero inputs are found for each part.
constexpr int conv_steps = 20;

using ConvKernel = void (*)(const ConvRows& rows, Then then);

/// Kernels store whole vectors and may write past the last column.
struct ConvKernels {
    /// Four rows at once, in blocks of one channel, of four and of five. `Then::shuffle` needs blocks of four.
    ConvKernel one, four, five;
    /// Two rows at once, in blocks of four channels.
    ConvKernel two_rows;
};

BOB_DECLARE_KERNELS(ConvKernels, conv_kernels)

}  // namespace bob
