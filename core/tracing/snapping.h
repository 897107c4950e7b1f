/// Snapping: the corner, centre, middle or edge of a shape near a place of a picture, for measures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/vec3d.h"
#include "picture/camera.h"
#include "tracing/scene.h"

namespace bob {

enum class SnapKind : std::uint8_t { corner, center, middle, edge };

[[nodiscard]] constexpr std::string_view name_of(SnapKind kind) {
    constexpr std::string_view names[] = {"corner", "center", "middle", "edge"};
    return names[static_cast<std::size_t>(kind)];
}

struct Snap {
    SnapKind kind;
    Vec3d point;                    // in the unit sphere
    std::optional<double> radius;   // of the circle, in radii of the unit sphere
    std::uint32_t instance;         // in the scene
    float row, column;              // where the surface next to it is visible
};

/// The nearest visible corner of an edge, middle of an edge, or centre of a visible circle; without one, the nearest visible edge. Not
/// farther than `reach`, in pixels. Tubes have the centres of their ends; formulas and caps of sections have nothing.
[[nodiscard]] std::optional<Snap> snap(const Scene& scene, const Camera& camera, int height, int width, float row, float column, float reach);

}  // namespace bob
