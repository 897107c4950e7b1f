/// Expressions as readable text.
#pragma once

#include <cstddef>
#include <string>

#include "formula/expression.h"

namespace bob {

/// The formula in Python's notation, such as "x**2 + sin(y) - 0.5". Parts beyond `length` characters, or nested too
/// deeply to read, are cut to "...".
[[nodiscard]] std::string to_text(const Expression& expression, std::size_t length = 200);

}  // namespace bob
