/// Extreme points of the trimmed faces of NURBS surfaces.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "nurbs/nurbs.h"
#include "nurbs/trim.h"

namespace bob {

/// The smallest and largest products of each direction and the points of a surface within its loops, as in TrimRegion.
///
/// Found from samples of the borders and of the inside, and refined: to about 1e-12 of the surface's size, unless there are
/// several extremes within one sample.
[[nodiscard]] std::vector<std::array<double, 2>> extremes(const NurbsSurface& surface, std::span<const TrimLoop> loops,
                                                          std::span<const std::array<double, 3>> directions);

}  // namespace bob
