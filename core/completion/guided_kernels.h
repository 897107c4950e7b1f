/// The inner loop of completion along guides, one variant for each instruction set.
#pragma once

#include <cstddef>

#include "base/isa.h"

namespace bob {

/// A traced pixel.
struct GuidedSample {
    float row, column;
    float depth, normal[3], albedo[3], coverage;
    float light[3];
    float shade, variance;  // of the light's luminance
};
static_assert(sizeof(GuidedSample) == 15 * sizeof(float));

/// Samples of one row of the picture, by their numbers; the row's own number.
struct GuidedRange {
    int begin, end;
    float row;
};

/// Input and output for places in a row of the picture. Pointers are to the first place; whole vectors are read and written.
struct GuidedRow {
    float row, column;
    float column_step;                 // from one place to the next; 1 except on planes
    const float *depth, *depth_right, *depth_down, *normal[3], *albedo[3], *coverage;  // not read on planes
    float reach, reach_right;          // reach at the first place, and its increment per place
    float sharpness, sharpness_right;  // offset of squared distances, and its increment per place
    float* light[3];
    float *weight;            // sum of the weights of samples on the same surface
    float *detail, *noise;    // squared scatter of the samples around the fit, and its share explained by noise
};

/// Tolerances for differences between surfaces.
struct GuidedLikeness {
    float normal, albedo, coverage;  // factors of squared differences
    float depth;                     // tolerance
};

/// Tolerance of depth around the tangent plane, given the slopes to the right and down.
template <class T>
[[gnu::always_inline]] static inline T depth_tolerance(const GuidedLikeness& likeness, T right, T down) {
    return likeness.depth + 0.5f * (right + down);
}

/// Distance between two surfaces: differences of normals, albedos and coverage, and one's distance from the other's tangent plane in
/// depth. T is a number or a vector of them.
template <class T, class Fma>
[[gnu::always_inline]] static inline T unlikeness(const GuidedLikeness& likeness, const T (&tilt)[3], T off_plane, T inverse_squared_tolerance,
                                                  T squared_distance, const T (&tint)[3], T uncovered, Fma fma) {
    constexpr float bend = 0.05f;  // depth is curved: its tolerance grows with the squared distance in pixels
    const T one = T{} + 1;
    T sum = likeness.normal * fma(tilt[0], tilt[0], fma(tilt[1], tilt[1], tilt[2] * tilt[2]));
    sum += off_plane * off_plane * inverse_squared_tolerance / fma(T{} + bend, squared_distance, one);
    sum += likeness.albedo * fma(tint[0], tint[0], fma(tint[1], tint[1], tint[2] * tint[2]));
    return sum + likeness.coverage * (uncovered * uncovered);
}

/// Weight of a sample on another surface, relative to one on the same surface.
template <class T>
[[gnu::always_inline]] static inline T likeness_of(T unlikeness) {
    const T more = unlikeness + 1;
    return 1 / (more * more);
}

struct GuidedKernels {
    /// Fits `count` places of a row to every `step`-th sample of each range. `is_noisy` also requests detail and noise.
    void (*fit_gray)(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
                     const GuidedRow& row, int count, bool is_noisy);
    void (*fit_color)(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
                      const GuidedRow& row, int count, bool is_noisy);
    /// Gray where all samples and places are on one plane.
    void (*fit_plane)(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
                      const GuidedRow& row, int count, bool is_noisy);
};

BOB_DECLARE_KERNELS(GuidedKernels, guided_kernels)

}  // namespace bob
