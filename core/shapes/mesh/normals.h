/// Shading normals of triangle meshes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/vec.h"
#include "shapes/mesh/triangles.h"

namespace bob {

/// The unit normals at a triangle's three corners; zero for a triangle without area.
using CornerNormals = std::array<Vec3, 3>;

/// Faces that meet at a smaller angle are shaded as one smooth surface. Coarse spheres (an icosphere of 80 faces bends
/// by up to 36 degrees per edge) stay round; chamfers of 45 degrees stay sharp.
constexpr float crease_angle_degrees = 40;

/// For each vertex, the first one at the same position.
[[nodiscard]] std::vector<std::uint32_t> merge_positions(std::span<const Vec3> vertices);

/// Unit normal by the right-hand rule; zero for a triangle without area.
[[nodiscard]] Vec3 face_normal(std::span<const Vec3> vertices, const Triangle& triangle);

/// The normals of all triangles, for the functions below.
[[nodiscard]] std::vector<Vec3> face_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Smooth normals with creases. A corner's normal is the mean, weighted by angle, of the faces at its position within
/// the crease angle of this corner's face. Vertices at the same position are merged, so that meshes without shared vertices
/// (STL) are smooth too.
[[nodiscard]] std::vector<CornerNormals> crease_normals(std::span<const Vec3> vertices,
                                                        std::span<const Triangle> triangles, std::span<const Vec3> face);

/// Corner normals from a file's vertex normals, of any length; where one is zero or not finite, as above.
[[nodiscard]] std::vector<CornerNormals> stored_normals(std::span<const Vec3> vertices,
                                                        std::span<const Triangle> triangles, std::span<const Vec3> face,
                                                        std::span<const Vec3> vertex_normals);

}  // namespace bob
