/// Turns in formulas: two coordinates u and v that an angle turns, cos(a) u - sin(a) v and sin(a) u + cos(a) v.
///
/// In a large box a twist's angle may be any, and bounds of either coordinate hold all that the other one excludes. A turn
/// keeps hypot(u, v), so that in each sector of directions both are known.
#pragma once

#include <vector>

#include "formula/expression.h"

namespace bob {

/// A formula for each sector, or for each choice of one if there are several turns: its bounds in a box hold the formula wherever the
/// turned coordinates lie in that sector, and so do all of them together everywhere. Only bounds of it mean anything.
using Sectors = std::vector<Expression>;

/// The sectors of f, or of each of several formulas whose minimum it is. Nothing where f has no turn, or so many that it
/// takes too long.
[[nodiscard]] std::vector<Sectors> in_sectors(const Expression& f);

}  // namespace bob
