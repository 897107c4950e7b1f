/// Traversal of rays through a grid of cells, from one occupied cell to the next.
#pragma once

#include <cstdint>
#include <limits>

#include "base/isa.h"
#include "shapes/shape.h"

namespace bob {

/// The cube -1..1, recursively subdivided into 4 x 4 x 4; empty regions are not subdivided.
struct CellGrid {
    static constexpr int levels = 4;
    static constexpr int side = 1 << (2 * levels);  // finest cells along an axis
    static constexpr std::int32_t empty = std::numeric_limits<std::int32_t>::max();
    static constexpr std::int32_t leaf(std::uint32_t cell) {
        return static_cast<std::int32_t>(cell) | std::numeric_limits<std::int32_t>::min();
    }
    static constexpr std::uint32_t cell(std::int32_t leaf) { return static_cast<std::uint32_t>(leaf) & 0x7fffffff; }

    /// Child x + 4 y + 16 z of node n is at 64 n + x + 4 y + 16 z: `empty`, another node, or, with the sign bit, a cell. Children of node 0,
    /// the cube, are never cells.
    const std::int32_t* children;

    /// The first two levels in one: grandchildren x + 16 y + 256 z; `all_empty` below an empty child.
    static constexpr int top_log2 = 4, top_side = 1 << top_log2;
    static constexpr std::int32_t all_empty = empty - 1;
    const std::int32_t* top;

    Vec3 low, high;  // bounds of all occupied cells
};

/// State of one ray, a row of a table that vectors access by columns (walk_kernels.cpp). t is in lengths of the ray's direction.
struct alignas(64) Walk {
    float origin[3], direction[3];  // the ray's
    float length;                   // of its direction
    float end;                      // t at the exit from the grid's box
    std::int32_t at[3];             // the finest cell that the ray is in
    std::int32_t size_log2;         // of the current occupied cell, in finest cells; -1 before the first
    float enter, leave;             // t at the cell's entry and exit
    std::uint32_t cell;             // `none` after the last
    std::int32_t unresolved;        // whether it may have passed a root

    static constexpr std::uint32_t none = 0xffffffff;
};

struct WalkKernels {
    /// Places each ray at its entry into the grid's box.
    void (*start)(const CellGrid& grid, const Ray* rays, std::size_t count, Walk* walks);

    /// Advances `count` walks, given by number, to their next occupied cells.
    ///
    /// Along the axis of the crossed face, integers determine the next cell. Along the other axes, the ray stays next to its last
    /// cell. So rounding never leaves a gap between cells.
    void (*next)(const CellGrid& grid, Walk* walks, const std::uint32_t* some, std::size_t count);
};

BOB_DECLARE_KERNELS(WalkKernels, walk_kernels)

}  // namespace bob
