/// Triangulations of trimmed regions of the plane.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace bob {

/// Coordinates of points that are triangulated: whole numbers, so that every decision is exact.
constexpr std::int32_t max_plane = 1 << 25;

using PlanePoint = std::array<std::int32_t, 2>;  // 0..max_plane

/// The constrained Delaunay triangulation of points that differ: triangles, anticlockwise, between which all edges are, of
/// what an odd number of the edges' loops surround. An edge that is there twice is none.
///
/// Lawson, "Software for C1 surface interpolation" (1977); Sloan, "A fast algorithm for generating constrained Delaunay
/// triangulations" (1993). Throws std::invalid_argument where edges cross, or a point is out of range or there twice.
[[nodiscard]] std::vector<std::array<std::int32_t, 3>> triangulate(std::span<const PlanePoint> points,
                                                                   std::span<const std::array<std::int32_t, 2>> edges);

}  // namespace bob
