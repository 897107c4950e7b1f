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
/// in a white environment is white (Fdez-Aguera, "A Multiple-Scattering Microfacet Model", JCGT 2019). A clear coat takes the light that
/// its own facets reflect from all below it.
class Reflection {
public:
    /// `color` is the product of the shape's and the material's; `eye` has z > 0.
    Reflection(const Material& material, Vec3 color, Vec3 eye) : Reflection(material, color, eye, roughness_of(material)) {}

    /// BSDF times cosine for light from a direction with z > 0.
    [[nodiscard]] Vec3 operator()(Vec3 toward) const {
        const Vec3 half = normalized(eye_ + toward);
        const Vec3 below = toward.z * ((1 / pi) * body_ + facets_.reflected(half, eye_, toward) * tint(dot(eye_, half)));
        return coat_ > 0 ? below + of_coat(half, toward) : below;
    }

    /// Rate of change of light from a direction as the eye turns: the facets' share over the width of their highlight.
    [[nodiscard]] float change_per_radian(Vec3 toward) const {
        const float all = luminance((*this)(toward)), body = luminance(toward.z / pi * body_);
        const float coat = coat_ > 0 ? luminance(of_coat(normalized(eye_ + toward), toward)) : 0;
        return all > 0 ? (std::max(0.f, 1 - (body + coat) / all) / facets_.width() + coat / all / coat_facets_.width()) : 0;
    }

    /// Probability density of a direction.
    [[nodiscard]] float density(Vec3 toward) const {
        const Vec3 half = normalized(eye_ + toward);
        const float below = (1 - share_) * toward.z / pi + share_ * facets_.density(half, eye_);
        return coat_ > 0 ? (1 - coat_share_) * below + coat_share_ * coat_facets_.density(half, eye_) : below;
    }

    /// A direction sampled nearly in proportion to the reflected light, and its reflectance over its density; empty if z <= 0.
    struct Drawn {
        Vec3 toward, weight;
        float density;
        bool is_mirrored;  // in a mirror
    };
    [[nodiscard]] Drawn draw(float choice, float u, float v) const {
        Drawn drawn{};
        const bool is_of_coat = choice < coat_share_;
        const float share = is_of_coat ? coat_share_ : (1 - coat_share_) * share_;
        if (is_of_coat || choice < coat_share_ + share) {
            const Facets& facets = is_of_coat ? coat_facets_ : facets_;
            const Vec3 half = facets.draw(eye_, u, v);
            drawn.toward = 2 * dot(eye_, half) * half - eye_;
            if (!(drawn.toward.z > 0)) return drawn;
            drawn.is_mirrored = is_of_coat ? coat_is_smooth_ : is_smooth_;
            if (drawn.is_mirrored && coat_ == 0) {
                // The body's share of such directions is negligible, and products of such densities overflow.
                drawn.weight = facets.joint(eye_.z, drawn.toward.z) * facets.masking(drawn.toward.z) / share * tint(dot(eye_, half));
                drawn.density = share * facets.density(half, eye_);
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
    static constexpr float coat_f0 = 0.04f;                    // of an index of 1.5

    static float rounded(double value) { return Material::rounded(value); }

    static float roughness_of(const Material& material) {
        if (material.is_physical()) return Material::rounded(material.roughness);
        return std::sqrt(std::sqrt(2 / (Material::rounded(material.shininess) + 2)));  // for a highlight of equal width
    }

    Reflection(const Material& material, Vec3 color, Vec3 eye, float roughness)
        : eye_(eye), facets_(std::max(smoothest, roughness * roughness)), is_smooth_(roughness * roughness <= smooth) {
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
        if (material.clearcoat > 0) cover(material, std::max(facets, body));
    }

    /// Puts a coat on a surface that reflects so much.
    void cover(const Material& material, float reflected) {
        const float roughness = rounded(material.clearcoat_roughness), squared = std::max(smoothest, roughness * roughness);
        coat_ = rounded(material.clearcoat), coat_facets_ = Facets(squared), coat_is_smooth_ = squared <= smooth;
        const auto [of_f0, of_white] = FacetAlbedo::at(roughness, eye_.z);
        const float own = coat_ * (coat_f0 * of_f0 + of_white);
        for (int k = 0; k < 3; ++k) body_[k] *= 1 - own, between_[k] *= 1 - own;
        coat_share_ = own / (own + (1 - own) * reflected);
    }

    [[nodiscard]] Vec3 of_coat(Vec3 half, Vec3 toward) const { return toward.z * coat_facets_.reflected(half, eye_, toward) * coat_tint(dot(eye_, half)); }
    [[nodiscard]] Vec3 coat_tint(float along) const {
        const float reflectance = coat_ * (coat_f0 + (1 - coat_f0) * schlick(along));
        return {reflectance, reflectance, reflectance};
    }
    static float schlick(float along) {
        const float beside = 1 - std::clamp(along, 0.f, 1.f);
        return beside * beside * beside * beside * beside;
    }

    /// Fresnel's reflectance by Schlick, and the light between facets.
    [[nodiscard]] Vec3 tint(float along) const {
        const float fresnel = schlick(along);
        Vec3 result;
        for (int k = 0; k < 3; ++k) result[k] = (f0_[k] + (grazing_[k] - f0_[k]) * fresnel) * between_[k];
        return result;
    }

    Vec3 eye_, body_, f0_, grazing_, between_;
    Facets facets_;
    bool is_smooth_;
    float share_ = 0;  // of directions sampled from facets, below the coat

    float coat_ = 0, coat_share_ = 0;  // its amount; of directions sampled from it
    Facets coat_facets_{smoothest};
    bool coat_is_smooth_ = false;
};

}  // namespace bob
