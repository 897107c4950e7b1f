/// Triangles of implicit surfaces, by dual contouring: a vertex in each cell of a lattice that the surface passes, where the
/// planes meet that touch the surface on the cell's edges, so that sharp edges and corners stay sharp.
///
/// Ju et al., "Dual contouring of hermite data" (SIGGRAPH 2002). A cell has a vertex for each sheet of the surface in it, as
/// in Nielson, "Dual marching cubes" (Visualization 2004), so that every edge belongs to exactly two triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shapes/implicit/implicit.h"

namespace bob {

/// The lattice's cells along an axis at most.
constexpr int max_lattice = 4096;

struct Triangulation {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<std::int32_t, 3>> triangles;  // anticlockwise seen from outside

    static constexpr std::size_t max_triangles = 1 << 25;
};

/// The closed surface of a shape, of cells of side `step`, in the shape's units: a sheet or a gap that is thinner may be lost
/// in part. Signs are looked up only in the shape's own cells, and roots only along edges whose ends differ. The same on any
/// number of threads.
///
/// Throws std::invalid_argument, saying why, if the lattice would have more than `max_lattice` cells along an axis or there
/// would be more than `max_triangles`, and Stopped if it is interrupted.
[[nodiscard]] Triangulation dual_contour(const Implicit& shape, double step);

}  // namespace bob
