#include "shapes/implicit/bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "base/work.h"
#include "formula/jumps.h"
#include "formula/scratch.h"
#include "formula/tape.h"
#include "formula/turns.h"

namespace bob {
namespace {

/// A box is cut into 16 x 16 x 16 cells, and before that into blocks of 4 x 4 x 4 of them.
constexpr int cuts = 16, block = 4;

/// Units of work per box and instruction. When they are spent, the box stays as it is.
constexpr std::uint64_t budget = 1'200'000'000, budget_to_tighten = 100'000'000;

/// Forms of a formula for computing bounds.
struct Forms {
    const Tape& tape;
    const Tape* jumping = nullptr;       // without modulo, for splitting at jumps; null for no splitting
    std::span<const std::vector<Tape>> parts = {};  // split into sectors of rotations (formula/turns.h); empty for no splitting
};

/// Finds cells of a box that may contain f <= 0, with as few evaluations as possible.
class Inside {
public:
    Inside(const Forms& forms, const Bounds& box, Work& work) : forms_(forms), box_(box), work_(work) {
        std::vector<Index> blocks = all(cuts / block);
        for (Index& at : blocks) at = {block * at[0], block * at[1], block * at[2]};
        look(blocks, block, [&](const Index& corner, const Finding& found) {
            if (found.maybe) return true;
            for (const Index& at : all(block)) known({corner[0] + at[0], corner[1] + at[1], corner[2] + at[2]}) = Known::outside;
            return true;
        });
    }

    /// The box around these cells; empty without cells.
    [[nodiscard]] std::optional<Bounds> hull() {
        Bounds result{};
        for (int axis = 0; axis < 3; ++axis) {
            int first = 0, last = cuts - 1;
            while (first < cuts && !any(axis, first)) ++first;
            if (first == cuts) return std::nullopt;
            while (!any(axis, last)) --last;
            result.low[axis] = face(axis, first);
            result.high[axis] = face(axis, last + 1);
        }
        return result;
    }

    /// Whether f is unbounded in any cell.
    [[nodiscard]] bool is_vague() {
        bool vague = false;
        look(all(cuts), 1, [&](const Index&, const Finding& found) {
            vague = vague || (found.maybe && !found.bounded);
            return !vague;
        });
        return vague;
    }

private:
    using Index = std::array<int, 3>;
    enum class Known : std::uint8_t { nothing, outside, maybe };
    struct Finding {
        bool maybe, bounded;
    };

    static std::vector<Index> all(int side) {
        std::vector<Index> result;
        for (int i = 0; i < side * side * side; ++i) result.push_back({i % side, i / side % side, i / (side * side)});
        return result;
    }

    /// Whether a layer has a cell without surface.
    bool any(int axis, int layer) {
        std::vector<Index> unknown;
        for (int i = 0; i < cuts * cuts; ++i) {
            Index at;
            at[static_cast<std::size_t>(axis)] = layer;
            at[static_cast<std::size_t>((axis + 1) % 3)] = i % cuts;
            at[static_cast<std::size_t>((axis + 2) % 3)] = i / cuts;
            if (known(at) == Known::maybe) return true;
            if (known(at) == Known::nothing) unknown.push_back(at);
        }
        bool found_one = false;
        look(unknown, 1, [&](const Index& at, const Finding& found) {
            const bool maybe = found.maybe && !(forms_.jumping && is_outside_beside_jumps(at));
            known(at) = maybe ? Known::maybe : Known::outside;
            found_one = found_one || maybe;
            return !found_one;
        });
        return found_one;
    }

    /// Whether f is positive in a cell on each side of its jumps.
    bool is_outside_beside_jumps(const Index& at) {
        BoxBatch cell{};
        for (int axis = 0; axis < 3; ++axis) {
            const int k = at[static_cast<std::size_t>(axis)];
            cell.low[axis][0] = static_cast<float>(face(axis, k));
            cell.high[axis][0] = static_cast<float>(face(axis, k + 1));
        }
        const auto apart = with_jumps_outside(*forms_.jumping, cell, work_);
        return apart && apart->nodes().back().op == Op::constant && apart->nodes().back().value > 0;
    }

