/// Shape scripts: text that makes one shape, in a subset of Python's syntax with the words of vocabulary.h. Python and
/// the browser both run scripts here; docs/scripts.md describes the language.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "modelling/vocabulary.h"

namespace bob {

/// A position in a script, from 1; columns are characters, not bytes.
struct Position {
    int line = 1;
    int column = 1;
};

/// An error in a script, in one line that starts with "line L, column C: ".
struct ScriptError : std::invalid_argument {
    ScriptError(Position at, const std::string& message);
    Position at;
};

/// The limits of a script, far above the needs of shapes: they stop endless scripts and excessive memory.
struct ScriptLimits {
    static constexpr std::size_t bytes = 1 << 20;     // of text
    static constexpr int depth = 100;                 // nesting of brackets, blocks and operators
    static constexpr std::size_t steps = 1'000'000;   // expressions evaluated
    static constexpr std::size_t items = 100'000;     // in a list, including nested lists
    static constexpr std::size_t nodes = 10'000'000;  // of all shapes that a script makes, together
};

/// Runs a script and returns its result: the three-dimensional shape of the last executed assignment, expression or
/// .save(). A script has no input or output, and the same text always gives the same shape. Any bytes end in a shape or
/// a ScriptError.
[[nodiscard]] Sdf run_script(std::string_view source);

}  // namespace bob
