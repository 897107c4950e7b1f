/// The orthographic camera that orbits the unit sphere.
#pragma once

#include <cmath>

#include "vec.h"

namespace bob {

struct Camera {
    float azimuth_degrees = 30;   // 0 looks along -x from +x, growing anticlockwise seen from +z
    float elevation_degrees = 20; // 90 looks straight down
    float roll_degrees = 0;       // turns the camera anticlockwise about its line of sight: the picture turns clockwise
    float zoom = 1;               // 1 fits the unit sphere exactly into the shorter side of the image
    float pan_x = 0, pan_y = 0;   // what the image's centre shows: radii of the unit sphere right of and above its centre
};

/// The camera's axes in the scene: x right and y up in the picture, z towards the camera.
struct Frame {
    Vec3 right, up, toward;

    explicit Frame(const Camera& camera) {
        constexpr double degree = 3.14159265358979323846 / 180;
        const double a = camera.azimuth_degrees * degree, e = camera.elevation_degrees * degree;
        const double r = camera.roll_degrees * degree;
        const double x[3] = {-std::sin(a), std::cos(a), 0};
        const double y[3] = {-std::sin(e) * std::cos(a), -std::sin(e) * std::sin(a), std::cos(e)};
        toward = {static_cast<float>(std::cos(e) * std::cos(a)), static_cast<float>(std::cos(e) * std::sin(a)),
                  static_cast<float>(std::sin(e))};
        for (int axis = 0; axis < 3; ++axis) {
            right[axis] = static_cast<float>(std::cos(r) * x[axis] + std::sin(r) * y[axis]);
            up[axis] = static_cast<float>(std::cos(r) * y[axis] - std::sin(r) * x[axis]);
        }
    }
};

/// The picture's plane: where each pixel's centre lies, in the camera's x and y.
struct Raster {
    int height, width;
    float pixel;  // size of a pixel, in radii of the unit sphere
    float pan_x, pan_y;

    Raster(int height, int width, const Camera& camera)
        : height(height), width(width),
          pixel(2 / (camera.zoom * static_cast<float>(height < width ? height : width))),
          pan_x(camera.pan_x), pan_y(camera.pan_y) {}
    [[nodiscard]] float x(int column) const { return (static_cast<float>(column) + 0.5f - 0.5f * width) * pixel + pan_x; }
    [[nodiscard]] float y(int row) const { return (0.5f * height - 0.5f - static_cast<float>(row)) * pixel + pan_y; }
};

}  // namespace bob
