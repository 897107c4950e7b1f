/// Inner loops of the filling, one variant for each instruction set. Each computes one row of a level's blocks in whole
/// vectors, which may extend past the width.
#pragma once

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

/// Per block: the number of traced pixels, how many show a surface, and the sum of its gray.
namespace counts {
enum : int { traced, shown, gray, channels };
}

/// The pictures of a level: the share of traced pixels that show a surface, and the surface's gray.
namespace filled {
enum : int { coverage, gray, channels };
}

/// In phases, the 2x2 pixels of each block. For coverage and for gray: the weight of each pixel, and the weighted
/// difference from the prediction.
namespace surprise {
enum : int { traced = 0, coverage = 4, shown = 8, gray = 12, channels = 16 };
}

struct DoubledPair {
    Doubled coverage, gray;
};

struct FillingKernels {
    /// Sums two rows of pixels to counts of 2x2 blocks.
    void (*pull_pixels)(PixelRows pixels, Rows counts, int width);
    /// Sums two rows of counts to one of the coarser level.
    void (*pull)(ConstRows finer, Rows counts, int width);
    /// Differences of two rows of counts from the doubled coarser pictures.
    void (*compare)(DoubledPair coarse, ConstRows finer, Rows surprise, int width);
    void (*compare_pixels)(DoubledPair coarse, PixelRows pixels, Rows surprise, int width);
    /// Corrects two rows of a level's pictures.
    void (*correct)(DoubledPair coarse, ConstRows surprise, Rows filled, int width);
    /// Writes two rows of the completed gray.
    void (*finish)(DoubledPair coarse, ConstRows surprise, PictureRows picture, int width);
};

BOB_DECLARE_KERNELS(FillingKernels, filling_kernels)

}  // namespace bob
