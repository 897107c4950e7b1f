/// Glass: reflection and refraction at the boundary of two media, and the stack of a path's media.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/vec.h"
#include "tracing/material.h"

namespace bob {

/// A boundary between media, for light whose angle to the normal has the cosine `along`. `eta` is the index on the side of the eye over the other.
struct Boundary {
    float reflectance;  // Fresnel, unpolarised; the rest is transmitted
    float beyond;       // cosine of the refracted ray; 0 under total reflection

    /// A sheet of an index in air, without a thickness: light goes straight on, or is reflected by either side, after any number of reflections inside.
    static Boundary sheet(float along, float ior) {
        Boundary result(along, 1 / ior);
        result.reflectance *= 2 / (1 + result.reflectance), result.beyond = along;
        return result;
    }

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

/// The glass solids around a path's current point, by instance. Solids may overlap: the last entered one is the medium, and leaving
/// another one changes nothing. Surfaces of a solid alternate between entering and leaving.
class Media {
public:
    static constexpr std::uint32_t max = 6;

    [[nodiscard]] bool is_empty() const { return count_ == 0; }
    [[nodiscard]] std::uint32_t last() const { return inside_[count_ - 1]; }
    [[nodiscard]] bool contains(std::uint32_t instance) const { return std::find(inside_.begin(), inside_.begin() + count_, instance) != inside_.begin() + count_; }
    /// Further solids beyond the maximum depth are ignored.
    void enter(std::uint32_t instance) {
        if (count_ < max) inside_[count_++] = instance;
    }
    void leave(std::uint32_t instance) {
        count_ = static_cast<std::uint32_t>(std::remove(inside_.begin(), inside_.begin() + count_, instance) - inside_.begin());
    }

private:
    std::array<std::uint32_t, max> inside_{};
    std::uint32_t count_ = 0;
};

/// Transmittance over a distance in radii, by the Beer-Lambert law. The radius has the given length.
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
