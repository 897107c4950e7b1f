/// Shapes as users place them, in any units: their extent, and the scene for rays.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/affine.h"
#include "tracing/canonical.h"
#include "tracing/scene.h"

namespace bob {

struct Placed {
    std::shared_ptr<const Shape> shape;  // may be placed several times
    AffineMap transform;                 // from the shape's units to the arrangement's; not singular
    Material material;
};

class Arrangement {
public:
    /// Measures each shape once per place. Throws std::invalid_argument if there are no shapes or too many, if all
    /// lie in one point, or if they exceed the range of numbers.
    explicit Arrangement(std::vector<Placed> shapes);

    /// About the centre of the common bounding box, to the farthest point.
    [[nodiscard]] const Sphere& sphere() const { return sphere_; }

    [[nodiscard]] std::size_t size() const { return shapes_.size(); }
    [[nodiscard]] const Bounds& bounds(std::size_t i) const { return places_[place_[i]].bounds; }

    /// Prepares the shapes and maps them to the unit sphere, in the order of `digests` if given.
    [[nodiscard]] Scene scene(std::span<const Digest> digests = {}) const;

    [[nodiscard]] const Placed& operator[](std::size_t i) const { return shapes_[i]; }

    /// A shape in one place, possibly with several materials.
    struct Place {
        const Shape* shape;
        AffineMap transform;
        Bounds bounds;
    };

private:
    void measure();
    [[nodiscard]] AffineMap to_shape(const Place& place) const;

    std::vector<Placed> shapes_;
    std::vector<Place> places_;
    std::vector<std::size_t> place_;  // of each shape
    Sphere sphere_;
};

}  // namespace bob
