#include "formula/jumps.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <vector>

#include "base/thread_memory.h"
#include "formula/scratch.h"
#include "formula/sequenced.h"

namespace bob {
namespace {

constexpr int max_jumps = 3;

/// Cost of each node: it is bounded, tested for need, and copied if needed.
constexpr std::uint64_t units_of_survey = 40;
using std::numbers::pi;

enum class Sign { positive, negative, mixed };

/// Decisions of a tape assumed on one side of a jump, by number.
using Given = std::map<std::size_t, Decision>;

/// A jump of a formula.
struct Jump {
    std::size_t decision;  // its number
    float low = 0;         // of a rounding: the lower of the numbers before and after the jump
};

/// The decisions and jumps of a formula in a box.
struct Survey {
    Sign sign = Sign::mixed;
    std::vector<Decision> decisions;
    std::optional<Jump> jump;   // an undecided one; preferably a rounding or an angle, else a select
    bool is_select = false;     // the jump is a select's
    bool other_jumps = false;   // that cannot be moved outside
};

/// Number of decisions of an instruction; a corner has two, first its maximum's.
int decisions_of(const Instruction& step) { return step.op == corner_distance ? 2 : is_decision(step.op) ? 1 : 0; }

/// Replaces an instruction by the outcome of its decision.
void settle(Instruction& step, const Decision& outcome) {
    const bool first = outcome.first & 1;
    if (is_rounding(step.op)) {
        step.offset = outcome.value[0];
        step.op = Op::constant;
        return;
    }
    step.scale = step.op == Op::absolute && !first ? -1.f : 1.f;
    if (is_select(step.op)) step.a = first ? step.b : step.c;
    if (step.op == Op::minimum || step.op == Op::maximum) step.a = first ? step.a : step.b;
    step.op = affine;
}

/// Bounds in the first box, and its decisions under given ones.
std::vector<Decision> bounds(const Tape& tape, const Given& given, BoxBatch& box) {
    std::vector<Decision> decisions(tape.decisions().size());
    const FormulaKernels& kernels = best_formula_kernels();
    const Code code = tape.code();
    if (given.empty()) {
        kernels.bounds(code, box, decisions.data(), scratch(code.registers));
        return decisions;
    }
    struct Memory {
        std::vector<Instruction> settled;
    };
    std::vector<Instruction>& settled = thread_memory<Memory>().settled;
    settled.assign(code.instructions, code.instructions + code.count);
    std::vector<bool> is_settled(decisions.size(), false);
    std::size_t at = 0;
    for (Instruction& step : settled) {
        const int count = decisions_of(step);
        if (count == 1) {
            if (const auto outcome = given.find(at); outcome != given.end()) {
                settle(step, outcome->second);
                is_settled[at] = true;
            }
        }
        at += static_cast<std::size_t>(count);
    }
    kernels.bounds({settled.data(), settled.size(), code.registers, code.result, code.may_jump}, box, decisions.data(), scratch(code.registers));
    // The kernel does not report settled decisions.
    auto told = decisions.size() - static_cast<std::size_t>(std::count(is_settled.begin(), is_settled.end(), true));
    for (at = decisions.size(); at-- > 0;) {
        if (!is_settled[at]) decisions[at] = decisions[--told];
    }
    for (const auto& [number, outcome] : given) decisions[number] = outcome;
    return decisions;
}

/// The undecided jumps of a box.
void find_jumps(const Tape& tape, Survey& survey) {
    const std::vector<bool> is_needed = tape.are_needed(survey.decisions, 0);
    std::optional<Jump> of_select;
    for (std::size_t at = 0; at < survey.decisions.size(); ++at) {
        const Op op = tape.decisions()[at];
        const Decision& decision = survey.decisions[at];
        if (!may_jump(op) || !is_needed[at] || is_decided(op, decision, 0)) continue;
        const bool first = decision.first & 1, second = decision.second & 1;
        if (op == Op::select) {
            if (!of_select) of_select = Jump{at};
        } else if (op == Op::atan2) {
            if (first && !survey.jump) survey.jump = Jump{at};
        } else {
            survey.other_jumps = survey.other_jumps || !second;
            if (second && !survey.jump) survey.jump = Jump{at, decision.value[0]};
        }
    }
    survey.is_select = !survey.jump && of_select;
    if (!survey.jump) survey.jump = of_select;
}

Survey survey(const Tape& tape, const Given& given, BoxBatch box, Work& work) {
    work.spend(units_of_survey * tape.expression().nodes().size());
    Survey result;
    result.decisions = bounds(tape, given, box);
    if (box.least[0] >= 0 || box.nowhere & 1) {
        result.sign = Sign::positive;
    } else if (box.most[0] < 0) {
        result.sign = Sign::negative;
    } else {
        find_jumps(tape, result);
    }
    if (box.partly & 1) {
        // Only given decisions may prune: the operand of a maximum that is never taken may still be NaN.
        for (std::size_t at = 0; at < result.decisions.size(); ++at) {
            if (!given.contains(at)) result.decisions[at] = {};
        }
    }
    return result;
}

/// An expression that is negative before a jump of a node with first operand `a`.
Value condition(Op op, const Jump& jump, Value a) {
    const float threshold = op == Op::floor ? jump.low + 1 : op == Op::ceil ? jump.low : jump.low + 0.5f;
    return is_rounding(op) ? a - threshold : a;
}

/// The decisions on one side of a jump of a rounding or a select, added to `given`. The sign of a select's condition is
/// known there. So is the sign of the value that the condition is a multiple of, which decides absolute values and
/// halves cut off at zero.
Given on_side(const Tape& tape, Given given, const Jump& jump, bool before) {
    const std::vector<Node>& nodes = tape.expression().nodes();
    const auto choice = [](bool first) { return Decision{first ? 1u : 0u, first ? 0u : 1u, {}}; };
    const std::uint32_t jumping = tape.decision_nodes()[jump.decision];
    if (nodes[jumping].op != Op::select) {
        given[jump.decision] = {1, 0, {before ? jump.low : jump.low + 1}};
        return given;
    }
    std::map<std::uint32_t, bool> is_negative;  // of nodes with known sign
    std::uint32_t i = nodes[jumping].operand[0];
    bool negative = is_negative[i] = before;
    while (nodes[i].op == Op::negate || (nodes[i].op == Op::multiply && nodes[nodes[i].operand[1]].op == Op::constant)) {
        if (nodes[i].op == Op::negate || nodes[nodes[i].operand[1]].value < 0) negative = !negative;
        i = nodes[i].operand[0];
        is_negative[i] = negative;
    }
    for (std::size_t at = 0; at < tape.decisions().size(); ++at) {
        const Op op = tape.decisions()[at];
        const Node& node = nodes[tape.decision_nodes()[at]];
        if (op == corner_distance || op == Op::atan2 || is_rounding(op)) continue;
        const auto sign = is_negative.find(node.operand[0]);
        if (sign == is_negative.end()) continue;
        if (op == Op::absolute) given[at] = choice(!sign->second);
        if (is_select(op)) given[at] = choice(sign->second);
        if ((op == Op::minimum || op == Op::maximum) && nodes[node.operand[1]].op == Op::constant && nodes[node.operand[1]].value == 0) {
            given[at] = choice(sign->second == (op == Op::minimum));
        }
    }
    return given;
}

/// The formula on one side of the cut of an angle. The angle is measured from the cut, where it is small, plus or minus
/// half a turn.
Expression beside_cut(const Tape& tape, const Survey& found, bool before) {
    thread_local Graph graph;
    const Graph::Reused reused(graph);
    const Tape::Instead instead{tape.decision_nodes()[found.jump->decision], [&](const Value* operand) {
                                    const Value across = -operand[1];
                                    return atan2(-operand[0], across) + (before ? -pi : pi);
                                }};
    const auto last = static_cast<std::uint32_t>(tape.expression().nodes().size() - 1);
    return graph.expression(tape.specialised(graph, found.decisions, 0, last, &instead));
}

/// A formula without inner jumps, and its sign if the box determines it.
struct Apart {
    Value value;
    Sign sign;
};

std::optional<Apart> taken_out(Graph& graph, const Tape& f, const Given& given, const BoxBatch& box, int jumps_left, Work& work) {
    const Survey found = survey(f, given, box, work);
    const auto value_of = [&](std::uint32_t node) { return f.specialised(graph, found.decisions, 0, node); };
    const auto last = static_cast<std::uint32_t>(f.expression().nodes().size() - 1);
    // Selects beyond the limit stay inside: most selects in practice do not jump. Even with a known sign the formula is
    // still needed for its slope: a jump from below zero to above is a surface with a normal.
    if (found.sign != Sign::mixed || (jumps_left == 0 && found.is_select)) return Apart{value_of(last), found.sign};
    const Op op = found.jump ? f.decisions()[found.jump->decision] : Op::constant;
    // Next to the cut of an angle, its values round to far fewer numbers.
    if (found.other_jumps && op != Op::atan2) return std::nullopt;
    if (!found.jump) return Apart{value_of(last), found.sign};
    if (jumps_left == 0) return std::nullopt;

    const auto side = [&](bool before) {
        if (op == Op::atan2) return taken_out(graph, Tape(beside_cut(f, found, before)), {}, box, jumps_left - 1, work);
        return taken_out(graph, f, on_side(f, given, *found.jump, before), box, jumps_left - 1, work);
    };
    const auto before = side(true);
    if (!before) return std::nullopt;
    const auto after = side(false);
    if (!after) return std::nullopt;
    const Node& jumping = f.expression().nodes()[f.decision_nodes()[found.jump->decision]];
    const Value jumps_at = condition(op, *found.jump, value_of(jumping.operand[0]));
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
    thread_local Graph graph;
    const Graph::Reused reused(graph);
    const auto apart = taken_out(graph, f, {}, box, max_jumps, work);
    if (!apart) return std::nullopt;
    if (apart->sign == Sign::mixed) return graph.expression(apart->value);
    return graph.expression(graph.constant(apart->sign == Sign::positive ? 1 : -1));
}

}  // namespace bob
