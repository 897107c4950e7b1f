/// The colours of a formula's surface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "formula/tape.h"
#include "shapes/implicit/cells.h"

namespace bob {

/// The colour's formula, pruned for each box of a grid: a box needs few of many shapes.
class Painting {
public:
    /// Prunes the formula, in coordinates of the unit sphere, for the boxes that have cells.
    Painting(ColorTape tape, const Cells& cells);

    /// Linear RGB, 0..1, at each point, independent of the other points; input and output may share memory.
    void operator()(std::span<const Vec3> points, std::span<Vec3> colors) const;

    [[nodiscard]] std::size_t bytes() const;

private:
    /// Boxes along an axis, on the two levels of the cells.
    static constexpr int side = 16;

    struct Program {
        std::size_t first, count;  // instructions
        int registers;
        std::array<int, 3> results;
    };
    /// The number of a part equal to `code`, from the part `first` on; added if it is new.
    std::uint32_t number_of(const LoweredCode& code, std::uint32_t first);
    [[nodiscard]] std::uint32_t part_at(Vec3 point) const;

    ColorTape tape_;
    std::vector<Instruction> instructions_;
    std::vector<Program> parts_;          // the first is the whole
    std::vector<std::uint32_t> part_in_;  // of each box
};

}  // namespace bob
