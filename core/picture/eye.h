/// A camera for loops over many points.
#pragma once

#include "base/vec.h"

namespace bob {

/// Where a camera sees points, and how deep, as `Projection` has it, in float and alike for both kinds of camera.
struct Eye {
    Vec3 right, up, toward;  // the camera's axes in the scene
    Vec3 at;                 // where it stands along these; without perspective, outside of the unit sphere
    float middle_row, middle_column;
    float pixels_per_radius;                // in perspective, at a distance of 1
    float depth_at_eye, depth_per_radius;   // the depth falls with the distance from the eye
    float side_at_back, side_per_depth;     // of a pixel as a difference of depths: at a depth of 0, and how it falls
    bool in_perspective;
};

}  // namespace bob
