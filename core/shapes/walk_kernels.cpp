#include "shapes/walk.h"

#include <cstddef>

#include "simd.h"

namespace bob::BOB_ISA {
namespace {

/// Lane k of row i becomes lane i of row k.
inline void transpose(F (&rows)[lanes]) {
    BOB_UNROLL
    for (int step = 1; step < lanes; step *= 2) {
        F zipped[lanes];
        BOB_UNROLL
        for (int i = 0; i < lanes / 2; ++i) {
            zipped[2 * i] = zip_low(rows[i], rows[i + lanes / 2]);
            zipped[2 * i + 1] = zip_high(rows[i], rows[i + lanes / 2]);
        }
        BOB_UNROLL
        for (int i = 0; i < lanes; ++i) rows[i] = zipped[i];
    }
}

inline M clamp(M a, M low, M high) {
    a = a < low ? low : a;
    return a > high ? high : a;
}

constexpr int words_of_walk = sizeof(Walk) / sizeof(float);
static_assert(words_of_walk % lanes == 0 && offsetof(Walk, enter) == 16 && offsetof(Walk, cell) == 24 && offsetof(Walk, origin) == 32 &&
              offsetof(Walk, end) == 56);

inline const float* words(const Walk& walk) { return reinterpret_cast<const float*>(&walk); }
inline float* words(Walk& walk) { return reinterpret_cast<float*>(&walk); }

/// Some rays' walks, a lane each.
struct Walks {
    F origin[3], direction[3], inverse[3];
    M at[3], size_log2, cell, unresolved;
    F enter, end;

    Walks(const Walk* walks, const std::uint32_t* some, int count) {
        F word[words_of_walk];
        for (int first = 0; first < words_of_walk; first += lanes) {
            F rows[lanes];
            for (int i = 0; i < lanes; ++i) rows[i] = load<F>(words(walks[some[i < count ? i : 0]]) + first);
            transpose(rows);
            for (int k = 0; k < lanes; ++k) word[first + k] = rows[k];
        }
        for (int axis = 0; axis < 3; ++axis) {
            at[axis] = (M)word[axis];
            origin[axis] = word[8 + axis];
            direction[axis] = word[11 + axis];
            inverse[axis] = 1.f / direction[axis];
        }
        size_log2 = (M)word[3], cell = (M)word[6], unresolved = (M)word[7];
        enter = word[4], end = word[14];
    }

    /// Where the first `count` rays are now, and where they leave the cells they are in.
    void write(Walk* walks, const std::uint32_t* some, int count) const {
        const F leave = max(min(this->leave(), end), enter);
        const F word[words_of_walk] = {(F)at[0],  (F)at[1],  (F)at[2],  (F)size_log2, enter,        leave,        (F)cell, (F)unresolved,
                                       origin[0], origin[1], origin[2], direction[0], direction[1], direction[2], end,     F{}};
        constexpr int changed = 7;
        for (int first = 0; first < changed; first += lanes) {
            F rows[lanes];
            for (int k = 0; k < lanes; ++k) rows[k] = word[first + k];
            transpose(rows);
            for (int i = 0; i < count; ++i) store(words(walks[some[i]]) + first, rows[i]);
        }
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
    for (int i = 0; i < lanes; ++i) moving[i] = i < count ? -1 : 0;
    moving &= rays.cell != all(-1);
    M arrived{};
    // Out of the present cell first, where there is one.
    const M beyond = moving & (rays.size_log2 >= M{});
    if (bits(beyond)) moving = beyond ? rays.cross(beyond) : moving;
    while (bits(moving)) {
        const M child = rays.look_up(grid, moving);
        const M found = moving & (child < M{});
        rays.cell = found ? child & std::numeric_limits<std::int32_t>::max() : rays.cell;
        arrived |= found;
        moving &= ~found;
        if (bits(moving)) moving = rays.cross(moving);
    }
    rays.cell = arrived ? rays.cell : all(-1);
    rays.write(walks, some, count);
}

void next(const CellGrid& grid, Walk* walks, const std::uint32_t* some, std::size_t count) {
    for (std::size_t i = 0; i < count; i += lanes) {
        next_batch(grid, walks, some + i, count - i < lanes ? static_cast<int>(count - i) : lanes);
    }
}

}  // namespace

const WalkKernels walk_kernels = {start, next};

}  // namespace bob::BOB_ISA
