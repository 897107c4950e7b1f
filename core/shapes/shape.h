/// What every kind of shape can do: be met by rays, and say how far it reaches.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "base/affine.h"
#include "base/box.h"
#include "base/ray.h"
#include "base/vec.h"

namespace bob {

/// The least radius whose reciprocal is finite; whatever is smaller is a point at any scale.
constexpr double smallest_radius = 1e-307;

class Picture;

constexpr std::uint32_t no_primitive = 0xffffffff;

/// Where a ray first meets a shape.
struct Hit {
    float t = std::numeric_limits<float>::infinity();
    float u = 0, v = 0;                      // where on the primitive, in its own terms
    std::uint32_t primitive = no_primitive;  // which piece of the shape: a triangle, a cell, a patch
};

/// Where a hit lies, in the numbering of the shape's users.
struct Place {
    std::uint32_t part;  // a mesh's triangle, a face of a boundary representation
    double u, v;         // on that part
};

/// A surface that users give in units of their own, at any place. Rays meet it in coordinates in which it is about 1 in
/// size and about the origin, so that float32 loses nothing of it.
class Shape {
public:
    virtual ~Shape() = default;

    /// In the shape's own units: what is the unit sphere about the origin in the coordinates of rays.
    [[nodiscard]] const Sphere& sphere() const { return sphere_; }

    /// The lowest and highest coordinates of the shape placed by a map from its own units.
    [[nodiscard]] virtual Bounds bounds(const AffineMap& map) const = 0;

    /// The distance from `center` to the farthest point of the shape placed by a map from its own units; infinite where
    /// numbers can't hold it.
    [[nodiscard]] virtual double radius(const AffineMap& map, const double center[3]) const = 0;

    /// How much farther than the corners of `bounds` `radius` may be at most, in radii of the shape's sphere that is placed,
    /// at its longest.
    [[nodiscard]] virtual double overshoot() const { return 1; }

    /// Makes `bounds` and `radius` fast for a shape in many places, without changing them; takes as long as some of them. Any
    /// thread may call it, and again. Throws Stopped where it shall not go on.
    virtual void prepare_places() const {}

    /// What rays need, where it was not made with the shape; comes before the first of them. Any thread may call it, and
    /// again.
    virtual void prepare() const {}

    /// The first intersection with t > 0 of each ray, or the default `Hit` where there is none. A ray's hit depends on
    /// that ray alone. Many rays in one call, neighbours close to each other, are traced fastest.
    virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const = 0;

    /// The shading normal at each hit: unit length, turned to the side that the ray came from.
    virtual void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const = 0;

    /// The surface's own normal at each hit, where shading has another: unit length, turned likewise.
    virtual void face_normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const { this->normals(rays, hits, normals); }

    /// How far the point of a hit lies from the surface at most, in the coordinates of rays: a ray that starts so far above it does not
    /// meet it again. Of rays whose origins are within a few sizes.
    [[nodiscard]] virtual float hit_error() const { return 1e-5f; }

    /// Whether it has colours of its own; else it is white.
    [[nodiscard]] virtual bool is_colored() const { return false; }

    /// Of a shape with colours: linear RGB, 0..1, at each hit, which is seen through a pixel of that width, in lengths of its ray's
    /// direction.
    virtual void colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float> widths,
                        std::span<Vec3> colors) const {
        (void)rays, (void)widths;
        std::fill_n(colors.begin(), hits.size(), Vec3{1, 1, 1});
    }

    /// Of a hit, not of a miss.
    [[nodiscard]] virtual Place place(const Hit& hit) const { return {hit.primitive, hit.u, hit.v}; }

    /// Of what rays need, without its picture.
    [[nodiscard]] virtual std::size_t bytes() const = 0;

    /// The one on its surface, which other shapes may share; none of most.
    [[nodiscard]] virtual const Picture* picture() const { return nullptr; }

protected:
    explicit Shape(const Sphere& sphere = {}) : sphere_(sphere) {}
    Shape(Shape&&) = default;

private:
    Sphere sphere_;
};

}  // namespace bob
