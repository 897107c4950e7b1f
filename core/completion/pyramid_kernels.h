/// The inner loops of the default network, besides its convolutions, one variant for each instruction set.
///
/// Each computes one row of a level. Whole vectors are written, beyond the width if need be. "Phases" are four channels that
/// hold the 2x2 pixels of each block, row by row.
#pragma once

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

/// Of a level's sums: how many pixels of a block were traced, and of those the gray, depth, normal x, normal y, and how far
/// to the right and below the block's centre they are; then 0 where all of them are background, else 1.
namespace sums {
enum : int { count, gray, depth, normal_x, normal_y, right, down, shown, channels };
}

struct PyramidKernels {
    /// Two rows of the G-buffer to sums of 2x2 pixels.
    void (*pull_pixels)(PixelRows pixels, Rows sums, int width);
    /// Two rows of sums to one of the coarser level's; `quarter` as in pyramid.py.
    void (*pull)(ConstRows finer, Rows sums, float quarter, int width);
    /// Doubles a row bilinearly, to two rows, and adds two rows.
    void (*enlarge)(Doubled coarse, ConstRows added, Rows gray, int width);
    /// What is known of blocks with sides of `side` pixels: inputs 1 to 7, given the gray in input 0, which is written to
    /// `corrected` with the means in the place of what they tell better.
    void (*know)(ConstRows sums, Rows inputs, float* corrected, float side, int width);
    /// The same for level 1: inputs 1 and 2, and the phases of the mask, inputs 3 to 6. `shown` as in the sums.
    void (*know_finest)(PixelRows pixels, Rows inputs, float* corrected, float* shown, int width);
    /// The maxima of 3x3 pixels of a plane with zeros around it, times the coarser level's row, each pixel twice.
    void (*spread)(ConstRows shown, const float* coarser, float* surface, int width);
    /// The phases of what the gray of traced pixels is more than the doubled picture, given those of the mask.
    void (*compare)(Doubled coarse, PixelRows pixels, ConstRows mask, Rows surprise, int width);
    /// The picture in a row of blocks, from column `begin` to `end`. `correction` in phases.
    void (*finish)(Doubled coarse, ConstRows mask, ConstRows surprise, ConstRows correction, const float* surface,
                   PictureRows picture, int begin, int end);
};

BOB_DECLARE_KERNELS(PyramidKernels, pyramid_kernels)

}  // namespace bob
