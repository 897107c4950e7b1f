/// The inner loops of what is carried along from camera to camera, one variant for each instruction set; all give the same bits.
/// Memory is read and written in whole vectors: `max_lanes` more than there are.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/isa.h"
#include "picture/eye.h"

namespace bob {

/// Points whose depths differ by less belong to one surface, in sides of a pixel: so steep it may be.
constexpr float same_surface = 2;

/// Points in the columns of a table.
template <class Float>
struct PointsIn {
    Float *x, *y, *z, *normal_x, *normal_y, *normal_z;
};

/// Pictures of what is seen, with a border around them: the cell of a pixel is (row + border) * stride + column + border.
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

/// Where points are seen: their cells, or nowhere; depths, and how these change from pixel to pixel; how far from pixels' centres, squared;
/// to their right of that and below it; and normals in screen space.
struct Sights {
    std::int32_t* cell;
    float *depth, *deeper_right, *deeper_down, *off_center, *right, *down, *normal_x, *normal_y;
};

/// What is nearest at each cell: a depth, and how it changes from pixel to pixel.
struct Surfaces {
    static constexpr float none = -1e9f;  // as the depth

    float *depth, *deeper_right, *deeper_down;
};

/// What discs around nearby points say of each cell: how near they are, at least -1, and bits of the eighths in which the centres of those lie
/// that belong to its surface. In the end instead from which depth on points are not hidden, and -1 or 0: whether
/// the cell is inside its surface. Then those centres lie on several sides; at a silhouette they all lie on one.
struct Covers {
    float* nearest;
    std::int32_t* sides;
};

/// Of all points that may be expected at a cell the one that was seen nearest its centre: the squared distance in the upper half, the bits
/// of a float that is not negative, and the point's number in the lower. The least wins, whichever came first.
using Choice = std::uint64_t;
constexpr Choice no_choice = ~Choice{0};
inline Choice choice(float off_center, std::uint32_t point) { return Choice{std::bit_cast<std::uint32_t>(off_center)} << 32 | point; }
inline std::int32_t chosen_point(Choice choice) { return static_cast<std::int32_t>(choice); }  // or -1

/// A disc's rows: from its centre so far to either side, and the bits of the eighths in which the centre lies from there.
struct DiscRows {
    std::int32_t radius;
    const std::int32_t* half_widths;              // of rows -radius to radius
    const std::int32_t (*sides)[2 * max_lanes];  // of all rows -border to border, from -border on
};

/// Where the pixels of a row were in the picture before, on straight lines between every so many of them, and what was empty there.
struct WasEmpty {
    static constexpr std::int32_t piece = 16;

    const float *row, *column;  // of pixel 0, `piece`, and so on
    const std::uint8_t* empty;  // (height, width), and behind that 0
    std::int32_t height, width;
};

/// What is expected in a row of a picture, and in its cells how far right of the pixel's centre and below it that was seen.
struct ExpectedRow {
    static constexpr float unknown = 8;  // as the latter, where nothing is expected

    float *mask, *depth, *normal_x, *normal_y, *off_center;
    float *right, *down;
};

struct HistoryKernels {
    /// Points `begin` to `end`; how many of them lie within the picture, also turned away.
    std::size_t (*see)(const Eye& eye, const BorderedGrid& cells, PointsIn<const float> points, Sights sights, std::size_t begin, std::size_t end);
    /// Adds to `counts` where a row of cells has a surface or of pixels is empty.
    void (*count)(const float* depth, const std::uint8_t* empty, std::int32_t* counts, std::int32_t width);
    /// Of a disc around a cell, how near it is.
    void (*cover_far)(DiscRows disc, Surfaces surfaces, Covers covers, std::int32_t cell, std::int32_t stride);
    /// And in which eighth its centre lies, where that belongs to the surface.
    void (*look_far)(const Eye& eye, DiscRows disc, Surfaces surfaces, Covers covers, std::int32_t cell, std::int32_t stride);
    /// Both, of the discs of five pixels around all cells of a row; before what is farther has been looked at. What that ends with
    /// where nothing is farther.
    void (*cover)(const Eye& eye, DiscRows disc, const std::int32_t* is_inside, Surfaces surfaces, Covers covers, std::int32_t first, std::int32_t stride, std::int32_t width, bool ends);
    void (*end_cover)(const Eye& eye, const std::int32_t* is_inside, Surfaces surfaces, Covers covers, std::int32_t first, std::int32_t width);
    /// Which pixels of a row are empty: those were at some place in the picture before, or lie outside of all, and no surface is near.
    void (*empty)(WasEmpty was, const std::uint8_t* outside, const Choice* chosen, const std::int32_t* inside, const std::uint8_t* overrun,
                  std::uint8_t* empty, std::int32_t width);
    /// What is expected where points were chosen, or the pixel is empty. Returns at how many pixels points were.
    std::int32_t (*expect)(Sights sights, const Choice* chosen, const std::uint8_t* empty, ExpectedRow to, std::int32_t width);
    /// Smooths a row of shades: what was seen beside a pixel's centre counts less the farther it was, and so does what was seen in the pixels
    /// around. At an edge that is the share of it that is likely.
    void (*smooth)(const float* shades, const float* right, const float* down, std::int32_t stride, float* to, std::int32_t width);
    /// A column of the table of points, where they were chosen, else 0.
    void (*carry)(const float* column, const Choice* chosen, float* to, std::int32_t width);
};

BOB_DECLARE_KERNELS(HistoryKernels, history_kernels)

}  // namespace bob
