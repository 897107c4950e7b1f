/// Outlines of line segments and circular arcs, and the boundary of their inside.
#pragma once

#include <array>
#include <vector>

namespace bob {

/// A segment of an outline. Its bulge is the tangent of a quarter of the arc's angle, as in DXF: 0 for a straight one,
/// 1 for half a circle that turns left.
struct Segment {
    std::array<double, 2> from, to;
    double bulge = 0;
};

/// Each segment begins at the end of the one before, the first at the end of the last.
using Loop = std::vector<Segment>;

/// Fill rule: a point is inside if its winding number is nonzero, or odd.
enum class Winding { nonzero, odd };

/// A connected part of the inside. Loops have the inside to their left: anticlockwise around it, clockwise around its
/// holes.
struct Island {
    Loop around;
    std::vector<Loop> holes;
};

/// The inside as islands whose loops meet at corners at most. The loops given may cross themselves and each other. Places
/// closer than 1e-9 of the extent are equal. Throws TooLarge if there are too many crossings.
[[nodiscard]] std::vector<Island> islands(const std::vector<Loop>& loops, Winding winding);

}  // namespace bob
