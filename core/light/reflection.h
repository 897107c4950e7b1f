/// Reflection at a lit surface: a rough body under microfacets. docs/reference/lights.md has the formulas.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/color.h"
#include "light/directions.h"
#include "light/facets.h"
#include "tracing/material.h"

namespace bob {

/// Reflection of a surface, in coordinates where z is the shading normal and `eye` points to the ray's origin.
///
/// The body receives the light that facets do not reflect. Facets are scaled to compensate for multiple scattering, so a white surface
/// in a white environment is white (Fdez-Aguera, "A Multiple-Scattering Microfacet Model", JCGT 2019).
class Reflection {
public:
    /// `color` is the product of the shape's and the material's; `eye` has z > 0.
    Reflection(const Material& material, Vec3 color, Vec3 eye) : Reflection(material, color, eye, roughness_of(material)) {}

    /// BSDF times cosine for light from a direction with z > 0.
    [[nodiscard]] Vec3 operator()(Vec3 toward) const {
        const Vec3 half = normalized(eye_ + toward);
        const float z = toward.z, facets = facets_.distribution(half) * facets_.masking(z) * facets_.masking(eye_.z) * facets_.joint(eye_.z, z) / (4 * eye_.z * z);
        return z * ((1 / pi) * body_ + facets * tint(dot(eye_, half)));
    }

    /// Rate of change of light from a direction as the eye turns: the facets' share over the width of their highlight.
    [[nodiscard]] float change_per_radian(Vec3 toward) const {
        const float all = luminance((*this)(toward)), body = luminance(toward.z / pi * body_);
        return all > 0 ? std::max(0.f, 1 - body / all) / facets_.width() : 0;
    }

    /// Probability density of a direction.
    [[nodiscard]] float density(Vec3 toward) const {
        return (1 - share_) * toward.z / pi + share_ * facets_.density(normalized(eye_ + toward), eye_);
    }

    /// A direction sampled nearly in proportion to the reflected light, and its reflectance over its density; empty if z <= 0.
    struct Drawn {
        Vec3 toward, weight;
        float density;
        bool is_mirrored;  // in a mirror
    };
    [[nodiscard]] Drawn draw(float choice, float u, float v) const {
        Drawn drawn{};
        if (choice < share_) {
            const Vec3 half = facets_.draw(eye_, u, v);
            drawn.toward = 2 * dot(eye_, half) * half - eye_;
            if (!(drawn.toward.z > 0)) return drawn;
            if (is_smooth_) {
                // The body's share of such directions is negligible, and products of such densities overflow.
                drawn.weight = facets_.joint(eye_.z, drawn.toward.z) * facets_.masking(drawn.toward.z) / share_ * tint(dot(eye_, half));
                drawn.density = share_ * facets_.density(half, eye_), drawn.is_mirrored = true;
                return drawn;
            }
        } else {
            drawn.toward = cosine_weighted(u, v);
            if (!(drawn.toward.z > 0)) return drawn;
        }
        drawn.density = density(drawn.toward);
        drawn.weight = (1 / drawn.density) * (*this)(drawn.toward);
        return drawn;
    }

private:
    static constexpr float smoothest = 1e-3f, smooth = 0.02f;  // of the squared roughness

    static float roughness_of(const Material& material) {
        if (material.is_physical()) return Material::rounded(material.roughness);
        return std::sqrt(std::sqrt(2 / (Material::rounded(material.shininess) + 2)));  // for a highlight of equal width
    }

    Reflection(const Material& material, Vec3 color, Vec3 eye, float roughness)
        : eye_(eye), facets_(std::max(smoothest, roughness * roughness)), is_smooth_(roughness * roughness <= smooth) {
        const auto rounded = [](double x) { return Material::rounded(x); };
        if (material.is_physical()) {
            const float metallic = rounded(material.metallic);
            body_ = (1 - metallic) * color, f0_ = (1 - metallic) * Vec3{0.04f, 0.04f, 0.04f} + metallic * color;
        } else {
            // Blinn-Phong: the body reflects ambient and diffuse; the highlight is a dielectric's, and 0.2 means 4 %, an index of 1.5.
            const float specular = 0.2f * rounded(material.specular);
            body_ = std::min(1.f, rounded(material.ambient) + rounded(material.diffuse)) * color, f0_ = {specular, specular, specular};
        }
        const auto [of_f0, of_white] = FacetAlbedo::at(roughness, eye.z);
        float facets = 0, body = 0;
        for (int k = 0; k < 3; ++k) {
            // A surface with f0 below 2 % has no highlight, even at grazing angles.
            grazing_[k] = std::min(1.f, 50 * f0_[k]);
            const float once = f0_[k] * of_f0 + grazing_[k] * of_white;
            between_[k] = 1 + f0_[k] * (1 / (of_f0 + of_white) - 1);
            const float own = std::min(1.f, once * between_[k]);
            body_[k] *= 1 - own;
            facets = std::max(facets, own), body = std::max(body, body_[k]);
        }
        share_ = facets + body > 0 ? facets / (facets + body) : 0;
    }

    /// Fresnel's reflectance by Schlick, and the light between facets.
    [[nodiscard]] Vec3 tint(float along) const {
        const float beside = 1 - std::clamp(along, 0.f, 1.f), schlick = beside * beside * beside * beside * beside;
        Vec3 result;
        for (int k = 0; k < 3; ++k) result[k] = (f0_[k] + (grazing_[k] - f0_[k]) * schlick) * between_[k];
        return result;
    }

    Vec3 eye_, body_, f0_, grazing_, between_;
    Facets facets_;
    bool is_smooth_;
    float share_ = 0;  // of directions sampled from facets
};

}  // namespace bob
