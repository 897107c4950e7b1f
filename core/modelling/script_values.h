/// Values of shape scripts and what can be done with them, by Python's rules. Errors are CallErrors: the interpreter
/// adds where they happened.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "modelling/script_syntax.h"
#include "modelling/vocabulary.h"

namespace bob::script {

struct List;

/// Numbers that are added and multiplied one by one, as numpy's arrays are: X, Y and Z are such, and what is computed
/// from them. Brackets make lists.
struct Vector {
    std::shared_ptr<const std::vector<double>> numbers;
};

struct Value {
    std::variant<None, bool, double, std::string_view, Vector, std::shared_ptr<const List>, Sdf, Easing> value;
};

/// A list or tuple; both are the same here, and never change.
struct List {
    std::vector<Value> items;
    int depth;         // 1 for a list without lists
    std::size_t size;  // the items of all lists within it, together
};

[[nodiscard]] Value make_list(std::vector<Value> items);
[[nodiscard]] Value make_vector(std::vector<double> numbers);

/// How much a value holds: 1 for a number.
[[nodiscard]] std::size_t size(const Value& value);

/// To the language's words and back.
[[nodiscard]] Object to_object(const Value& value);
[[nodiscard]] Value from_object(const Object& object);

[[nodiscard]] std::string describe(const Value& value);

/// What `if` makes of it.
[[nodiscard]] bool truth(const Value& value);

/// + - * / // % ** of numbers, vectors and lists; not of shapes.
[[nodiscard]] Value arithmetic(Operator op, const Value& a, const Value& b);
[[nodiscard]] Value negative(const Value& a);
[[nodiscard]] bool compare(Operator op, const Value& a, const Value& b);

/// Number of items of a list or vector, and one of them; `what` begins the message if it is neither.
[[nodiscard]] std::size_t length(std::string_view what, const Value& value);
[[nodiscard]] Value item(const Value& value, std::size_t index);

/// list[index] with Python's negative indices.
[[nodiscard]] Value element(const Value& list, const Value& index);

struct Function {
    std::string_view name;
    std::size_t least, most;  // number of arguments
    Value (*call)(std::string_view name, std::span<const Value> arguments);
};

/// Python's own functions and those of its math module that scripts have; nullptr where there is none.
[[nodiscard]] const Function* find_function(std::string_view name);

struct Constant {
    std::string_view name;
    Value value;
};
[[nodiscard]] std::span<const Constant> constants();

}  // namespace bob::script
