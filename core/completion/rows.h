/// Rows of images, as the networks' kernels see them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "base/isa.h"

namespace bob {

/// Rows `begin` to `end` of a picture; `end` is excluded.
struct Band {
    int begin, end;
};

/// Columns `begin` to `end` of a row; `end` is excluded.
struct Stretch {
    int begin = 0, end = 0;

    [[nodiscard]] constexpr bool is_empty() const { return begin >= end; }
};

/// The smallest stretch that contains both.
constexpr Stretch joined(Stretch a, Stretch b) {
    if (a.is_empty()) return b;
    return b.is_empty() ? a : Stretch{std::min(a.begin, b.begin), std::max(a.end, b.end)};
}

/// The smallest stretch that contains the existing rows from `begin` to `end`.
inline Stretch joined(std::span<const Stretch> rows, int begin, int end) {
    Stretch all;
    for (int y = std::max(0, begin); y < std::min(end, static_cast<int>(rows.size())); ++y) all = joined(all, rows[static_cast<std::size_t>(y)]);
    return all;
}

/// A stretch extended to multiples of `columns`; by default, to whole vectors of any instruction set.
constexpr Stretch aligned(Stretch some, int columns = max_lanes) {
    return {some.begin / columns * columns, (some.end + columns - 1) / columns * columns};
}

/// A stretch clipped to `count` columns.
constexpr Stretch within(Stretch some, int count) { return {some.begin, std::min(some.end, count)}; }

/// A row of one or more planes, with offsets to its neighbours.
template <class T>
struct RowsIn {
    T* row;  // first pixel in the first channel
    std::ptrdiff_t above, below;  // floats from there to the rows above and below
    std::size_t plane_stride;

    /// The row above for y = -1, and the row below for y = 1.
    T* at(int channel, int y = 0) const {
        return row + static_cast<std::ptrdiff_t>(plane_stride) * channel + (y < 0 ? above : y > 0 ? below : 0);
    }
};
using Rows = RowsIn<float>;
using ConstRows = RowsIn<const float>;

/// Two rows of the G-buffer with `rows` rows and `columns` columns inside the picture; the others are untraced.
struct PixelRows {
    ConstRows from;
    int rows, columns;
};

/// Two rows of the completed picture, with `rows` rows and `columns` columns inside the picture.
struct PictureRows {
    float* row;
    std::ptrdiff_t stride;
    int rows, columns;
};

/// Three rows of a picture for doubling: the row above, this row and the row below. Pixels -1 and width repeat the
/// edges.
struct Doubled {
    const float *above, *here, *below;
};

}  // namespace bob
