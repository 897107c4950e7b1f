/// The lights of a scene: discs far away, and a sky around it. docs/reference/lights.md has the units.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "light/environment.h"

namespace bob {

/// A disc at infinity, such as the sun or a soft box.
struct DiscLight {
    Vec3 direction;  // towards its centre, unit length
    float height;    // of the cap that it covers on the unit sphere: 1 - cos of half its angle; 0 for a point
    Vec3 color;      // linear RGB of a white, rough surface that faces it

    /// Radiance of the disc. A point light's would be infinite: call this for discs only.
    [[nodiscard]] Vec3 radiance() const { return (1 / (height * (2 - height))) * color; }
    /// Whether it is seen in a direction of unit length.
    [[nodiscard]] bool covers(Vec3 toward) const {
        const Vec3 apart = toward - direction;  // of length 2 sin of half the angle between them, exact for small ones
        return dot(apart, apart) <= 2 * height;
    }
};

/// Light from all directions: linear in height from the bottom's colour to the top's, or an environment times the top's colour.
struct Sky {
    Vec3 top, bottom;  // linear RGB of a white, rough surface under it alone
    std::shared_ptr<const Environment> environment = {};
    float turn_cos = 1, turn_sin = 0;  // the environment's rotation about z, anticlockwise seen from above

    [[nodiscard]] Vec3 radiance(Vec3 toward) const {
        if (environment) {
            const Vec3 seen = environment->radiance(in_environment(toward));
            return {top.x * seen.x, top.y * seen.y, top.z * seen.z};
        }
        const float share = 0.5f + 0.5f * toward.z;
        return bottom + share * (top - bottom);
    }
    /// Directions of the scene in the environment's picture, and back.
    [[nodiscard]] Vec3 in_environment(Vec3 v) const { return {turn_cos * v.x + turn_sin * v.y, turn_cos * v.y - turn_sin * v.x, v.z}; }
    [[nodiscard]] Vec3 from_environment(Vec3 v) const { return {turn_cos * v.x - turn_sin * v.y, turn_cos * v.y + turn_sin * v.x, v.z}; }
};

struct Lights {
    std::vector<DiscLight> discs;
    Sky sky;
    bool has_ground = false;  // a plane through the scene's lowest point catches shadows
    double radius = 1;        // of the unit sphere, in the scene's units
    int bounces = 2;          // surfaces that a path of light meets, mirrors not counted

    /// Light from a direction where nothing is, without points.
    [[nodiscard]] Vec3 radiance(Vec3 toward) const {
        Vec3 light = sky.radiance(toward);
        for (const DiscLight& disc : discs) {
            if (disc.height > 0 && disc.covers(toward)) light = light + disc.radiance();
        }
        return light;
    }
};

}  // namespace bob
