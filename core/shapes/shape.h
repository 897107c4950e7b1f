/// The interface of all shapes: ray intersection and extent.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/affine.h"
#include "base/box.h"
#include "base/ray.h"
#include "base/vec.h"

namespace bob {

/// The minimum radius with a finite reciprocal; anything smaller is a point at any scale.
constexpr double smallest_radius = 1e-307;

class Picture;
struct ShapeEdge;

constexpr std::uint32_t no_primitive = 0xffffffff;

/// The first intersection of a ray with a shape.
struct Hit {
    float t = std::numeric_limits<float>::infinity();
    float u = 0, v = 0;                      // on the primitive, in its parameters
    std::uint32_t primitive = no_primitive;  // a triangle, a cell, a patch
};

/// A hit's place in the user's numbering.
struct Place {
    std::uint32_t part;  // a mesh's triangle, a face of a boundary representation
    double u, v;         // on that part
};

/// A surface in the user's units, at any place. In the coordinates of rays it is about 1 in size and near the origin,
/// so that float32 keeps its precision.
class Shape {
public:
    virtual ~Shape() = default;

    /// The sphere, in the shape's units, that becomes the unit sphere in the coordinates of rays.
    [[nodiscard]] const Sphere& sphere() const { return sphere_; }

    /// The lowest and highest coordinates of the shape, mapped from its own units.
    [[nodiscard]] virtual Bounds bounds(const AffineMap& map) const = 0;

    /// The distance from `center` to the farthest point of the mapped shape; infinite if out of range.
    [[nodiscard]] virtual double radius(const AffineMap& map, const double center[3]) const = 0;

    /// How far `radius` may exceed the distance to the corners of `bounds`. In radii of the mapped sphere along its
    /// longest axis.
    [[nodiscard]] virtual double overshoot() const { return 1; }

    /// Makes `bounds` and `radius` fast for shapes in many places, without changing them, at the cost of a few calls.
    /// Safe to call from any thread, repeatedly. Throws Stopped if interrupted.
    virtual void prepare_places() const {}

    /// Prepares ray intersection; call it before the first ray. Safe to call from any thread, repeatedly.
    virtual void prepare() const {}

    /// The first intersection with t > 0 of each ray, or the default `Hit` for a miss. A ray's hit depends on that ray
    /// alone. Many rays in one call, sorted by proximity, are fastest.
    virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const = 0;

    /// The shading normal at each hit: unit length, facing the ray's origin.
    virtual void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const = 0;

    /// The geometric normal at each hit, if shading uses another: unit length, facing the ray's origin.
    virtual void face_normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const { this->normals(rays, hits, normals); }

    /// The maximum distance of a hit point from the surface, in the coordinates of rays, for origins within a few sizes.
    /// A ray that starts at this distance above the surface does not hit it again.
    [[nodiscard]] virtual float hit_error() const { return 1e-5f; }

    /// Whether it has colours; otherwise it is white.
    [[nodiscard]] virtual bool is_colored() const { return false; }

    /// For a shape with colours: linear RGB, 0..1, at each hit. `widths` are pixel footprints, in lengths of the ray's
    /// direction.
    virtual void colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float> widths,
                        std::span<Vec3> colors) const {
        (void)rays, (void)widths;
        std::fill_n(colors.begin(), hits.size(), Vec3{1, 1, 1});
    }

    /// Prepares `starts_inside`, after `prepare`. Returns whether the surface encloses a solid: a closed one does, but for
    /// gaps that less than 1 % of lines through it meet. Safe to call from any thread, repeatedly.
    [[nodiscard]] virtual bool prepare_inside() const { return false; }

    /// For shapes that enclose a solid: whether each ray starts inside it. `hits` are its first, no misses.
    virtual void starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const {
        (void)rays;
        std::fill_n(inside.begin(), hits.size(), std::uint8_t{0});
    }

    /// For shapes with colours that enclose a solid: linear RGB, 0..1, at points inside it, in the coordinates of rays.
    virtual void colors_inside(std::span<const Vec3> points, std::span<Vec3> colors) const { std::fill_n(colors.begin(), points.size(), Vec3{1, 1, 1}); }

    /// For hits only, not misses.
    [[nodiscard]] virtual Place place(const Hit& hit) const { return {hit.primitive, hit.u, hit.v}; }

    /// The face of a hit, for drawings: where two faces meet there is an edge, even if they meet smoothly.
    [[nodiscard]] virtual std::uint32_t face(const Hit& hit) const {
        (void)hit;
        return 0;
    }

    /// Edges as curves, in the coordinates of rays, found at the first call; null if the shape has no curves for them. Safe to call
    /// from any thread. Those of meshes are Mesh::creases.
    [[nodiscard]] virtual const std::vector<ShapeEdge>* edges() const { return nullptr; }

    /// The shape itself, or the one that it shows in another way.
    [[nodiscard]] virtual const Shape& surface() const { return *this; }

    /// Memory of the intersection data, without the picture.
    [[nodiscard]] virtual std::size_t bytes() const = 0;

    /// The texture's picture, which shapes may share; usually null.
    [[nodiscard]] virtual const Picture* picture() const { return nullptr; }

protected:
    explicit Shape(const Sphere& sphere = {}) : sphere_(sphere) {}
    Shape(Shape&&) = default;

private:
    Sphere sphere_;
};

}  // namespace bob
