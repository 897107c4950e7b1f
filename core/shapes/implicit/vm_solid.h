/// What a .vm file's formula is the solid of: such files do not say where to look.
#pragma once

#include <optional>

#include "shapes/implicit/bounds.h"

namespace bob {

struct VmSolid {
    Expression formula;
    std::optional<Bounds> bounds;  // nothing where the formula is positive everywhere
    bool cut;                      // whether the formula would go on beyond the bounds
};

/// A bounded formula is taken whole; one without bounds is cut by the cube from -1 to 1, which fidget views. A formula
/// without z is flat: it becomes an extrusion of height 0.1 about z = 0, cut by the square from -1 to 1.
/// Throws Stopped where it shall not go on.
[[nodiscard]] VmSolid vm_solid(const Expression& f);

}  // namespace bob
