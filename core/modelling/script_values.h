/// Values of shape scripts and their operations, by Python's rules. Errors are CallErrors; the interpreter adds their
/// positions.
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

/// Numbers with elementwise arithmetic, like numpy's arrays: X, Y and Z, and values computed from them. Brackets make
/// lists.
struct Vector {
    std::shared_ptr<const std::vector<double>> numbers;
};

struct Value {
    std::variant<None, bool, double, std::string_view, Vector, std::shared_ptr<const List>, Sdf, Easing> value;
};

/// A list or tuple, with no difference between them; immutable.
struct List {
    std::vector<Value> items;
    int depth;         // 1 for a list without lists
    std::size_t size;  // the number of items, including nested lists
};

[[nodiscard]] Value make_list(std::vector<Value> items);
[[nodiscard]] Value make_vector(std::vector<double> numbers);

/// The size of a value: 1 for a number.
[[nodiscard]] std::size_t size(const Value& value);

/// Conversion to and from the vocabulary's objects.
[[nodiscard]] Object to_object(const Value& value);
[[nodiscard]] Value from_object(const Object& object);

[[nodiscard]] std::string describe(const Value& value);

/// The truth of a value for `if`.
[[nodiscard]] bool truth(const Value& value);

/// + - * / // % ** of numbers, vectors and lists; not of shapes.
[[nodiscard]] Value arithmetic(Operator op, const Value& a, const Value& b);
[[nodiscard]] Value negative(const Value& a);
[[nodiscard]] bool compare(Operator op, const Value& a, const Value& b);

/// Number of items of a list or vector, and one item; `what` begins the message if the value is neither.
[[nodiscard]] std::size_t length(std::string_view what, const Value& value);
[[nodiscard]] Value item(const Value& value, std::size_t index);

/// list[index] with Python's negative indices.
[[nodiscard]] Value element(const Value& list, const Value& index);

struct Function {
    std::string_view name;
    std::size_t least, most;  // number of arguments
    Value (*call)(std::string_view name, std::span<const Value> arguments);
};

/// A supported function of Python or its math module; nullptr for any other name.
[[nodiscard]] const Function* find_function(std::string_view name);

struct Constant {
    std::string_view name;
    Value value;
};
[[nodiscard]] std::span<const Constant> constants();

}  // namespace bob::script
