#include "base/simd.h"
#include "shapes/implicit/walk.h"

namespace bob::BOB_ISA {
namespace {

inline M clamp(M a, M low, M high) {
    a = a < low ? low : a;
    return a > high ? high : a;
}

/// Finest cells in a unit of length.
constexpr float scale = CellGrid::side / 2;

/// Some walks as columns, a lane each.
struct WalkColumns {
    enum { origin = 0, direction = 3, length = 6, end, at, size_log2 = 11, enter, leave, cell, unresolved, count };
    static_assert(count * sizeof(float) == sizeof(Walk));

    F of[count];
    float* rows[lanes];
    int used;

    /// `used` lanes, at least one; walk_of(lane) returns the walk.
    template <class WalkOf>
    WalkColumns(int used, WalkOf walk_of) : used(used) {
        for (int i = 0; i < lanes; ++i) rows[i] = reinterpret_cast<float*>(&walk_of(i < used ? i : 0));
        load_rows(rows, of);
    }

    F& operator[](int column) { return of[column]; }
    [[nodiscard]] F origin_of(int axis) const { return (of[origin + axis] + 1.f) * scale; }
    [[nodiscard]] F direction_of(int axis) const { return of[direction + axis] * scale; }

    void write_all() { store_rows<0>(of, rows, used); }
    /// Stores the columns that change along the walk.
    void write() { store_rows<lanes <= count - at ? at : 0>(of, rows, used); }
};

/// Walking rays, a lane each. Lengths are in finest cells.
struct Walks {
    F origin[3], direction[3], inverse[3];
    M at[3], size_log2;
    F enter, end;

    explicit Walks(const WalkColumns& columns) : size_log2((M)columns.of[WalkColumns::size_log2]), enter(columns.of[WalkColumns::enter]), end(columns.of[WalkColumns::end]) {
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = columns.origin_of(axis), direction[axis] = columns.direction_of(axis);
            inverse[axis] = 1.f / direction[axis];
            at[axis] = (M)columns.of[WalkColumns::at + axis];
        }
    }

    [[nodiscard]] M low(int axis) const { return at[axis] >> size_log2 << size_log2; }
    [[nodiscard]] M forward(int axis) const { return direction[axis] > F{}; }

    /// Ray parameters at the exit faces of the cells along an axis.
    [[nodiscard]] F face(int axis) const {
        const M size = all(1) << size_log2;
        const F plane = to_floats(low(axis) + (forward(axis) & size));
        const F never = constant(std::numeric_limits<float>::infinity());
        return direction[axis] == F{} ? never : (plane - origin[axis]) * inverse[axis];
    }
    [[nodiscard]] F leave() const { return min(min(face(0), face(1)), face(2)); }

    /// Moves to the neighbours across the first faces; returns a mask of rays still in the grid.
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

