#include "shapes/implicit/cells.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/work.h"
#include "formula/mesh_distance.h"
#include "formula/scratch.h"

namespace bob {

Box Cells::box(const Cell& cell) {
    Box result;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int low = cell.at[axis];
        result.low[static_cast<int>(axis)] = static_cast<float>(low) * finest - 1;
        result.high[static_cast<int>(axis)] = static_cast<float>(low + side(cell.level)) * finest - 1;
    }
    return result;
}

std::size_t Cells::bytes() const {
    std::size_t of_meshes = 0;
    for (const auto& mesh : meshes_) of_meshes += mesh->bytes();
    return of_meshes + (children_.size() + top_.size()) * sizeof(std::int32_t) + cells_.size() * sizeof(Cell) +
           codes_.size() * sizeof(Stored) + instructions_.size() * sizeof(Instruction);
}

namespace {

/// Units of work, for each box and instruction.
constexpr std::uint64_t maximum_budget = 150'000'000;

/// A box cut into parts, `Cuts` along each axis, and bounds of a convex function in each: it is largest at a corner.
template <int Cuts>
class Parts {
public:
    Parts(const Box& box, const Cells::Function& convex) : low_(box.low), size_((1.f / Cuts) * (box.high - box.low)) {
        std::array<Vec3, corners * corners * corners> points;
        for (int z = 0, i = 0; z < corners; ++z) {
            for (int y = 0; y < corners; ++y) {
                for (int x = 0; x < corners; ++x, ++i) points[static_cast<std::size_t>(i)] = corner({x, y, z});
            }
        }
        convex(points, at_corner_);
    }

    /// The box of part x + Cuts y + Cuts² z.
    [[nodiscard]] Box box(int part) const {
        const std::array<int, 3> at = place(part);
        return {corner(at), corner({at[0] + 1, at[1] + 1, at[2] + 1})};
    }
    [[nodiscard]] double bound(int part) const {
        const auto [x, y, z] = place(part);
        double most = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < 8; ++i) {
            most = std::max(most, at_corner_[x + (i & 1) + corners * (y + (i >> 1 & 1) + corners * (z + (i >> 2)))]);
        }
        return most;
    }

private:
    static constexpr int corners = Cuts + 1;

    static std::array<int, 3> place(int part) { return {part % Cuts, part / Cuts % Cuts, part / (Cuts * Cuts)}; }
    /// Exact: all lengths are powers of two.
    [[nodiscard]] Vec3 corner(std::array<int, 3> at) const {
        Vec3 result;
        for (int axis = 0; axis < 3; ++axis) {
            result[axis] = low_[axis] + static_cast<float>(at[static_cast<std::size_t>(axis)]) * size_[axis];
        }
        return result;
    }

    Vec3 low_, size_;
    double at_corner_[corners * corners * corners];
};

}  // namespace

double Cells::maximum(const Function& convex) const {
    struct Candidate {
        double bound;
        std::int32_t child;  // a node or a cell, as in CellGrid
        Box box;

        bool operator<(const Candidate& other) const { return bound < other.bound; }
    };
    const FormulaKernels& kernels = best_formula_kernels();
    void* const memory = scratch(max_registers_);
    std::vector<Decision> decisions(max_code_);
    Work work(maximum_budget);  // once spent, cells are measured as a whole
    double most = -std::numeric_limits<double>::infinity();
    // Depth first, and the largest bound of each cut first: boxes below the current maximum are skipped.
    std::vector<Candidate> open{{std::numeric_limits<double>::infinity(), 0, {{-1, -1, -1}, {1, 1, 1}}}}, parts;
    while (!open.empty()) {
        const Candidate top = open.back();
        open.pop_back();
        if (top.bound <= most) continue;
        parts.clear();
        if (top.child >= 0) {
            const Parts<4> children(top.box, convex);
            for (int i = 0; i < 64; ++i) {
                const std::int32_t child = children_[static_cast<std::size_t>(64 * top.child + i)];
                if (child == CellGrid::empty || children.bound(i) <= most) continue;
                parts.push_back({children.bound(i), child, children.box(i)});
            }
        } else if (top.box.high.x - top.box.low.x <= tolerance || work.is_spent()) {
            most = top.bound;
        } else {
            const Parts<2> halves(top.box, convex);
            std::array<int, 8> larger;
            int count = 0;
            for (int i = 0; i < 8; ++i) {
                if (halves.bound(i) > most) larger[static_cast<std::size_t>(count++)] = i;
            }
            const Code code = this->code(cells_[CellGrid::cell(top.child)].code);
            for (int start = 0; start < count; start += kernels.lanes) {
                const int lanes = std::min(count - start, kernels.lanes);
                BoxBatch boxes{};
                for (int lane = 0; lane < lanes; ++lane) {
                    const Box b = halves.box(larger[static_cast<std::size_t>(start + lane)]);
                    for (int axis = 0; axis < 3; ++axis) {
                        boxes.low[axis][lane] = b.low[axis];
                        boxes.high[axis][lane] = b.high[axis];
                    }
                }
                work.spend(static_cast<std::uint64_t>(lanes) * code.count);
                kernels.bounds(code, boxes, decisions.data(), memory);
                for (int lane = 0; lane < lanes; ++lane) {
                    const int i = larger[static_cast<std::size_t>(start + lane)];
                    if (may_change_sign(boxes, lane)) parts.push_back({halves.bound(i), top.child, halves.box(i)});
                }
            }
        }
        std::sort(parts.begin(), parts.end());
        open.insert(open.end(), parts.begin(), parts.end());
    }
    return most;
}

}  // namespace bob
