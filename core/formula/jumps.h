/// Jumps taken out of formulas.
///
/// Repeated shapes are formulas with jumps: floor(x) within which everything else is computed. In a box with such a
/// jump the bounds mix both sides, and are useless. f = select(c, f before the jump, f after it) has the same values,
/// but each side is bounded by itself; they only meet on the surface c = 0.
#pragma once

#include <optional>

#include "base/work.h"
#include "formula/evaluate.h"
#include "formula/tape.h"

namespace bob {

/// The formula with every a mod b written as a - b floor(a / b).
[[nodiscard]] Expression without_modulo(const Expression& f);

/// A formula with the same signs and roots in the first of the boxes, in which up to three selects stand outside of
/// everything that jumps there; a constant where there is no root. Nothing if more roundings and angles jump there, or a
/// rounding between more than two numbers.
[[nodiscard]] std::optional<Expression> with_jumps_outside(const Tape& f, const BoxBatch& box, Work& work);

}  // namespace bob
