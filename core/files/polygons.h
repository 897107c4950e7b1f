/// Polygons become triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "files/part.h"

namespace bob::files {

/// Polygons of any size, one after the other.
struct Polygons {
    Numbers<std::int32_t> corners;
    Numbers<std::int32_t> sizes;  // corners of each polygon; empty if all are triangles

    void add(std::span<const std::int32_t> polygon);
    /// Triangles of a polygon: 2 fewer than corners, and 0 below 3 corners.
    [[nodiscard]] static std::size_t triangles(std::int32_t size) { return size < 3 ? 0 : static_cast<std::size_t>(size - 2); }
};

/// The triangles (T, 3) of polygons in their order. vertices: (V, 3); points: the vertex of each corner's position, or empty if corners
/// are vertices. A fan around the first corner suffices if it turns no triangle over; other polygons lose one ear after
/// the other. Adds a warning where there is too much work for that, and one of faces without a triangle.
[[nodiscard]] Numbers<std::int32_t> triangulated(Polygons&& polygons, const Numbers<double>& vertices,
                                                 std::span<const std::int32_t> points, std::vector<std::string>& warnings);

/// A value (n, width) of each polygon for each of its triangles.
[[nodiscard]] Numbers<double> of_triangles(Numbers<double>&& values, std::size_t width, const Polygons& polygons);

}  // namespace bob::files
