/// .vm files: formulas as text, one operation per line, as written by fidget and related programs.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "formula/expression.h"

namespace bob {

/// An error in a .vm text, in one line that starts with "line L: ".
struct VmError : std::invalid_argument {
    VmError(int line, const std::string& message);
    int line;  // from 1
};

/// Reads lines `NAME OPERATION ARGUMENT...`. Arguments are names of earlier lines, and the last line is the formula. A
/// repeated name refers to its latest line. Empty lines and lines that start with # are ignored. The operations, with
/// fidget's meanings (`Context::from_text`):
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
/// Everything propagates NaN, which fidget's `and`, `or` and `not` do not. Throws VmError.
[[nodiscard]] Expression parse_vm(std::string_view text);

}  // namespace bob
