/// Directions around a normal, drawn from two numbers in 0..1.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"

namespace bob {

constexpr float pi = 3.14159265358979f;

/// Two unit vectors across a unit vector: Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
struct Across {
    Vec3 x, y, z;

    explicit Across(Vec3 normal) : z(normal) {
        const float sign = std::copysign(1.f, normal.z), a = -1 / (sign + normal.z), b = normal.x * normal.y * a;
        x = {1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
        y = {b, sign + normal.y * normal.y * a, -normal.y};
    }
    [[nodiscard]] Vec3 from(Vec3 v) const { return v.x * x + v.y * y + v.z * z; }
    [[nodiscard]] Vec3 to(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
};

/// Density cos / pi about the z axis.
inline Vec3 cosine_weighted(float u, float v) {
    const float radius = std::sqrt(u), angle = 2 * pi * v;
    return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(std::max(0.f, 1 - u))};
}

/// Uniform over the cap about the z axis where z is at least 1 - height.
inline Vec3 in_cap(float height, float u, float v) {
    const float down = height * u, radius = std::sqrt(std::max(0.f, down * (2 - down))), angle = 2 * pi * v;
    return {radius * std::cos(angle), radius * std::sin(angle), 1 - down};
}

}  // namespace bob
