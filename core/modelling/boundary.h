/// Outlines of straight lines and arcs of circles, and the boundary of what they wind around.
#pragma once

#include <array>
#include <vector>

namespace bob {

/// A piece of an outline. Its bulge is the tangent of a quarter of its arc's angle, as in DXF: 0 of a straight line, 1 of
/// half a circle that turns left on its way.
struct Piece {
    std::array<double, 2> from, to;
    double bulge = 0;
};

/// Each piece begins where the one before ends, the first one where the last ends.
using Loop = std::vector<Piece>;

/// What is inside: what the loops wind around other than 0 times, or an odd number of times.
enum class Winding { nonzero, odd };

/// A connected part of the inside. Loops have it to their left: around it anticlockwise, around its holes clockwise.
struct Part {
    Loop around;
    std::vector<Loop> holes;
};

/// What is inside, as parts whose loops meet at corners at most. The loops given may cross themselves and each other; what
/// differs by less than 1e-9 of their extent counts as the same. Throws TooLarge where they cross too often.
[[nodiscard]] std::vector<Part> parts(const std::vector<Loop>& loops, Winding winding);

}  // namespace bob
