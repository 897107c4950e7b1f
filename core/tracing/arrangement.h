/// Shapes as users place them, in any units: how far they reach, and the scene that rays meet.
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
    AffineMap transform;                 // from the shape's own units to the arrangement's; not singular
    Material material;
};

class Arrangement {
public:
    /// Measures the shapes, each once in a place. Throws std::invalid_argument where there is none, or where all of them lie
    /// in one point or beyond what numbers hold.
    explicit Arrangement(std::vector<Placed> shapes);

    /// About the centre of the common bounding box, to the farthest point.
    [[nodiscard]] const Sphere& sphere() const { return sphere_; }

    [[nodiscard]] std::size_t size() const { return shapes_.size(); }
    [[nodiscard]] const Bounds& bounds(std::size_t i) const { return places_[place_[i]].bounds; }

    /// Prepares the shapes, and puts them in the unit sphere, in the order of their digests if there are any.
    [[nodiscard]] Scene scene(std::span<const Digest> digests = {}) const;

    [[nodiscard]] const Placed& operator[](std::size_t i) const { return shapes_[i]; }

    /// A shape in one place, where it may stand in several materials.
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
