#include "reprojection/history_kernels.h"

#include "base/vec_lanes.h"

namespace bob::BOB_ISA {
namespace {

/// Lower bound of the normal's z: limits the slope of surfaces seen nearly edge-on.
constexpr float min_normal_z = 0.3f;

inline M load_integers(const std::int32_t* p) { return (M)load<F>(reinterpret_cast<const float*>(p)); }
inline void store_integers(std::int32_t* p, M v) { store(reinterpret_cast<float*>(p), (F)v); }

inline M load_bytes(const std::uint8_t* p) {
    using Bytes [[gnu::vector_size(lanes)]] = std::uint8_t;
    Bytes bytes;
    std::memcpy(&bytes, p, sizeof bytes);
    return __builtin_convertvector(bytes, M);
}

/// Loads the first `count` bytes; another thread may write those after the row.
inline M load_bytes(const std::uint8_t* p, std::int32_t count) {
    if (count >= lanes) return load_bytes(p);
    std::uint8_t bytes[lanes]{};
    std::memcpy(bytes, p, static_cast<std::size_t>(count));
    return load_bytes(bytes);
}

inline F gathered(const float* p, M index) { return (F)gather(reinterpret_cast<const std::int32_t*>(p), index); }

inline F side(const Eye& eye, F depth) { return constant(eye.side_at_back) - depth * constant(eye.side_per_depth); }

/// Points whose depths differ by less belong to one surface.
inline F tolerance(const Eye& eye, F depth) { return constant(same_surface) * side(eye, depth); }

/// The points and squared distances of a vector of choices.
struct Chosen {
    M point;
    F off_center;

    explicit Chosen(const Choice* choices) {
        const auto* const halves = reinterpret_cast<const float*>(choices);
        const F first = load<F>(halves), second = load<F>(halves + lanes);
        point = (M)even(first, second), off_center = odd(first, second);
    }
};

/// Points relative to the eye along the camera's axes, and their projections.
struct Places {
    Vector3 from_eye;  // z: distance in front of the eye
    F row, column, distance;

    Places(const Eye& eye, const Vector3& point)
        : from_eye{dot(point, eye.right) - constant(eye.at.x), dot(point, eye.up) - constant(eye.at.y), constant(eye.at.z) - dot(point, eye.toward)} {
        F scale = constant(eye.pixels_per_radius);
        distance = from_eye.z;
        if (eye.in_perspective) {
            scale = scale / from_eye.z;
            distance = sqrt(dot(from_eye, from_eye));
        }
        row = constant(eye.middle_row) - from_eye.y * scale, column = constant(eye.middle_column) + from_eye.x * scale;
    }

    [[nodiscard]] F depth(const Eye& eye) const { return min(max(constant(eye.depth_at_eye) - distance * constant(eye.depth_per_radius), F{}), constant(1)); }