    /// Bounds of f in blocks of `side` cells, reported until `tell` returns false.
    template <class Tell>
    void look(const std::vector<Index>& corners, int side, Tell tell) {
        const auto lanes = static_cast<std::size_t>(best_formula_kernels().lanes);
        bool go_on = true;
        for (std::size_t first = 0; first < corners.size() && go_on; first += lanes) {
            BoxBatch boxes{};
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const Index& at = corners[std::min(first + lane, corners.size() - 1)];
                for (int axis = 0; axis < 3; ++axis) {
                    const int k = at[static_cast<std::size_t>(axis)];
                    boxes.low[axis][lane] = static_cast<float>(face(axis, k));
                    boxes.high[axis][lane] = static_cast<float>(face(axis, k + side));
                }
            }
            if (work_.is_spent()) {  // the rest stays unknown
                for (; first < corners.size() && go_on; ++first) go_on = tell(corners[first], Finding{true, false});
                return;
            }
            const std::uint32_t maybe = maybe_inside(forms_.tape, boxes);
            std::uint32_t in_sectors = forms_.parts.empty() ? maybe : 0;
            BoxBatch of_sector = boxes;
            for (const std::vector<Tape>& part : forms_.parts) {
                for (const Tape& sector : part) {
                    if ((maybe & ~in_sectors) == 0) break;
                    in_sectors |= maybe_inside(sector, of_sector);
                }
            }
            for (std::size_t lane = 0; lane < lanes && first + lane < corners.size(); ++lane) {
                go_on = tell(corners[first + lane], Finding{((maybe & in_sectors) >> lane & 1) != 0, std::isfinite(boxes.least[lane])}) && go_on;
            }
        }
    }

    /// Mask of boxes whose bounds allow f <= 0.
    std::uint32_t maybe_inside(const Tape& tape, BoxBatch& boxes) {
        const FormulaKernels& kernels = best_formula_kernels();
        const Code code = tape.code();
        decisions_.resize(std::max(decisions_.size(), tape.decisions().size()));
        work_.spend(static_cast<std::size_t>(kernels.lanes) * code.count);
        kernels.bounds(code, boxes, decisions_.data(), scratch(code.registers));
        std::uint32_t result = 0;
        for (int lane = 0; lane < kernels.lanes; ++lane) result |= static_cast<std::uint32_t>(!(boxes.least[lane] > 0)) << lane;
        return result & ~boxes.nowhere;
    }

    [[nodiscard]] double face(int axis, int k) const {
        return box_.low[axis] + (box_.high[axis] - box_.low[axis]) * k / cuts;
    }
    Known& known(const Index& at) { return known_[static_cast<std::size_t>((at[2] * cuts + at[1]) * cuts + at[0])]; }

    const Forms forms_;
    Bounds box_;
    Work& work_;
    std::vector<Decision> decisions_;
    std::array<Known, cuts * cuts * cuts> known_{};
};

/// A box, shrunk provably; empty if f is positive everywhere in it.
std::optional<Bounds> shrunk(const Forms& forms, Bounds box, Work& work) {
    for (int round = 0; round < 100; ++round) {
        const std::optional<Bounds> hull = Inside(forms, box, work).hull();
        if (!hull) return std::nullopt;
        double least_left = 1;
        for (int axis = 0; axis < 3; ++axis) {
            least_left = std::min(least_left, (hull->high[axis] - hull->low[axis]) / (box.high[axis] - box.low[axis]));
        }
        box = *hull;
        if (least_left > 0.99) break;
    }
    return box;
}

}  // namespace

std::optional<Bounds> find_bounds(const Expression& f) {
    const Tape tape(f);
    std::optional<Tape> jumping;
    if (f.uses(Op::modulo) || std::any_of(tape.decisions().begin(), tape.decisions().end(), may_jump)) jumping.emplace(without_modulo(f));
    const Forms plain{tape}, best{tape, jumping ? &*jumping : nullptr};
    // The box if f is positive outside it, an empty box if f is positive everywhere, nothing if neither can be proved.
    const auto enclosed = [&](const Forms& forms) -> std::optional<std::optional<Bounds>> {
        Work work(budget);
        // A formula that overflows far from the origin may have bounds nearer to it.
        for (const double reach : {1e9, 1e6, 1e3, 30.}) {
            const std::optional<Bounds> box = shrunk(forms, {{-reach, -reach, -reach}, {reach, reach, reach}}, work);
            if (!box) return box;
            bool open = false;
            for (int axis = 0; axis < 3; ++axis) open = open || box->low[axis] <= -reach || box->high[axis] >= reach;
            if (!open) {
                Work more(budget_to_tighten);
                return best.jumping && !forms.jumping ? shrunk(best, *box, more) : box;
            }
            if (work.is_spent()) throw std::invalid_argument("an expression whose bounds are found in a few seconds, got one that takes longer");
            if (!Inside(forms, *box, work).is_vague()) break;
        }
        return std::nullopt;
    };
    if (const auto found = enclosed(plain)) return *found;
    // Bounds of cells with jumps, or with twists by any angle, are loose at any distance. Splitting them is slow, so it is done only if
    // needed, and then to shrink the box.
    std::vector<std::vector<Tape>> parts;
    for (const Sectors& part : in_sectors(f)) parts.emplace_back(part.begin(), part.end());
    if (!parts.empty()) {
        if (const auto found = enclosed({tape, nullptr, parts})) return *found;
    }
    if (jumping) {
        if (const auto found = enclosed(best)) return *found;
    }
    throw std::invalid_argument("an expression that is bounded, got one whose inside may reach beyond 1e9 from the origin");
}

}  // namespace bob
