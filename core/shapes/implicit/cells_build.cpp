#include "shapes/implicit/cells.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "base/parallel.h"
#include "base/work.h"
#include "formula/jumps.h"
#include "formula/scratch.h"

namespace bob {
namespace {

/// Codes up to this length are not worth simplifying further: with 8, CSG of a few balls and boxes takes 8 % longer; with 20, a
/// tanglecube takes 15 % longer.
constexpr std::size_t short_code = 12;

/// A formula with this number of nodes is kept in a cell that still needs more than this share of them: simplifying saves little
/// there, takes as long, and neighbours no longer share the code. With a share of 1, woven strips
/// take 1.5 times as long to build, three times the memory, and rays a tenth longer; with 0.6, sparse rays take a twentieth longer.
/// In short formulas each node matters: with 0 nodes, a tanglecube takes 6 % longer.
constexpr std::size_t long_formula = 50;
constexpr double share_needed = 0.8;

/// Work of bounding slopes per instruction and box, and of pruning per node, relative to that of bounding values.
constexpr std::uint64_t units_to_narrow = 4, units_to_specialise = 100;

/// Work of bounding values in a box: an angle or a power costs as much as many sums, and a distance to a mesh as many of these.
std::uint64_t units_of(const Code& code) {
    std::uint64_t units = code.count;
    for (std::size_t i = 0; i < code.count; ++i) {
        const Op op = code.instructions[i].op;
        if ((op >= Op::sin && op <= Op::log) || op == Op::power || op == Op::atan2) units += 24;
        if (op == Op::mesh_distance) units += 600;
    }
    return units;
}

bool has_mesh(const Code& code) {
    const Instruction* const end = code.instructions + code.count;
    return std::any_of(code.instructions, end, [](const Instruction& step) { return step.op == Op::mesh_distance; });
}

/// Whether each decision belongs to a select whose condition is never NaN.
std::vector<bool> certain_selects(const Tape& tape) {
    const std::vector<Node>& nodes = tape.expression().nodes();
    std::vector<bool> total(nodes.size());  // whether finite operands give a finite value
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Op op = nodes[i].op;
        total[i] = op != Op::sqrt && op != Op::log && op != Op::asin && op != Op::acos && op != Op::divide &&
                   op != Op::modulo;
        for (int k = 0; k < operands(op); ++k) total[i] = total[i] && total[nodes[i].operand[k]];
    }
    std::vector<bool> result;
    result.reserve(tape.decisions().size());
    for (std::size_t at = 0; at < tape.decisions().size(); ++at) {
        const Node& node = nodes[tape.decision_nodes()[at]];
        result.push_back(node.op == Op::select && total[node.operand[0]]);
    }
    return result;
}

}  // namespace

using TapePtr = std::shared_ptr<const Tape>;

/// Writes codes into cells, each once.
class Cells::Library {
public:
    /// The number of the code, added if it is new.
    std::uint32_t number_of(const Code& code, Cells& cells) {
        const std::size_t size = code.count * sizeof(Instruction);
        const std::string_view bytes(reinterpret_cast<const char*>(code.instructions), size);
        std::vector<std::uint32_t>& same_hash = written_[std::hash<std::string_view>{}(bytes)];
        for (const std::uint32_t number : same_hash) {
            const Code known = cells.code(number);
            // Codes without instructions differ only in their result: x, y or z.
            if (known.count == code.count && known.result == code.result &&
                (size == 0 || std::memcmp(known.instructions, code.instructions, size) == 0)) {
                return number;
            }
        }
        same_hash.push_back(cells.codes());
        cells.codes_.push_back({static_cast<std::uint32_t>(cells.instructions_.size()),
                                static_cast<std::uint32_t>(code.count), static_cast<std::uint16_t>(code.registers),
                                static_cast<std::uint16_t>(code.result), code.may_jump});
        cells.instructions_.insert(cells.instructions_.end(), code.instructions, code.instructions + code.count);
        cells.max_code_ = std::max(cells.max_code_, static_cast<std::uint32_t>(code.count));
        cells.max_registers_ = std::max(cells.max_registers_, code.registers);
        return same_hash.back();
    }

private:
    std::unordered_map<std::size_t, std::vector<std::uint32_t>> written_;  // numbers of codes by hash
};

/// Builds the subtree of one cell, with its own numbering.
class Cells::Builder {
public:
    explicit Builder(std::uint32_t max_cells, std::uint64_t at_once = budget / 64) : max_cells_(max_cells), at_once_(at_once) {}

