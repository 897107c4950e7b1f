/// The connected pieces of a mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "shapes/mesh/triangles.h"

namespace bob {

struct Shells {
    std::uint32_t count = 0;
    std::vector<std::uint32_t> of;       // of each triangle
    std::vector<std::uint8_t> reversed;  // whether a triangle's corners run the other way than the first's of its shell
};

/// Joins triangles across edges that exactly two of them share, by the positions of corners.
[[nodiscard]] Shells find_shells(std::span<const Vec3> points, std::span<const Triangle> triangles);

}  // namespace bob