    /// Transforms a direction from the scene to screen space, as `Projection::on_screen`.
    [[nodiscard]] Vector3 on_screen(const Eye& eye, const Vector3& direction) const {
        const Vector3 axes{dot(direction, eye.right), dot(direction, eye.up), dot(direction, eye.toward)};
        if (!eye.in_perspective) return axes;
        const F scale = constant(1) / distance;
        const Vector3 to_eye{-from_eye.x * scale, -from_eye.y * scale, from_eye.z * scale};
        const F along = dot(axes, to_eye), k = (axes.z + along) / (constant(1) + to_eye.z);
        return {axes.x - k * to_eye.x, axes.y - k * to_eye.y, along};
    }
};

inline Vector3 load_point(const PointsIn<const float>& points, std::size_t i) {
    return {load<F>(points.x + i), load<F>(points.y + i), load<F>(points.z + i)};
}
inline Vector3 load_normal(const PointsIn<const float>& points, std::size_t i) {
    return {load<F>(points.normal_x + i), load<F>(points.normal_y + i), load<F>(points.normal_z + i)};
}

std::size_t see(const Eye& eye, const BorderedGrid& cells, PointsIn<const float> points, Sights sights, std::size_t begin, std::size_t end) {
    const F half = constant(0.5f), rows = constant(static_cast<float>(cells.height)), columns = constant(static_cast<float>(cells.width));
    M in_picture{};
    for (std::size_t i = begin; i < end; i += lanes) {
        const Places at(eye, load_point(points, i));
        const F row = at.row + half, column = at.column + half;  // NaN for a marked point
        const M inside = (row >= F{}) & (row < rows) & (column >= F{}) & (column < columns) & (at.from_eye.z > F{}) &
                         (lane_numbers() < all(static_cast<std::int32_t>(end - i)));
        const Vector3 normal = at.on_screen(eye, load_normal(points, i));
        const M seen = inside & (normal.z > F{});
        in_picture -= inside;
        const M whole_row = to_integers(inside ? row : F{}), whole_column = to_integers(inside ? column : F{});
        const F down = at.row - to_floats(whole_row), right = at.column - to_floats(whole_column);
        const F depth = at.depth(eye), steep = side(eye, depth) / max(normal.z, constant(min_normal_z));
        const M cell = (whole_row + all(BorderedGrid::border)) * all(cells.stride) + whole_column + all(BorderedGrid::border);
        store_integers(sights.cell + i, seen ? cell : all(BorderedGrid::nowhere));
        store(sights.depth + i, depth);
        store(sights.deeper_right + i, -normal.x * steep), store(sights.deeper_down + i, normal.y * steep);
        store(sights.off_center + i, down * down + right * right);
        store(sights.right + i, right), store(sights.down + i, down);
        store(sights.normal_x + i, normal.x), store(sights.normal_y + i, normal.y);
    }
    std::size_t sum = 0;
    for (int k = 0; k < lanes; ++k) sum += static_cast<std::size_t>(in_picture[k]);
    return sum;
}

void count(const float* depth, const std::uint8_t* empty, std::int32_t* counts, std::int32_t width) {
    for (std::int32_t x = 0; x < width; x += lanes) {
        const M known = (load<F>(depth + x) > constant(Surfaces::none)) | (load_bytes(empty + x) != M{});
        store_integers(counts + x, load_integers(counts + x) - known);
    }
}

/// Calls use(cell, depths of the disc's plane, sides) for all cells of a disc, row by row.
template <class Use>
inline void for_disc(const DiscRows& disc, const Surfaces& surfaces, std::int32_t cell, std::int32_t stride, Use use) {
    const float depth = surfaces.depth[cell], deeper_right = surfaces.deeper_right[cell], deeper_down = surfaces.deeper_down[cell];
    for (std::int32_t down = -disc.radius; down <= disc.radius; ++down) {
        const std::int32_t half = disc.half_widths[down + disc.radius];
        const float of_row = depth + deeper_down * static_cast<float>(down);
        for (std::int32_t right = -half; right <= half; right += lanes) {
            const M at = lane_numbers() + all(right);
            const F there = constant(of_row) + constant(deeper_right) * to_floats(at);
            use(cell + down * stride + right, at <= all(half), there, disc.sides[down + BorderedGrid::border] + (right + BorderedGrid::border));
        }
    }
}

void cover_far(DiscRows disc, Surfaces surfaces, Covers covers, std::int32_t cell, std::int32_t stride) {
    for_disc(disc, surfaces, cell, stride, [&](std::int32_t to, M inside, F depth, const std::int32_t*) {
        const F before = load<F>(covers.nearest + to);
        store(covers.nearest + to, max(inside ? depth : before, before));
    });
}

void look_far(const Eye& eye, DiscRows disc, Surfaces surfaces, Covers covers, std::int32_t cell, std::int32_t stride) {
    for_disc(disc, surfaces, cell, stride, [&](std::int32_t to, M inside, F depth, const std::int32_t* sides) {
        const F nearest = load<F>(covers.nearest + to);
        const M same = inside & (depth >= nearest - tolerance(eye, nearest));
        store_integers(covers.sides + to, load_integers(covers.sides + to) | (same & load_integers(sides)));
    });
}

/// Finishes the cells: the occlusion threshold, and whether a cell is inside its surface.
inline void end_cover_at(const Eye& eye, const Surfaces& surfaces, const Covers& covers, const std::int32_t* is_inside, std::int32_t to, F nearest, M sides) {
    const M inside = gather(is_inside, sides);
    const F depth = inside ? nearest : load<F>(surfaces.depth + to);
    store(covers.nearest + to, depth - tolerance(eye, depth)), store_integers(covers.sides + to, inside);
}

void cover(const Eye& eye, DiscRows disc, const std::int32_t* is_inside, Surfaces surfaces, Covers covers, std::int32_t first, std::int32_t stride,
           std::int32_t width, bool ends) {
    for (std::int32_t x = 0; x < width; x += lanes) {
        const std::int32_t to = first + x;
        // The cell itself and its neighbours to the left, right, above and below.
        constexpr std::int32_t rights[] = {0, 1, -1, 0, 0}, downs[] = {0, 0, 0, 1, -1};
        F around[5], nearest = ends ? constant(-1) : load<F>(covers.nearest + to);
        BOB_UNROLL
        for (int k = 0; k < 5; ++k) {
            const std::int32_t from = to - downs[k] * stride - rights[k];
            around[k] = load<F>(surfaces.depth + from);
            if (rights[k] != 0) around[k] += constant(static_cast<float>(rights[k])) * load<F>(surfaces.deeper_right + from);
            if (downs[k] != 0) around[k] += constant(static_cast<float>(downs[k])) * load<F>(surfaces.deeper_down + from);
            nearest = max(around[k], nearest);
        }
        const F min_depth = nearest - tolerance(eye, nearest);
        M sides{};
        BOB_UNROLL
        for (int k = 1; k < 5; ++k) sides |= (around[k] >= min_depth) & all(disc.sides[downs[k] + BorderedGrid::border][rights[k] + BorderedGrid::border]);
        if (ends) end_cover_at(eye, surfaces, covers, is_inside, to, nearest, sides);
        else store(covers.nearest + to, nearest), store_integers(covers.sides + to, sides);
    }
}

void end_cover(const Eye& eye, const std::int32_t* is_inside, Surfaces surfaces, Covers covers, std::int32_t first, std::int32_t width) {
    for (std::int32_t to = first; to < first + width; to += lanes) {
        end_cover_at(eye, surfaces, covers, is_inside, to, load<F>(covers.nearest + to), load_integers(covers.sides + to));
    }
}

void empty(WasEmpty was, const std::uint8_t* outside, const Choice* chosen, const std::int32_t* inside, const std::uint8_t* overrun,
           std::uint8_t* to, std::int32_t width) {
    using Bytes [[gnu::vector_size(lanes)]] = std::uint8_t;
    const F half = constant(0.5f), rows = constant(static_cast<float>(was.height)), columns = constant(static_cast<float>(was.width));
    for (std::int32_t x = 0; x < width; x += lanes) {
        const M may_be = (Chosen(chosen + x).point < M{}) & (load_integers(inside + x) == M{}) & (load_bytes(overrun + x) == M{});
        M is_empty{};
        if (bits(may_be)) {
            const std::int32_t k = x / WasEmpty::piece;
            const F along = constant(1.f / WasEmpty::piece) * to_floats(lane_numbers() + all(x % WasEmpty::piece));
            const F row = constant(was.row[k]) + along * constant(was.row[k + 1] - was.row[k]) + half;
            const F column = constant(was.column[k]) + along * constant(was.column[k + 1] - was.column[k]) + half;
            const M in_picture = (row >= F{}) & (row < rows) & (column >= F{}) & (column < columns);
            const M at = to_integers(in_picture ? row : rows) * all(was.width) + to_integers(in_picture ? column : F{});
            const bool in_a_row = bits(at != lane_numbers() + all(at[0])) == 0;
            const M was_empty = in_a_row ? load_bytes(was.empty + at[0]) : gather_bytes(was.empty, at);
            is_empty = may_be & ((was_empty != M{}) | (load_bytes(outside + x) != M{}));
        }
        const Bytes bytes = __builtin_convertvector(is_empty & all(1), Bytes);
        std::memcpy(to + x, &bytes, static_cast<std::size_t>(x + lanes <= width ? lanes : width - x));
    }
}

/// Stores a vector without writing past the row: the next row may belong to another thread.
inline void put(float* row, std::int32_t x, F values, std::int32_t width) {
    if (x + lanes <= width) store(row + x, values);
    else std::memcpy(row + x, &values, sizeof(float) * static_cast<std::size_t>(width - x));
}

std::int32_t expect(Sights sights, const Choice* choices, const std::uint8_t* empty, ExpectedRow to, std::int32_t width) {
    M surfaces{};
    for (std::int32_t x = 0; x < width; x += lanes) {
        const Chosen chosen(choices + x);
        const M is_empty = load_bytes(empty + x, width - x) != M{}, is_surface = (chosen.point >= M{}) & (lane_numbers() < all(width - x));
        surfaces -= is_surface;
        F depth{}, normal_x{}, normal_y{}, off_center = is_empty ? constant(0.5f) : F{};
        F right = is_empty ? F{} : constant(ExpectedRow::unknown), down = right;
        if (bits(is_surface)) {
            const M i = is_surface ? chosen.point : M{};
            const auto found = [=](const float* column) { return is_surface ? gathered(column, i) : F{}; };
            depth = found(sights.depth), normal_x = found(sights.normal_x), normal_y = found(sights.normal_y);
            off_center = is_surface ? sqrt(chosen.off_center) : off_center;
            right = is_surface ? gathered(sights.right, i) : right, down = is_surface ? gathered(sights.down, i) : down;
        }
        put(to.mask, x, is_surface | is_empty ? constant(1) : F{}, width), put(to.depth, x, depth, width);
        put(to.right, x, right, width), put(to.down, x, down, width);
        put(to.normal_x, x, normal_x, width), put(to.normal_y, x, normal_y, width), put(to.off_center, x, off_center, width);
    }
    std::int32_t sum = 0;
    for (int k = 0; k < lanes; ++k) sum += surfaces[k];
    return sum;
}

void smooth(const float* shades, const float* right, const float* down, std::int32_t stride, float* to, std::int32_t width) {
    // Smaller differences are invisible, and common.
    const F min_difference = constant(1 / 32.f), one = constant(1);
    for (std::int32_t x = 0; x < width; x += lanes) {
        const F own = load<F>(shades + x);
        F low = own, high = own;
        for (int k = 0; k < 9; ++k) {
            const F there = load<F>(shades + x + (k / 3 - 1) * stride + k % 3 - 1);
            low = min(there, low), high = max(there, high);
        }
        const F off_center = load<F>(right + x);
        const M changes = (high - low > min_difference) & (off_center != F{}) & (off_center != constant(ExpectedRow::unknown));
        F smooth = own;
        if (bits(changes)) {
            F sum{}, weights{};
            for (int k = 0; k < 9; ++k) {
                const std::int32_t at = x + (k / 3 - 1) * stride + k % 3 - 1;
                const F across = load<F>(right + at) + constant(static_cast<float>(k % 3 - 1)), along = load<F>(down + at) + constant(static_cast<float>(k / 3 - 1));
                const F near = max(one - across * across - along * along, F{}), weight = near * near;
                sum += weight * load<F>(shades + at), weights += weight;
            }
            smooth = (changes & (weights > F{})) ? sum / weights : own;
        }
        put(to, x, smooth, width);
    }
}

void carry(const float* column, const Choice* chosen, float* to, std::int32_t width) {
    for (std::int32_t x = 0; x < width; x += lanes) {
        const M point = Chosen(chosen + x).point, is_surface = point >= M{};
        put(to, x, bits(is_surface) ? (is_surface ? gathered(column, is_surface ? point : M{}) : F{}) : F{}, width);
    }
}

}  // namespace

const HistoryKernels history_kernels = {see, count, cover_far, look_far, cover, end_cover, empty, expect, smooth, carry};

}  // namespace bob::BOB_ISA
