/// Rows of images, as the kernels of networks see them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "base/isa.h"

namespace bob {

/// Rows of a picture, from `begin` to before `end`.
struct Band {
    int begin, end;
};

/// Columns of a row, from `begin` to before `end`.
struct Stretch {
    int begin = 0, end = 0;

    [[nodiscard]] constexpr bool is_empty() const { return begin >= end; }
};

/// From the first to the last of both.
constexpr Stretch joined(Stretch a, Stretch b) {
    if (a.is_empty()) return b;
    return b.is_empty() ? a : Stretch{std::min(a.begin, b.begin), std::max(a.end, b.end)};
}

/// From the first to the last of some rows, of those that exist.
inline Stretch joined(std::span<const Stretch> rows, int begin, int end) {
    Stretch all;
    for (int y = std::max(0, begin); y < std::min(end, static_cast<int>(rows.size())); ++y) all = joined(all, rows[static_cast<std::size_t>(y)]);
    return all;
}

/// Made longer to multiples of so many columns, by default whole vectors of any kind.
constexpr Stretch aligned(Stretch some, int columns = max_lanes) {
    return {some.begin / columns * columns, (some.end + columns - 1) / columns * columns};
}

/// Those of `count` columns that there are.
constexpr Stretch within(Stretch some, int count) { return {some.begin, std::min(some.end, count)}; }

/// A row of a plane, or of several, and those beside it.
template <class T>
struct RowsIn {
    T* row;  // its first pixel in the first channel
    std::ptrdiff_t above, below;  // floats from there to the rows above and below
    std::size_t plane_stride;

    /// The row above for y = -1, that below for 1.
    T* at(int channel, int y = 0) const {
        return row + static_cast<std::ptrdiff_t>(plane_stride) * channel + (y < 0 ? above : y > 0 ? below : 0);
    }
};
using Rows = RowsIn<float>;
using ConstRows = RowsIn<const float>;

/// Two rows of the G-buffer, of which `rows` and `columns` exist; the others count as not traced.
struct PixelRows {
    ConstRows from;
    int rows, columns;
};

/// Two rows of the completed picture, of which `rows` and `columns` exist.
struct PictureRows {
    float* row;
    std::ptrdiff_t stride;
    int rows, columns;
};

/// Three rows of a picture to be doubled: that above, this one and that below; pixels -1 and width repeat the edges.
struct Doubled {
    const float *above, *here, *below;
};

}  // namespace bob
