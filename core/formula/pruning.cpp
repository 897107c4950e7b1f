#include "formula/pruning.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/thread_memory.h"
#include "formula/registers.h"

namespace bob {
namespace {

/// An instruction. Its operands are registers of the pruned code at first, then numbers of values.
struct Step {
    Instruction instruction;
    bool passes_on = false;  // operand 0 unchanged
    std::uint32_t operand[3] = {};
};

int decisions_of(Op op) { return op == corner_distance ? 2 : is_decision(op) ? 1 : 0; }

/// The remainder of an instruction in a box.
Step left_of(const Instruction& instruction, const Decision* decision, int lane) {
    Step step{instruction, false, {instruction.a, instruction.b, instruction.c}};
    if (decisions_of(instruction.op) == 0) return step;
    const auto is = [lane](std::uint32_t lanes) { return (lanes >> lane & 1) != 0; };
    const bool first = is(decision->first), second = is(decision->second);
    const auto passes_on = [&](std::uint16_t operand) { step.passes_on = true, step.operand[0] = operand; };
    const Op op = instruction.op;
    if (op == Op::minimum || op == Op::maximum) {
        if (first || second) passes_on(first ? instruction.a : instruction.b);
    } else if (is_select(op)) {
        if (first || second) passes_on(first ? instruction.b : instruction.c);
    } else if (op == Op::absolute) {
        if (first) passes_on(instruction.a);
        else if (second) step.instruction.op = affine, step.instruction.scale = -1, step.instruction.offset = 0;
    } else if (op == corner_distance) {
        if (first || second) passes_on(first ? instruction.a : instruction.b);
        else if (is(decision[1].first)) step.instruction.op = Op::maximum;
        else if (is(decision[1].second)) step.instruction.op = Op::hypot;
    } else if (is_rounding(op) && first) {
        step.instruction.op = Op::constant, step.instruction.offset = decision->value[lane];
    }
    return step;
}

}  // namespace

std::size_t decision_count(const Code& code) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < code.count; ++i) count += static_cast<std::size_t>(decisions_of(code.instructions[i].op));
    return count;
}

void prune(const Code& code, std::span<const int> results, std::span<const Decision> decisions, int lane, LoweredCode& to) {
    struct Memory {
        std::vector<std::uint8_t> is_needed;          // registers
        std::vector<std::uint32_t> value_in;          // registers
        std::vector<Step> steps;                      // in reverse order, then in order
        std::vector<std::uint32_t> last_use;          // of values
        std::vector<std::uint16_t> place;             // of values
    };
    auto& [is_needed, value_in, steps, last_use, place] = thread_memory<Memory>();

    is_needed.assign(static_cast<std::size_t>(code.registers), 0);
    for (const int result : results) is_needed[static_cast<std::size_t>(result)] = 1;
    steps.clear();
    std::size_t at = decisions.size();
    for (std::size_t i = code.count; i-- > 0;) {
        const Instruction& instruction = code.instructions[i];
        at -= static_cast<std::size_t>(decisions_of(instruction.op));
        if (!is_needed[instruction.out]) continue;
        is_needed[instruction.out] = 0;
        const Step& step = steps.emplace_back(left_of(instruction, decisions.data() + at, lane));
        const int count = step.passes_on ? 1 : operands_of(step.instruction.op);
        for (int k = 0; k < count; ++k) is_needed[step.operand[k]] = 1;
    }
    std::ranges::reverse(steps);

    // A passed-on value exists already.
    value_in.assign(static_cast<std::size_t>(code.registers), never_used);
    std::uint32_t values = 3;
    for (std::uint32_t axis = 0; axis < values; ++axis) value_in[axis] = axis;
    std::size_t kept = 0;
    for (Step& step : steps) {
        const std::uint16_t out = step.instruction.out;
        if (step.passes_on) {
            value_in[out] = value_in[step.operand[0]];
            continue;
        }
        for (int k = 0; k < operands_of(step.instruction.op); ++k) step.operand[k] = value_in[step.operand[k]];
        value_in[out] = values++;
        steps[kept++] = step;
    }
    steps.resize(kept);

    last_use.assign(values, never_used);
    for (const int result : results) last_use[value_in[static_cast<std::size_t>(result)]] = values;
    for (std::uint32_t i = values; i-- > 3;) {
        const Step& step = steps[i - 3];
        for (int k = 0; k < operands_of(step.instruction.op); ++k) {
            std::uint32_t& last = last_use[step.operand[k]];
            if (last == never_used) last = i;
        }
    }
    Registers registers;
    place.resize(values);
    for (std::uint16_t axis = 0; axis < 3; ++axis) place[axis] = axis;
    to.instructions.clear();
    for (std::uint32_t i = 3; i < values; ++i) {
        const Step& step = steps[i - 3];
        Instruction& instruction = to.instructions.emplace_back(step.instruction);
        std::uint16_t* const slots[3] = {&instruction.a, &instruction.b, &instruction.c};
        const int count = operands_of(instruction.op);
        for (int k = 0; k < 3; ++k) *slots[k] = k < count ? place[step.operand[k]] : std::uint16_t{0};
        for (int k = 0; k < count; ++k) {
            const std::uint32_t operand = step.operand[k];
            if (operand > 2 && last_use[operand] == i) registers.give_back(place[operand]), last_use[operand] = never_used;
        }
        instruction.out = place[i] = registers.take();
    }
    to.registers = registers.count();
    for (std::size_t k = 0; k < results.size(); ++k) to.results[k] = place[value_in[static_cast<std::size_t>(results[k])]];
}

}  // namespace bob
