/// The studio: a soft key light from the camera's upper left, a rim light from behind, and a dim sky.
#pragma once

#include <array>
#include <cmath>

#include "light/lights.h"

namespace bob {

/// A disc of the studio: angles in degrees, its azimuth from the camera's on; linear RGB before its intensity.
struct StudioLight {
    double azimuth, elevation, angle;
    std::array<double, 3> color;
    double intensity;
};
inline constexpr std::array<StudioLight, 2> studio_lights{{{-55, 48, 24, {1, 0.97, 0.93}, 0.66}, {145, 30, 30, {0.93, 0.96, 1}, 0.22}}};

struct StudioSky {
    std::array<double, 3> top, bottom;
    double intensity;
};
inline constexpr StudioSky studio_sky{{0.96, 0.98, 1}, {0.62, 0.60, 0.58}, 0.32};

/// The studio of a camera that looks from this azimuth, in degrees.
inline Lights studio(double azimuth) {
    constexpr double degree = 3.14159265358979323846 / 180;
    const auto scaled = [](const std::array<double, 3>& color, double intensity) {
        return Vec3{static_cast<float>(intensity * color[0]), static_cast<float>(intensity * color[1]), static_cast<float>(intensity * color[2])};
    };
    Lights lights;
    for (const StudioLight& light : studio_lights) {
        const double a = (azimuth + light.azimuth) * degree, e = light.elevation * degree, sine = std::sin(light.angle / 4 * degree);
        const Vec3 direction{static_cast<float>(std::cos(e) * std::cos(a)), static_cast<float>(std::cos(e) * std::sin(a)), static_cast<float>(std::sin(e))};
        lights.discs.push_back({direction, static_cast<float>(2 * sine * sine), scaled(light.color, light.intensity)});
    }
    lights.sky = {scaled(studio_sky.top, studio_sky.intensity), scaled(studio_sky.bottom, studio_sky.intensity)};
    return lights;
}

}  // namespace bob
