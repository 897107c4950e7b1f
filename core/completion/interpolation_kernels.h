/// The inner loops of what follows a network, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "isa.h"

namespace bob {

/// A row of what pixels are taken for: their values, of one component or three, by how much what each was made of differs at most (0 where traced, infinity
/// where nothing is known), and what is made of them.
struct LatticeRow {
    int components;
    std::ptrdiff_t value_plane, output_plane;  // floats from a component to the next
    const float* mask;
    float *value, *contrast;
    std::ptrdiff_t corners[4];  // floats from a pixel to those between which it lies, opposite ones in pairs
    float weight_per_contrast;
    float* output;
    float* weight;  // how far the mean counts; may be null
};

struct InterpolationKernels {
    /// Traced pixels as they are, of the others nothing: a component's values, and by how much what they were made of differs.
    void (*begin)(const float* mask, const float* traced, float* value, std::size_t pixels);
    void (*begin_contrast)(const float* mask, float* contrast, std::size_t pixels);
    /// Takes the pixels x, x + apart, ... before `end` for the mean of the two opposite corners that differ less, unless these differ
    /// too much, a corner is unknown, or the two others lie off on the same side. `end` lies where all corners are inside the picture; whole vectors are done, up to the column that is returned. `apart` is 2 or 4.
    int (*between)(const LatticeRow& row, int x, int end, int apart);
    /// Traced pixels keep their values, the others are clamped to a channel's range, and NaN to its low end.
    void (*keep)(const float* mask, const float* traced, float low, float high, float* output, std::size_t pixels);
};

BOB_DECLARE_KERNELS(InterpolationKernels, interpolation_kernels)

}  // namespace bob
