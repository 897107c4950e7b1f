/// Formulas ready to be evaluated: an expression, or that of a colour, and the code that computes it.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "formula/evaluate.h"
#include "formula/expression.h"

namespace bob {

/// What lowering makes of nodes.
struct LoweredCode {
    [[nodiscard]] Code code() const { return {instructions.data(), instructions.size(), registers, results[0], may_jump}; }

    std::vector<Instruction> instructions;
    std::vector<Op> decisions;
    std::vector<std::uint32_t> decision_nodes;
    int registers = 3;
    bool may_jump = false;
    std::array<int, 3> results{};  // the registers of the roots, of which there is one or three
};

/// Puts the steps of a formula's code into an order in which those of one op follow each other where they can, and says how many
/// registers that takes and where the result is then. Processors guess the next step by those before it, and lose as much time as
/// several steps take where they are wrong; and steps side by side of which none needs another overlap. Of all rays, those of a knob
/// take .85 of the time, of a weave .87, of letters .96; of 5 %, .96, .95 and .90.
void group_steps(std::span<Instruction> code, int& registers, int& result);

class Tape {
public:
    explicit Tape(Expression expression);

    /// What is left out within box `lane`, as bytes: where they are the same, so is what is specialised. Empty where nothing
    /// is, or where more than a share of the nodes is still needed.
    [[nodiscard]] std::vector<std::uint8_t> left_out(std::span<const Decision> decisions, int lane, double share) const;

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
    [[nodiscard]] Code code() const { return code_.code(); }
    /// The ops that are decisions, in the order in which evaluation comes to them.
    [[nodiscard]] const std::vector<Op>& decisions() const { return code_.decisions; }
    /// And which nodes of the expression they are.
    [[nodiscard]] const std::vector<std::uint32_t>& decision_nodes() const { return code_.decision_nodes; }

private:
    struct Memory;
    void find_needed(Memory& memory, std::span<const Decision> decisions, int lane, std::uint32_t node) const;

    Expression expression_;
    LoweredCode code_;
};

class ColorTape {
public:
    explicit ColorTape(const ColorFormula& formula);

    [[nodiscard]] Code code() const { return code_.code(); }
    /// The registers that hold red, green and blue at the end.
    [[nodiscard]] const std::array<int, 3>& results() const { return code_.results; }
    [[nodiscard]] std::size_t bytes() const { return code_.instructions.size() * sizeof(Instruction); }

private:
    LoweredCode code_;
    Meshes meshes_;
};

}  // namespace bob
