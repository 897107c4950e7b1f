/// Extent of shapes after a map; for curved pieces, from maxima of convex functions over them.
#pragma once

#include <cmath>
#include <span>

#include "base/parallel.h"
#include "shapes/brep/brep.h"
#include "shapes/implicit/implicit.h"
#include "shapes/tube/tube.h"

namespace bob {

/// The maximum of f(centre, radius) over the shape's balls, which are points except in tubes. f is convex and has a Lipschitz
/// constant of 1, so 1e-3 is relative to the shape's size.
template <class F>
double maximum(const Implicit& shape, F f) {
    return shape.cells().maximum([&](std::span<const Vec3> points, double* values) {
        for (const Vec3 p : points) *values++ = f(p, 0.f);
    });
}
template <class F>
double maximum(const Brep& shape, F f) {
    return shape.maximum([&](Vec3 p) { return f(p, 0.f); }, 1e-3);
}
template <class F>
double maximum(const Tube& shape, F f) {
    return shape.maximum(f);
}

/// Operator norm of a map to one coordinate.
inline double stretch(const double* row) { return std::hypot(row[0], row[1], row[2]); }

inline double mapped(const double* row, Vec3 p) { return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3]; }

/// std::hypot, but fast if squares stay in range.
inline double length(double x, double y, double z) {
    const double square = x * x + y * y + z * z;
    return square > 1e-280 && square < 1e280 ? std::sqrt(square) : std::hypot(x, y, z);
}

/// The lowest and the highest coordinates, in `bounds` (2, 3), of a shape placed by `map`, (3, 4) row by row.
template <class S>
void placed_bounds(const S& shape, const double* map, double* bounds) {
    parallel_for(6, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double* row = map + 4 * (i % 3);
            const double sign = i < 3 ? -1 : 1, scale = stretch(row);
            bounds[i] = sign * scale * maximum(shape, [=](Vec3 center, float radius) {
                return sign * mapped(row, center) / scale + static_cast<double>(radius);
            });
        }
    });
}

/// The distance from `center` to the farthest point of a shape placed by `map`, whose largest singular value is given. For
/// a tube, it is too large by at most the ratio of the singular values, since mapped balls are replaced by enclosing spheres.
template <class S>
double placed_radius(const S& shape, const double* map, const double* center, double largest_singular_value) {
    const double scale = largest_singular_value;
    return scale * maximum(shape, [=](Vec3 p, float radius) {
        return length(mapped(map, p) - center[0], mapped(map + 4, p) - center[1], mapped(map + 8, p) - center[2]) / scale +
               static_cast<double>(radius);
    });
}

}  // namespace bob
