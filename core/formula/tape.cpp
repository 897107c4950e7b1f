#include "formula/tape.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/thread_memory.h"
#include "formula/mesh_distance.h"
#include "formula/registers.h"

namespace bob {
namespace {

bool is_axis(Op op) { return op == Op::x || op == Op::y || op == Op::z; }

/// A node as an instruction, with node numbers in place of registers.
struct Lowered {
    Op op;
    std::uint32_t operand[3];
    double scale = 0, offset = 0;
};

/// The distances whose corner a node is, as the modelling words write it (modelling/words.h): select(min(a, b), max(a,
/// b), hypot(max(a, 0), max(b, 0))). Boxes may simplify the maxima with 0 to a or b.
std::optional<std::array<std::uint32_t, 2>> corner_of(const std::vector<Node>& nodes, const Node& node) {
    if (node.op != Op::select) return std::nullopt;
    const Node &least = nodes[node.operand[0]], &most = nodes[node.operand[1]], &far = nodes[node.operand[2]];
    if (least.op != Op::minimum || most.op != Op::maximum || far.op != Op::hypot) return std::nullopt;
    const std::uint32_t a = most.operand[0], b = most.operand[1];  // in the order of the decisions
    const auto are = [](const Node& pair, std::uint32_t p, std::uint32_t q) {
        return pair.operand[0] == p && pair.operand[1] == q;
    };
    if (!are(least, a, b) && !are(least, b, a)) return std::nullopt;
    const auto beyond_zero = [&](std::uint32_t of, std::uint32_t i) {
        const Node& half = nodes[i];
        const auto zero = [&](int k) {
            const Node& other = nodes[half.operand[k]];
            return other.op == Op::constant && other.value == 0;
        };
        return i == of || (half.op == Op::maximum && ((half.operand[0] == of && zero(1)) || (half.operand[1] == of && zero(0))));
    };
    const std::uint32_t u = far.operand[0], v = far.operand[1];
    const bool is_corner = (beyond_zero(a, u) && beyond_zero(b, v)) || (beyond_zero(b, u) && beyond_zero(a, v));
    return is_corner ? std::optional(std::array{a, b}) : std::nullopt;
}

/// Merges sums and products with constants, also in a chain, into one affine step, and corners into one step. Written
/// in place, number by number: a copy would wait for the stores before it.
void lower(const std::vector<Node>& nodes, std::uint32_t i, Lowered& to) {
    const Node& node = nodes[i];
    const auto is_constant = [&](int k) { return nodes[node.operand[k]].op == Op::constant; };
    const auto value = [&](int k) { return nodes[node.operand[k]].value; };
    const auto becomes = [&](Op op, std::uint32_t a, std::uint32_t b, double scale, double offset) {
        to.op = op;
        to.operand[0] = a, to.operand[1] = b, to.operand[2] = node.operand[2];
        to.scale = scale, to.offset = offset;
    };
    const auto [a, b, c] = node.operand;
    switch (node.op) {
        case Op::constant: return becomes(node.op, 0, 0, 0, node.value);
        case Op::power: return becomes(node.op, a, 0, node.value, 0);
        case Op::negate: return becomes(affine, a, 0, -1, 0);
        case Op::multiply:
            if (is_constant(1)) return becomes(affine, a, 0, value(1), 0);
            break;
        case Op::subtract:
            if (is_constant(0)) return becomes(affine, b, 0, -1, value(0));
            break;
        case Op::add:
            if (is_constant(1)) {
                const Node& left = nodes[a];
                if (left.op == Op::multiply && nodes[left.operand[1]].op == Op::constant) {
                    return becomes(affine, left.operand[0], 0, nodes[left.operand[1]].value, value(1));
                }
                return becomes(affine, a, 0, 1, value(1));
            }
            break;
        case Op::select:
            if (const auto sides = corner_of(nodes, node)) return becomes(corner_distance, (*sides)[0], (*sides)[1], 0, 0);
            if (node.value == meets) return becomes(piecewise_select, a, b, 0, 0);
            break;
        default: break;
    }
    becomes(node.op, a, b, 0, 0);
}

/// Powers below 1 occur in plain nodes, but not in a Graph.
template <class Formula>
bool has_low_powers(const Formula& f) {
    const auto low = [](const Node& node) { return node.op == Op::power && node.value < 1; };
    return std::any_of(f.nodes().begin(), f.nodes().end(), low);
}

/// Replaces them by quotients.
Expression without_low_powers(Expression f) {
    if (!has_low_powers(f)) return f;
    Graph graph;
    return graph.expression(graph.copy(f));
}
ColorFormula without_low_powers(const ColorFormula& f) {
    if (!has_low_powers(f)) return f;
    Graph graph;
    const Value x = graph.x(), y = graph.y(), z = graph.z();
    return graph.color_formula(graph.substitute(f, x, y, z));
}

LoweredCode lowered(const std::vector<Node>& nodes, std::span<const std::uint32_t> roots) {
    const auto count = static_cast<std::uint32_t>(nodes.size());
    LoweredCode result;

    struct Memory {
        std::vector<Lowered> steps;
        std::vector<std::uint32_t> last_use;
        std::vector<std::uint16_t> place;
    };
    auto& [steps, last_use, place] = thread_memory<Memory>();

    // The last use of each node; lowering skips nodes without a use.
    if (steps.size() < count) steps.resize(count);
    last_use.assign(count, never_used);
    for (const std::uint32_t root : roots) last_use[root] = count;
    for (std::uint32_t i = count; i-- > 0;) {
        if (last_use[i] == never_used) continue;
        lower(nodes, i, steps[i]);
        for (int k = 0; k < operands_of(steps[i].op); ++k) {
            std::uint32_t& last = last_use[steps[i].operand[k]];
            if (last == never_used) last = i;
        }
    }

    Registers registers;
    place.resize(count);
    result.instructions.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (last_use[i] == never_used) continue;
        const Lowered& step = steps[i];
        if (is_axis(step.op)) {
            place[i] = static_cast<std::uint16_t>(static_cast<int>(step.op) - static_cast<int>(Op::x));
            continue;
        }
        Instruction& instruction = result.instructions.emplace_back();
        instruction.op = step.op;
        instruction.scale = static_cast<float>(step.scale), instruction.offset = static_cast<float>(step.offset);
        if (step.op == Op::mesh_distance) set_mesh(instruction, MeshDistance::numbered(nodes[i].value).get());
        std::uint16_t* const slots[3] = {&instruction.a, &instruction.b, &instruction.c};
        for (int k = 0; k < operands_of(step.op); ++k) *slots[k] = place[step.operand[k]];
        // The result may take an operand's register: every step reads its operands before it writes.
        for (int k = 0; k < operands_of(step.op); ++k) {
            const std::uint32_t operand = step.operand[k];
            if (last_use[operand] == i && place[operand] > 2) {
                registers.give_back(place[operand]);
                last_use[operand] = never_used;  // once only, if it occurs twice among the operands
            }
        }
        instruction.out = place[i] = registers.take();
        const auto decides = [&](Op op, std::uint32_t node) {
            result.decisions.push_back(op), result.decision_nodes.push_back(node);
        };
        if (step.op == corner_distance) decides(Op::maximum, nodes[i].operand[1]);
        if (is_decision(step.op)) decides(step.op, i);
        result.may_jump = result.may_jump || may_jump(step.op);
    }
    result.registers = registers.count();
    for (std::size_t i = 0; i < roots.size(); ++i) result.results[i] = place[roots[i]];
    return result;
}

/// Groups steps of equal op where their dependencies allow.
class Groups {
public:
    /// Reorders the code and allocates registers, each reused as soon as possible. Leaves the order unchanged if it
    /// needs too many.
    void form(std::span<Instruction> code, int& registers, int& result) {
        const auto count = static_cast<std::uint32_t>(code.size());
        before_.assign(code.begin(), code.end());
        find_operands(registers, result);
        order_.clear();
        while (order_.size() < count) {
            // Takes the op with the largest number of ready steps, and its steps that become ready meanwhile.
            int most = 0;
            for (std::uint64_t left = ops_; left; left &= left - 1) {
                const int op = __builtin_ctzll(left);
                if (ready_[op].size() > ready_[most].size()) most = op;
            }
            while (!ready_[most].empty()) {
                const std::uint32_t i = ready_[most].back();
                ready_[most].pop_back();
                order_.push_back(i);
                for (const std::uint32_t operand : steps_[i].operand) last_use_[operand] = i;
                for (std::uint32_t k = steps_[i].users_begin; k < steps_[i].users_end; ++k) {
                    if (--steps_[users_[k]].missing == 0) add(users_[k]);
                }
            }
            ops_ &= ~(std::uint64_t{1} << most);
        }
        last_use_[last_] = count;
        Registers taken;
        for (std::uint32_t at = 0; at < count; ++at) {
            const std::uint32_t i = order_[at];
            Instruction& to = code[at] = before_[i];
            std::uint16_t* const slots[3] = {&to.a, &to.b, &to.c};
            for (int k = 0; k < operands_of(to.op); ++k) {
                if (steps_[i].operand[k] != none_) *slots[k] = place_[steps_[i].operand[k]];
            }
            for (const std::uint32_t operand : steps_[i].operand) {
                if (operand == none_ || last_use_[operand] != i) continue;
                taken.give_back(place_[operand]);
                last_use_[operand] = never_used;  // once only, if it occurs twice among the operands
            }
            to.out = place_[i] = taken.take();
            if (taken.count() > most_registers) {
                std::copy(before_.begin(), before_.end(), code.begin());
                return;
            }
        }
        registers = taken.count();
        if (last_ != none_) result = place_[last_];
    }

private:
    /// Values computed long before their use occupy registers; this number of the widest vectors for rays fits the
    /// first-level cache.
    static constexpr int most_registers = 128;

