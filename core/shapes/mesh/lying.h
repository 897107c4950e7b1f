/// A guess of the up axis of meshes from files that store y up without a declaration.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/vec3d.h"

namespace bob {

/// Whether y is more likely the up axis than z; true only if the evidence is clear.
///
/// Objects stand on a wide base below their centre, and are less symmetric between up and down than between left and right or front and
/// back (after Fu, Cohen-Or, Dror and Sheffer, "Upright orientation of man-made objects", 2008).
[[nodiscard]] bool seems_to_lie(std::span<const Vec3d> vertices, std::span<const std::array<std::int32_t, 3>> triangles);

}  // namespace bob
