#include "shapes/cells.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>
#include <unordered_map>

#include "formula/jumps.h"
#include "formula/scratch.h"
#include "parallel.h"

namespace bob {
namespace {

/// Code that cutting a cell hardly makes shorter: with 8, CSG of a few balls and boxes takes 8 % longer; with 20, a
/// tanglecube takes 15 % longer.
constexpr std::size_t short_code = 12;

/// What the boxes decide about lane `lane`, as bytes that can be compared.
std::vector<std::uint8_t> signature(const Tape& tape, std::span<const Decision> decisions, int lane) {
    std::vector<std::uint8_t> result;
    result.reserve(decisions.size());
    for (std::size_t i = 0; i < decisions.size(); ++i) {
        const Decision& d = decisions[i];
        const Op op = tape.decisions()[i];
        const bool first = op != Op::atan2 && d.first >> lane & 1;
        const bool second = !is_rounding(op) && d.second >> lane & 1;
        result.push_back(static_cast<std::uint8_t>(first | second << 1));
        if (!first || !is_rounding(op)) continue;
        const auto value = std::bit_cast<std::array<std::uint8_t, 4>>(d.value[lane]);
        result.insert(result.end(), value.begin(), value.end());
    }
    return result;
}

bool decides(const std::vector<std::uint8_t>& signature) {
    return std::any_of(signature.begin(), signature.end(), [](std::uint8_t b) { return b != 0; });
}

}  // namespace

using TapePtr = std::shared_ptr<const Tape>;

/// Builds the subtree of one cell, with its own numbering.
class Cells::Builder {
public:
    Builder(std::uint32_t budget, Interruption& interruption) : budget_(budget), interruption_(interruption) {}

    void build(const TapePtr& tape, bool smooth, std::array<int, 3> at, int level) {
        build(add_node(), tape, smooth, at, level);
    }

    Cells result;

private:
    struct Child {
        int index;
        TapePtr tape;
        bool smooth;  // no jumps but those that select the whole formula
    };

    void build(std::int32_t node, const TapePtr& tape, bool smooth, std::array<int, 3> at, int level) {
        for (const auto& [index, child_tape, child_smooth] : occupied(tape, smooth, at, level + 1)) {
            const std::array<int, 3> corner = child_at(at, level + 1, index);
            std::int32_t child;
            if (is_leaf(child_tape->code(), child_smooth, level + 1)) {
                child = CellGrid::leaf(add_cell(child_tape->code(), corner, level + 1));
            } else {
                child = add_node();
                build(child, child_tape, child_smooth, corner, level + 1);
            }
            result.children_[static_cast<std::size_t>(64 * node + index)] = child;
        }
    }

    std::int32_t add_node() {
        const std::size_t children = result.children_.size();
        result.children_.resize(children + 64, CellGrid::empty);
        return static_cast<std::int32_t>(children / 64);
    }

    /// The last level is for jumps that are too many in one cell. All else is traced faster in larger cells, which more
    /// rays share, as long as the code does not get much shorter: with the last level for all, a tanglecube took twice as
    /// long; with the last two for spheres, 1.7 times.
    bool is_leaf(const Code& code, bool smooth, int level) {
        if (level == max_levels) return true;
        if (smooth && level == max_levels - 2 && code.count <= short_code) return true;
        if (level < max_levels - 1) return false;
        return smooth || result.cells_.size() >= budget_;
    }

    static std::array<int, 3> child_at(std::array<int, 3> at, int level, int index) {
        return {at[0] + (index & 3) * side(level), at[1] + (index >> 2 & 3) * side(level),
                at[2] + (index >> 4) * side(level)};
    }

    static BoxBatch boxes_of(std::array<int, 3> at, int level, const int* children, int count) {
        BoxBatch boxes{};
        for (int lane = 0; lane < count; ++lane) {
            const std::array<int, 3> corner = child_at(at, level, children[lane]);
            for (int axis = 0; axis < 3; ++axis) {
                boxes.low[axis][lane] = static_cast<float>(corner[axis]) * finest - 1 - margin;
                boxes.high[axis][lane] = static_cast<float>(corner[axis] + side(level)) * finest - 1 + margin;
            }
        }
        return boxes;
    }

