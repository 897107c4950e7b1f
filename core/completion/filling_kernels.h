/// The inner loops of the filling, one variant for each instruction set. Each computes one row of a level's blocks, in whole
/// vectors, beyond the width if need be.
#pragma once

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

/// Of the pixels of a block: how many were traced, how many of those show a surface, and these' gray.
namespace counts {
enum : int { traced, shown, gray, channels };
}

/// Pictures of a level: the share of traced pixels that show a surface, and the surface's gray.
namespace filled {
enum : int { coverage, gray, channels };
}

/// In phases, the 2x2 pixels of each block: how many pixels each counts for, and by how much all of these together differ from what
/// is expected; for coverage, and for gray.
namespace surprise {
enum : int { traced = 0, coverage = 4, shown = 8, gray = 12, channels = 16 };
}

struct DoubledPair {
    Doubled coverage, gray;
};

struct FillingKernels {
    /// Two rows of pixels to counts of 2x2 of them.
    void (*pull_pixels)(PixelRows pixels, Rows counts, int width);
    /// Two rows of counts to one of the coarser level's.
    void (*pull)(ConstRows finer, Rows counts, int width);
    /// By how much two rows of counts differ from the coarser pictures, doubled.
    void (*compare)(DoubledPair coarse, ConstRows finer, Rows surprise, int width);
    void (*compare_pixels)(DoubledPair coarse, PixelRows pixels, Rows surprise, int width);
    /// Two rows of a level's pictures.
    void (*correct)(DoubledPair coarse, ConstRows surprise, Rows filled, int width);
    /// Two rows of the completed gray.
    void (*finish)(DoubledPair coarse, ConstRows surprise, PictureRows picture, int width);
};

BOB_DECLARE_KERNELS(FillingKernels, filling_kernels)

}  // namespace bob
