/// Formulas ready to be evaluated: an expression and the code that computes it.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "formula/evaluate.h"
#include "formula/expression.h"

namespace bob {

class Tape {
public:
    explicit Tape(Expression expression);

    /// The formula within box `lane`, where less needs to be computed: what is never chosen is left out.
    [[nodiscard]] Expression specialised(std::span<const Decision> decisions, int lane) const;

    /// A node that becomes something else than its op of its operands.
    struct Instead {
        std::uint32_t node;
        std::function<Value(const Value* operands)> make;
    };
    /// The same of one of the nodes, in a graph.
    [[nodiscard]] Value specialised(Graph& graph, std::span<const Decision> decisions, int lane, std::uint32_t node,
                                    const Instead* instead = nullptr) const;

    /// Of each decision, whether what it decides is still needed within box `lane`.
    [[nodiscard]] std::vector<bool> are_needed(std::span<const Decision> decisions, int lane) const;

    [[nodiscard]] const Expression& expression() const { return expression_; }
    [[nodiscard]] Code code() const { return {code_.data(), code_.size(), registers_, result_}; }
    /// The ops that are decisions, in the order in which evaluation comes to them.
    [[nodiscard]] const std::vector<Op>& decisions() const { return decisions_; }
    /// And which nodes of the expression they are.
    [[nodiscard]] const std::vector<std::uint32_t>& decision_nodes() const { return decision_nodes_; }

private:
    struct Memory;
    void find_needed(Memory& memory, std::span<const Decision> decisions, int lane, std::uint32_t node) const;

    Expression expression_;
    std::vector<Instruction> code_;
    std::vector<Op> decisions_;
    std::vector<std::uint32_t> decision_nodes_;
    int registers_ = 3;
    int result_ = 0;
};

}  // namespace bob
