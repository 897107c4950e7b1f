/// Checks that hold for every shape.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "fuzz/fuzz.h"
#include "shapes/shape.h"

namespace fuzz {

inline bob::Vec3 vec3(Source& source, float size) {
    bob::Vec3 v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = static_cast<float>(source.within(-size, size));
    return v;
}

/// Rays that come from about the unit sphere, some along axes.
inline std::vector<bob::Ray> rays(Source& source, int count) {
    std::vector<bob::Ray> result;
    for (int i = 0; i < count; ++i) {
        const std::uint8_t kind = source.byte();
        bob::Vec3 direction{0, 0, 0};
        direction[kind % 3] = kind & 4 ? 1.f : -1.f;
        if (kind & 8) direction = vec3(source, 1);
        if (dot(direction, direction) < 1e-6f) direction = {0, 0, 1};
        const bob::Vec3 target = vec3(source, 1);
        result.push_back({target - (kind & 16 ? 0.f : 2.f) * bob::normalized(direction), direction});
    }
    return result;
}

inline bool same(const bob::Hit& a, const bob::Hit& b) {
    const auto bits = [](const bob::Hit& hit) { return std::bit_cast<std::array<std::uint32_t, 4>>(hit); };
    return bits(a) == bits(b);
}

/// Checks that each ray's hit in a batch equals its hit alone, with a usable normal.
inline std::vector<bob::Hit> hits(const bob::Shape& shape, const std::vector<bob::Ray>& rays) {
    std::vector<bob::Hit> all(rays.size());
    shape.closest_hits(rays, all);
    std::vector<bob::Ray> met;
    std::vector<bob::Hit> found;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        bob::Hit alone;
        shape.closest_hits({&rays[i], 1}, {&alone, 1});
        expect(same(all[i], alone), "a hit that depends on the ray alone");
        if (all[i].primitive == bob::no_primitive) continue;
        expect(all[i].t > 0 && std::isfinite(all[i].t), "a hit in front of the ray's origin");
        const bob::Place place = shape.place(all[i]);
        expect(std::isfinite(place.u) && std::isfinite(place.v), "a place that is a number");
        met.push_back(rays[i]);
        found.push_back(all[i]);
    }
    std::vector<bob::Vec3> normals(met.size());
    shape.normals(met, found, normals);
    for (const bob::Vec3 normal : normals) expect(std::fabs(length(normal) - 1) < 1e-3f, "a normal of length 1");
    return all;
}

/// Intersects a shape with rays. Hits lie within the bounds, up to a thousandth of the shape's size, or `along` for rays within the
/// surface.
inline void meet(const bob::Shape& shape, const bob::Bounds& bounds, Source& source, int count, double along = 1e-3) {
    const auto& [center, radius] = shape.sphere();
    shape.prepare();
    const std::vector<bob::Ray> cast = rays(source, count);
    const std::vector<bob::Hit> found = hits(shape, cast);
    for (std::size_t i = 0; i < cast.size(); ++i) {
        if (found[i].primitive == bob::no_primitive) continue;
        bob::Vec3 normal;
        shape.normals({&cast[i], 1}, {&found[i], 1}, {&normal, 1});
        const bool slanted = std::fabs(dot(normal, cast[i].direction)) > 0.05f * length(cast[i].direction);
        const double tolerance = slanted ? 1e-3 : along;
        const bob::Vec3 point = cast[i].origin + found[i].t * cast[i].direction;
        for (int axis = 0; axis < 3; ++axis) {
            const double p = point[axis] * radius + center[axis], most = tolerance * radius + 1e-12 * std::fabs(center[axis]);
            expect(p >= bounds.low[axis] - most && p <= bounds.high[axis] + most, "a hit within the shape's bounds");
        }
    }
}

/// The same, and measures the shape for some inputs, since this is slow.
inline void meet(const bob::Shape& shape, Source& source, int count, double along = 1e-3) {
    constexpr double far = HUGE_VAL;
    const bool measured = source.below(8) == 0;
    meet(shape, measured ? shape.bounds({}) : bob::Bounds{{-far, -far, -far}, {far, far, far}}, source, count, along);
}

}  // namespace fuzz
