/// The inner loops of completing by ratios, one variant for each instruction set. Rows of pixels, or of blocks of a coarser level.
#pragma once

#include "isa.h"

namespace bob {

/// A row and those above and below it, which are null beyond the picture.
struct RowOfThree {
    const float *above, *row, *below;
};

struct RatioKernels {
    /// 1 where a row is above 0, else 0.
    void (*count)(const float* row, int width, float* counts);
    /// Sums of two rows in pairs of pixels, (width + 1) / 2 of them; `below` may be null.
    void (*pull)(const float* above, const float* below, int width, float* sums);
    /// Sums over 3 x 3 pixels, of which those beside, above and below count `beside`, and those across the square of it. `between`
    /// has room for the row and one more pixel at each end.
    void (*gather)(const RowOfThree& rows, float beside, int width, float* between, float* sums);
    /// A row of the next finer level, bilinear between blocks: of blocks in the nearer and the farther row.
    void (*push)(const float* nearer, const float* farther, int width, int finer_width, float* between, float* finer);
    /// 1 / (weight + prior)
    void (*inverse)(const float* weight, float prior, int width, float* inverse);
    /// (sum + prior * expected) * inverse, in place of what was expected.
    void (*mean)(const float* sum, const float* inverse, float prior, int width, float* expected);
    /// ratio * min(wanted, brighter * mean), and where more is wanted, the rest as it is; in place of the ratio.
    void (*shade)(const float* wanted, const float* mean, float brighter, int width, float* ratio);
};

BOB_DECLARE_KERNELS(RatioKernels, ratio_kernels)

}  // namespace bob