    struct Step {
        std::uint32_t operand[3];  // the steps that compute them; none_ for x, y and z
        std::uint32_t users_begin, users_end;
        std::uint32_t missing;     // number of operands not computed yet
    };

    void find_operands(int registers, int result) {
        none_ = static_cast<std::uint32_t>(before_.size());
        steps_.assign(none_ + 1, {{none_, none_, none_}, 0, 0, 0}), place_.resize(none_ + 1), last_use_.assign(none_ + 1, never_used);
        writer_.assign(static_cast<std::size_t>(registers), none_);
        for (std::uint32_t i = 0; i < none_; ++i) {
            const Instruction& from = before_[i];
            const std::uint16_t slots[3] = {from.a, from.b, from.c};
            for (int k = 0; k < operands_of(from.op); ++k) {
                const std::uint32_t operand = steps_[i].operand[k] = writer_[slots[k]];
                if (operand != none_) ++steps_[operand].users_end, ++steps_[i].missing;
            }
            writer_[from.out] = i;
        }
        last_ = writer_[static_cast<std::size_t>(result)];
        std::uint32_t sum = 0;
        for (std::uint32_t i = 0; i < none_; ++i) {
            steps_[i].users_begin = sum;
            sum += std::exchange(steps_[i].users_end, sum);
        }
        users_.resize(sum);
        for (std::uint32_t i = none_; i-- > 0;) {
            for (const std::uint32_t operand : steps_[i].operand) {
                if (operand != none_) users_[steps_[operand].users_end++] = i;
            }
            if (steps_[i].missing == 0) add(i);
        }
    }
    void add(std::uint32_t step) {
        const int op = static_cast<int>(before_[step].op);
        ready_[op].push_back(step);
        ops_ |= std::uint64_t{1} << op;
    }

