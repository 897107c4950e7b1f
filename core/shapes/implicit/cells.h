/// Cells of the cube -1..1 that may contain zeros of a formula, each with the formula simplified for it.
///
/// Interval arithmetic decides once, for every view, which cells are empty, and which branches of the formula the others
/// need (Duff, "Interval arithmetic and recursive subdivision for implicit functions and constructive solid
/// geometry", 1992; Keeter, "Massively parallel rendering of complex closed-form implicit surfaces", 2020).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/box.h"
#include "formula/evaluate.h"
#include "formula/tape.h"
#include "shapes/implicit/walk.h"

namespace bob {

class Cells {
public:
    /// Each level cuts a cell into 4 x 4 x 4.
    static constexpr int max_levels = CellGrid::levels;
    static constexpr int grid = CellGrid::side;  // finest cells along an axis
    static constexpr float finest = 2.f / grid;  // side of the finest cells
    static constexpr std::uint32_t max_cells = 1 << 21;

    /// Side of a level's cells, in finest cells.
    static constexpr int side(int level) { return grid >> (2 * level); }

    /// Maximum distance from the surface of a point that represents it in measurements of extent.
    static constexpr float tolerance = 0x1p-7f;

    /// Overlap of cells, and of ray segments in them, so that rounding loses nothing between two cells.
    static constexpr float margin = 0x1p-20f;

    /// Units of work (work.h) of building; the most intricate of the examples takes less than half of it.
    static constexpr std::uint64_t budget = 8'000'000'000;

    /// Stops subdividing when the budget is spent. Throws Stopped if interrupted.
    explicit Cells(const Expression& f);

    /// Whether the budget was spent: rays are still exact, but slow.
    [[nodiscard]] bool is_coarse() const { return is_coarse_; }

    struct Cell {
        std::uint32_t code;              // shared by cells with the same simplified formula
        std::array<std::uint8_t, 3> at;  // low corner, in finest cells
        std::uint8_t level;              // 1 to max_levels
        Vec3 least_slope, most_slope;    // bounds of the formula's gradient, per axis; NaN if unknown
    };
    [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
    [[nodiscard]] std::uint32_t codes() const { return static_cast<std::uint32_t>(codes_.size()); }
    [[nodiscard]] Code code(std::uint32_t code) const {
        const Stored& stored = codes_[code];
        return {instructions_.data() + stored.first, stored.count, stored.registers, stored.result, stored.may_jump};
    }
    /// Prefetches the code's instructions.
    void prefetch(std::uint32_t code) const {
        const Stored& stored = codes_[code];
        const Instruction *const first = instructions_.data() + stored.first, *const end = first + std::min(stored.count, most_prefetched);
        constexpr std::size_t line = 64 / sizeof(Instruction);  // at most a cache line
        for (const Instruction* i = first; i < end; i += line) __builtin_prefetch(i);
    }
    [[nodiscard]] static Box box(const Cell& cell);

    /// A box that contains all cells.
    [[nodiscard]] const Box& hull() const { return hull_; }

    /// A function of points: writes its value at each.
    using Function = std::function<void(std::span<const Vec3> points, double* values)>;

    /// The maximum of a convex function over the surface, or over points at most `tolerance` beyond it; -inf without a surface.
    [[nodiscard]] double maximum(const Function& convex) const;

    /// A set of points that contains the maximum of any convex function up to rounding, and of a linear function, with its
    /// products summed in order, to the bit. Throws Stopped if interrupted.
    [[nodiscard]] std::vector<std::array<double, 3>> outline() const;

    [[nodiscard]] int max_registers() const { return max_registers_; }
    [[nodiscard]] std::size_t bytes() const;

    /// The cells as a grid that rays walk through.
    [[nodiscard]] CellGrid grid_view() const { return {children_.data(), top_.data(), hull_.low, hull_.high}; }

private:
    Cells() = default;

    /// Reorders all codes for rays; decisions while cells are built need the order of the formula's nodes.
    void group_all_steps();

    /// Joins the first two levels.
    void make_top();

    class Builder;
    class Library;

    /// Number of prefetched instructions; hardware prefetches the following ones.
    static constexpr std::uint32_t most_prefetched = 64;

    struct Stored {
        std::uint32_t first, count;  // of the instructions
        std::uint16_t registers, result;
        bool may_jump;
    };

    std::vector<std::int32_t> children_;  // 64 to a node, the root's first; see CellGrid
    std::vector<std::int32_t> top_;       // of the whole, not of a subtree
    std::vector<Cell> cells_;
    std::vector<Stored> codes_;
    std::vector<Instruction> instructions_;
    Meshes meshes_;  // that the instructions name
    Box hull_;
    std::uint32_t max_code_ = 0;
    int max_registers_ = 3;
    bool is_coarse_ = false;
};

}  // namespace bob
