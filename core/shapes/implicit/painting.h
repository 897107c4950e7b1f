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

/// In the boxes of a grid, what is left of a colour's formula there: of many shapes each box needs few.
class Painting {
public:
    /// Of the formula in the unit sphere, in the boxes that have cells.
    Painting(ColorTape tape, const Cells& cells);

    /// Linear RGB, 0..1, at each point, which does not depend on the others; both may be in one place.
    void operator()(std::span<const Vec3> points, std::span<Vec3> colors) const;

    [[nodiscard]] std::size_t bytes() const;

private:
    /// Boxes along an axis: on two levels, as the cells have them.
    static constexpr int side = 16;

    struct Part {
        std::size_t first, count;  // instructions
        int registers;
        std::array<int, 3> results;
    };
    /// The number of a part that is as `code` is, added where there is none from the part `first` on.
    std::uint32_t number_of(const LoweredCode& code, std::uint32_t first);
    [[nodiscard]] std::uint32_t part_at(Vec3 point) const;

    ColorTape tape_;
    std::vector<Instruction> instructions_;
    std::vector<Part> parts_;             // the first is the whole
    std::vector<std::uint32_t> part_in_;  // of each box
};

}  // namespace bob
