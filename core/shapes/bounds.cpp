#include "shapes/bounds.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "formula/scratch.h"
#include "formula/tape.h"

namespace bob {
namespace {

/// A box, drawn together around what may be inside of f.
struct Shrunk {
    Bounds box{};
    bool empty = true;    // nothing may be inside
    bool vague = false;   // nothing is known of f in a part of the box
};

/// One round: the box is cut into 16 x 16 x 16, and what is left of it is the hull of the cells that may hold f <= 0.
Shrunk shrunk(const Tape& tape, const Bounds& box, std::vector<Decision>& decisions) {
    constexpr int cuts = 16;
    const FormulaKernels& kernels = best_formula_kernels();
    const auto face = [&](int axis, int k) { return box.low[axis] + (box.high[axis] - box.low[axis]) * k / cuts; };
    const auto index = [](int cell, int axis) { return cell >> (4 * axis) & (cuts - 1); };
    Shrunk result;
    for (int first = 0; first < cuts * cuts * cuts; first += kernels.lanes) {
        BoxBatch boxes{};
        for (int lane = 0; lane < kernels.lanes; ++lane) {
            for (int axis = 0; axis < 3; ++axis) {
                const int k = index(first + lane, axis);
                boxes.low[axis][lane] = static_cast<float>(face(axis, k));
                boxes.high[axis][lane] = static_cast<float>(face(axis, k + 1));
            }
        }
        kernels.bounds(tape.code(), boxes, decisions.data(), scratch(tape.code().registers));
        for (int lane = 0; lane < kernels.lanes; ++lane) {
            if (boxes.least[lane] > 0 || boxes.nowhere >> lane & 1) continue;
            result.vague = result.vague || !std::isfinite(boxes.least[lane]);
            for (int axis = 0; axis < 3; ++axis) {
                const int k = index(first + lane, axis);
                const double low = face(axis, k), high = face(axis, k + 1);
                result.box.low[axis] = result.empty ? low : std::min(result.box.low[axis], low);
                result.box.high[axis] = result.empty ? high : std::max(result.box.high[axis], high);
            }
            result.empty = false;
        }
    }
    return result;
}

}  // namespace

std::optional<Bounds> find_bounds(const Expression& f) {
    const Tape tape(f);
    std::vector<Decision> decisions(tape.decisions().size());
    // A formula that overflows far out tells nothing there; nearer, it may.
    for (const double reach : {1e9, 1e6, 1e3, 30.}) {
        Bounds box{{-reach, -reach, -reach}, {reach, reach, reach}};
        bool vague = false;
        for (int round = 0; round < 100; ++round) {
            const Shrunk next = shrunk(tape, box, decisions);
            if (next.empty) return std::nullopt;
            double least_left = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const double left = (next.box.high[axis] - next.box.low[axis]) / (box.high[axis] - box.low[axis]);
                least_left = std::min(least_left, left);
            }
            box = next.box;
            vague = next.vague;
            if (least_left > 0.99) break;
        }
        bool open = false;
        for (int axis = 0; axis < 3; ++axis) open = open || box.low[axis] <= -reach || box.high[axis] >= reach;
        if (!open) return box;
        if (!vague) break;
    }
    throw std::invalid_argument("an expression that is bounded, got one whose inside reaches beyond 1e9 from the origin");
}

}  // namespace bob
