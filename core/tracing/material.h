/// Materials and their shading under a headlight: Blinn-Phong, or metallic-roughness. docs/reference/shading.md has the formulas
/// and constants.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/color.h"
#include "base/vec.h"

namespace bob {

constexpr double max_ior = 100;  // of glass

/// In double precision, as given; shading rounds to float. viewer/tracing/description.js has the numbers in this order.
struct Material {
    double color[3] = {1, 1, 1};  // linear RGB, 0..1, multiplied by the shape's own colours
    double ambient = 0.1, diffuse = 0.7, specular = 0.2, shininess = 32;  // of Blinn-Phong
    double metallic = 0, roughness = -1;  // 0..1, of glTF's model; a negative roughness selects Blinn-Phong
    double emissive[3] = {0, 0, 0};       // linear RGB, 0..1, added to reflected light

    double clearcoat = 0, clearcoat_roughness = 0;  // 0..1, visible only under lights: how much of a varnish lies on the surface

    // Glass, visible only under lights: the share of light that enters instead of being reflected diffusely, the index of refraction, and the
    // colour of white light after a distance inside, in the scene's units.
    double transmission = 0, ior = 1.5;
    double attenuation[3] = {1, 1, 1};
    double attenuation_distance = std::numeric_limits<double>::infinity();
    bool is_thin = false;  // a sheet, such as a window pane, instead of the boundary of a solid: light goes straight on

    [[nodiscard]] bool is_physical() const { return roughness >= 0; }
    [[nodiscard]] bool emits() const { return emissive[0] > 0 || emissive[1] > 0 || emissive[2] > 0; }
    [[nodiscard]] bool is_white() const { return color[0] == 1 && color[1] == 1 && color[2] == 1 && !emits(); }

    [[nodiscard]] Vec3 base_color() const { return rounded(color); }
    [[nodiscard]] static float rounded(double value) { return static_cast<float>(value); }
    [[nodiscard]] static Vec3 rounded(const double (&rgb)[3]) { return {rounded(rgb[0]), rounded(rgb[1]), rounded(rgb[2])}; }
};

/// Unnormalised direction to the light along the camera's axes: slightly up and left of the camera.
constexpr Vec3 light_direction{-0.3f, 0.4f, 1};

/// The light at a surface: unit directions in its screen space, z towards the eye.
struct Light {
    Vec3 direction = normalized(light_direction);
    Vec3 half = normalized(direction + Vec3{0, 0, 1});  // halfway to the eye

    /// The headlight for distant eyes, and at every pixel of orthographic pictures.
    static const Light& of_the_camera() {
        static const Light light;
        return light;
    }
};

/// Reflection at a surface with unit `normal` in screen space: body times the surface's colour, plus a white highlight.
struct BlinnPhong {
    float body, highlight;

    BlinnPhong(Vec3 normal, const Material& material, const Light& light) {
        const auto rounded = [](double value) { return Material::rounded(value); };
        const float d = std::max(0.f, dot(normal, light.direction));
        const float s = std::pow(std::max(0.f, dot(normal, light.half)), rounded(material.shininess));
        body = rounded(material.ambient) + rounded(material.diffuse) * d;
        highlight = rounded(material.specular) * s;
    }
};

/// Unclamped linear RGB of a surface by the model of glTF 2.0 (appendix B): Trowbridge and Reitz's microfacet
/// distribution, Smith's masking and Schlick's Fresnel, under the headlight and uniform surroundings. Karis' fit
/// ("Physically Based Shading on Mobile", 2014) gives the integral of the microfacets over all directions.
inline Vec3 physical(Vec3 normal, Vec3 color, const Material& material, const Light& light) {
    constexpr float pi = 3.14159265f;
    constexpr float headlight = 0.6f, surroundings = 0.3f;  // a white rough surface is close to Blinn-Phong's default
    const float metallic = Material::rounded(material.metallic);
    const float roughness = std::max(0.045f, Material::rounded(material.roughness));  // otherwise the highlight is a point
    const float a2 = roughness * roughness * roughness * roughness;
    const float nv = std::max(normal.z, 1e-4f), nl = std::max(0.f, dot(normal, light.direction));
    const float nh = std::max(0.f, dot(normal, light.half)), vh = light.half.z;

    const Vec3 dielectric{0.04f, 0.04f, 0.04f};
    const Vec3 body = (1 - metallic) * color, f0 = (1 - metallic) * dielectric + metallic * color;

    const Vec3 aside = cross(normal, light.half);  // its square is 1 - nh * nh, which would lose digits in the highlight
    const float spread = a2 * nh * nh + dot(aside, aside), distribution = a2 / (pi * spread * spread);
    const auto shadowed = [=](float x) { return x + std::sqrt(a2 + (1 - a2) * x * x); };
    const float visibility = 1 / (shadowed(nl) * shadowed(nv));
    const float beside = 1 - vh, schlick = beside * beside * beside * beside * beside, facets = nl > 0 ? distribution * visibility : 0;

    // Karis' fit: the reflected surroundings are f0 times the first plus the second.
    const float r0 = 1 - roughness, r1 = 0.0425f - 0.0275f * roughness, r2 = 1.04f - 0.572f * roughness;
    const float r3 = 0.022f * roughness - 0.04f;
    const float falloff = std::min(r0 * r0, std::exp2(-9.28f * nv)) * r0 + r1;
    const float scale = -1.04f * falloff + r2, bias = std::max(0.f, 1.04f * falloff + r3);

    Vec3 result;
    for (int k = 0; k < 3; ++k) {
        const float fresnel = f0[k] + (1 - f0[k]) * schlick, around = std::min(1.f, f0[k] * scale + bias);
        const float direct = ((1 - fresnel) * body[k] / pi + fresnel * facets) * nl * pi * headlight;
        result[k] = direct + surroundings * ((1 - around) * body[k] + around);
    }
    return result;
}

/// The shade of a surface.
struct Shade {
    Vec3 color;  // linear RGB, 0..1
    float gray;  // luminance before clamping, clamped
};

/// The shade of a surface from its unit `normal` in screen space, its `color` and a material.
inline Shade shaded(Vec3 normal, Vec3 color, const Material& material, const Light& light = Light::of_the_camera()) {
    Shade shade;
    if (material.is_physical()) {
        shade.color = physical(normal, color, material, light);
        shade.gray = luminance(shade.color);
    } else {
        const BlinnPhong reflected(normal, material, light);
        shade.color = reflected.body * color + Vec3{reflected.highlight, reflected.highlight, reflected.highlight};
        shade.gray = luminance(color) * reflected.body + reflected.highlight;
    }
    if (material.emits()) {
        const Vec3 emitted = Material::rounded(material.emissive);
        shade.color = shade.color + emitted;
        shade.gray += luminance(emitted);
    }
    for (int k = 0; k < 3; ++k) shade.color[k] = std::clamp(shade.color[k], 0.f, 1.f);
    shade.gray = std::clamp(shade.gray, 0.f, 1.f);
    return shade;
}

}  // namespace bob