    static constexpr Vec3 unknown{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN(),
                                  std::numeric_limits<float>::quiet_NaN()};

    struct Child {
        int index;
        TapePtr tape;
        bool smooth;  // without jumps, apart from selects of the whole formula
        Vec3 least_slope = unknown, most_slope = unknown;
    };

    void start(const TapePtr& tape, bool smooth, std::array<int, 3> at, int level) { waiting_ = {tape, smooth, at, level}; }

    /// Continues until done, or for about this amount of work.
    void go_on(std::uint64_t units) {
        work_.grant(units);
        if (waiting_.tape) open(std::exchange(waiting_, {}));
        while (!open_.empty() && !work_.is_spent()) step();
    }
    [[nodiscard]] bool is_done() const { return !waiting_.tape && open_.empty(); }
    [[nodiscard]] const Work& work() const { return work_; }

    /// Finishes without further subdivision.
    void finish() {
        if (waiting_.tape) open(std::exchange(waiting_, {}));
        coarse_ = true;
        while (!open_.empty()) step();
    }

    Cells result;

    /// The children that may contain the surface, each with its parent's tape or a simpler one.
    std::vector<Child> occupied(const TapePtr& parent, bool smooth, std::array<int, 3> at, int level);

    static std::array<int, 3> child_at(std::array<int, 3> at, int level, int index) {
        return {at[0] + (index & 3) * side(level), at[1] + (index >> 2 & 3) * side(level),
                at[2] + (index >> 4) * side(level)};
    }

private:
    struct Waiting {
        TapePtr tape;
        bool smooth = false;
        std::array<int, 3> at{};
        int level = 0;
    };

    /// A node in progress; its children are grouped by tape.
    struct Open {
        std::int32_t node;
        std::array<int, 3> at;
        int level;
        std::vector<Child> children;
        std::size_t next = 0;
    };

    void open(const Waiting& cell) {
        const std::int32_t node = add_node();
        open_.push_back({node, cell.at, cell.level, occupied(cell.tape, cell.smooth, cell.at, cell.level + 1)});
    }

    void step() {
        Open& top = open_.back();
        if (top.next == top.children.size()) return open_.pop_back();
        const Child child = std::move(top.children[top.next++]);
        const int level = top.level + 1;
        const std::array<int, 3> corner = child_at(top.at, level, child.index);
        std::int32_t& place = result.children_[static_cast<std::size_t>(64 * top.node + child.index)];
        if (coarse_ || is_leaf(child, level)) {
            place = CellGrid::leaf(add_cell(child, corner, level));
            return;
        }
        place = static_cast<std::int32_t>(result.children_.size() / 64);  // the next place that open assigns
        open({child.tape, child.smooth, corner, level});
    }

    std::int32_t add_node() {
        const std::size_t children = result.children_.size();
        result.children_.resize(children + 64, CellGrid::empty);
        return static_cast<std::int32_t>(children / 64);
    }

    /// The last level is for cells with many jumps. Otherwise larger cells are faster, since more rays share their code, unless the
    /// code gets much shorter: with the last level for all, a tanglecube took twice as
    /// long; with the last two for spheres, 1.7 times. In cells of level 2 instead of 3, the median code of letters and
    /// gears is five to six times as long. A mesh is subdivided until it is nearly flat, so rays cross it once: with slopes
    /// that differ by up to 1 instead of 0.5, rays took twice as long; with 0.25, a sphere of 3,700 triangles took seven times as long
    /// to build.
    bool is_leaf(const Child& child, int level) {
        if (level == max_levels) return true;
        const Code code = child.tape->code();
        const bool smooth = child.smooth && !(has_mesh(code) && is_uneven(child));
        if (smooth && level == max_levels - 2 && code.count <= short_code) return true;
        if (level < max_levels - 1) return false;
        return smooth || result.cells_.size() >= max_cells_;
    }

