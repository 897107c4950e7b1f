/// Blinn-Phong under a headlight; the constants stand in CONVENTIONS.md.
#pragma once

#include <algorithm>
#include <cmath>

#include "vec.h"

namespace bob {

constexpr float ambient = 0.1f, diffuse = 0.7f, specular = 0.2f, shininess = 32;

/// Direction to the light in the camera's frame before it is normalised: slightly up and left of the camera.
constexpr Vec3 light_direction{-0.3f, 0.4f, 1};

/// Shade in 0..1 of a surface with unit `normal` in the camera's frame (z towards the camera, which is far away).
inline float blinn_phong(Vec3 normal) {
    static const Vec3 light = normalized(light_direction);
    static const Vec3 half = normalized(light + Vec3{0, 0, 1});
    const float d = std::max(0.f, dot(normal, light));
    const float s = std::pow(std::max(0.f, dot(normal, half)), shininess);
    return std::clamp(ambient + diffuse * d + specular * s, 0.f, 1.f);
}

}  // namespace bob
