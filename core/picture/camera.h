/// The orthographic camera that orbits the unit sphere, and its projection: the only place that knows how pixels and points
/// of the scene belong together.
#pragma once

#include <algorithm>
#include <cmath>

#include "picture/gbuffer.h"
#include "ray.h"

namespace bob {

struct Camera {
    float azimuth_degrees = 30;   // 0 looks along -x from +x, growing anticlockwise seen from +z
    float elevation_degrees = 20; // 90 looks straight down
    float roll_degrees = 0;       // turns the camera anticlockwise about its line of sight: the picture turns clockwise
    float zoom = 1;               // 1 fits the unit sphere exactly into the shorter side of the image
    float pan_x = 0, pan_y = 0;   // what the image's centre shows: radii of the unit sphere right of and above its centre
};

static_assert(sizeof(Camera) == 6 * sizeof(float), "viewer/picture/camera.js has these numbers in this order");

/// A camera and the size of its picture: from pixels to rays, and from points back to pixels and depths.
class Projection {
public:
    Projection(const Camera& camera, int height, int width)
        : rows_(static_cast<float>(height)), columns_(static_cast<float>(width)),
          pixel_(2 / (camera.zoom * static_cast<float>(height < width ? height : width))), pan_x_(camera.pan_x),
          pan_y_(camera.pan_y) {
        constexpr double degree = 3.14159265358979323846 / 180;
        const double a = camera.azimuth_degrees * degree, e = camera.elevation_degrees * degree;
        const double r = camera.roll_degrees * degree;
        const double x[3] = {-std::sin(a), std::cos(a), 0};
        const double y[3] = {-std::sin(e) * std::cos(a), -std::sin(e) * std::sin(a), std::cos(e)};
        toward_ = {static_cast<float>(std::cos(e) * std::cos(a)), static_cast<float>(std::cos(e) * std::sin(a)),
                   static_cast<float>(std::sin(e))};
        for (int axis = 0; axis < 3; ++axis) {
            right_[axis] = static_cast<float>(std::cos(r) * x[axis] + std::sin(r) * y[axis]);
            up_[axis] = static_cast<float>(std::cos(r) * y[axis] - std::sin(r) * x[axis]);
        }
    }

    /// The ray through a pixel's centre, from just before it enters the unit sphere; false where it passes by.
    [[nodiscard]] bool ray(Pixel pixel, Ray& ray) const {
        const float x = (static_cast<float>(pixel.column) + 0.5f - 0.5f * columns_) * pixel_ + pan_x_;
        const float y = (0.5f * rows_ - 0.5f - static_cast<float>(pixel.row)) * pixel_ + pan_y_;
        const float z2 = 1 - x * x - y * y;
        if (z2 < -start_margin) return false;
        const float z = std::sqrt(std::max(0.f, z2)) + start_margin;
        ray = {x * right_ + y * up_ + z * toward_, -toward_};
        return true;
    }

    /// Where a point of the scene is seen.
    struct Seen {
        float row, column;  // pixels' centres are at whole numbers
        float depth;        // 1 at the point of the unit sphere nearest the camera, 0 at the farthest
    };
    [[nodiscard]] Seen seen(Vec3 point) const {
        const float x = dot(point, right_) - pan_x_, y = dot(point, up_) - pan_y_;
        return {0.5f * rows_ - 0.5f - y / pixel_, x / pixel_ - 0.5f + 0.5f * columns_, depth(point)};
    }
    [[nodiscard]] float depth(Vec3 point) const { return std::clamp(0.5f + 0.5f * dot(point, toward_), 0.f, 1.f); }

    /// A direction of the scene in screen space: x right, y up, z towards the camera.
    [[nodiscard]] Vec3 on_screen(Vec3 direction) const {
        return {dot(direction, right_), dot(direction, up_), dot(direction, toward_)};
    }

private:
    // Rays start outside the unit sphere by this much, so that surfaces on it are in front of them.
    static constexpr float start_margin = 1e-3f;

    Vec3 right_, up_, toward_;  // the camera's axes in the scene
    float rows_, columns_;
    float pixel_;  // its side, in radii of the unit sphere
    float pan_x_, pan_y_;
};

}  // namespace bob
