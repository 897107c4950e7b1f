/// The camera, orthographic or perspective, and its projection: the only place that maps between pixels and points of
/// the scene.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/ray.h"
#include "base/vec3d.h"
#include "picture/eye.h"
#include "picture/gbuffer.h"

namespace bob {

/// Position and view direction of a camera that does not orbit, in the coordinates of the unit sphere.
struct Standpoint {
    std::array<double, 3> position{}, target{};
    std::array<double, 3> up{0, 0, 1};  // not parallel to the line of sight; of any length

    bool operator==(const Standpoint&) const = default;
};

/// A camera that orbits the unit sphere, or stands anywhere. viewer/picture/camera.js has the numbers in this order.
struct Camera {
    float azimuth_degrees = 30;   // 0 looks along -x from +x; grows anticlockwise seen from +z
    float elevation_degrees = 20; // 90 looks straight down
    float roll_degrees = 0;       // rotates the camera anticlockwise about its line of sight: the picture rotates clockwise
    float zoom = 1;               // enlarges the picture about its centre; at 1 the unit sphere fits an orbiting camera
    float pan_x = 0, pan_y = 0;   // translation of camera and target to the right and up, in radii
    float fov_degrees = 0;        // vertical angle of the picture at zoom 1; 0 is orthographic
    std::optional<Standpoint> standpoint{};  // replaces azimuth and elevation; needs a fov above 0

    bool operator==(const Camera&) const = default;
};

/// A camera and the size of its picture: from pixels to rays, and from points back to pixels and depths.
///
/// At zoom 1, an orbiting orthographic camera fits the unit sphere exactly into the shorter side of the picture. A
/// perspective camera has the distance where it does so too.
class Projection {
public:
    Projection(const Camera& camera, int height, int width)
        : rows_(static_cast<float>(height)), columns_(static_cast<float>(width)), in_perspective_(camera.fov_degrees > 0),
          pixel_(2 / (camera.zoom * static_cast<float>(height < width ? height : width))), pan_x_(camera.pan_x),
          pan_y_(camera.pan_y) {
        const double r = camera.roll_degrees * degree;
        Axis x, y;
        camera.standpoint ? look(*camera.standpoint, x, y) : orbit(camera, x, y);
        for (int axis = 0; axis < 3; ++axis) {
            right_in_double_[axis] = std::cos(r) * x[axis] + std::sin(r) * y[axis];
            up_in_double_[axis] = std::cos(r) * y[axis] - std::sin(r) * x[axis];
        }
        right_ = rounded(right_in_double_), up_ = rounded(up_in_double_), toward_ = rounded(toward_in_double_);
        if (in_perspective_) stand(camera, height, width);
    }

    /// The ray through a pixel's centre. It starts at the camera or just before the unit sphere, whichever is later.
    /// False if it misses the sphere.
    [[nodiscard]] bool ray(Pixel pixel, Ray& ray) const { return this->ray(static_cast<float>(pixel.row), static_cast<float>(pixel.column), ray); }

    /// The ray through any place in the picture.
    [[nodiscard]] bool ray(float row, float column, Ray& ray) const {
        if (in_perspective_) return ray_from_eye(direction(row, column), ray);
        const float x = x_of(column), y = y_of(row);
        const float z2 = 1 - x * x - y * y;
        if (z2 < -start_margin) return false;
        const float z = std::sqrt(std::max(0.f, z2)) + start_margin;
        ray = {x * right_ + y * up_ + z * toward_, -toward_};
        return true;
    }

    /// The line of sight through a place in the picture, for any scene. It starts at the eye, or from a plane in front
    /// of the unit sphere.
    [[nodiscard]] Ray line(float row, float column) const {
        if (in_perspective_) return {rounded(eye_), rounded(direction(row, column))};
        return {x_of(column) * right_ + y_of(row) * up_ + 2 * toward_, -toward_};
    }

    /// The projection of a point.
    struct Seen {
        float row, column;  // pixel centres are integers; NaN if the point is not in front of the camera
        float depth;        // 1 at the unit sphere's nearest point, 0 at its farthest
    };
    [[nodiscard]] Seen seen(Vec3 point) const {
        if (in_perspective_) {
            const Axis from_eye = {point.x - eye_[0], point.y - eye_[1], point.z - eye_[2]};
            const double before = -dot(from_eye, toward_in_double_), scale = 1 / (before * slope_);
            if (!(before > 0)) return {nowhere, nowhere, depth(point)};
            return {static_cast<float>(0.5 * rows_ - 0.5 - dot(from_eye, up_in_double_) * scale),
                    static_cast<float>(dot(from_eye, right_in_double_) * scale - 0.5 + 0.5 * columns_), depth(point)};
        }
        const float x = bob::dot(point, right_) - pan_x_, y = bob::dot(point, up_) - pan_y_;
        return {0.5f * rows_ - 0.5f - y / pixel_, x / pixel_ - 0.5f + 0.5f * columns_, depth(point)};
    }
    /// The point with this projection: the inverse of `seen`.
    [[nodiscard]] Vec3 point(float row, float column, float depth) const {
        if (in_perspective_) {
            const double distance = nearest_ + (1 - static_cast<double>(depth)) * range_;
            const Axis d = direction(row, column);
            return rounded({eye_[0] + distance * d[0], eye_[1] + distance * d[1], eye_[2] + distance * d[2]});
        }
        return x_of(column) * right_ + y_of(row) * up_ + (2 * depth - 1) * toward_;
    }
    /// Along the line of sight; in perspective, by the distance from the camera.
    [[nodiscard]] float depth(Vec3 point) const {
        if (in_perspective_) {
            const Axis from_eye = {point.x - eye_[0], point.y - eye_[1], point.z - eye_[2]};
            const double nearness = 1 - (std::sqrt(dot(from_eye, from_eye)) - nearest_) / range_;
            return static_cast<float>(std::clamp(nearness, 0., 1.));
        }
        return std::clamp(0.5f + 0.5f * bob::dot(point, toward_), 0.f, 1.f);
    }

