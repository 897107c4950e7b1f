#include "formula/jumps.h"

#include <vector>

#include "formula/scratch.h"
#include "formula/tape.h"

namespace bob {
namespace {

constexpr int max_jumps = 3;
constexpr double pi = 3.14159265358979323846;

/// Where a formula jumps: its node `at` is `before` where `condition` < 0, else `after`.
struct Jump {
    std::uint32_t at;
    float low = 0;  // of a rounding: the number before or after the jump, whichever is lower
};

/// What a box tells of a formula.
struct Survey {
    enum { positive, negative, mixed } sign;
    Expression simpler;       // as far as the box decides
    std::optional<Jump> jump; // the first in `simpler` that the box leaves open
    bool other_jumps = false; // that can't be taken out
};

Survey survey(const Expression& f, BoxBatch box) {
    const FormulaKernels& kernels = best_formula_kernels();
    const auto decide = [&](const Tape& tape) {
        std::vector<Decision> decisions(tape.decisions().size());
        kernels.bounds(tape.code(), box, decisions.data(), scratch(tape.code().registers));
        return decisions;
    };
    const Tape tape(f);
    std::vector<Decision> decisions = decide(tape);
    if (box.least[0] >= 0 || box.nowhere & 1) return {Survey::positive, f, {}};
    if (box.most[0] < 0) return {Survey::negative, f, {}};
    Survey result{Survey::mixed, box.partly & 1 ? f : tape.specialised(decisions, 0), {}};

    decisions = decide(Tape(result.simpler));
    std::size_t next = 0;
    const std::vector<Node>& nodes = result.simpler.nodes();
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        if (!is_decision(nodes[i].op)) continue;
        const Decision& decision = decisions[next++];
        const bool first = decision.first & 1, second = decision.second & 1;
        if (nodes[i].op == Op::select && !first && !second) {
            if (!result.jump) result.jump = Jump{i};
        } else if (nodes[i].op == Op::atan2 && first) {
            if (!result.jump) result.jump = Jump{i};
        } else if (is_rounding(nodes[i].op) && !first) {
            if (!second) result.other_jumps = true;
            if (second && !result.jump) result.jump = Jump{i, decision.value[0]};
        }
    }
    return result;
}

/// What is negative before a jump, in a graph that holds the formula's nodes as `values`.
Value condition(const Node& node, const Jump& jump, const std::vector<Value>& values) {
    const Value a = values[node.operand[0]];
    const float threshold = node.op == Op::floor ? jump.low + 1 : node.op == Op::ceil ? jump.low : jump.low + 0.5f;
    return is_rounding(node.op) ? a - threshold : a;
}

/// The node that jumps, as it is on one side.
Value side(Graph& graph, const Node& node, const Jump& jump, const std::vector<Value>& values, bool before) {
    if (node.op == Op::select) return values[node.operand[before ? 1 : 2]];
    if (node.op == Op::atan2) {
        // The angle is counted from the cut, where it is small, and half a turn added or taken.
        return atan2(-values[node.operand[0]], -values[node.operand[1]]) + (before ? -pi : pi);
    }
    return graph.constant(before ? jump.low : jump.low + 1);
}

/// The formula on one side of a jump. There the sign of what a select asks for is known, of it and of what it is a multiple
/// of: absolute values and halves cut off at zero need no longer be asked.
Expression on_side(const Expression& f, const Jump& jump, bool before) {
    const std::vector<Node>& nodes = f.nodes();
    std::vector<int> sign(nodes.size(), 0);
    if (nodes[jump.at].op == Op::select) {
        std::uint32_t i = nodes[jump.at].operand[0];
        int known = before ? -1 : 1;
        sign[i] = known;
        while (nodes[i].op == Op::negate ||
               (nodes[i].op == Op::multiply && nodes[nodes[i].operand[1]].op == Op::constant)) {
            if (nodes[i].op == Op::negate || nodes[nodes[i].operand[1]].value < 0) known = -known;
            i = nodes[i].operand[0];
            sign[i] = known;
        }
    }
    Graph graph;
    std::vector<Value> values;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        const auto operand = [&](int k) { return k < operands(node.op) ? values[node.operand[k]] : Value{}; };
        const int known = operands(node.op) > 0 ? sign[node.operand[0]] : 0;
        const bool at_zero = operands(node.op) == 2 && nodes[node.operand[1]].op == Op::constant &&
                             nodes[node.operand[1]].value == 0;
        if (i == jump.at) {
            values.push_back(side(graph, node, jump, values, before));
        } else if (known && node.op == Op::absolute) {
            values.push_back(known < 0 ? -operand(0) : operand(0));
        } else if (known && node.op == Op::select) {
            values.push_back(operand(known < 0 ? 1 : 2));
        } else if (known && at_zero && (node.op == Op::minimum || node.op == Op::maximum)) {
            values.push_back(operand((known < 0) == (node.op == Op::minimum) ? 0 : 1));
        } else {
            values.push_back(graph.like(node, operand(0), operand(1), operand(2)));
        }
    }
    return graph.expression(values.back());
}

Value same(Graph& graph, const Expression& f) { return graph.substitute(f, graph.x(), graph.y(), graph.z()); }

std::optional<Value> taken_out(Graph& graph, const Expression& f, const BoxBatch& box, int jumps_left) {
    const Survey found = survey(f, box);
    if (found.sign != Survey::mixed) return graph.constant(found.sign == Survey::positive ? 1 : -1);
    if (found.other_jumps) return std::nullopt;
    if (!found.jump) return same(graph, found.simpler);
    if (jumps_left == 0) return std::nullopt;
    const auto before = taken_out(graph, on_side(found.simpler, *found.jump, true), box, jumps_left - 1);
    if (!before) return std::nullopt;
    const auto after = taken_out(graph, on_side(found.simpler, *found.jump, false), box, jumps_left - 1);
    if (!after) return std::nullopt;

    std::vector<Value> values;
    for (const Node& node : found.simpler.nodes()) {
        const auto operand = [&](int k) { return k < operands(node.op) ? values[node.operand[k]] : Value{}; };
        values.push_back(graph.like(node, operand(0), operand(1), operand(2)));
    }
    return select(condition(found.simpler.nodes()[found.jump->at], *found.jump, values), *before, *after);
}

}  // namespace

Expression without_modulo(const Expression& f) {
    Graph graph;
    std::vector<Value> values;
    for (const Node& node : f.nodes()) {
        const auto operand = [&](int k) { return k < operands(node.op) ? values[node.operand[k]] : Value{}; };
        values.push_back(node.op == Op::modulo ? operand(0) - operand(1) * floor(operand(0) / operand(1))
                                               : graph.like(node, operand(0), operand(1), operand(2)));
    }
    return graph.expression(values.back());
}

std::optional<Expression> with_jumps_outside(const Expression& f, const BoxBatch& box) {
    Graph graph;
    const auto value = taken_out(graph, f, box, max_jumps);
    if (!value) return std::nullopt;
    return graph.expression(*value);
}

}  // namespace bob
