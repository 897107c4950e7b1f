/// Bounding spheres of shapes defined by control points.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/affine.h"
#include "shapes/shape.h"

namespace bob {

/// The sphere around all balls, about the centre of their box. `each_ball` calls its argument with (x, y, z) and a
/// radius for every ball.
template <class EachBall>
Sphere sphere_around(EachBall each_ball) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double low[3] = {infinity, infinity, infinity}, high[3] = {-infinity, -infinity, -infinity};
    each_ball([&](const double* p, double radius) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis] - radius), high[axis] = std::max(high[axis], p[axis] + radius);
        }
    });
    Sphere sphere;
    double* const center = sphere.center;
    for (int axis = 0; axis < 3; ++axis) center[axis] = low[axis] / 2 + high[axis] / 2;  // the sum could overflow
    double farthest = 0;
    each_ball([&](const double* p, double radius) {
        const double x = p[0] - center[0], y = p[1] - center[1], z = p[2] - center[2];
        farthest = std::max(farthest, std::sqrt(x * x + y * y + z * z) + radius);
    });
    if (farthest > smallest_radius) sphere.radius = farthest;
    return sphere;
}

}  // namespace bob
