/// Moves jumps to the outside of formulas.
///
/// Repeated shapes are formulas with jumps: everything else is computed within floor(x). In a box with that jump the
/// bounds mix both sides and are useless. f = select(c, f before the jump, f after it) has the same values, but each
/// side is bounded separately; they only meet on the surface c = 0.
#pragma once

#include <optional>

#include "base/work.h"
#include "formula/evaluate.h"
#include "formula/tape.h"

namespace bob {

/// The formula with every a mod b replaced by a - b floor(a / b).
[[nodiscard]] Expression without_modulo(const Expression& f);

/// A formula with the same signs and roots in the first box. Up to three selects are outside everything that jumps
/// there. A constant if there is no root. Empty if more roundings and angles jump there, or a rounding takes more than
/// two values.
[[nodiscard]] std::optional<Expression> with_jumps_outside(const Tape& f, const BoxBatch& box, Work& work);

}  // namespace bob
