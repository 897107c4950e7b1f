/// Inner loops of reprojection, one variant for each instruction set, with identical results to the bit. Memory is read
/// and written in whole vectors: buffers are padded by `max_lanes`.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/isa.h"
#include "picture/eye.h"

namespace bob {

/// Points whose depths differ by less, in sides of a pixel, belong to one surface: a bound on its slope.
constexpr float same_surface = 2;

/// Points in the columns of a table.
template <class Float>
struct PointsIn {
    Float *x, *y, *z, *normal_x, *normal_y, *normal_z;
};

/// Screen grids with a border on all sides: the cell of a pixel is (row + border) * stride + column + border.
struct BorderedGrid {
    static constexpr std::int32_t border = 8;
    static constexpr std::int32_t nowhere = -1;

    std::int32_t height, width;
    std::int32_t stride = width + 2 * border;

    [[nodiscard]] std::int32_t at(std::int32_t row, std::int32_t column) const { return (row + border) * stride + column + border; }
    [[nodiscard]] std::int32_t row_of(std::int32_t cell) const { return cell / stride - border; }
    [[nodiscard]] std::int32_t column_of(std::int32_t cell) const { return cell % stride - border; }
    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(at(height + border, 0)) + max_lanes; }
};

/// Projected points, with their cells or nowhere, and with depths and their change per pixel. Also the squared distances
/// from the pixels' centres, the offsets to the right and down, and normals in screen space.
struct Sights {
    std::int32_t* cell;
    float *depth, *deeper_right, *deeper_down, *off_center, *right, *down, *normal_x, *normal_y;
};

/// The nearest surface at each cell: its depth, and the change of depth per pixel.
struct Surfaces {
    static constexpr float none = -1e9f;  // as the depth

    float *depth, *deeper_right, *deeper_down;
};

/// The discs of nearby points at each cell. First the nearest depth, at least -1, and bits of the octants with disc
/// centres of the same surface.
///
/// The kernel replaces these by the depth below which points are occluded, and -1 or 0 for whether the cell is inside its surface.
/// Inside, the centres lie on several sides; at a silhouette, all lie on one.
struct Covers {
    float* nearest;
    std::int32_t* sides;
};

/// The candidate point nearest to a cell's centre. The squared distance is in the upper half, as the bits of a
/// nonnegative float, and the point's number in the lower half. The minimum does not depend on the order of points.
using Choice = std::uint64_t;
constexpr Choice no_choice = ~Choice{0};
inline Choice choice(float off_center, std::uint32_t point) { return Choice{std::bit_cast<std::uint32_t>(off_center)} << 32 | point; }
inline std::int32_t chosen_point(Choice choice) { return static_cast<std::int32_t>(choice); }  // or -1

/// A disc's rows: half-widths, and the bits of the octant with the centre as seen from each cell.
struct DiscRows {
    std::int32_t radius;
    const std::int32_t* half_widths;              // for rows -radius to radius
    const std::int32_t (*sides)[2 * max_lanes];  // for all rows -border to border, from -border on
};

/// Positions of a row's pixels in the last picture, interpolated linearly between every `piece` pixels, and its
/// background.
struct WasEmpty {
    static constexpr std::int32_t piece = 16;

    const float *row, *column;  // for pixel 0, `piece`, and so on
    const std::uint8_t* empty;  // (height, width), followed by 0
    std::int32_t height, width;
};

/// The reprojected samples of a row, and the offsets to the right and down from the pixels' centres.
struct ExpectedRow {
    static constexpr float unknown = 8;  // offset where there is no sample

    float *mask, *depth, *normal_x, *normal_y, *off_center;
    float *right, *down;
};

struct HistoryKernels {
    /// Projects points `begin` to `end`; returns the number inside the picture, back faces included.
    std::size_t (*see)(const Eye& eye, const BorderedGrid& cells, PointsIn<const float> points, Sights sights, std::size_t begin, std::size_t end);
    /// Adds 1 to `counts` where a row has a surface or background.
    void (*count)(const float* depth, const std::uint8_t* empty, std::int32_t* counts, std::int32_t width);
    /// Splats the depth of a disc around a cell.
    void (*cover_far)(DiscRows disc, Surfaces surfaces, Covers covers, std::int32_t cell, std::int32_t stride);
    /// Adds the octant of its centre where that belongs to the same surface.
    void (*look_far)(const Eye& eye, DiscRows disc, Surfaces surfaces, Covers covers, std::int32_t cell, std::int32_t stride);
    /// Both, for the discs of five pixels around all cells of a row, before the larger discs' second pass. Finishes the
    /// cells if there are no larger discs.
    void (*cover)(const Eye& eye, DiscRows disc, const std::int32_t* is_inside, Surfaces surfaces, Covers covers, std::int32_t first, std::int32_t stride, std::int32_t width, bool ends);
    void (*end_cover)(const Eye& eye, const std::int32_t* is_inside, Surfaces surfaces, Covers covers, std::int32_t first, std::int32_t width);
    /// Finds the background of a row: background in the last picture, or outside the unit sphere, and no surface
    /// nearby.
    void (*empty)(WasEmpty was, const std::uint8_t* outside, const Choice* chosen, const std::int32_t* inside, const std::uint8_t* overrun,
                  std::uint8_t* empty, std::int32_t width);
    /// Writes the samples of chosen points and background. Returns the number of pixels with a point.
    std::int32_t (*expect)(Sights sights, const Choice* chosen, const std::uint8_t* empty, ExpectedRow to, std::int32_t width);
    /// Smooths a row of shades by distance from the pixel's centre. Weights fall with the offset of the sample, also
    /// for neighbouring pixels; at an edge they estimate its coverage.
    void (*smooth)(const float* shades, const float* right, const float* down, std::int32_t stride, float* to, std::int32_t width);
    /// Copies a column of the chosen points, 0 elsewhere.
    void (*carry)(const float* column, const Choice* chosen, float* to, std::int32_t width);
};

BOB_DECLARE_KERNELS(HistoryKernels, history_kernels)

}  // namespace bob
