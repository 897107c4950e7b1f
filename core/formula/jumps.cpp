#include "formula/jumps.h"

#include <vector>

#include "formula/scratch.h"
#include "formula/sequenced.h"

namespace bob {
namespace {

constexpr int max_jumps = 3;

/// Of each node: bounded, simplified, copied and made instructions of.
constexpr std::uint64_t units_of_survey = 150;
constexpr double pi = 3.14159265358979323846;

/// Where a formula jumps: its node `at` is `before` where `condition` < 0, else `after`.
struct Jump {
    std::uint32_t at;
    float low = 0;  // of a rounding: the number before or after the jump, whichever is lower
};

enum class Sign { positive, negative, mixed };

/// What a box shows about a formula.
struct Survey {
    Sign sign;
    Expression simpler;         // as far as the box decides
    std::optional<Jump> jump;   // in `simpler`: one that the box leaves open, a rounding or an angle rather than a select
    bool is_select = false;     // the jump is that of a select
    bool other_jumps = false;   // that can't be taken out
};

/// The jumps that a box leaves open.
void find_jumps(const Tape& tape, const std::vector<Decision>& decisions, Survey& survey) {
    std::optional<Jump> of_select;
    for (std::size_t at = 0; at < decisions.size(); ++at) {
        const Op op = tape.decisions()[at];
        const std::uint32_t i = tape.decision_nodes()[at];
        const Decision& decision = decisions[at];
        const bool first = decision.first & 1, second = decision.second & 1;
        if (op == Op::select && !first && !second) {
            if (!of_select) of_select = Jump{i};
        } else if (op == Op::atan2 && first) {
            if (!survey.jump) survey.jump = Jump{i};
        } else if (is_rounding(op) && !first) {
            survey.other_jumps = survey.other_jumps || !second;
            if (second && !survey.jump) survey.jump = Jump{i, decision.value[0]};
        }
    }
    survey.is_select = !survey.jump && of_select;
    if (!survey.jump) survey.jump = of_select;
}

Survey survey(const Tape& tape, BoxBatch box, Work& work) {
    const Expression& f = tape.expression();
    std::vector<Decision> decisions;
    const auto decide = [&](const Tape& tape) {
        decisions.assign(tape.decisions().size(), {});
        best_formula_kernels().bounds(tape.code(), box, decisions.data(), scratch(tape.code().registers));
    };
    work.spend(units_of_survey * f.nodes().size());
    decide(tape);
    if (box.least[0] >= 0 || box.nowhere & 1) return {Sign::positive, f, {}};
    if (box.most[0] < 0) return {Sign::negative, f, {}};
    Survey result{Sign::mixed, f, {}};
    if (!(box.partly & 1)) {
        result.simpler = tape.specialised(decisions, 0);
        if (!(result.simpler == f)) {
            const Tape simpler(result.simpler);
            decide(simpler);
            find_jumps(simpler, decisions, result);
            return result;
        }
    }
    find_jumps(tape, decisions, result);
    return result;
}

/// What is negative before a jump of a node whose first operand is `a`.
Value condition(const Node& node, const Jump& jump, Value a) {
    const float threshold = node.op == Op::floor ? jump.low + 1 : node.op == Op::ceil ? jump.low : jump.low + 0.5f;
    return is_rounding(node.op) ? a - threshold : a;
}

/// The node that jumps, as it is on one side.
Value side(Graph& graph, const Node& node, const Jump& jump, const Value* operand, bool before) {
    if (node.op == Op::select) return operand[before ? 1 : 2];
    if (node.op == Op::atan2) {
        // The angle is counted from the cut, where it is small, and half a turn added or taken.
        const Value across = -operand[1];
        return atan2(-operand[0], across) + (before ? -pi : pi);
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
    const std::vector<Value> values = graph.rebuild(f, [&](std::uint32_t i, const Value* operand) {
        const Node& node = nodes[i];
        if (i == jump.at) return side(graph, node, jump, operand, before);
        const int known = operands(node.op) > 0 ? sign[node.operand[0]] : 0;
        if (known && node.op == Op::absolute) return known < 0 ? -operand[0] : operand[0];
        if (known && node.op == Op::select) return operand[known < 0 ? 1 : 2];
        if (known && (node.op == Op::minimum || node.op == Op::maximum) &&
            nodes[node.operand[1]].op == Op::constant && nodes[node.operand[1]].value == 0) {
            return operand[(known < 0) == (node.op == Op::minimum) ? 0 : 1];
        }
        return graph.like(node, operand);
    });
    return graph.expression(values.back());
}

/// A formula without inner jumps, and its sign where the box shows it.
struct Apart {
    Value value;
    Sign sign;
};

std::optional<Apart> taken_out(Graph& graph, const Tape& f, const BoxBatch& box, int jumps_left, Work& work) {
    const Survey found = survey(f, box, work);
    // Selects that are too many stay inside: most that people write do not jump at all. Where the sign is known, the
    // formula is still asked for its slope: what jumps from below zero to above is a surface with a normal.
    if (found.sign != Sign::mixed || (jumps_left == 0 && found.is_select)) {
        return Apart{graph.copy(found.simpler), found.sign};
    }
    if (found.other_jumps) return std::nullopt;
    if (!found.jump) return Apart{graph.copy(found.simpler), found.sign};
    if (jumps_left == 0) return std::nullopt;
    const auto before = taken_out(graph, Tape(on_side(found.simpler, *found.jump, true)), box, jumps_left - 1, work);
    if (!before) return std::nullopt;
    const auto after = taken_out(graph, Tape(on_side(found.simpler, *found.jump, false)), box, jumps_left - 1, work);
    if (!after) return std::nullopt;

    const std::vector<Node>& nodes = found.simpler.nodes();
    const std::vector<Value> values = graph.rebuild(
        found.simpler, [&](std::uint32_t i, const Value* operand) { return graph.like(nodes[i], operand); });
    const Node& jumping = nodes[found.jump->at];
    const Value jumps_at = condition(jumping, *found.jump, values[jumping.operand[0]]);
    return Apart{select(jumps_at, before->value, after->value),
                 before->sign == after->sign ? before->sign : Sign::mixed};
}

}  // namespace

Expression without_modulo(const Expression& f) {
    Graph graph;
    const std::vector<Value> values = graph.rebuild(f, [&](std::uint32_t i, const Value* operand) {
        const Node& node = f.nodes()[i];
        if (node.op == Op::modulo) return operand[0] - operand[1] * floor(operand[0] / operand[1]);
        return graph.like(node, operand);
    });
    return graph.expression(values.back());
}

std::optional<Expression> with_jumps_outside(const Tape& f, const BoxBatch& box, Work& work) {
    Graph graph;
    const auto apart = taken_out(graph, f, box, max_jumps, work);
    if (!apart) return std::nullopt;
    if (apart->sign == Sign::mixed) return graph.expression(apart->value);
    return graph.expression(graph.constant(apart->sign == Sign::positive ? 1 : -1));
}

}  // namespace bob
