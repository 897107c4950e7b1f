#include "shapes/walk.h"
#include "simd.h"

namespace bob::BOB_ISA {
namespace {

inline M clamp(M a, M low, M high) {
    a = a < low ? low : a;
    return a > high ? high : a;
}

/// Some rays' walks, a lane each.
struct Walks {
    F origin[3], direction[3], inverse[3];
    M at[3], size_log2;
    F enter, end;

    Walks(const Walk* walks, const std::uint32_t* some, int count) {
        for (int i = 0; i < lanes; ++i) {
            const Walk& w = walks[some[i < count ? i : 0]];
            for (int axis = 0; axis < 3; ++axis) {
                origin[axis][i] = w.origin[axis];
                direction[axis][i] = w.direction[axis];
                at[axis][i] = w.at[axis];
            }
            size_log2[i] = w.size_log2;
            enter[i] = w.enter;
            end[i] = w.end;
        }
        for (int axis = 0; axis < 3; ++axis) inverse[axis] = 1.f / direction[axis];
    }

    [[nodiscard]] M low(int axis) const { return at[axis] >> size_log2 << size_log2; }
    [[nodiscard]] M forward(int axis) const { return direction[axis] > F{}; }

    /// Where each ray comes to the face of its cell along an axis.
    [[nodiscard]] F face(int axis) const {
        const M size = all(1) << size_log2;
        const F plane = to_floats(low(axis) + (forward(axis) & size));
        const F never = constant(std::numeric_limits<float>::infinity());
        return direction[axis] == F{} ? never : (plane - origin[axis]) * inverse[axis];
    }
    [[nodiscard]] F leave() const { return min(min(face(0), face(1)), face(2)); }

    /// Crosses to the neighbours behind the faces that come first; a mask of those that are still in the grid.
    M cross(M moving) {
        const F t[3] = {face(0), face(1), face(2)};
        const F first = min(min(t[0], t[1]), t[2]);
        const M through_x = t[0] == first, through_y = ~through_x & (t[1] == first);
        const M through[3] = {through_x, through_y, ~(through_x | through_y)};
        M inside = moving & (first < end);
        const F here = max(enter, first);
        const M size = all(1) << size_log2;
        for (int axis = 0; axis < 3; ++axis) {
            const M from = low(axis);
            const M behind = forward(axis) ? from + size : from - 1;
            const M beside = clamp(to_integers(origin[axis] + here * direction[axis]), from, from + size - 1);
            const M to = through[axis] ? behind : beside;
            at[axis] = moving ? to : at[axis];
            inside &= (to >= M{}) & (to < all(CellGrid::side));
        }
        enter = moving ? here : enter;
        return inside;
    }

    /// What the tree holds where the rays are; `size_log2` becomes the size of it.
    M look_up(const CellGrid& grid, M looking) {
        M child{}, node{};
        M size = all(2 * (CellGrid::levels - 1));
        M open = looking;
        for (int level = 0; level < CellGrid::levels; ++level) {
            const M index = ((at[0] >> size) & 3) | ((at[1] >> size) & 3) << 2 | ((at[2] >> size) & 3) << 4;
            const M found = gather(grid.children, (open & (node * 64 + index)));
            child = open ? found : child;
            open &= (found >= M{}) & (found != all(CellGrid::empty));
            if (!bits(open)) break;
            node = open ? found : node;
            size = open ? size - 2 : size;
        }
        size_log2 = looking ? size : size_log2;
        return child;
    }
};

void start(const CellGrid& grid, const Ray* rays, std::size_t count, Walk* walks) {
    constexpr float scale = CellGrid::side / 2;
    for (std::size_t i = 0; i < count; ++i) {
        Walk w{};
        w.end = std::numeric_limits<float>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            w.origin[axis] = ((&rays[i].origin.x)[axis] + 1) * scale;
            w.direction[axis] = (&rays[i].direction.x)[axis] * scale;
            const float low = ((&grid.low.x)[axis] + 1) * scale, high = ((&grid.high.x)[axis] + 1) * scale;
            const float inverse = 1 / w.direction[axis];
            const float a = (low - w.origin[axis]) * inverse, b = (high - w.origin[axis]) * inverse;
            if (w.direction[axis] != 0) {
                w.enter = a < b ? (a > w.enter ? a : w.enter) : (b > w.enter ? b : w.enter);
                w.end = a < b ? (b < w.end ? b : w.end) : (a < w.end ? a : w.end);
            } else if (!(w.origin[axis] >= low && w.origin[axis] <= high)) {
                w.end = -1;
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            const float p = w.origin[axis] + w.enter * w.direction[axis];
            constexpr float last = CellGrid::side - 1;
            w.at[axis] = static_cast<std::int32_t>(p > 0 ? (p < last ? p : last) : 0);
        }
        w.size_log2 = -1;
        w.cell = w.enter <= w.end ? 0 : Walk::none;
        walks[i] = w;
    }
}

void next_batch(const CellGrid& grid, Walk* walks, const std::uint32_t* some, int count) {
    Walks rays(walks, some, count);
    M moving{};
    for (int i = 0; i < count; ++i) moving[i] = walks[some[i]].cell != Walk::none ? -1 : 0;
    M arrived{}, cell{};
    // Out of the present cell first, where there is one.
    const M beyond = moving & (rays.size_log2 >= M{});
    if (bits(beyond)) moving = beyond ? rays.cross(beyond) : moving;
    while (bits(moving)) {
        const M child = rays.look_up(grid, moving);
        const M found = moving & (child < M{});
        cell = found ? child & std::numeric_limits<std::int32_t>::max() : cell;
        arrived |= found;
        moving &= ~found;
        if (bits(moving)) moving = rays.cross(moving);
    }
    const F leave = min(rays.leave(), rays.end);
    for (int i = 0; i < count; ++i) {
        Walk& w = walks[some[i]];
        for (int axis = 0; axis < 3; ++axis) w.at[axis] = rays.at[axis][i];
        w.size_log2 = rays.size_log2[i];
        w.enter = rays.enter[i];
        w.leave = leave[i] > w.enter ? leave[i] : w.enter;
        w.cell = arrived[i] ? static_cast<std::uint32_t>(cell[i]) : Walk::none;
    }
}

void next(const CellGrid& grid, Walk* walks, const std::uint32_t* some, std::size_t count) {
    for (std::size_t i = 0; i < count; i += lanes) {
        next_batch(grid, walks, some + i, count - i < lanes ? static_cast<int>(count - i) : lanes);
    }
}

}  // namespace

const WalkKernels walk_kernels = {start, next};

}  // namespace bob::BOB_ISA
