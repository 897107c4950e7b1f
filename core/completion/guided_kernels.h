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

/// Planes of guides.
struct Guides {
    enum Plane { depth, depth_right, depth_down, normal_x, normal_y, normal_z, red, green, blue, coverage, count };
};

/// Places in the picture, and fits of light there. A place's value is `of[value][place]`; whole vectors are read and written.
struct GuidedPlaces {
    static constexpr int capacity = 128;
    /// 1, the position in the picture, and the normal unless all places are on one plane.
    static constexpr int on_surfaces = 6, on_plane = 3;

    enum Value {
        row,
        column,
        reach,
        sharpness,                   // offset of squared distances
        guides,                      // Guides::Plane; not read on planes
        light = guides + static_cast<int>(Guides::count),  // components of the linear functions of the unknowns, relative to the place
        low = light + 3 * on_surfaces, high = low + 3,  // extremes of the samples, which limit the functions
        weight = high + 3,           // sum of the weights of samples on the same surface
        detail, noise,               // squared scatter of the samples around the fit, and its share explained by noise
        values
    };
    static constexpr int guide(int plane) { return guides + plane; }
    static constexpr int light_of(int component, int unknown) { return light + on_surfaces * component + unknown; }

    int count = 0;
    alignas(64) float of[values][capacity]{};
};

/// Places in rows and columns of an area, at its corners too.
struct GuidedGrid {
    static constexpr int max_rows = 8, max_columns = 16;
    static_assert(max_rows * max_columns <= GuidedPlaces::capacity);

    int rows, columns;
    int row[max_rows], column[max_columns];  // in the area
    int place[max_rows][max_columns];        // its number, or -1
};

/// The pixels of an area. Pointers are to its first one.
struct GuidedPixels {
    int top, left, height, width;
    const float* guides[Guides::count];  // not read on planes
    std::size_t guides_stride, output_stride;
    float* light[3];
    float* weight;  // likeness of the places' surfaces; of places without enough samples, 0
    float *detail, *noise;
};

/// Minimum weight of a fit.
constexpr float least_weight = 1e-2f;

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
    /// Fits every place to every `step`-th sample of each range. `is_noisy` also requests detail and noise.
    using Fit = void(const GuidedSample* samples, const GuidedRange* ranges, std::size_t range_count, int step, const GuidedLikeness& likeness,
                     GuidedPlaces& places, bool is_noisy);
    /// Blends the functions of the places around each pixel, by nearness and likeness.
    using Blend = void(const GuidedPlaces& places, const GuidedGrid& grid, const GuidedLikeness& likeness, const GuidedPixels& pixels, int components,
                       bool is_noisy);

    Fit *fit_gray, *fit_color;
    /// Gray where all samples and places are on one plane.
    Fit* fit_plane;
    Blend *blend_surfaces, *blend_plane;
};

BOB_DECLARE_KERNELS(GuidedKernels, guided_kernels)

}  // namespace bob
