#include "shapes/implicit/painting.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "formula/pruning.h"
#include "formula/scratch.h"
#include "shapes/batches.h"

namespace bob {
namespace {

/// Shorter code is not pruned.
constexpr std::size_t long_code = 32;

/// Overlap of boxes, since points are assigned to them with rounded numbers.
constexpr float margin = 1e-5f;

int box_of(float coordinate, int side) {
    const float at = 0.5f * (coordinate + 1) * static_cast<float>(side);
    return static_cast<int>(std::clamp(at, 0.f, static_cast<float>(side - 1)));
}

/// The number of a box of a grid with `side` boxes along an axis.
std::size_t number_in(int side, const std::array<int, 3>& at) { return static_cast<std::size_t>((at[2] * side + at[1]) * side + at[0]); }

/// Prunes code in boxes of a grid with `side` boxes along an axis; calls use(box, pruned) for each box with certainly shorter code.
template <class Use>
void prune_in(const Code& code, std::span<const int> results, int side, std::span<const std::array<int, 3>> boxes, Use use) {
    const FormulaKernels& kernels = best_formula_kernels();
    std::vector<Decision> decisions(decision_count(code));
    if (decisions.empty()) return;
    LoweredCode pruned;
    const auto lanes = static_cast<std::size_t>(kernels.lanes);
    for (std::size_t first = 0; first < boxes.size(); first += lanes) {
        const std::size_t count = std::min(lanes, boxes.size() - first);
        BoxBatch batch{};
        for (std::size_t lane = 0; lane < count; ++lane) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto at = static_cast<float>(boxes[first + lane][axis]);
                batch.low[axis][lane] = 2 * at / static_cast<float>(side) - 1 - margin;
                batch.high[axis][lane] = 2 * (at + 1) / static_cast<float>(side) - 1 + margin;
            }
        }
        kernels.bounds(code, batch, decisions.data(), scratch(code.registers));
        for (std::size_t lane = 0; lane < count; ++lane) {
            if (batch.partly >> lane & 1) continue;  // a branch that is not chosen may be NaN, and make the result NaN
            prune(code, results, decisions, static_cast<int>(lane), pruned);
            if (pruned.instructions.size() < code.count) use(boxes[first + lane], pruned);
        }
    }
}

}  // namespace

Painting::Painting(ColorTape tape, const Cells& cells) : tape_(std::move(tape)) {
    const Code whole = tape_.code();
    instructions_.assign(whole.instructions, whole.instructions + whole.count);
    parts_.push_back({0, whole.count, whole.registers, tape_.results()});
    if (whole.count < long_code) return;
    constexpr int coarse = 4, finer = side / coarse;
    std::vector<bool> is_occupied(side * side * side);
    std::vector<std::vector<std::array<int, 3>>> boxes(coarse * coarse * coarse);  // of the finer ones, in each coarse one
    for (const Cells::Cell& cell : cells.cells()) {
        constexpr int width = Cells::grid / side;
        std::array<int, 3> low, high;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = cell.at[axis] / width, high[axis] = (cell.at[axis] + Cells::side(cell.level) - 1) / width;
        }
        std::array<int, 3> at;
        for (at[2] = low[2]; at[2] <= high[2]; ++at[2]) {
            for (at[1] = low[1]; at[1] <= high[1]; ++at[1]) {
                for (at[0] = low[0]; at[0] <= high[0]; ++at[0]) {
                    if (is_occupied[number_in(side, at)]) continue;
                    is_occupied[number_in(side, at)] = true;
                    boxes[number_in(coarse, {at[0] / finer, at[1] / finer, at[2] / finer})].push_back(at);
                }
            }
        }
    }
    part_in_.assign(is_occupied.size(), 0);
    std::vector<std::array<int, 3>> occupied;
    for (const auto& inside : boxes) {
        if (!inside.empty()) occupied.push_back({inside[0][0] / finer, inside[0][1] / finer, inside[0][2] / finer});
    }
    prune_in(whole, tape_.results(), coarse, occupied, [&](const std::array<int, 3>& at, const LoweredCode& there) {
        const auto& inside = boxes[number_in(coarse, at)];
        const std::uint32_t number = number_of(there, 0);
        for (const auto& box : inside) part_in_[number_in(side, box)] = number;
        if (there.instructions.size() < long_code) return;
        prune_in(there.code(), there.results, side, inside, [&](const std::array<int, 3>& box, const LoweredCode& here) {
            part_in_[number_in(side, box)] = number_of(here, number);
        });
    });
}

std::uint32_t Painting::number_of(const LoweredCode& code, std::uint32_t first) {
    const std::size_t count = code.instructions.size();
    for (auto number = static_cast<std::uint32_t>(parts_.size()); number-- > first;) {  // neighbours often have equal code
        const Program& part = parts_[number];
        if (part.count == count && part.results == code.results &&
            std::memcmp(instructions_.data() + part.first, code.instructions.data(), count * sizeof(Instruction)) == 0) {
            return number;
        }
    }
    parts_.push_back({instructions_.size(), count, code.registers, code.results});
    instructions_.insert(instructions_.end(), code.instructions.begin(), code.instructions.end());
    return static_cast<std::uint32_t>(parts_.size() - 1);
}

std::uint32_t Painting::part_at(Vec3 p) const {
    const bool is_inside = std::fabs(p.x) <= 1 && std::fabs(p.y) <= 1 && std::fabs(p.z) <= 1;  // false for NaN
    if (part_in_.empty() || !is_inside) return 0;
    return part_in_[number_in(side, {box_of(p.x, side), box_of(p.y, side), box_of(p.z, side)})];
}

void Painting::operator()(std::span<const Vec3> points, std::span<Vec3> colors) const {
    const FormulaKernels& kernels = best_formula_kernels();
    void* const memory = scratch(parts_[0].registers);
    const auto lanes = static_cast<std::size_t>(kernels.lanes);
    const auto part_of = [&](std::uint32_t i) { return part_at(points[i]); };
    for_each_batch(points.size(), static_cast<std::uint32_t>(parts_.size()), lanes, part_of, [&](std::uint32_t number, Items items) {
        const Program& part = parts_[number];
        const Code code{instructions_.data() + part.first, part.count, part.registers, part.results[0], false};
        float point[3][max_lanes], color[3][max_lanes];
        const float* const axes[3] = {point[0], point[1], point[2]};
        float* const components[3] = {color[0], color[1], color[2]};
        for (int axis = 0; axis < 3; ++axis) {
            for (std::size_t i = 0; i < items.size(); ++i) point[axis][i] = points[items[i]][axis];
        }
        kernels.colors(code, part.results.data(), axes, static_cast<int>(items.size()), components, memory);
        for (std::size_t i = 0; i < items.size(); ++i) {
            for (int k = 0; k < 3; ++k) colors[items[i]][k] = color_component(color[k][i]);
        }
    });
}

std::size_t Painting::bytes() const {
    return tape_.bytes() + instructions_.capacity() * sizeof(Instruction) + parts_.capacity() * sizeof(Program) + part_in_.capacity() * sizeof(std::uint32_t);
}

}  // namespace bob
