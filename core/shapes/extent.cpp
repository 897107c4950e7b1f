#include "shapes/extent.h"

#include "shapes/brep.h"
#include "shapes/implicit.h"
#include "shapes/tube.h"

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

}  // namespace

Bounds Implicit::bounds(const AffineMap& map) const { return bounds_of(*this, map); }
Bounds Brep::bounds(const AffineMap& map) const { return bounds_of(*this, map); }
Bounds Tube::bounds(const AffineMap& map) const { return bounds_of(*this, map); }

double Implicit::radius(const AffineMap& map, const double center[3]) const { return radius_of(*this, map, center); }
double Brep::radius(const AffineMap& map, const double center[3]) const { return radius_of(*this, map, center); }
double Tube::radius(const AffineMap& map, const double center[3]) const { return radius_of(*this, map, center); }

}  // namespace bob
