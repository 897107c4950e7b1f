#include "shapes/implicit/extent.h"

#include "shapes/brep/brep.h"
#include "shapes/implicit/implicit.h"
#include "shapes/tube/tube.h"

namespace bob {
namespace {

template <class S>
Bounds bounds_of(const S& shape, const AffineMap& map) {
    double bounds[2][3];
    placed_bounds(shape, (map * from_unit_sphere(shape.sphere())).row[0], bounds[0]);
    const auto& [low, high] = bounds;
    return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

template <class S>
double radius_of(const S& shape, const AffineMap& map, const double center[3]) {
    const AffineMap from_unit = map * from_unit_sphere(shape.sphere());
    return placed_radius(shape, from_unit.row[0], center, singular_values(from_unit)[0]);
}

/// `placed_bounds` and `placed_radius`, with the same rounding.
Bounds bounds_of(const PointTree& outline, const AffineMap& from_unit) {
    Bounds bounds = outline.bounds(from_unit);
    for (int axis = 0; axis < 3; ++axis) {
        const double scale = stretch(from_unit.row[axis]);
        for (double* end : {&bounds.low[axis], &bounds.high[axis]}) *end = scale * (*end / scale);
    }
    return bounds;
}

double radius_of(const PointTree& outline, const AffineMap& from_unit, const double center[3]) {
    const double scale = singular_values(from_unit)[0];
    return scale * outline.farthest(from_unit, center, [&](const PointTree::Point& p) {
        return length(p[0] - center[0], p[1] - center[1], p[2] - center[2]) / scale;
    });
}

}  // namespace

void Implicit::prepare_places() const {
    outline_.prepare([&] { return cells_.outline(); });
}

Bounds Implicit::bounds(const AffineMap& map) const {
    if (const PointTree* const outline = outline_.get()) return bounds_of(*outline, map * from_unit_sphere(sphere()));
    return bounds_of(*this, map);
}
Bounds Brep::bounds(const AffineMap& map) const { return bounds_of(*this, map); }
Bounds Tube::bounds(const AffineMap& map) const { return bounds_of(*this, map); }

double Implicit::radius(const AffineMap& map, const double center[3]) const {
    if (const PointTree* const outline = outline_.get()) return radius_of(*outline, map * from_unit_sphere(sphere()), center);
    return radius_of(*this, map, center);
}
double Brep::radius(const AffineMap& map, const double center[3]) const { return radius_of(*this, map, center); }
double Tube::radius(const AffineMap& map, const double center[3]) const { return radius_of(*this, map, center); }

}  // namespace bob