    /// Whether slopes vary widely, or are unknown.
    static bool is_uneven(const Child& child) {
        constexpr float most = 0.5f;
        bool even = true;
        for (int axis = 0; axis < 3; ++axis) even = even && child.most_slope[axis] - child.least_slope[axis] <= most;  // false for NaN
        return !even;
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

    /// Reverts decisions of boxes, except for selects whose condition is never NaN.
    void forget_extremes(const std::vector<bool>& is_certain, std::uint32_t lanes) {
        for (std::size_t i = 0; i < decisions_.size(); ++i) {
            if (is_certain[i]) continue;
            decisions_[i].first &= ~lanes;
            decisions_[i].second &= ~lanes;
        }
    }

    /// Splits the children's formulas at jumps, and drops children that are then empty.
    void take_out_jumps(std::vector<Child>& children, std::array<int, 3> at, int level, std::uint64_t most) {
        std::vector<Child> left;
        for (Child& child : children) {
            const Tape& tape = *child.tape;
            child.smooth = !tape.code().may_jump;
            if (!child.smooth && work_.spent() < most) {
                const auto apart = with_jumps_outside(tape, boxes_of(at, level, &child.index, 1), work_);
                if (apart && apart->nodes().back().op == Op::constant) continue;
                if (apart) {
                    child.tape = std::make_shared<Tape>(std::move(*apart));
                    child.smooth = true;
                    child.least_slope = child.most_slope = unknown;
                }
            }
            left.push_back(std::move(child));
        }
        children = std::move(left);
    }

    /// Drops children that are empty by the bounds of their slopes. Children of one tape are tested together.
    void narrow(std::vector<Child>& children, std::array<int, 3> at, int level, std::uint64_t most) {
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
            const Code code = children[i].tape->code();
            if (work_.spent() >= most) {
                for (int lane = 0; lane < count; ++lane) left.push_back(children[place[lane]]);
                continue;
            }
            work_.spend(units_to_narrow * static_cast<std::uint64_t>(count) * units_of(code));
            BoxBatch boxes = boxes_of(at, level, index, count);
            std::fill_n(boxes.least, max_lanes, -std::numeric_limits<float>::infinity());
            std::fill_n(boxes.most, max_lanes, std::numeric_limits<float>::infinity());
            kernels.narrow(code, boxes, scratch(code.registers));
            for (int lane = 0; lane < count; ++lane) {
                if (!may_change_sign(boxes, lane)) continue;
                Child& child = left.emplace_back(children[place[lane]]);
                for (int axis = 0; axis < 3; ++axis) {
                    child.least_slope[axis] = boxes.least_slope[axis][lane];
                    child.most_slope[axis] = boxes.most_slope[axis][lane];
                }
            }
        }
        std::sort(left.begin(), left.end(), [](const Child& a, const Child& b) { return a.index < b.index; });
        children = std::move(left);
    }

    std::uint32_t add_cell(const Child& child, std::array<int, 3> at, int level) {
        if (child.tape != last_tape_) {
            last_tape_ = child.tape;
            work_.spend(child.tape->code().count);
            last_code_ = library_.number_of(child.tape->code(), result);
        }
        result.cells_.push_back({last_code_,
                                 {static_cast<std::uint8_t>(at[0]), static_cast<std::uint8_t>(at[1]),
                                  static_cast<std::uint8_t>(at[2])},
                                 static_cast<std::uint8_t>(level), child.least_slope, child.most_slope});
        return static_cast<std::uint32_t>(result.cells_.size() - 1);
    }

    std::uint32_t max_cells_;
    std::uint64_t at_once_;  // budget for one cell
    Work work_;
    bool coarse_ = false;
    TapePtr last_tape_;  // neighbours often share it
    std::uint32_t last_code_ = 0;
    Waiting waiting_;
    std::vector<Open> open_;
    std::vector<Decision> decisions_;
    Library library_;

    friend class Cells;
};