    /// Depth without clamping: above 1 in front of the unit sphere, below 0 behind it.
    [[nodiscard]] float unbounded_depth(Vec3 point) const {
        if (!in_perspective_) return 0.5f + 0.5f * bob::dot(point, toward_);
        const Axis from_eye = {point.x - eye_[0], point.y - eye_[1], point.z - eye_[2]};
        return static_cast<float>(1 - (std::sqrt(dot(from_eye, from_eye)) - nearest_) / range_);
    }

    /// A direction in the screen space of a place in the picture. Axes: x right, y up, z towards the camera along the
    /// ray through that place. In perspective these are the camera's axes, rotated by the smallest angle.
    [[nodiscard]] Vec3 on_screen(Vec3 direction, float row, float column) const {
        return turned({bob::dot(direction, right_), bob::dot(direction, up_), bob::dot(direction, toward_)}, row, column);
    }
    /// The inverse of `on_screen`.
    [[nodiscard]] Vec3 in_scene(Vec3 direction, float row, float column) const {
        if (in_perspective_) {
            const Vec3 eye = toward_eye(row, column);
            direction = turn(direction, {-eye.x, -eye.y, eye.z});
        }
        return direction.x * right_ + direction.y * up_ + direction.z * toward_;
    }
    /// A direction in the camera's axes, to the screen space of a place; the two differ only in perspective.
    [[nodiscard]] Vec3 turned(Vec3 direction, float row, float column) const {
        return in_perspective_ ? turn(direction, toward_eye(row, column)) : direction;
    }

    /// The side of a pixel at a depth, in radii of the unit sphere.
    [[nodiscard]] float pixel_width(float depth) const {
        if (!in_perspective_) return pixel_;
        return static_cast<float>((nearest_ + (1 - static_cast<double>(depth)) * range_) * slope_);
    }
    /// The side of a pixel as a difference of depths.
    [[nodiscard]] float pixel_side(float depth) const {
        if (!in_perspective_) return 0.5f * pixel_;
        return static_cast<float>((nearest_ / range_ + (1 - static_cast<double>(depth))) * slope_);
    }

    [[nodiscard]] bool in_perspective() const { return in_perspective_; }

    /// The camera in the coordinates of the unit sphere: unit axes, and the eye, or the picture's centre in a plane in front of the
    /// sphere. `pixel` is the side of a pixel at a distance of 1, or anywhere if orthographic.
    struct Pose {
        Vec3d right, up, toward, origin;
        double pixel;
    };
    [[nodiscard]] Pose pose() const {
        if (in_perspective_) return {right_in_double_, up_in_double_, toward_in_double_, eye_, slope_};
        const Vec3d origin = double{pan_x_} * right_in_double_ + double{pan_y_} * up_in_double_ + 2.0 * toward_in_double_;
        return {right_in_double_, up_in_double_, toward_in_double_, origin, pixel_};
    }

    /// The projection's constants, for loops over many points.
    [[nodiscard]] Eye eye() const {
        Eye eye{right_, up_, toward_, {pan_x_, pan_y_, 2}, 0.5f * rows_ - 0.5f, 0.5f * columns_ - 0.5f, 1 / pixel_,
                1.5f, 0.5f, 0.5f * pixel_, 0, in_perspective_};
        if (!in_perspective_) return eye;
        eye.at = rounded({dot(eye_, right_in_double_), dot(eye_, up_in_double_), dot(eye_, toward_in_double_)});
        const double to_back = 1 + nearest_ / range_;
        eye.pixels_per_radius = static_cast<float>(1 / slope_);
        eye.depth_at_eye = static_cast<float>(to_back), eye.depth_per_radius = static_cast<float>(1 / range_);
        eye.side_at_back = static_cast<float>(to_back * slope_), eye.side_per_depth = static_cast<float>(slope_);
        return eye;
    }

private:
    using Axis = Vec3d;
    static Axis normalized(const Axis& a) {
        const double size = length(a);
        return {a[0] / size, a[1] / size, a[2] / size};
    }

