/// The inner loops of completing by ratios, one variant for each instruction set. Rows of pixels, or of blocks of a coarser level;
/// stretches are those of the coarser of two levels, from whole vectors on, and whole vectors are written.
#pragma once

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

constexpr int ratio_components = 3;

/// Sums over a block's pixels, of those whose guide is above 0; their number comes last.
namespace ratio_sums { enum : int { guide, color, count = color + ratio_components, channels }; }
/// The mean of the guide, and the components' ratios to it.
namespace ratio_means { enum : int { guide, color, channels = color + ratio_components }; }

/// A coarser level's means, to be doubled.
struct DoubledMeans {
    Doubled of[ratio_means::channels];
};

/// Two rows of pixels and those above and below them, in order: the guide, null beyond the picture, and the colours' first component.
struct GuidedRows {
    const float *guide[4], *color[4];
    std::size_t plane_stride;
    int columns;
};

/// Two rows of a picture of colours to be made: its first component, and the guide, of which all pixels are known.
struct ColoredRows {
    float* row;
    const float* guide;
    std::size_t plane_stride;
    std::ptrdiff_t stride;
    int rows;
    float low, high;  // of the components
};

struct RatioKernels {
    /// Where two rows of both are not all 0, of whole vectors.
    Stretch (*lit)(PixelRows guide, PixelRows known_guide);
    /// Sums of two rows of pixels in blocks.
    void (*pull_pixels)(PixelRows guide, PixelRows color, Rows sums, Stretch some);
    /// The same of the next finer level's sums.
    void (*pull)(ConstRows finer, Rows sums, Stretch some);
    /// Two rows of means, from the sums around and what the coarser level expects. `unit` of the guide counts as 1; the level is
    /// `width` wide.
    void (*mean)(DoubledMeans coarse, ConstRows sums, ConstRows sums_below, Rows means, float unit, int width, Stretch some);
    /// Two rows of the picture: the guide times the ratios around, up to somewhat more than its mean there, and white beyond; within
    /// low..high, NaN as low.
    void (*finish)(DoubledMeans coarse, GuidedRows traced, ColoredRows picture, float unit, Stretch some);
};

BOB_DECLARE_KERNELS(RatioKernels, ratio_kernels)

}  // namespace bob
