#include "shapes/cells.h"

#include <algorithm>
#include <limits>
#include <queue>

#include "formula/scratch.h"

namespace bob {

Box Cells::box(const Cell& cell) {
    Box result;
    const auto size = static_cast<float>(side(cell.level)) * finest;
    for (int axis = 0; axis < 3; ++axis) {
        result.low[axis] = static_cast<float>(cell.at[axis]) * finest - 1;
        result.high[axis] = result.low[axis] + size;
    }
    return result;
}

std::size_t Cells::bytes() const {
    return children_.size() * sizeof(std::int32_t) + cells_.size() * sizeof(Cell) +
           instructions_.size() * sizeof(Instruction);
}

double Cells::maximum(const std::function<double(Vec3)>& convex) const {
    struct Candidate {
        double bound;
        std::uint32_t cell;
        Box box;
        bool operator<(const Candidate& other) const { return bound < other.bound; }
    };
    // A convex function is largest at a corner.
    const auto bound = [&](const Box& b) {
        double most = -std::numeric_limits<double>::infinity();
        for (int corner = 0; corner < 8; ++corner) {
            most = std::max(most, convex({corner & 1 ? b.high.x : b.low.x, corner & 2 ? b.high.y : b.low.y,
                                          corner & 4 ? b.high.z : b.low.z}));
        }
        return most;
    };
    std::priority_queue<Candidate> candidates;
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
        const Box b = box(cells_[i]);
        candidates.push({bound(b), i, b});
    }
    const FormulaKernels& kernels = best_formula_kernels();
    void* const memory = scratch(max_registers_);
    std::vector<Decision> decisions(max_code_);
    while (!candidates.empty()) {
        const Candidate top = candidates.top();
        candidates.pop();
        if (top.box.high.x - top.box.low.x <= tolerance) return top.bound;
        const Vec3 half = 0.5f * (top.box.high - top.box.low);
        const Code code = this->code(cells_[top.cell]);
        for (int start = 0; start < 8; start += kernels.lanes) {
            BoxBatch boxes{};
            const int count = std::min(8, kernels.lanes);
            for (int lane = 0; lane < count; ++lane) {
                for (int axis = 0; axis < 3; ++axis) {
                    const float low = top.box.low[axis] + ((start + lane) >> axis & 1 ? half[axis] : 0);
                    boxes.low[axis][lane] = low;
                    boxes.high[axis][lane] = low + half[axis];
                }
            }
            kernels.bounds(code, boxes, decisions.data(), memory);
            for (int lane = 0; lane < count; ++lane) {
                if (!may_change_sign(boxes, lane)) continue;
                const Box b{{boxes.low[0][lane], boxes.low[1][lane], boxes.low[2][lane]},
                            {boxes.high[0][lane], boxes.high[1][lane], boxes.high[2][lane]}};
                candidates.push({bound(b), top.cell, b});
            }
        }
    }
    return -std::numeric_limits<double>::infinity();
}

}  // namespace bob
