/// The solid of a .vm file's formula; such files have no bounds.
#pragma once

#include <optional>

#include "shapes/implicit/bounds.h"

namespace bob {

struct VmSolid {
    Expression formula;
    std::optional<Bounds> bounds;  // empty if the formula is positive everywhere
    bool cut;                      // whether the formula extends beyond the bounds
};

/// A bounded formula is kept whole; an unbounded one is cut by the cube from -1 to 1, as in fidget. A formula
/// without z is flat: it becomes an extrusion of height 0.1 about z = 0, cut by the square from -1 to 1.
/// Throws Stopped if interrupted.
[[nodiscard]] VmSolid vm_solid(const Expression& f);

}  // namespace bob
