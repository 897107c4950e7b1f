/// Outlines of polygons: edges that know which of their sides is inside.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace bob {

/// A straight piece of the border of a polygon. Signs are those of the distance: -1 inside, 1 outside.
struct OutlinePiece {
    std::array<double, 2> from, to;
    int left, right;  ///< Seen from `from` towards `to`. They are the same where two edges coincide.
    /// Where this end is the nearest point of the whole outline; none where that is so nowhere, or on a line only.
    std::optional<int> beyond_from, beyond_to;
};

/// The pieces between the places where a closed polygon, even-odd inside, touches itself. Takes the square of the number
/// of corners in time. Corners that follow each other are different.
[[nodiscard]] std::vector<OutlinePiece> outline(std::span<const std::array<double, 2>> corners);

/// The corners of the convex hull, anticlockwise, without any that lie on a straight line between others.
[[nodiscard]] std::vector<std::array<double, 2>> convex_hull(std::vector<std::array<double, 2>> points);

}  // namespace bob
