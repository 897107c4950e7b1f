/// The inner loop of completion along guides, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "base/isa.h"

namespace bob {

/// A traced pixel, as those around it look at it.
struct GuidedSample {
    float row, column;
    float depth, normal[3], albedo[3], coverage;
    float light[3];
    float shade, variance;  // light's luminance, and how uncertain that is
};
static_assert(sizeof(GuidedSample) == 15 * sizeof(float));

/// Samples of one row of the picture, by their numbers; the row's own number.
struct GuidedRange {
    int begin, end;
    float row;
};

/// Some pixels of a row, and what is wanted of them. Pointers are to the first of them; whole vectors are read and written.
struct GuidedRow {
    float row, column;
    const float *depth, *depth_right, *depth_down, *normal[3], *albedo[3], *coverage;
    float reach, reach_right;        // how far samples count, at the first pixel, and how that grows from pixel to pixel
    float sharpness, sharpness_right;  // what is added to squared distances: the more, the less near ones count for
    float* light[3];
    float *weight;            // sum of the weights of like samples: where it is small, there were none
    float *detail, *noise;    // how far the samples' light scatters around the fit, squared, and how far noise explains it
};

/// How much surfaces may differ.
struct GuidedLikeness {
    float normal, albedo, coverage;  // by what squared differences are multiplied
    float depth;                     // tolerance
};

/// How far depth may be off the plane that it goes along, by how much it changes to the right and down.
template <class T>
[[gnu::always_inline]] static inline T depth_tolerance(const GuidedLikeness& likeness, T right, T down) {
    return likeness.depth + 0.5f * (right + down);
}

/// How unlike two surfaces are: by the differences of their normals and of their albedos, by how far one is off the plane that the other's
/// depth goes along, and by the difference of their coverage. T is a number or a vector of them.
template <class T, class Fma>
[[gnu::always_inline]] static inline T unlikeness(const GuidedLikeness& likeness, const T (&tilt)[3], T off_plane, T inverse_squared_tolerance,
                                                  T squared_distance, const T (&tint)[3], T uncovered, Fma fma) {
    constexpr float bend = 0.05f;  // depth bends: its tolerance grows with the distance in pixels, squared
    const T one = T{} + 1;
    T sum = likeness.normal * fma(tilt[0], tilt[0], fma(tilt[1], tilt[1], tilt[2] * tilt[2]));
    sum += off_plane * off_plane * inverse_squared_tolerance / fma(T{} + bend, squared_distance, one);
    sum += likeness.albedo * fma(tint[0], tint[0], fma(tint[1], tint[1], tint[2] * tint[2]));
    return sum + likeness.coverage * (uncovered * uncovered);
}

/// How much an unlike sample counts for, of one that is alike.
template <class T>
[[gnu::always_inline]] static inline T likeness_of(T unlikeness) {
    const T more = unlikeness + 1;
    return 1 / (more * more);
}

struct GuidedKernels {
    /// Pixels 0 to `count` of a row; every `step`-th sample of each range. `is_noisy` asks for detail and noise, too.
    void (*fit_gray)(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
                     const GuidedRow& row, int count, bool is_noisy);
    void (*fit_color)(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
                      const GuidedRow& row, int count, bool is_noisy);
};

BOB_DECLARE_KERNELS(GuidedKernels, guided_kernels)

}  // namespace bob