    static constexpr int ops = op_count + 3;  // including ops only lowering makes
    static_assert(ops <= 64);
    std::vector<std::uint32_t> ready_[ops];  // steps with all operands computed, by op
    std::uint64_t ops_ = 0;                  // ops with ready steps
    std::vector<Instruction> before_;
    std::vector<Step> steps_;
    std::vector<std::uint32_t> users_, order_, last_use_, writer_;
    std::vector<std::uint16_t> place_;
    std::uint32_t none_ = 0, last_ = 0;
};

}  // namespace

void group_steps(std::span<Instruction> code, int& registers, int& result) {
    thread_memory<Groups>().form(code, registers, result);
}

Tape::Tape(Expression expression) : expression_(without_low_powers(std::move(expression))) {
    const std::uint32_t root[] = {static_cast<std::uint32_t>(expression_.nodes().size() - 1)};
    code_ = lowered(expression_.nodes(), root);
}

ColorTape::ColorTape(const ColorFormula& formula) {
    const ColorFormula f = without_low_powers(formula);
    code_ = lowered(f.nodes(), f.roots());
    meshes_ = f.meshes();
}

namespace {

/// The outcome of a node in a box.
enum Outcome : std::uint8_t { itself, first_operand, second_operand, third_operand, negative, constant };

}  // namespace

struct Tape::Memory {
    std::vector<Outcome> outcome;
    std::vector<std::uint8_t> is_needed, is_as_it_was;
    std::vector<std::uint32_t> needed;  // from the last to the first
    std::vector<float> constants;
    std::vector<Value> values;
};

