/// Materials, and how they are shaded: Blinn-Phong under a headlight. CONVENTIONS.md has the constants.
#pragma once

#include <algorithm>
#include <cmath>

#include "vec.h"

namespace bob {

struct Material {
    Vec3 color{1, 1, 1};  // linear RGB, 0..1
    float ambient = 0.1f, diffuse = 0.7f, specular = 0.2f, shininess = 32;

    /// Of the colour, by Rec. 709's weights; exactly 1 for white, which the sum in float is not.
    [[nodiscard]] float luminance() const {
        return static_cast<float>(0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z);
    }
};

/// Direction to the light in the camera's frame before it is normalised: slightly up and left of the camera.
constexpr Vec3 light_direction{-0.3f, 0.4f, 1};

/// Shade in 0..1 of a surface with unit `normal` in the camera's frame (z towards the camera, which is far away). The
/// highlight is the light's, white whatever the surface's colour.
inline float blinn_phong(Vec3 normal, const Material& material) {
    static const Vec3 light = normalized(light_direction);
    static const Vec3 half = normalized(light + Vec3{0, 0, 1});
    const float d = std::max(0.f, dot(normal, light));
    const float s = std::pow(std::max(0.f, dot(normal, half)), material.shininess);
    const float body = material.luminance() * (material.ambient + material.diffuse * d);
    return std::clamp(body + material.specular * s, 0.f, 1.f);
}

}  // namespace bob
