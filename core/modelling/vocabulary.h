/// The words of the modelling language, each declared once, as data. They are shapes, operations on shapes and easing
/// functions, with the names and meanings of fogleman/sdf. Python, shape scripts and the documentation are generated
/// from this table.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "formula/expression.h"

namespace bob {

/// A shape of the language: inside where its expression is negative. In two dimensions, an expression in x and y.
struct Sdf {
    int dimensions = 3;
    std::shared_ptr<const Expression> expression;
    std::optional<double> k;  // the radius of smooth blends with this shape, set by .k(); only .color() keeps it
    std::shared_ptr<const ColorFormula> color;  // of its surface; null if it has no colour
};

/// A function of one number t, stored as an expression in x.
struct Easing {
    std::shared_ptr<const Expression> expression;
};

/// A colour for each point.
struct Color {
    std::shared_ptr<const ColorFormula> formula;
};

struct None {
    friend bool operator==(None, None) = default;
};

/// A value of the language. A vector is a list of numbers.
struct Object {
    using List = std::vector<Object>;
    std::variant<None, bool, double, std::string, Sdf, Easing, Color, std::shared_ptr<const List>> value;
};

enum class Type {
    number,
    integer,  // a whole number
    vector,   // two numbers in two dimensions, three in three
    size,     // a number, for all axes, or a vector
    numbers,  // a number, or one for each axis or corner, as the meaning says
    points,   // a list of vectors
    easing,
    color,    // "#rrggbb", three numbers of linear RGB, or a Color
    sdf,      // of the word's own dimensions
};

struct Parameter {
    std::string_view name;
    Type type;
    std::optional<Object> default_value;  // empty: required; None: optional
    bool variadic = false;                // takes all further positional arguments, in Python's notation *name
};

class Arguments;  // the arguments of a call, checked and in the order of the parameters

struct Word {
    enum class Kind {
        shape,      // makes a shape
        operation,  // takes a shape first: a function and a method of the same name
        easing,
    };
    std::string_view name;
    Kind kind;
    int dimensions;         // of the shapes it takes, or makes if it is a shape; 0 for easings
    int result_dimensions;  // of the shape it makes
    std::vector<Parameter> parameters;
    std::string_view meaning;  // one line
    Object (*call)(const Arguments&);
};

/// All words. A name may occur twice, once for each number of dimensions.
[[nodiscard]] std::span<const Word> vocabulary();

/// nullptr if the name is unknown. `dimensions` is 0 for easings; for shapes and operations, 0 means 3, or 2 if the
/// name has no meaning in three.
[[nodiscard]] const Word* find_word(std::string_view name, int dimensions);

/// An error in a call, in one line: word, parameter, expected, got.
struct CallError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An argument of the wrong type, or one too many or too few.
struct CallTypeError : CallError {
    using CallError::CallError;
};

using Keyword = std::pair<std::string, Object>;

/// Calls a word like a Python function; throws CallError, or TooLarge.
///
/// An operation called with a shape of other dimensions becomes the operation of that name for these, if there is one.
/// An easing called with a number is a number; without it, the Easing itself. Colours do not change the shape's
/// expression: it is the same, node by node.
[[nodiscard]] Object call(const Word& word, std::span<const Object> positional, std::span<const Keyword> keywords);

/// Calls the method `name` of a shape: the operation of that name for shapes of its dimensions, or `k`.
[[nodiscard]] Object call_method(const Sdf& sdf, std::string_view name, std::span<const Object> positional,
                                 std::span<const Keyword> keywords);

/// a | b, a & b and a - b of shapes: union, intersection and difference.
[[nodiscard]] Object combine(char op, const Sdf& a, const Sdf& b);

/// A short name of an object's type for messages, such as "a number" or "a 2D shape".
[[nodiscard]] std::string describe(const Object& object);

}  // namespace bob
