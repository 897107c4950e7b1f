/// Integrals over the trimmed faces of NURBS surfaces: areas, and the terms of volumes.
#pragma once

#include <array>
#include <span>

#include "nurbs/nurbs.h"
#include "nurbs/trim.h"

namespace bob {

/// Integrals over a face. n is the unit normal along dS/du x dS/dv, x the position.
struct Moments {
    double area = 0;
    std::array<double, 3> normal{};    // of n
    std::array<double, 9> position{};  // of x n^T, row by row. Over a closed surface it is the volume times the identity.
    std::array<double, 2> inside{};    // (u, v) of a point of the face, far from its borders
};

/// The moments of a surface within its loops, as in TrimRegion: inside are the points that an odd number of loops surround.
///
/// By Green's theorem each is an integral along the loops of an integral along u, both by adaptive Gauss-Kronrod quadrature
/// between knots. Errors are near 1e-9 of the face's squared size, unless the surface is singular. Weights are above 0.
[[nodiscard]] Moments moments(const NurbsSurface& surface, std::span<const TrimLoop> loops);

}  // namespace bob
