/// Sections: planes that cut a scene open.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/ray.h"
#include "base/vec.h"
#include "base/vec3d.h"
#include "shapes/shape.h"

namespace bob {

/// Keeps the points p of normal · p <= offset. The normal has length 1.
struct SectionPlane {
    Vec3d normal{};
    double offset = 0;
};

constexpr std::size_t max_sections = 6;

/// The primitive of a hit on the cap of a plane is first_cap + the plane's index.
constexpr std::uint32_t first_cap = 0xffffff00;
[[nodiscard]] constexpr bool is_cap(std::uint32_t primitive) { return primitive >= first_cap && primitive != no_primitive; }

/// The part of a ray that the planes keep, as t from `enter` to `leave`; empty if not enter < leave.
struct KeptPart {
    double enter = 0, leave = 0;                           // `enter` is 0 if the ray starts in the kept part
    double start = 0, end = 0;                             // the same, moved inwards by more than rounding
    std::uint32_t entered = no_primitive, left = no_primitive;  // the planes there, if any

    KeptPart(std::span<const SectionPlane> planes, const Ray& ray);

    [[nodiscard]] bool is_empty() const { return !(start < end); }
};

/// Directions along a plane: seen against its normal, right and up.
struct PlaneAxes {
    Vec3d right, up;

    explicit PlaneAxes(const Vec3d& normal);
};

/// The share of a colour that hatching leaves at a point of a plane: lines of 45°, which differ between successive parts.
/// `width` is a pixel's width there. In the coordinates of rays.
[[nodiscard]] float hatched(const PlaneAxes& axes, Vec3 point, float width, std::uint32_t part);

}  // namespace bob
