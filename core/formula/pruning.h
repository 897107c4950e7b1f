/// Code for a part of space, without what is never chosen there.
#pragma once

#include <cstddef>
#include <span>

#include "formula/tape.h"

namespace bob {

/// How many decisions code has, as FormulaKernels::bounds writes them.
[[nodiscard]] std::size_t decision_count(const Code& code);

/// Writes what is left of code within box `lane` of those that `decisions` are of (FormulaKernels::bounds): what is always chosen stands
/// in the place of the choice, and what is never chosen is left out. Its results, of which there are one or three, are the same to the bit at
/// all points of the box, unless it may be NaN there.
///
/// Far faster than to make the formula anew, which leaves out a little more (Tape::specialised).
void prune(const Code& code, std::span<const int> results, std::span<const Decision> decisions, int lane, LoweredCode& to);

}  // namespace bob
