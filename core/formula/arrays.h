/// Formulas as arrays, as files hold them and bindings pass them on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formula/expression.h"

namespace bob {

/// ops: (n,), operands: (n, 3), values: (n,).
[[nodiscard]] inline std::vector<Node> nodes_of(const std::uint8_t* ops, const std::uint32_t* operands, const double* values,
                                                std::size_t count) {
    std::vector<Node> nodes(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t* operand = operands + 3 * i;
        nodes[i] = {static_cast<Op>(ops[i]), {operand[0], operand[1], operand[2]}, values[i]};
    }
    return nodes;
}

}  // namespace bob
