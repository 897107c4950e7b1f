/// Triangulations of trimmed regions of the plane.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace bob {

/// Integer coordinates, so that every decision is exact.
constexpr std::int32_t max_plane = 1 << 25;

using PlanePoint = std::array<std::int32_t, 2>;  // 0..max_plane

/// The constrained Delaunay triangulation of distinct points, inside an odd number of the edges' loops. Triangles are
/// anticlockwise and contain all edges. Edges given twice cancel.
///
/// Lawson, "Software for C1 surface interpolation" (1977); Sloan, "A fast algorithm for generating constrained Delaunay
/// triangulations" (1993). Throws std::invalid_argument if edges cross, or a point is out of range or occurs twice.
[[nodiscard]] std::vector<std::array<std::int32_t, 3>> triangulate(std::span<const PlanePoint> points,
                                                                   std::span<const std::array<std::int32_t, 2>> edges);

}  // namespace bob
