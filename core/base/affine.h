/// Affine maps of space.
#pragma once

#include <array>

#include "base/vec.h"

namespace bob {

/// x -> A x + b, as the rows of (A | b); initially the identity. In double precision: the map from a scene to a small
/// shape far from the scene's centre takes the difference of large numbers.
struct AffineMap {
    double row[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

    bool operator==(const AffineMap&) const = default;

    /// The image of the point origin + t direction.
    [[nodiscard]] Vec3 point(Vec3 origin, double t, Vec3 direction) const {
        const double x = origin.x + t * direction.x, y = origin.y + t * direction.y, z = origin.z + t * direction.z;
        Vec3 result;
        for (int i = 0; i < 3; ++i) {
            const auto& r = row[i];
            result[i] = static_cast<float>(r[0] * x + r[1] * y + r[2] * z + r[3]);
        }
        return result;
    }

    [[nodiscard]] Vec3 direction(Vec3 d) const {
        Vec3 result;
        for (int i = 0; i < 3; ++i) {
            result[i] = static_cast<float>(row[i][0] * d.x + row[i][1] * d.y + row[i][2] * d.z);
        }
        return result;
    }

    /// The unit normal at x of a surface with the normal `n` at A x + b. Multiplies by the transpose of A, the inverse
    /// transpose of the inverse map; zero if `n` is zero.
    [[nodiscard]] Vec3 normal_back(Vec3 n) const {
        double v[3];
        for (int i = 0; i < 3; ++i) v[i] = row[0][i] * n.x + row[1][i] * n.y + row[2][i] * n.z;
        const double size = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        if (!(size > 0)) return {};
        return {static_cast<float>(v[0] / size), static_cast<float>(v[1] / size), static_cast<float>(v[2] / size)};
    }
};

/// The map of a row-major 4x4 matrix with last row (0, 0, 0, 1).
[[nodiscard]] AffineMap affine_map(const double* matrix);

/// The composition: first b, then a.
[[nodiscard]] AffineMap operator*(const AffineMap& a, const AffineMap& b);

/// The inverse of a nonsingular map. Exact if A is diagonal with powers of two.
[[nodiscard]] AffineMap inverse(const AffineMap& map);

/// The singular values of A, the largest first; small ones have the same relative accuracy as large ones.
[[nodiscard]] std::array<double, 3> singular_values(const AffineMap& map);

struct Sphere {
    double center[3] = {};
    double radius = 1;
};

/// The map from a sphere to the unit sphere, and its inverse.
[[nodiscard]] AffineMap to_unit_sphere(const Sphere& sphere);
[[nodiscard]] AffineMap from_unit_sphere(const Sphere& sphere);

}  // namespace bob