    // The camera's axes before the roll.
    void orbit(const Camera& camera, Axis& x, Axis& y) {
        const double a = camera.azimuth_degrees * degree, e = camera.elevation_degrees * degree;
        x = {-std::sin(a), std::cos(a), 0};
        y = {-std::sin(e) * std::cos(a), -std::sin(e) * std::sin(a), std::cos(e)};
        toward_in_double_ = {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
    }
    void look(const Standpoint& at, Axis& x, Axis& y) {
        const Axis back{at.position[0] - at.target[0], at.position[1] - at.target[1], at.position[2] - at.target[2]};
        toward_in_double_ = normalized(back);
        x = normalized(cross(normalized(at.up), toward_in_double_));
        y = cross(toward_in_double_, x);
    }

    /// Positions a perspective camera.
    void stand(const Camera& camera, int height, int width) {
        const double high = std::tan(0.5 * camera.fov_degrees * degree), rows = height;
        slope_ = 2 * high / (camera.zoom * rows);
        const double shorter = high * std::min(height, width) / rows;
        const double orbit = std::sqrt(1 + shorter * shorter) / shorter;  // 1 / sin of the shorter side's half angle
        for (int k = 0; k < 3; ++k) {
            const auto axis = static_cast<std::size_t>(k);
            const double stands = camera.standpoint ? camera.standpoint->position[axis] : orbit * toward_in_double_[axis];
            eye_[axis] = stands + pan_x_ * right_in_double_[axis] + pan_y_ * up_in_double_[axis];
        }
        const double distance = std::sqrt(dot(eye_, eye_));
        nearest_ = std::max(0., distance - 1), range_ = distance + 1 - nearest_;
    }

    bool ray_from_eye(const Axis& d, Ray& ray) const {
        const double before = -dot(eye_, d);  // from the eye to the ray's nearest point to the sphere's centre
        const Axis middle{eye_[0] + before * d[0], eye_[1] + before * d[1], eye_[2] + before * d[2]};
        const double z2 = 1 - dot(middle, middle);
        if (z2 < -start_margin) return false;
        const double z = std::sqrt(std::max(0., z2)) + start_margin;
        if (before + z < 0) return false;
        const double back = std::min(before, z);
        ray = {rounded({middle[0] - back * d[0], middle[1] - back * d[1], middle[2] - back * d[2]}), rounded(d)};
        return true;
    }

    // A place in the picture, in radii right of and above the sphere's centre. In perspective, at a distance of 1.
    [[nodiscard]] float x_of(float column) const { return (column + 0.5f - 0.5f * columns_) * pixel_ + pan_x_; }
    [[nodiscard]] float y_of(float row) const { return (0.5f * rows_ - 0.5f - row) * pixel_ + pan_y_; }
    [[nodiscard]] double across(float column) const { return (column + 0.5 - 0.5 * columns_) * slope_; }
    [[nodiscard]] double above(float row) const { return (0.5 * rows_ - 0.5 - row) * slope_; }

    /// The unit direction from the eye through a place in the picture.
    [[nodiscard]] Axis direction(float row, float column) const {
        const double x = across(column), y = above(row), scale = 1 / std::sqrt(1 + x * x + y * y);
        Axis result;
        for (std::size_t k = 0; k < 3; ++k) {
            result[k] = (x * right_in_double_[k] + y * up_in_double_[k] - toward_in_double_[k]) * scale;
        }
        return result;
    }
    /// The opposite direction, in the camera's axes.
    [[nodiscard]] Vec3 toward_eye(float row, float column) const {
        const double x = across(column), y = above(row), scale = 1 / std::sqrt(1 + x * x + y * y);
        return rounded({-x * scale, -y * scale, scale});
    }

    /// Applies the smallest rotation that takes `from`, a unit vector with z >= 0, to (0, 0, 1).
    static Vec3 turn(Vec3 direction, Vec3 from) {
        const float along = bob::dot(direction, from), k = (direction.z + along) / (1 + from.z);
        return {direction.x - k * from.x, direction.y - k * from.y, along};
    }

    static constexpr double degree = 3.14159265358979323846 / 180;
    static constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();
    // Rays start outside the unit sphere by this distance, so that surfaces on the sphere are in front of them.
    static constexpr float start_margin = 1e-3f;

    Vec3 right_, up_, toward_;  // the camera's axes in the scene
    float rows_, columns_;
    bool in_perspective_;
    float pixel_;  // side, in radii of the unit sphere
    float pan_x_, pan_y_;
    Axis right_in_double_, up_in_double_, toward_in_double_;
    // In perspective only: the side of a pixel at a distance of 1, and the eye. Then its distance from the nearest
    // point of the unit ball, and from there to the farthest.
    double slope_ = 0;
    Axis eye_{};
    double nearest_ = 0, range_ = 0;
};

}  // namespace bob
