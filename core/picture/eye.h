/// A camera for loops over many points.
#pragma once

#include "base/vec.h"

namespace bob {

/// `Projection` to rows, columns and depths in float, with one formula for both kinds of camera.
struct Eye {
    Vec3 right, up, toward;  // the camera's axes in the scene
    Vec3 at;                 // position along these axes; orthographic: outside the unit sphere
    float middle_row, middle_column;
    float pixels_per_radius;                // in perspective, at a distance of 1
    float depth_at_eye, depth_per_radius;   // the depth falls with the distance from the eye
    float side_at_back, side_per_depth;     // pixel side as a difference of depths: at depth 0, and its decrease with depth
    bool in_perspective;
};

}  // namespace bob
