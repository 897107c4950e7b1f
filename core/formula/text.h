/// Expressions as people write them.
#pragma once

#include <cstddef>
#include <string>

#include "formula/expression.h"

namespace bob {

/// The formula in Python's notation, such as "x**2 + sin(y) - 0.5"; what is longer than `length` characters, or nested
/// too deeply to be read, is cut to "...".
[[nodiscard]] std::string to_text(const Expression& expression, std::size_t length = 200);

}  // namespace bob