    /// The children that the surface may pass, each with its parent's tape or a simpler one.
    std::vector<Child> occupied(const TapePtr& parent, bool smooth, std::array<int, 3> at, int level) {
        const FormulaKernels& kernels = best_formula_kernels();
        const Tape& tape = *parent;
        void* memory = scratch(tape.code().registers);
        decisions_.resize(tape.decisions().size());
        std::vector<Child> children;
        std::vector<std::pair<std::vector<std::uint8_t>, TapePtr>> known;
        for (int start = 0; start < 64; start += kernels.lanes) {
            int index[max_lanes];
            for (int lane = 0; lane < kernels.lanes; ++lane) index[lane] = start + lane;
            BoxBatch boxes = boxes_of(at, level, index, kernels.lanes);
            interruption_.check();
            kernels.bounds(tape.code(), boxes, decisions_.data(), memory);
            for (int lane = 0; lane < kernels.lanes; ++lane) {
                if (!may_change_sign(boxes, lane)) continue;
                Child child{index[lane], parent, smooth};
                // The greater of two that is never taken may still be NaN, and so make all of the formula NaN.
                if (boxes.partly >> lane & 1) forget_extremes(tape, lane);
                std::vector<std::uint8_t> key = signature(tape, decisions_, lane);
                if (decides(key)) {
                    const auto same = std::find_if(known.begin(), known.end(),
                                                   [&](const auto& k) { return k.first == key; });
                    if (same != known.end()) {
                        child.tape = same->second;
                    } else {
                        interruption_.check();
                        child.tape = std::make_shared<Tape>(tape.specialised(decisions_, lane));
                        known.emplace_back(std::move(key), child.tape);
                    }
                }
                children.push_back(std::move(child));
            }
        }
        narrow(children, at, level);
        if (!smooth) take_out_jumps(children, at, level);
        return children;
    }

    /// Takes back what a box decided, but for the branches of selects that always know which one to take.
    void forget_extremes(const Tape& tape, int lane) {
        const std::vector<Node>& nodes = tape.expression().nodes();
        std::vector<bool> total(nodes.size());  // whether numbers give a number
        std::size_t next = 0;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const Op op = nodes[i].op;
            total[i] = op != Op::sqrt && op != Op::log && op != Op::asin && op != Op::acos && op != Op::divide &&
                       op != Op::modulo;
            for (int k = 0; k < operands(op); ++k) total[i] = total[i] && total[nodes[i].operand[k]];
            if (!is_decision(op)) continue;
            Decision& decision = decisions_[next++];
            if (op == Op::select && total[nodes[i].operand[0]]) continue;
            decision.first &= ~(1u << lane);
            decision.second &= ~(1u << lane);
        }
    }

    /// Gives children formulas in which each side of a jump is by itself, and leaves out those that are empty then.
    void take_out_jumps(std::vector<Child>& children, std::array<int, 3> at, int level) {
        std::vector<Child> left;
        for (Child& child : children) {
            const Tape& tape = *child.tape;
            child.smooth = std::none_of(tape.decisions().begin(), tape.decisions().end(), may_jump);
            if (!child.smooth) {
                interruption_.check();
                const auto apart = with_jumps_outside(tape, boxes_of(at, level, &child.index, 1));
                if (apart && apart->nodes().back().op == Op::constant) continue;
                if (apart) {
                    child.tape = std::make_shared<Tape>(std::move(*apart));
                    child.smooth = true;
                }
            }
            left.push_back(std::move(child));
        }
        children = std::move(left);
    }

    /// Leaves out the children that slopes show to be empty. Children of one tape are looked at together.
    void narrow(std::vector<Child>& children, std::array<int, 3> at, int level) {
        const FormulaKernels& kernels = best_formula_kernels();
        std::vector<Child> left;
        std::vector<bool> seen(children.size(), false);
        for (std::size_t i = 0; i < children.size(); ++i) {
            if (seen[i]) continue;
            int index[max_lanes], count = 0;
            std::size_t place[max_lanes];
            for (std::size_t j = i; j < children.size() && count < kernels.lanes; ++j) {
                if (seen[j] || children[j].tape != children[i].tape) continue;
                seen[j] = true;
                place[count] = j;
                index[count++] = children[j].index;
            }
            interruption_.check();
            const Code code = children[i].tape->code();
            BoxBatch boxes = boxes_of(at, level, index, count);
            std::fill_n(boxes.least, max_lanes, -std::numeric_limits<float>::infinity());
            std::fill_n(boxes.most, max_lanes, std::numeric_limits<float>::infinity());
            kernels.narrow(code, boxes, scratch(code.registers));
            for (int lane = 0; lane < count; ++lane) {
                if (may_change_sign(boxes, lane)) left.push_back(children[place[lane]]);
            }
        }
        std::sort(left.begin(), left.end(), [](const Child& a, const Child& b) { return a.index < b.index; });
        children = std::move(left);
    }

