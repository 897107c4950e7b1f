/// The studio: a soft key light from the camera's upper left, a rim light from behind, and a dim sky.
#pragma once

#include <array>
#include <cmath>

#include "light/lights.h"

namespace bob {

inline constexpr double degree = 3.14159265358979323846 / 180;

/// A disc of the studio: angles in degrees, its azimuth from the camera's on; linear RGB before its intensity.
struct StudioLight {
    double azimuth, elevation, angle;
    std::array<double, 3> color;
    double intensity;

    /// Towards it, for a camera that looks from this azimuth.
    [[nodiscard]] std::array<double, 3> direction(double camera) const {
        const double a = (camera + azimuth) * degree, e = elevation * degree;
        return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
    }
};
inline constexpr std::array<StudioLight, 2> studio_lights{{{-55, 48, 24, {1, 0.97, 0.93}, 0.66}, {145, 30, 30, {0.93, 0.96, 1}, 0.22}}};

struct StudioSky {
    std::array<double, 3> top, bottom;
    double intensity;
};
inline constexpr StudioSky studio_sky{{0.96, 0.98, 1}, {0.62, 0.60, 0.58}, 0.32};

/// The studio of a camera that looks from this azimuth, in degrees.
inline Lights studio(double azimuth) {
    const auto scaled = [](const std::array<double, 3>& v, double factor) {
        return Vec3{static_cast<float>(factor * v[0]), static_cast<float>(factor * v[1]), static_cast<float>(factor * v[2])};
    };
    Lights lights;
    for (const StudioLight& light : studio_lights) {
        const double sine = std::sin(light.angle / 4 * degree);
        lights.discs.push_back({scaled(light.direction(azimuth), 1), static_cast<float>(2 * sine * sine), scaled(light.color, light.intensity)});
    }
    lights.sky = {scaled(studio_sky.top, studio_sky.intensity), scaled(studio_sky.bottom, studio_sky.intensity)};
    return lights;
}

}  // namespace bob
