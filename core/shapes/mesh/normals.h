/// Shading normals of triangle meshes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/vec.h"
#include "shapes/mesh/triangles.h"

namespace bob {

/// The normals at a triangle's three corners, each of unit length (zero for a triangle without area).
using CornerNormals = std::array<Vec3, 3>;

/// Faces that meet at less than this are shaded as one smooth surface. Coarse spheres (an icosphere of 80 faces bends
/// by up to 36 degrees an edge) stay round, chamfers of 45 degrees stay sharp.
constexpr float crease_angle_degrees = 40;

/// Unit normal by the right hand rule; zero for a triangle without area.
[[nodiscard]] Vec3 face_normal(std::span<const Vec3> vertices, const Triangle& triangle);

/// Those of all triangles, which the functions below are given.
[[nodiscard]] std::vector<Vec3> face_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Smooth where the mesh is smooth, flat where it is not: a corner's normal is the mean, weighted by angle, of the
/// faces at its position that turn from its own face by less than the crease angle. Vertices at the same position
/// count as one, so that meshes stored without shared vertices (STL) are smooth as well.
[[nodiscard]] std::vector<CornerNormals> crease_normals(std::span<const Vec3> vertices,
                                                        std::span<const Triangle> triangles, std::span<const Vec3> face);

/// Corner normals from a file's vertex normals, of any length; where one is zero or not finite, by the rule above.
[[nodiscard]] std::vector<CornerNormals> stored_normals(std::span<const Vec3> vertices,
                                                        std::span<const Triangle> triangles, std::span<const Vec3> face,
                                                        std::span<const Vec3> vertex_normals);

}  // namespace bob
