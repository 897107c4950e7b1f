/// Inner loops of completion by ratios, one variant for each instruction set. Rows of pixels, or of blocks of a coarser
/// level. Stretches are in columns of the coarser of two levels; they begin at whole vectors, and whole vectors are
/// written.
#pragma once

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

constexpr int ratio_components = 3;

/// Sums over a block's pixels whose guide is above 0; their number comes last.
namespace ratio_sums { enum : int { guide, color, count = color + ratio_components, channels }; }
/// The mean of the guide, and the components' ratios to it.
namespace ratio_means { enum : int { guide, color, channels = color + ratio_components }; }

/// Means of a coarser level, for doubling.
struct DoubledMeans {
    Doubled of[ratio_means::channels];
};

/// Two rows of pixels and the rows above and below, in order. The guide is null outside the picture; the colours are
/// given by their first component.
struct GuidedRows {
    const float *guide[4], *color[4];
    std::size_t plane_stride;
    int columns;
};

/// Two output rows of colours: the first component, and the completed guide.
struct ColoredRows {
    float* row;
    const float* guide;
    std::size_t plane_stride;
    std::ptrdiff_t stride;
    int rows;
    float low, high;  // of the components
};

struct RatioKernels {
    /// The range where two rows of both are not all 0, in whole vectors.
    Stretch (*lit)(PixelRows guide, PixelRows known_guide);
    /// Sums two rows of pixels in blocks.
    void (*pull_pixels)(PixelRows guide, PixelRows color, Rows sums, Stretch some);
    /// Sums two rows of the next finer level.
    void (*pull)(ConstRows finer, Rows sums, Stretch some);
    /// Computes two rows of means from the neighbouring sums and the coarser level's prediction. `unit` is the guide's
    /// size of a 1; the level is `width` wide.
    void (*mean)(DoubledMeans coarse, ConstRows sums, ConstRows sums_below, Rows means, float unit, int width, Stretch some);
    /// Writes two rows of the picture. Up to somewhat above the guide's mean nearby, a pixel is the guide times the
    /// ratios there; the rest is white. Clamped to low..high, NaN to low.
    void (*finish)(DoubledMeans coarse, GuidedRows traced, ColoredRows picture, float unit, Stretch some);
};

BOB_DECLARE_KERNELS(RatioKernels, ratio_kernels)

}  // namespace bob
