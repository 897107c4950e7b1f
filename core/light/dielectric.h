/// Glass: reflection and refraction at the boundary of two media, and what a path is inside of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/vec.h"
#include "tracing/material.h"

namespace bob {

/// A boundary between media, for light at an angle of the cosine `along` to its normal. `eta` is the index on the side of the eye over the other.
struct Boundary {
    float reflectance;  // by Fresnel, of both polarisations alike; the rest is transmitted
    float beyond;       // cosine of the refracted ray; 0 under total reflection

    Boundary(float along, float eta) {
        const float squared = 1 - eta * eta * (1 - along * along);
        beyond = std::sqrt(std::max(0.f, squared));
        if (squared <= 0) {
            reflectance = 1;
            return;
        }
        const float across = (eta * along - beyond) / (eta * along + beyond), within = (along - eta * beyond) / (along + eta * beyond);
        reflectance = 0.5f * (across * across + within * within);
    }
};

/// A direction to the eye, refracted at a facet whose normal is on the eye's side.
inline Vec3 refracted(Vec3 eye, Vec3 half, float eta, float beyond) { return (eta * dot(eye, half) - beyond) * half - eta * eye; }

/// The solids of glass that a path is inside of, by their instances. Solids may overlap: the last one that was entered counts, and to leave
/// another one changes nothing. Each surface of a solid is where it is entered or left, in turn.
class Media {
public:
    static constexpr std::uint32_t most = 6;

    [[nodiscard]] bool is_empty() const { return count_ == 0; }
    [[nodiscard]] std::uint32_t last() const { return inside_[count_ - 1]; }
    [[nodiscard]] bool contains(std::uint32_t instance) const { return std::find(inside_.begin(), inside_.begin() + count_, instance) != inside_.begin() + count_; }
    /// Beyond the most, it is as if there were none.
    void enter(std::uint32_t instance) {
        if (count_ < most) inside_[count_++] = instance;
    }
    void leave(std::uint32_t instance) {
        count_ = static_cast<std::uint32_t>(std::remove(inside_.begin(), inside_.begin() + count_, instance) - inside_.begin());
    }

private:
    std::array<std::uint32_t, most> inside_{};
    std::uint32_t count_ = 0;
};

/// The share of light that is left after a distance in radii of the unit sphere, which is so long: Beer's law.
inline Vec3 attenuation(const Material& material, float distance, float radius) {
    const float lengths = distance * radius / Material::rounded(material.attenuation_distance);
    const Vec3 color = Material::rounded(material.attenuation);
    Vec3 left{1, 1, 1};
    for (int k = 0; k < 3; ++k) {
        if (color[k] < 1 && lengths > 0) left[k] = std::pow(color[k], lengths);
    }
    return left;
}

}  // namespace bob
