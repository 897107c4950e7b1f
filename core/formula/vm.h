/// .vm files: formulas as text, one operation a line, as fidget and its kin write them.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "formula/expression.h"

namespace bob {

/// What is wrong with a .vm text, in one line that starts with "line L: ".
struct VmError : std::invalid_argument {
    VmError(int line, const std::string& message);
    int line;  // from 1
};

/// Reads lines `NAME OPERATION ARGUMENT...`; arguments are names of lines above, and the last line is the formula. A
/// name that stands twice means its latest line. Empty lines and those that start with # count for nothing. The
/// operations, with the meanings they have in fidget (`Context::from_text`):
///
///     const NUMBER                    var-x var-y var-z
///     neg abs recip sqrt square       sin cos tan asin acos atan exp ln
///     floor ceil                      round   halves away from zero
///     add sub mul div min max         atan2 y x
///     mod a b     the remainder of a / b that is not negative
///     compare a b     -1, 0 or 1 as a is less than, equal to or greater than b
///     not a       1 where a is 0, else 0
///     and a b     a where a is 0, else b
///     or a b      a where a is not 0, else b
///
/// Everything passes NaN on, which fidget's `and`, `or` and `not` do not. Throws VmError.
[[nodiscard]] Expression parse_vm(std::string_view text);

}  // namespace bob
