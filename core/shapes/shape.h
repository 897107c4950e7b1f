/// What every kind of shape can do: be met by rays.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "ray.h"
#include "vec.h"

namespace bob {

constexpr std::uint32_t no_primitive = 0xffffffff;

/// Where a ray first meets a shape.
struct Hit {
    float t = std::numeric_limits<float>::infinity();
    float u = 0, v = 0;                      // where on the primitive, in its own terms
    std::uint32_t primitive = no_primitive;  // which piece of the shape: a triangle, a cell, a patch
};

/// Where a hit lies, as users of the shape count.
struct Place {
    std::uint32_t part;  // a mesh's triangle, a face of a boundary representation
    double u, v;         // on that part
};

class Shape {
public:
    virtual ~Shape() = default;

    /// The first intersection with t > 0 of each ray, or the default `Hit` where there is none. A ray's hit depends on
    /// that ray alone. Many rays in one call, neighbours close to each other, are traced fastest.
    virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const = 0;

    /// The shading normal at each hit: unit length, turned to the side that the ray came from.
    virtual void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const = 0;

    /// Of a hit, not of a miss.
    [[nodiscard]] virtual Place place(const Hit& hit) const { return {hit.primitive, hit.u, hit.v}; }

    [[nodiscard]] virtual std::size_t bytes() const = 0;
};

}  // namespace bob
