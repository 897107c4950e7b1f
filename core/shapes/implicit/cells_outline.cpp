/// The points of a surface's cells that decide how far it reaches.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "base/interruption.h"
#include "formula/scratch.h"
#include "shapes/implicit/cells.h"

namespace bob {
namespace {

/// Corners of the smallest boxes, whose side is the tolerance, along an axis.
constexpr std::size_t corners = static_cast<std::size_t>(2 / Cells::tolerance) + 1;

using Corner = std::array<std::uint16_t, 3>;

/// The first and the last of some corners on each line along an axis: no other is farther out in any direction.
class Ends {
public:
    explicit Ends(std::size_t axis) : axis_(axis), first_(corners * corners, corners), last_(corners * corners, -1) {}

    void add(const Corner& corner) {
        const std::size_t line = line_of(corner);
        first_[line] = std::min<std::int32_t>(first_[line], corner[axis_]);
        last_[line] = std::max<std::int32_t>(last_[line], corner[axis_]);
    }
    [[nodiscard]] bool has(const Corner& corner) const {
        const std::size_t line = line_of(corner);
        return first_[line] == corner[axis_] || last_[line] == corner[axis_];
    }

    /// Whether the lines through a box of corners, `side` boxes wide, go on beyond it on both sides.
    [[nodiscard]] bool surround(const Corner& low, int side) const {
        Corner at = low;
        const std::size_t u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        for (at[u] = low[u]; at[u] <= low[u] + side; ++at[u]) {
            for (at[v] = low[v]; at[v] <= low[v] + side; ++at[v]) {
                const std::size_t line = line_of(at);
                if (first_[line] > low[axis_] || last_[line] < low[axis_] + side) return false;
            }
        }
        return true;
    }

    template <class F>
    void for_each(F f) const {
        for (std::size_t line = 0; line < first_.size(); ++line) {
            if (last_[line] < 0) continue;
            Corner corner{};
            corner[(axis_ + 1) % 3] = static_cast<std::uint16_t>(line / corners);
            corner[(axis_ + 2) % 3] = static_cast<std::uint16_t>(line % corners);
            corner[axis_] = static_cast<std::uint16_t>(first_[line]);
            f(corner);
            corner[axis_] = static_cast<std::uint16_t>(last_[line]);
            if (first_[line] != last_[line]) f(corner);
        }
    }

private:
    [[nodiscard]] std::size_t line_of(const Corner& corner) const {
        return corner[(axis_ + 1) % 3] * corners + corner[(axis_ + 2) % 3];
    }

    std::size_t axis_;
    std::vector<std::int32_t> first_, last_;  // of each line
};

}  // namespace

std::vector<std::array<double, 3>> Cells::outline() const {
    const FormulaKernels& kernels = best_formula_kernels();
    void* const memory = scratch(max_registers_);
    std::vector<Decision> decisions(max_code_);
    Ends along_x(0);
    struct Cube {
        Corner low;
        int side;  // in smallest boxes
    };
    constexpr int finest_side = static_cast<int>(finest / tolerance);
    const auto coordinate = [](int corner) { return static_cast<float>(corner) * tolerance - 1; };
    std::vector<Cube> open, halves;
    for (const Cell& cell : cells_) {
        Interruption::check();
        const Code code = this->code(cell.code);
        Corner low;
        for (std::size_t axis = 0; axis < 3; ++axis) low[axis] = static_cast<std::uint16_t>(finest_side * cell.at[axis]);
        open.assign(1, {low, finest_side * side(cell.level)});
        while (!open.empty()) {
            const Cube part = open.back();
            open.pop_back();
            if (along_x.surround(part.low, part.side)) continue;
            if (part.side == 1) {
                for (int i = 0; i < 8; ++i) {
                    Corner corner = part.low;
                    for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] += i >> axis & 1;
                    along_x.add(corner);
                }
                continue;
            }
            halves.clear();
            for (int i = 0; i < 8; ++i) {
                Cube half{part.low, part.side / 2};
                for (std::size_t axis = 0; axis < 3; ++axis) half.low[axis] += (i >> axis & 1) * half.side;
                halves.push_back(half);
            }
            for (int start = 0; start < 8; start += kernels.lanes) {
                const int lanes = std::min(8 - start, kernels.lanes);
                BoxBatch boxes{};
                for (int lane = 0; lane < lanes; ++lane) {
                    const Cube& half = halves[static_cast<std::size_t>(start + lane)];
                    for (int axis = 0; axis < 3; ++axis) {
                        const int at = half.low[static_cast<std::size_t>(axis)];
                        boxes.low[axis][lane] = coordinate(at), boxes.high[axis][lane] = coordinate(at + half.side);
                    }
                }
                kernels.bounds(code, boxes, decisions.data(), memory);
                for (int lane = 0; lane < lanes; ++lane) {
                    if (may_change_sign(boxes, lane)) open.push_back(halves[static_cast<std::size_t>(start + lane)]);
                }
            }
        }
    }
    Ends along_y(1), along_z(2);
    along_x.for_each([&](const Corner& corner) { along_y.add(corner); });
    along_y.for_each([&](const Corner& corner) {
        if (along_x.has(corner)) along_z.add(corner);
    });
    std::vector<std::array<double, 3>> points;
    along_z.for_each([&](const Corner& corner) {
        points.push_back({double{coordinate(corner[0])}, double{coordinate(corner[1])}, double{coordinate(corner[2])}});
    });
    return points;
}

}  // namespace bob