    /// Tree entries at the rays; sets `size_log2` to their size.
    M look_up(const CellGrid& grid, M looking) {
        constexpr int top_size = 2 * CellGrid::levels - CellGrid::top_log2;
        const M place = (at[0] >> top_size) | (at[1] >> top_size) << CellGrid::top_log2 | (at[2] >> top_size) << 2 * CellGrid::top_log2;
        M child = gather(grid.top, (looking & place)), node = child;
        M size = all(top_size) + ((child == all(CellGrid::all_empty)) & 2);
        M open = looking & (child >= M{}) & (child < all(CellGrid::all_empty));
        while (bits(open)) {
            size = open ? size - 2 : size;
            const M index = ((at[0] >> size) & 3) | ((at[1] >> size) & 3) << 2 | ((at[2] >> size) & 3) << 4;
            const M found = gather(grid.children, (open & node) * 64 + index);
            child = open ? found : child;
            open &= (found >= M{}) & (found != all(CellGrid::empty));
            node = open ? found : node;
        }
        size_log2 = looking ? size : size_log2;
        return child;
    }
};

void start(const CellGrid& grid, const Ray* rays, std::size_t count, Walk* walks) {
    constexpr std::size_t at_once = 64;  // few enough to stay in the cache, and the first writes have left the store buffer
    for (std::size_t first = 0; first < count; first += at_once) {
        const std::size_t last = count - first < at_once ? count : first + at_once;
        for (std::size_t i = first; i < last; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                walks[i].origin[axis] = rays[i].origin[axis], walks[i].direction[axis] = rays[i].direction[axis];
            }
        }
        for (std::size_t i = first; i < last; i += lanes) {
            WalkColumns columns(last - i < lanes ? static_cast<int>(last - i) : lanes, [&](int lane) -> Walk& { return walks[i + static_cast<std::size_t>(lane)]; });
            F enter{}, end = constant(std::numeric_limits<float>::infinity()), origin[3], direction[3], squared{};
            for (int axis = 0; axis < 3; ++axis) {
                origin[axis] = columns.origin_of(axis), direction[axis] = columns.direction_of(axis);
                const F low = constant((grid.low[axis] + 1) * scale), high = constant((grid.high[axis] + 1) * scale);
                const F inverse = 1.f / direction[axis], a = (low - origin[axis]) * inverse, b = (high - origin[axis]) * inverse;
                const M moves = direction[axis] != F{}, beside = ~((origin[axis] >= low) & (origin[axis] <= high));
                const F soonest = a < b ? a : b, latest = a < b ? b : a;
                enter = (moves & (soonest > enter)) ? soonest : enter;
                end = (moves & (latest < end)) ? latest : end;
                end = (~moves & beside) ? constant(-1) : end;
                squared += columns[WalkColumns::direction + axis] * columns[WalkColumns::direction + axis];
            }
            for (int axis = 0; axis < 3; ++axis) {
                const F p = origin[axis] + enter * direction[axis], last_cell = constant(CellGrid::side - 1);
                columns[WalkColumns::at + axis] = (F)to_integers(p > F{} ? (p < last_cell ? p : last_cell) : F{});
            }
            columns[WalkColumns::length] = sqrt(squared), columns[WalkColumns::end] = end;
            columns[WalkColumns::size_log2] = (F)all(-1);
            columns[WalkColumns::enter] = enter, columns[WalkColumns::leave] = F{};
            columns[WalkColumns::cell] = (F)(enter <= end ? M{} : all(static_cast<std::int32_t>(Walk::none)));
            columns[WalkColumns::unresolved] = F{};
            columns.write_all();
        }
    }
}

void next_batch(const CellGrid& grid, Walk* walks, const std::uint32_t* some, int count) {
    WalkColumns columns(count, [&](int lane) -> Walk& { return walks[some[lane]]; });
    Walks rays(columns);
    M moving = ((M)columns[WalkColumns::cell] != all(static_cast<std::int32_t>(Walk::none))) & first_lanes(count);
    M arrived{}, cell{};
    // First out of the current cell, if there is one.
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
    for (int axis = 0; axis < 3; ++axis) columns[WalkColumns::at + axis] = (F)rays.at[axis];
    columns[WalkColumns::size_log2] = (F)rays.size_log2;
    columns[WalkColumns::enter] = rays.enter;
    columns[WalkColumns::leave] = leave > rays.enter ? leave : rays.enter;
    columns[WalkColumns::cell] = (F)(arrived ? cell : all(static_cast<std::int32_t>(Walk::none)));
    columns.write();
}

void next(const CellGrid& grid, Walk* walks, const std::uint32_t* some, std::size_t count) {
    for (std::size_t i = 0; i < count; i += lanes) {
        next_batch(grid, walks, some + i, count - i < lanes ? static_cast<int>(count - i) : lanes);
    }
}

}  // namespace

const WalkKernels walk_kernels = {start, next};

}  // namespace bob::BOB_ISA
