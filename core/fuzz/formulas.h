/// What is done with a formula, wherever it came from.
#pragma once

#include <optional>
#include <stdexcept>

#include "formula/expression.h"
#include "fuzz/fuzz.h"
#include "fuzz/rays.h"
#include "interruption.h"
#include "shapes/bounds.h"
#include "shapes/implicit.h"

namespace fuzz {

/// Boxes and cells that building may look at: some milliseconds of work, and for most formulas as much as they need.
constexpr int patience = 1000;

/// The bounds of a formula; nothing where it has none, or where they take too long.
inline std::optional<bob::Bounds> bounds_of(const bob::Expression& f) {
    const bob::Interruption impatience(Patience{patience});
    try {
        return bob::find_bounds(f);
    } catch (const std::invalid_argument&) {  // unbounded
    } catch (const bob::Stopped&) {
    }
    return std::nullopt;
}

/// Builds the surface of a formula within a box, and meets it with some rays.
inline void trace(const bob::Expression& f, const bob::Bounds& box, Source& source) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(in_range(box.low[axis]) && in_range(box.high[axis]) && box.low[axis] < box.high[axis])) return;
    }
    const bob::Interruption impatience(Patience{patience});
    try {
        const bob::Implicit shape(f, box);
        if (!shape.cells().cells().empty()) meet(shape, box, source, 8);
    } catch (const bob::Stopped&) {
    } catch (const bob::TooLarge&) {
    }
}

}  // namespace fuzz
