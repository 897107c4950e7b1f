/// Rays on their way through a grid of cells, from one occupied cell to the next.
#pragma once

#include <cstdint>
#include <limits>

#include "base/isa.h"
#include "shapes/shape.h"

namespace bob {

/// A cube, -1..1, cut into 4 x 4 x 4 again and again; what is not occupied is not cut further.
struct CellGrid {
    static constexpr int levels = 4;
    static constexpr int side = 1 << (2 * levels);  // finest cells along an axis
    static constexpr std::int32_t empty = std::numeric_limits<std::int32_t>::max();
    static constexpr std::int32_t leaf(std::uint32_t cell) {
        return static_cast<std::int32_t>(cell) | std::numeric_limits<std::int32_t>::min();
    }
    static constexpr std::uint32_t cell(std::int32_t leaf) { return static_cast<std::uint32_t>(leaf) & 0x7fffffff; }

    /// Child x + 4 y + 16 z of node n is at 64 n + x + 4 y + 16 z: `empty`, another node, or, with the sign bit, a cell. Those of node 0,
    /// the cube, are no cells.
    const std::int32_t* children;

    /// The first two cuts in one: the children of the children, x + 16 y + 256 z; where a child itself is empty, `all_empty`.
    static constexpr int top_log2 = 4, top_side = 1 << top_log2;
    static constexpr std::int32_t all_empty = empty - 1;
    const std::int32_t* top;

    Vec3 low, high;  // a box that holds all occupied cells
};

/// One ray's place on its way, a row of a table whose columns vectors read and write (walk_kernels.cpp). t counts in lengths of the ray's
/// direction.
struct alignas(64) Walk {
    float origin[3], direction[3];  // the ray's
    float length;                   // of its direction
    float end;                      // where it leaves the grid's box
    std::int32_t at[3];             // the finest cell that the ray is in
    std::int32_t size_log2;         // of the occupied cell around it, in finest ones; -1 before the first
    float enter, leave;             // where the ray enters and leaves that cell
    std::uint32_t cell;             // `none` after the last
    std::int32_t unresolved;        // whether it may have passed a root

    static constexpr std::uint32_t none = 0xffffffff;
};

struct WalkKernels {
    /// Puts each ray where it enters the grid's box.
    void (*start)(const CellGrid& grid, const Ray* rays, std::size_t count, Walk* walks);

    /// Takes the rays of some walks, `count` numbers, to their next occupied cells.
    ///
    /// Along the axis of the face that a ray crosses, whole numbers say which cell is behind it, and along the others the
    /// ray stays beside the cell it left: rounding never leaves a gap between two cells.
    void (*next)(const CellGrid& grid, Walk* walks, const std::uint32_t* some, std::size_t count);
};

BOB_DECLARE_KERNELS(WalkKernels, walk_kernels)

}  // namespace bob
