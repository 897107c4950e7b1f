/// Turns in formulas: two coordinates u and v that an angle turns, cos(a) u - sin(a) v and sin(a) u + cos(a) v.
///
/// In a large box the angle is arbitrary, and independent bounds of the two coordinates include the axis. A turn keeps
/// hypot(u, v), so each sector of directions bounds both coordinates.
#pragma once

#include <vector>

#include "formula/expression.h"

namespace bob {

/// One formula per sector, or per combination of sectors of several turns. Its bounds in a box contain the values of f at all
/// points whose turned coordinates lie in that sector. Its values at points are meaningless.
using Sectors = std::vector<Expression>;

/// The sectors of f, or of each of several formulas whose minimum it is. Empty if f has no turn, or too many to
/// split in acceptable time.
[[nodiscard]] std::vector<Sectors> in_sectors(const Expression& f);

}  // namespace bob
