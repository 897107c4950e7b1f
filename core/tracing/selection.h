/// Parts of a scene: hidden, in one colour, and measured.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/box.h"
#include "base/vec.h"
#include "tracing/scene.h"

namespace bob {

/// Consecutive primitives of an instance: triangles of a mesh. Other shapes are taken as a whole.
struct Primitives {
    std::uint32_t instance, begin, end;
};

/// The scene without some primitives, and with others in one colour. It stays where it is, and may be
/// empty. Hits on instances that were cut keep the user's numbers (`Shape::place`), and meshes keep their shading.
[[nodiscard]] Scene selected(const Scene& scene, std::span<const Primitives> hidden, std::span<const Primitives> highlighted, const Vec3& color);

/// The box of a scene's surfaces by rays from the six sides of a box around them, finer around the nearest hit of each side. They may miss
/// parts thinner than 1/256 of it; a side whose rays all miss stays.
[[nodiscard]] Box box_by_rays(const Scene& scene, const Box& around);

/// Size, area and volume of primitives, in the units of the sphere that is the scene's. The size of other shapes than meshes is found by
/// rays, as above.
struct Amount {
    Bounds bounds;
    std::optional<double> area;    // only if all are triangles
    std::optional<double> volume;  // only if they are closed: each edge has its opposite
};
[[nodiscard]] Amount amount(const Scene& scene, std::span<const Primitives> primitives, const Sphere& sphere);

}  // namespace bob
