#include "tracing/section.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bob {
namespace {

/// Surfaces within this distance of a plane, in radii of the scene, belong to the part that it removes: more than
/// rounding moves hits. So a face in a plane is either seen as a whole, or not at all.
constexpr double in_plane = 4e-6;

/// Where a ray runs along a plane, it is shortened by at most this number of such distances.
constexpr double most_shortened = 32;

/// Hatching: the distance between lines in radii of the scene, the line's share of it, and the darkening.
constexpr float period = 1.f / 24, duty = 0.2f, darkness = 0.3f;

/// Hatch lines per `period`; part after part takes the next of these.
constexpr float closeness[] = {1, 1, 1.6f, 1.6f, 0.7f, 0.7f};

/// How much of 0..x lines cover that begin at whole numbers.
float covered(float x) {
    const float whole = std::floor(x);
    return whole * duty + std::min(x - whole, duty);
}

}  // namespace

KeptPart::KeptPart(std::span<const SectionPlane> planes, const Ray& ray) : leave(std::numeric_limits<double>::infinity()) {
    const Vec3d origin{ray.origin.x, ray.origin.y, ray.origin.z}, direction{ray.direction.x, ray.direction.y, ray.direction.z};
    const double longest = most_shortened * in_plane / length(direction);
    double shortened_start = 0, shortened_end = 0;
    for (std::uint32_t i = 0; i < planes.size(); ++i) {
        const double outside = dot(planes[i].normal, origin) - planes[i].offset, slope = dot(planes[i].normal, direction);
        if (slope == 0) {
            if (outside > 0) leave = -1;
            continue;
        }
        const double t = -outside / slope, shortened = std::min(in_plane / std::fabs(slope), longest);
        if (slope < 0 && t > enter) enter = t, entered = i, shortened_start = shortened;
        if (slope > 0 && t < leave) leave = t, left = i, shortened_end = shortened;
    }
    start = enter + shortened_start, end = leave - shortened_end;
}

PlaneAxes::PlaneAxes(const Vec3d& normal) {
    const Vec3d vertical = std::fabs(normal[2]) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0}, across = cross(vertical, normal);
    right = (1 / length(across)) * across, up = cross(normal, right);
}

float hatched(const PlaneAxes& axes, Vec3 point, float width, std::uint32_t part) {
    const Vec3d p{point.x, point.y, point.z};
    const double x = dot(axes.right, p), y = dot(axes.up, p), across = (part % 2 ? x + y : x - y) * std::sqrt(0.5);
    const float scale = closeness[part % std::size(closeness)] / period;
    const float at = scale * static_cast<float>(across), half = std::max(0.5f * scale * width, 1e-4f);
    const float share = (covered(at + half) - covered(at - half)) / (2 * half);
    return 1 - darkness * share;
}

}  // namespace bob