    /// A cell with its code; cells whose code is the same share it.
    std::uint32_t add_cell(const Code& code, std::array<int, 3> at, int level) {
        const std::size_t size = code.count * sizeof(Instruction);
        const std::string_view bytes(reinterpret_cast<const char*>(code.instructions), size);
        std::vector<std::uint32_t>& same_hash = written_[std::hash<std::string_view>{}(bytes)];
        const auto known = std::find_if(same_hash.begin(), same_hash.end(), [&](std::uint32_t first) {
            return first + code.count <= result.instructions_.size() &&
                   (size == 0 || std::memcmp(result.instructions_.data() + first, code.instructions, size) == 0);
        });
        const std::uint32_t first = known != same_hash.end() ? *known
                                                             : static_cast<std::uint32_t>(result.instructions_.size());
        if (known == same_hash.end()) {
            same_hash.push_back(first);
            result.instructions_.insert(result.instructions_.end(), code.instructions,
                                        code.instructions + code.count);
        }
        result.max_code_ = std::max(result.max_code_, static_cast<std::uint32_t>(code.count));
        result.max_registers_ = std::max(result.max_registers_, code.registers);
        result.cells_.push_back({first, static_cast<std::uint32_t>(code.count),
                                 static_cast<std::uint16_t>(code.registers), static_cast<std::uint16_t>(code.result),
                                 {static_cast<std::uint8_t>(at[0]), static_cast<std::uint8_t>(at[1]),
                                  static_cast<std::uint8_t>(at[2])},
                                 static_cast<std::uint8_t>(level)});
        return static_cast<std::uint32_t>(result.cells_.size() - 1);
    }

    std::uint32_t budget_;
    Interruption& interruption_;
    std::vector<Decision> decisions_;
    std::unordered_map<std::size_t, std::vector<std::uint32_t>> written_;  // where code of a hash starts

    friend class Cells;
};

Cells::Cells(const Expression& f, const KeepGoing& keep_going) {
    Interruption interruption(keep_going);
    // The root's children are built apart, by all threads, and put together in order.
    const auto tape = std::make_shared<const Tape>(f);
    Builder root(0, interruption);
    const std::vector<Builder::Child> children = root.occupied(tape, false, {0, 0, 0}, 1);
    std::vector<Builder> subtrees(children.size(), Builder(max_cells / 64, interruption));
    const auto build = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto& [index, own, smooth] = children[i];
            subtrees[i].build(own, smooth, Builder::child_at({0, 0, 0}, 1, index), 1);
        }
    };
    if (!parallel_for(children.size(), 1, build, [&] { return interruption.keeps_going(); })) throw Stopped();

    children_.assign(64, CellGrid::empty);
    for (std::size_t i = 0; i < children.size(); ++i) {
        const Cells& part = subtrees[i].result;
        if (part.cells_.empty()) continue;
        const auto node0 = static_cast<std::int32_t>(children_.size() / 64);
        const auto cell0 = static_cast<std::int32_t>(cells_.size());
        const auto code0 = static_cast<std::uint32_t>(instructions_.size());
        children_[static_cast<std::size_t>(children[i].index)] = node0;
        for (const std::int32_t child : part.children_) {
            children_.push_back(child == CellGrid::empty ? child : child + (child < 0 ? cell0 : node0));
        }
        for (Cell cell : part.cells_) {
            cell.first += code0;
            cells_.push_back(cell);
        }
        instructions_.insert(instructions_.end(), part.instructions_.begin(), part.instructions_.end());
        max_code_ = std::max(max_code_, part.max_code_);
        max_registers_ = std::max(max_registers_, part.max_registers_);
    }

    if (cells_.empty()) {
        hull_ = {{0, 0, 0}, {0, 0, 0}};
        return;
    }
    for (const Cell& cell : cells_) hull_.extend(box(cell));
}

}  // namespace bob
