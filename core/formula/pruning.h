/// Pruned code for a part of space, without branches never chosen there.
#pragma once

#include <cstddef>
#include <span>

#include "formula/tape.h"

namespace bob {

/// Number of decisions in code, as FormulaKernels::bounds writes them.
[[nodiscard]] std::size_t decision_count(const Code& code);

/// Writes code pruned by the `decisions` of box `lane` (from FormulaKernels::bounds). Each choice is replaced by its
/// outcome, and unused code is dropped.
///
/// Its one or three results are identical to the bit at all points of the box, unless the formula may be NaN there. Far
/// faster than rebuilding the formula, which drops a little more (Tape::specialised).
void prune(const Code& code, std::span<const int> results, std::span<const Decision> decisions, int lane, LoweredCode& to);

}  // namespace bob
