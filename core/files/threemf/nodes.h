/// Kinds of nodes in the functions of a 3MF.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "files/threemf/functions.h"

namespace bob::files::threemf {

/// A scalar, a vector of 3, a matrix of 4 by 4 in rows, or the id of a resource.
struct Operand {
    std::vector<Value> values;  // 1, 3 or 16; none for a resource
    std::string resource = {};
};

/// Values by name; a node's only output has the name "", since files have several names for it.
using Operands = std::map<std::string, Operand, std::less<>>;

constexpr std::size_t scalar = 1, vector = 3, matrix = 16;

/// Throws std::invalid_argument unless the operand has this many values.
void check_shape(const Operand& operand, std::size_t size);

/// A matrix times (x, y, z, 1), less the last component.
[[nodiscard]] Operand times(const Operand& matrix, const Operand& vector);

/// The outputs of a node whose kind needs neither meshes nor functions. Throws std::invalid_argument for other kinds, and for inputs
/// that are missing or have another shape.
[[nodiscard]] Operands outputs_of(Graph& graph, const FunctionNode& node, const Operands& inputs);

/// An input of a node. Throws MissingInput.
[[nodiscard]] const Operand& input(const Operands& inputs, std::string_view name);

/// Names an input or an attribute that a node lacks.
struct MissingInput {
    std::string name;
};

}  // namespace bob::files::threemf
