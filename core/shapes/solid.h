/// The solid that a surface encloses, known by lines through it.
///
/// Along a line, a line enters and leaves a closed surface alternately. So lines tell which side of a surface is
/// outside, whatever the order of corners or parameters in a file, and whether the surface is closed.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/once.h"
#include "shapes/shape.h"

namespace bob {

/// A side of a surface, as a ray meets it.
struct Side {
    std::uint32_t part;  // parts have their sides in common: a connected piece of a mesh, a face
    bool is_front;       // the side that the part's own orientation takes for its outside
};

/// Finds the side at each hit.
using SidesOf = std::function<void(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> sides)>;

struct Solid {
    bool is_closed = false;            // all but 1 % of the lines cross the surface an even number of times
    bool overlaps = false;             // some points are inside several times
    std::vector<std::uint8_t> turned;  // of each part, whether its outside is at its back; empty if no part is turned
    Vec3 color{1, 1, 1};               // the most frequent colour of the surface

    /// Whether a ray enters the solid there.
    [[nodiscard]] bool is_entered(const Side& side) const { return side.is_front != (!turned.empty() && turned[side.part]); }
};

/// Finds the outside by lines that cross all parts. Each begins outside the unit sphere and has a direction of length 1.
[[nodiscard]] Solid find_solid(const Shape& shape, std::size_t parts, std::span<const Ray> lines, const SidesOf& sides);

/// A line through a point of the unit sphere, which turns with `number` about a normal of any length.
[[nodiscard]] Ray line_through(Vec3 point, Vec3 normal, std::uint32_t number);

/// A shape made of surfaces that may enclose a solid.
class SurfaceShape : public Shape {
public:
    [[nodiscard]] bool prepare_inside() const override;
    /// Where nothing overlaps, a ray that leaves first starts inside.
    void starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const override;
    /// The most frequent colour of the surface.
    void colors_inside(std::span<const Vec3> points, std::span<Vec3> colors) const override;

protected:
    using Shape::Shape;

    [[nodiscard]] virtual Solid find_solid() const = 0;
    /// The side at each hit.
    virtual void sides(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> sides) const = 0;

private:
    mutable Once<Solid> solid_;
};

}  // namespace bob