std::vector<Cells::Builder::Child> Cells::Builder::occupied(const TapePtr& parent, bool smooth, std::array<int, 3> at, int level) {
    const FormulaKernels& kernels = best_formula_kernels();
    const Tape& tape = *parent;
    void* memory = scratch(tape.code().registers);
    decisions_.resize(tape.decisions().size());
    // One cell of a huge formula may exceed the whole budget: beyond its share, its parts are not subdivided.
    const std::uint64_t most = work_.spent() + at_once_;
    const std::uint64_t units = units_of(tape.code());
    std::vector<Child> children;
    std::vector<std::pair<std::vector<std::uint8_t>, TapePtr>> known;
    std::optional<std::vector<bool>> is_certain;
    const double share = tape.expression().nodes().size() < long_formula ? 1 : share_needed;
    for (int start = 0; start < 64; start += kernels.lanes) {
        int index[max_lanes];
        for (int lane = 0; lane < kernels.lanes; ++lane) index[lane] = start + lane;
        BoxBatch boxes = boxes_of(at, level, index, kernels.lanes);
        work_.spend(static_cast<std::uint64_t>(kernels.lanes) * units);
        kernels.bounds(tape.code(), boxes, decisions_.data(), memory);
        // The operand of max that is never taken may be NaN, and make the formula NaN.
        if (boxes.partly) {
            if (!is_certain) is_certain = certain_selects(tape);
            forget_extremes(*is_certain, boxes.partly);
        }
        for (int lane = 0; lane < kernels.lanes; ++lane) {
            if (!may_change_sign(boxes, lane)) continue;
            Child child{index[lane], parent, smooth};
            std::vector<std::uint8_t> key = tape.left_out(decisions_, lane, share);
            if (!key.empty() && work_.spent() < most) {
                const auto same = std::find_if(known.begin(), known.end(),
                                               [&](const auto& k) { return k.first == key; });
                if (same != known.end()) {
                    child.tape = same->second;
                } else {
                    work_.spend(units_to_specialise * tape.expression().nodes().size());
                    child.tape = std::make_shared<Tape>(tape.specialised(decisions_, lane));
                    known.emplace_back(std::move(key), child.tape);
                }
            }
            children.push_back(std::move(child));
        }
    }
    narrow(children, at, level, most);
    if (!smooth) take_out_jumps(children, at, level, most);
    return children;
}

void Cells::group_all_steps() {
    for (Stored& code : codes_) {
        int registers = code.registers, result = code.result;
        group_steps({instructions_.data() + code.first, code.count}, registers, result);
        code.registers = static_cast<std::uint16_t>(registers), code.result = static_cast<std::uint16_t>(result);
    }
}

void Cells::make_top() {
    constexpr std::size_t side = CellGrid::top_side;
    top_.resize(side * side * side);
    for (std::size_t z = 0, i = 0; z < side; ++z) {
        for (std::size_t y = 0; y < side; ++y) {
            for (std::size_t x = 0; x < side; ++x, ++i) {
                const std::int32_t child = children_[x / 4 + 4 * (y / 4) + 16 * (z / 4)];
                const std::size_t grandchild = x % 4 + 4 * (y % 4) + 16 * (z % 4);
                top_[i] = child == CellGrid::empty ? CellGrid::all_empty : children_[64 * static_cast<std::size_t>(child) + grandchild];
            }
        }
    }
}

Cells::Cells(const Expression& f) : meshes_(f.meshes()) {
    // All threads build the root's children, which are joined in order.
    const auto tape = std::make_shared<const Tape>(f);
    Builder root(0, budget / 16);
    const std::vector<Builder::Child> children = root.occupied(tape, false, {0, 0, 0}, 1);
    std::vector<Builder> subtrees(children.size(), Builder(max_cells / 64));
    for (std::size_t i = 0; i < children.size(); ++i) {
        const Builder::Child& child = children[i];
        subtrees[i].start(child.tape, child.smooth, Builder::child_at({0, 0, 0}, 1, child.index), 1);
    }
    is_coarse_ = !do_in_turns(subtrees, budget);
    for (Builder& subtree : subtrees) subtree.finish();
    parallel_for(subtrees.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) subtrees[i].result.group_all_steps();
    });

    children_.assign(64, CellGrid::empty);
    Library library;
    std::vector<std::uint32_t> codes;  // of a subtree, among all
    for (std::size_t i = 0; i < children.size(); ++i) {
        const Cells& part = subtrees[i].result;
        if (part.cells_.empty()) continue;
        const auto node0 = static_cast<std::int32_t>(children_.size() / 64);
        const auto cell0 = static_cast<std::int32_t>(cells_.size());
        children_[static_cast<std::size_t>(children[i].index)] = node0;
        for (const std::int32_t child : part.children_) {
            children_.push_back(child == CellGrid::empty ? child : child + (child < 0 ? cell0 : node0));
        }
        codes.clear();
        for (std::uint32_t code = 0; code < part.codes(); ++code) codes.push_back(library.number_of(part.code(code), *this));
        for (Cell cell : part.cells_) {
            cell.code = codes[cell.code];
            cells_.push_back(cell);
        }
    }

    make_top();
    if (cells_.empty()) {
        hull_ = {{0, 0, 0}, {0, 0, 0}};
        return;
    }
    for (const Cell& cell : cells_) hull_.extend(box(cell));
}

}  // namespace bob
