/// Inner loops of the default network, other than its convolutions, one variant for each instruction set.
///
/// Each computes one row of a level in whole vectors, which may extend past the width. "Phases" are four channels with
/// the 2x2 pixels of each block, row by row.
#pragma once

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

/// Sums of a level over the traced pixels of a block. Their number, gray, depth, normal x and normal y, and their
/// offsets from the block's centre, right and down. Then 0 if all are background, else 1.
namespace sums {
enum : int { count, gray, depth, normal_x, normal_y, right, down, shown, channels };
}

struct PyramidKernels {
    /// Sums two rows of the G-buffer over 2x2 pixels.
    void (*pull_pixels)(PixelRows pixels, Rows sums, int width);
    /// Sums two rows to one of the coarser level; `quarter` as in pyramid.py.
    void (*pull)(ConstRows finer, Rows sums, float quarter, int width);
    /// Doubles a row bilinearly to two rows, and adds two rows.
    void (*enlarge)(Doubled coarse, ConstRows added, Rows gray, int width);
    /// Features of blocks with sides of `side` pixels: inputs 1 to 7, given the gray in input 0. Writes the gray to
    /// `corrected`, replaced by the traced means where these are better.
    void (*know)(ConstRows sums, Rows inputs, float* corrected, float side, int width);
    /// The same for level 1: inputs 1 and 2, and the phases of the mask, inputs 3 to 6. `shown` as in the sums.
    void (*know_finest)(PixelRows pixels, Rows inputs, float* corrected, float* shown, int width);
    /// The maxima of 3x3 pixels of a plane with a border of zeros. Multiplied by the coarser level's row, each pixel
    /// twice.
    void (*spread)(ConstRows shown, const float* coarser, float* surface, int width);
    /// The phases of the traced gray minus the doubled picture, given the phases of the mask.
    void (*compare)(Doubled coarse, PixelRows pixels, ConstRows mask, Rows surprise, int width);
    /// The picture in a row of blocks, from column `begin` to `end`. `correction` is in phases.
    void (*finish)(Doubled coarse, ConstRows mask, ConstRows surprise, ConstRows correction, const float* surface,
                   PictureRows picture, int begin, int end);
};

BOB_DECLARE_KERNELS(PyramidKernels, pyramid_kernels)

}  // namespace bob
