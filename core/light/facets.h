/// Microfacets by Trowbridge and Reitz with Smith's masking, and their albedo.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "light/directions.h"

namespace bob {

/// Trowbridge-Reitz microfacets. Coordinates have z along the shading normal; directions from the surface have a z above 0.
class Facets {
public:
    explicit Facets(float alpha) : alpha_(alpha) {}

    /// Width of a highlight, roughly in radians.
    [[nodiscard]] float width() const { return alpha_; }

    /// Density of facets with this normal (GGX).
    [[nodiscard]] float distribution(Vec3 half) const {
        const float a2 = alpha_ * alpha_, x = half.x * half.x + half.y * half.y + a2 * half.z * half.z;
        return half.z > 0 ? a2 / (pi * x * x) : 0;
    }
    /// The share of the facets visible from a direction with this z.
    [[nodiscard]] float masking(float z) const { return 1 / (1 + hidden(z)); }
    /// Facets both visible and lit, relative to the product of both shares: height-correlated masking.
    [[nodiscard]] float joint(float eye, float light) const { return (1 + hidden(eye)) * (1 + hidden(light)) / (1 + hidden(eye) + hidden(light)); }

    /// Light reflected by white facets, over the cosine: both directions are on the surface's side.
    [[nodiscard]] float reflected(Vec3 half, Vec3 eye, Vec3 toward) const {
        return distribution(half) * masking(toward.z) * masking(eye.z) * joint(eye.z, toward.z) / (4 * eye.z * toward.z);
    }

    /// A visible facet: Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps" (2023).
    [[nodiscard]] Vec3 draw(Vec3 eye, float u, float v) const {
        const Vec3 stretched = normalized({alpha_ * eye.x, alpha_ * eye.y, eye.z});
        const float angle = 2 * pi * v, z = (1 - u) * (1 + stretched.z) - stretched.z, ring = std::sqrt(std::clamp(1 - z * z, 0.f, 1.f));
        const Vec3 half = Vec3{ring * std::cos(angle), ring * std::sin(angle), z} + stretched;
        return normalized({alpha_ * half.x, alpha_ * half.y, half.z});
    }
    /// Density of directions reflected by facets that `draw` returns.
    [[nodiscard]] float density(Vec3 half, Vec3 eye) const { return distribution(half) * masking(eye.z) / (4 * eye.z); }

private:
    /// Smith's lambda.
    [[nodiscard]] float hidden(float z) const { return 0.5f * (std::sqrt(1 + alpha_ * alpha_ * (1 / (z * z) - 1)) - 1); }

    float alpha_;
};

/// The facets' directional albedo under Schlick's Fresnel: f0 times the first share, plus the second. Integrated once, interpolated.
class FacetAlbedo {
public:
    struct Shares {
        float of_f0, of_white;
    };

    [[nodiscard]] static Shares at(float roughness, float height) {
        static const FacetAlbedo table;
        const auto place = [](float x) { return std::clamp(x, 0.f, 1.f) * (side - 1); };
        const float row = place(roughness), column = place(height);
        const auto r = std::min(static_cast<std::size_t>(row), side - 2), c = std::min(static_cast<std::size_t>(column), side - 2);
        const float down = row - static_cast<float>(r), right = column - static_cast<float>(c);
        const auto blend = [&](auto of) {
            const auto value = [&](std::size_t i, std::size_t j) { return of(table.shares_[i * side + j]); };
            return (1 - down) * ((1 - right) * value(r, c) + right * value(r, c + 1)) + down * ((1 - right) * value(r + 1, c) + right * value(r + 1, c + 1));
        };
        return {blend([](Shares s) { return s.of_f0; }), blend([](Shares s) { return s.of_white; })};
    }

private:
    static constexpr std::size_t side = 32;
    static constexpr int strata = 24;  // across; errors stay below 1/500

    FacetAlbedo() {
        for (std::size_t r = 0; r < side; ++r) {
            const float roughness = static_cast<float>(r) / (side - 1);
            const Facets facets(std::max(1e-3f, roughness * roughness));
            for (std::size_t c = 0; c < side; ++c) {
                const float height = std::max(1e-3f, static_cast<float>(c) / (side - 1));
                const Vec3 eye{std::sqrt(1 - height * height), 0, height};
                Shares sum{0, 0};
                for (int k = 0; k < strata * strata; ++k) {
                    const auto within = [](int i) { return (static_cast<float>(i) + 0.5f) / strata; };
                    const Vec3 half = facets.draw(eye, within(k / strata), within(k % strata));
                    const float along = dot(eye, half), toward = 2 * along * half.z - eye.z;
                    if (!(toward > 0)) continue;
                    const float beside = 1 - std::clamp(along, 0.f, 1.f), schlick = beside * beside * beside * beside * beside;
                    const float seen = facets.joint(height, toward) * facets.masking(toward);
                    sum.of_f0 += (1 - schlick) * seen, sum.of_white += schlick * seen;
                }
                shares_[r * side + c] = {sum.of_f0 / (strata * strata), sum.of_white / (strata * strata)};
            }
        }
    }

    std::array<Shares, side * side> shares_;
};

}  // namespace bob
