/// Materials, and how they are shaded: Blinn-Phong under a headlight. CONVENTIONS.md has the constants.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "vec.h"

namespace bob {

/// As users give it; shading rounds to float.
struct Material {
    double color[3] = {1, 1, 1};  // linear RGB, 0..1
    double ambient = 0.1, diffuse = 0.7, specular = 0.2, shininess = 32;

    /// Of the colour, by Rec. 709's weights; exactly 1 for white, which the sum in float is not.
    [[nodiscard]] float luminance() const {
        const auto [red, green, blue] = std::array{rounded(color[0]), rounded(color[1]), rounded(color[2])};
        return static_cast<float>(0.2126 * red + 0.7152 * green + 0.0722 * blue);
    }

    [[nodiscard]] static float rounded(double value) { return static_cast<float>(value); }
};

/// Direction to the light along the camera's axes before it is normalised: slightly up and left of the camera.
constexpr Vec3 light_direction{-0.3f, 0.4f, 1};

/// The light as a surface has it: unit directions in its screen space, z towards the eye.
struct Light {
    Vec3 direction = normalized(light_direction);
    Vec3 half = normalized(direction + Vec3{0, 0, 1});  // between that and the eye

    /// As it is for eyes far away, and everywhere in orthographic pictures.
    static const Light& of_the_camera() {
        static const Light light;
        return light;
    }
};

/// Shade in 0..1 of a surface with unit `normal` in screen space. The highlight is the light's, white whatever the surface's
/// colour.
inline float blinn_phong(Vec3 normal, const Material& material, const Light& light = Light::of_the_camera()) {
    const auto rounded = Material::rounded;
    const float d = std::max(0.f, dot(normal, light.direction));
    const float s = std::pow(std::max(0.f, dot(normal, light.half)), rounded(material.shininess));
    const float body = material.luminance() * (rounded(material.ambient) + rounded(material.diffuse) * d);
    return std::clamp(body + rounded(material.specular) * s, 0.f, 1.f);
}

}  // namespace bob
