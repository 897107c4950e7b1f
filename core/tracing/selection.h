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

/// Size, area and volume of primitives, in the units of the sphere that is the scene's. The size of other shapes than meshes is that
/// which rays from six sides find: they may miss parts thinner than 1/256 of it.
struct Amount {
    Bounds bounds;
    std::optional<double> area;    // only if all are triangles
    std::optional<double> volume;  // only if they are closed: each edge has its opposite
};
[[nodiscard]] Amount amount(const Scene& scene, std::span<const Primitives> primitives, const Sphere& sphere);

}  // namespace bob