void Tape::find_needed(Memory& memory, std::span<const Decision> decisions, int lane, std::uint32_t node) const {
    auto& [outcome, is_needed, is_as_it_was, needed, constants, values] = memory;
    const std::vector<Node>& nodes = expression_.nodes();
    const std::uint32_t count = node + 1;
    outcome.assign(nodes.size(), itself);
    is_needed.assign(count, 0);
    needed.clear();
    if (values.size() < nodes.size()) values.resize(nodes.size()), constants.resize(nodes.size());

    for (std::size_t at = 0; at < code_.decisions.size(); ++at) {
        const Op op = code_.decisions[at];
        const Decision& decision = decisions[at];
        if (!is_decided(op, decision, lane)) continue;
        const bool first = decision.first >> lane & 1, second = decision.second >> lane & 1;
        Outcome& known = outcome[code_.decision_nodes[at]];
        if (is_rounding(op)) {
            known = constant, constants[code_.decision_nodes[at]] = decision.value[lane];
        } else if (op == Op::absolute) {
            known = first ? first_operand : negative;
        } else {
            known = static_cast<Outcome>(first_operand + (is_select(op) || op == corner_distance ? 1 : 0) + (second ? 1 : 0));
        }
    }

    // Boxes decide most of a formula: each unneeded node costs only one byte test.
    is_needed[node] = 1;
    for (std::uint32_t i = count; i-- > 0;) {
        if (!is_needed[i]) continue;
        needed.push_back(i);
        switch (outcome[i]) {
            case itself:
                for (int k = 0; k < operands(nodes[i].op); ++k) is_needed[nodes[i].operand[k]] = 1;
                break;
            case constant: break;
            case negative: is_needed[nodes[i].operand[0]] = 1; break;
            default: is_needed[nodes[i].operand[outcome[i] - first_operand]] = 1;
        }
    }
}

std::vector<std::uint8_t> Tape::left_out(std::span<const Decision> decisions, int lane, double share) const {
    const std::size_t count = expression_.nodes().size();
    Memory& memory = thread_memory<Memory>();
    find_needed(memory, decisions, lane, static_cast<std::uint32_t>(count - 1));
    std::vector<std::uint8_t> result;
    if (static_cast<double>(memory.needed.size()) > share * static_cast<double>(count)) return result;
    result.reserve(code_.decision_nodes.size());
    bool any = false;
    for (const std::uint32_t node : code_.decision_nodes) {
        if (!memory.is_needed[node]) continue;
        const Outcome outcome = memory.outcome[node];
        any = any || outcome != itself;
        result.push_back(outcome);
        if (outcome != constant) continue;
        const auto value = std::bit_cast<std::array<std::uint8_t, 4>>(memory.constants[node]);
        result.insert(result.end(), value.begin(), value.end());
    }
    if (!any) result.clear();
    return result;
}

std::vector<bool> Tape::are_needed(std::span<const Decision> decisions, int lane) const {
    Memory& memory = thread_memory<Memory>();
    find_needed(memory, decisions, lane, static_cast<std::uint32_t>(expression_.nodes().size() - 1));
    std::vector<bool> result;
    result.reserve(code_.decision_nodes.size());
    for (const std::uint32_t node : code_.decision_nodes) result.push_back(memory.is_needed[node]);
    return result;
}

Value Tape::specialised(Graph& graph, std::span<const Decision> decisions, int lane, std::uint32_t node, const Instead* instead) const {
    Memory& memory = thread_memory<Memory>();
    find_needed(memory, decisions, lane, node);
    auto& [outcome, is_needed, is_as_it_was, needed, constants, values] = memory;
    const std::vector<Node>& nodes = expression_.nodes();
    is_as_it_was.assign(node + 1, 0);
    for (std::size_t at = needed.size(); at-- > 0;) {
        const std::uint32_t i = needed[at];
        switch (outcome[i]) {
            case itself: {
                Value operand[3];
                std::uint8_t unchanged = 1;
                for (int k = 0; k < operands(nodes[i].op); ++k) {
                    operand[k] = values[nodes[i].operand[k]];
                    unchanged &= is_as_it_was[nodes[i].operand[k]];
                }
                if (instead && instead->node == i) {
                    values[i] = instead->make(operand);
                } else {
                    is_as_it_was[i] = unchanged;
                    values[i] = unchanged ? graph.again(nodes[i], operand) : graph.like(nodes[i], operand);
                }
                break;
            }
            case constant: values[i] = graph.constant(constants[i]); break;
            case negative: values[i] = -values[nodes[i].operand[0]]; break;
            default: values[i] = values[nodes[i].operand[outcome[i] - first_operand]];
        }
    }
    return values[node];
}

Expression Tape::specialised(std::span<const Decision> decisions, int lane) const {
    thread_local Graph graph;
    const Graph::Reused reused(graph);
    return graph.expression(specialised(graph, decisions, lane, static_cast<std::uint32_t>(expression_.nodes().size() - 1)));
}

}  // namespace bob
