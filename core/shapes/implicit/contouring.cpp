#include "shapes/implicit/contouring.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/interruption.h"
#include "base/parallel.h"
#include "formula/scratch.h"
#include "shapes/implicit/visits.h"
#include "shapes/implicit/walk.h"

namespace bob {
namespace {

// ---- Inside points of the lattice ----------------------------------------------------------------------------

constexpr int word_bits = 64;

/// A bit for each point of a lattice layer in row order, with prefix counts of ones.
class Bits {
public:
    Bits(int rows, int columns)
        : words_((columns + word_bits - 1) / word_bits), bits_(static_cast<std::size_t>(rows) * static_cast<std::size_t>(words_)) {}

    [[nodiscard]] int words() const { return words_; }
    [[nodiscard]] std::uint64_t* row(int y) { return bits_.data() + static_cast<std::ptrdiff_t>(y) * words_; }
    [[nodiscard]] const std::uint64_t* row(int y) const { return bits_.data() + static_cast<std::ptrdiff_t>(y) * words_; }
    [[nodiscard]] bool operator()(int x, int y) const { return row(y)[x / word_bits] >> (x % word_bits) & 1; }

    /// Numbers the ones; returns their count.
    std::size_t number() {
        before_.resize(bits_.size());
        std::uint32_t sum = 0;
        for (std::size_t i = 0; i < bits_.size(); ++i) {
            before_[i] = sum;
            sum += static_cast<std::uint32_t>(std::popcount(bits_[i]));
        }
        return sum;
    }
    /// The number of a one.
    [[nodiscard]] std::size_t number_of(int x, int y) const {
        const std::size_t word = static_cast<std::size_t>(y) * static_cast<std::size_t>(words_) + static_cast<std::size_t>(x / word_bits);
        const std::uint64_t below = (std::uint64_t{1} << (x % word_bits)) - 1;
        return before_[word] + static_cast<std::size_t>(std::popcount(bits_[word] & below));
    }

    /// Calls body(x, y) for each one, in order.
    template <class Body>
    void for_each(Body body) const {
        for (std::size_t i = 0; i < bits_.size(); ++i) {
            const int y = static_cast<int>(i) / words_, x = static_cast<int>(i) % words_ * word_bits;
            for (std::uint64_t left = bits_[i]; left; left &= left - 1) body(x + std::countr_zero(left), y);
        }
    }

private:
    int words_;
    std::vector<std::uint64_t> bits_;
    std::vector<std::uint32_t> before_;
};

void set(std::uint64_t* bits, int from, int to) {
    for (int i = from; i < to; ++i) bits[i / word_bits] |= std::uint64_t{1} << (i % word_bits);
}

/// Finds the inside points among `count` points along each ray, at t = 0, 1, … Rays start outside. Between the shape's cells,
/// the sign is that at the exit of the previous cell.
void inside(const Implicit& shape, std::span<const Ray> rays, int count, std::span<std::uint64_t* const> bits) {
    const Cells& cells = shape.cells();
    const FormulaKernels& kernels = best_formula_kernels();
    void* const memory = scratch(cells.max_registers());
    struct Row {
        int next = 0;  // the first unknown point
        bool inside = false;
    };
    struct Asked {
        std::uint32_t ray;
        float t;
        int point;  // or -1 at the exit from the cell
    };
    std::vector<Walk> walks;
    std::vector<Row> rows(rays.size());
    std::vector<Asked> asked;
    visit_cells(cells, rays, walks, [&](std::uint32_t code, Rays some) {
        Interruption::check();
        asked.clear();
        for (const std::uint32_t ray : some) {
            const Walk& walk = walks[ray];
            Row& row = rows[ray];
            const int first = std::max(row.next, static_cast<int>(std::ceil(walk.enter)));
            const int end = std::min(count, static_cast<int>(std::floor(walk.leave)) + 1);
            if (row.inside) set(bits[ray], row.next, std::min(first, count));
            for (int i = first; i < end; ++i) asked.push_back({ray, static_cast<float>(i), i});
            asked.push_back({ray, walk.leave, -1});
            row.next = std::max(first, end);
        }
        for (std::size_t begin = 0; begin < asked.size(); begin += static_cast<std::size_t>(kernels.lanes)) {
            const int lanes = static_cast<int>(std::min(asked.size() - begin, static_cast<std::size_t>(kernels.lanes)));
            float point[3][max_lanes], value[max_lanes];
            const float* const points[3] = {point[0], point[1], point[2]};
            for (int lane = 0; lane < lanes; ++lane) {
                const Asked& a = asked[begin + static_cast<std::size_t>(lane)];
                const Vec3 p = rays[a.ray].origin + a.t * rays[a.ray].direction;
                for (int axis = 0; axis < 3; ++axis) point[axis][lane] = p[axis];
            }
            kernels.values(cells.code(code), points, lanes, value, memory);
            for (int lane = 0; lane < lanes; ++lane) {
                const Asked& a = asked[begin + static_cast<std::size_t>(lane)];
                const bool in = value[lane] < 0;  // false for NaN
                if (a.point < 0) {
                    rows[a.ray].inside = in;
                } else if (in) {
                    set(bits[a.ray], a.point, a.point + 1);
                }
            }
        }
    });
}

// ---- Cells of the lattice ----------------------------------------------------------------------------------------------

// Corner x + 2 y + 4 z of a cell. Its edges 4 a to 4 a + 3 lie along axis a, in the order of their lower corners.

constexpr int next(int axis) { return (axis + 1) % 3; }
constexpr int last(int axis) { return (axis + 2) % 3; }

/// The edge between two neighbouring corners.
constexpr int edge_between(int a, int b) {
    const int axis = std::countr_zero(static_cast<unsigned>(a ^ b)), low = a & b;
    const int below = low & ((1 << axis) - 1), above = low >> (axis + 1);
    return 4 * axis + (below | above << axis);
}

/// Groups the crossed edges of a cell into sheets of the surface, by the inside corners.
struct Sheets {
    std::array<std::int8_t, 12> of_edge{};  // -1: not crossed
    int count = 0;
    int doubled = 0;  // bit 2 a + side: a sheet crosses that face of axis a twice
};

/// The corners of a face in order around it.
constexpr std::array<int, 4> face_corners(int axis, int side) {
    const int b = 1 << next(axis), c = 1 << last(axis), at = side << axis;
    return {at, at | b, at | b | c, at | c};
}

/// On a face crossed twice, the surface encloses the inside corners, in both cells of the face.
Sheets sheets_of(int corners) {
    std::array<int, 12> leader;
    std::iota(leader.begin(), leader.end(), 0);
    const auto find = [&](int edge) {
        while (leader[static_cast<std::size_t>(edge)] != edge) edge = leader[static_cast<std::size_t>(edge)];
        return edge;
    };
    const auto is_inside = [corners](int corner) { return (corners >> corner & 1) != 0; };
    std::array<bool, 12> crossed{};
    std::array<bool, 6> twice{};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            const std::array<int, 4> around = face_corners(axis, side);
            std::vector<int> edges;  // i: from corner i on
            for (int i = 0; i < 4; ++i) {
                const int edge = edge_between(around[static_cast<std::size_t>(i)], around[static_cast<std::size_t>((i + 1) % 4)]);
                if (is_inside(around[static_cast<std::size_t>(i)]) == is_inside(around[static_cast<std::size_t>((i + 1) % 4)])) continue;
                edges.push_back(edge);
                crossed[static_cast<std::size_t>(edge)] = true;
            }
            if (edges.size() == 4) {
                twice[static_cast<std::size_t>(2 * axis + side)] = true;
                if (is_inside(around[0])) std::rotate(edges.begin(), edges.begin() + 3, edges.end());
            }
            for (std::size_t i = 0; i < edges.size(); i += 2) {
                leader[static_cast<std::size_t>(find(edges[i]))] = find(edges[i + 1]);
            }
        }
    }
    Sheets result;
    std::array<int, 12> number;
    number.fill(-1);
    for (int edge = 0; edge < 12; ++edge) {
        const auto i = static_cast<std::size_t>(edge);
        result.of_edge[i] = -1;
        if (!crossed[i]) continue;
        int& n = number[static_cast<std::size_t>(find(edge))];
        if (n < 0) n = result.count++;
        result.of_edge[i] = static_cast<std::int8_t>(n);
    }
    for (int face = 0; face < 6; ++face) {
        if (!twice[static_cast<std::size_t>(face)]) continue;
        const std::array<int, 4> around = face_corners(face / 2, face % 2);
        const auto sheet = [&](int i) {
            const int edge = edge_between(around[static_cast<std::size_t>(i)], around[static_cast<std::size_t>((i + 1) % 4)]);
            return result.of_edge[static_cast<std::size_t>(edge)];
        };
        if (sheet(0) == sheet(1) && sheet(0) == sheet(2) && sheet(0) == sheet(3)) result.doubled |= 1 << face;
    }
    return result;
}

const std::array<Sheets, 256>& all_sheets() {
    static const std::array<Sheets, 256> all = [] {
        std::array<Sheets, 256> made;
        for (int corners = 0; corners < 256; ++corners) made[static_cast<std::size_t>(corners)] = sheets_of(corners);
        return made;
    }();
    return all;
}

// ---- Vertices ----------------------------------------------------------------------------------------------------------

using Point = std::array<double, 3>;  // in cells

/// The surface's crossing of a lattice edge: its parameter along the edge, and the normal; zero without a crossing.
struct Crossing {
    float t;
    Vec3 normal;
};

/// Sum of squared distances from planes: x'Ax - 2 b'x + c.
struct Quadric {
    double a[6] = {}, b[3] = {}, c = 0;  // a: xx, yy, zz, yz, zx, xy

    void add(const Point& p, Vec3 n) {
        const double x = n.x, y = n.y, z = n.z, d = x * p[0] + y * p[1] + z * p[2];
        a[0] += x * x, a[1] += y * y, a[2] += z * z, a[3] += y * z, a[4] += z * x, a[5] += x * y;
        b[0] += d * x, b[1] += d * y, b[2] += d * z;
        c += d * d;
    }
    [[nodiscard]] Point times(const Point& p) const {
        return {a[0] * p[0] + a[5] * p[1] + a[4] * p[2], a[5] * p[0] + a[1] * p[1] + a[3] * p[2],
                a[4] * p[0] + a[3] * p[1] + a[2] * p[2]};
    }
    [[nodiscard]] double operator()(const Point& p) const {
        const Point ap = times(p);
        return p[0] * (ap[0] - 2 * b[0]) + p[1] * (ap[1] - 2 * b[1]) + p[2] * (ap[2] - 2 * b[2]) + c;
    }
};

/// Eigenvalues of a symmetric matrix, and eigenvectors as columns: Jacobi's rotations (Golub and Van Loan, section 8.5).
void diagonalise(double (&a)[3][3], double (&v)[3][3]) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) v[i][j] = i == j;
    }
    for (int sweep = 0; sweep < 12; ++sweep) {
        const double off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        if (off < 1e-24) return;
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
                const double cosine = 1 / std::sqrt(t * t + 1), sine = t * cosine;
                for (int k = 0; k < 3; ++k) {
                    const double x = a[k][p], y = a[k][q];
                    a[k][p] = cosine * x - sine * y, a[k][q] = sine * x + cosine * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = a[p][k], y = a[q][k];
                    a[p][k] = cosine * x - sine * y, a[q][k] = sine * x + cosine * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = v[k][p], y = v[k][q];
                    v[k][p] = cosine * x - sine * y, v[k][q] = sine * x + cosine * y;
                }
            }
        }
    }
}

/// Eigenvalues below this share of the largest are treated as zero: along their directions, a vertex stays at the mean of its
/// crossings. Edges sharper than about 2 asin(sqrt(share)) are kept; if it is too small, vertices slide along smooth surfaces.
constexpr double least_share = 0.02;

/// The least-squares point of all planes that is nearest to the mean of the crossings.
Point meeting_point(const Quadric& quadric, const Point& middle) {
    const double* m = quadric.a;
    double a[3][3] = {{m[0], m[5], m[4]}, {m[5], m[1], m[3]}, {m[4], m[3], m[2]}}, v[3][3];
    const Point am = quadric.times(middle);
    diagonalise(a, v);
    const double largest = std::max({a[0][0], a[1][1], a[2][2]});
    Point result = middle;
    for (int k = 0; k < 3; ++k) {
        if (!(a[k][k] > least_share * largest)) continue;
        double along = 0;
        for (std::size_t i = 0; i < 3; ++i) along += v[i][k] * (quadric.b[i] - am[i]);
        for (std::size_t i = 0; i < 3; ++i) result[i] += v[i][k] * along / a[k][k];
    }
    return result;
}

/// The least-squares point of all planes within a box, regularised towards the mean of the crossings. If the planes meet outside, it
/// is the best point on the border, found by coordinate descent.
void keep_within(Point& point, const Point& low, const Point& high, const Quadric& quadric, const Point& middle) {
    constexpr int other[3][2] = {{5, 4}, {5, 3}, {4, 3}};  // indices of off-diagonal entries
    const auto is_in = [&](std::size_t axis) { return point[axis] >= low[axis] && point[axis] <= high[axis]; };
    if (is_in(0) && is_in(1) && is_in(2)) return;
    const double pull = 0.01 * (quadric.a[0] + quadric.a[1] + quadric.a[2]) + 1e-12;
    for (int round = 0; round < 24; ++round) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double rest = quadric.a[other[axis][0]] * point[axis == 0 ? 1 : 0] + quadric.a[other[axis][1]] * point[axis == 2 ? 1 : 2];
            const double best = (quadric.b[axis] - rest + pull * middle[axis]) / (quadric.a[axis] + pull);
            point[axis] = std::clamp(best, low[axis], high[axis]);
        }
    }
}

/// Range of a cell's vertices: the cell, and half of each neighbour across a face without crossed edges. Sharp edges and corners of
/// the surface may poke through this face.
std::pair<Point, Point> room_of(const Point& low, int corners) {
    Point from = low, to = low;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        for (int side = 0; side < 2; ++side) {
            int inside = 0;
            for (const int corner : face_corners(axis, side)) inside += corners >> corner & 1;
            (side ? to : from)[a] += (inside % 4 ? 0 : side ? 0.5 : -0.5) + side;
        }
    }
    return {from, to};
}

// ---- The lattice, layer by layer ---------------------------------------------------------------------------------------

/// The lattice points at one z, and their edges.
struct Layer {
    Bits inside;
    std::array<Bits, 2> crossed;  // edges along x and y, at their lower points
    std::array<std::vector<Crossing>, 2> crossings;

    Layer(int rows, int columns) : inside(rows, columns), crossed{Bits{rows, columns}, Bits{rows, columns}} {}
};

/// Cells and edges between two layers.
struct Slab {
    Bits crossed;  // edges along z
    Bits cells;
    std::vector<Crossing> crossings;
    std::vector<std::array<int, 2>> places;  // x and y of each cell
    std::vector<std::uint8_t> corners;       // inside corners of each cell
    std::vector<std::int32_t> first;         // the first vertex of each cell
    std::vector<std::array<Crossing, 4>> diagonals;  // of each cell of one sheet, from its lower corners on; NaN: not crossed
    std::int32_t first_of_all = 0;
    std::vector<Quadric> quadrics;  // of each vertex

    Slab(int rows, int columns) : crossed(rows, columns), cells(rows, columns) {}
};

class Contouring {
public:
    Contouring(const Implicit& shape, double step) : shape_(shape), side_(step / shape.sphere().radius) {
        const Box& hull = shape.cells().hull();
        for (int axis = 0; axis < 3; ++axis) {
            const double low = hull.low[axis], size = hull.high[axis] - low, cells = std::ceil(size / side_) + 1;
            if (!(cells <= max_lattice)) {
                throw std::invalid_argument("more than " + std::to_string(max_lattice) + " cells along an axis");
            }
            points_[axis] = static_cast<int>(cells) + 1;
            // Off-centre, so that planes of symmetry and faces at round coordinates do not pass through lattice points.
            low_[axis] = low - (cells * side_ - size) * share_below[axis];
        }
    }

    Triangulation run() {
        const int chunk = std::clamp(rows_at_once / points_[1], 1, points_[2]);
        add_layer();  // the lowest layer and the one below it, all outside
        for (lowest_ = 0; lowest_ + 1 < points_[2]; lowest_ += static_cast<int>(layers_.size()) - 1, drop_layers()) {
            while (static_cast<int>(layers_.size()) <= std::min(chunk, points_[2] - 1 - lowest_)) add_layer();
            look_inside();
            for (std::size_t i = 1; i < layers_.size(); ++i) find_crossed(i);
            find_crossings();
            for (std::size_t i = 1; i < layers_.size(); ++i) place_vertices(i);
            for (std::size_t i = 1; i < layers_.size(); ++i) join(i);
        }
        const auto& [center, radius] = shape_.sphere();
        for (Point& p : mesh_.vertices) {
            for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = center[axis] + radius * (low_[axis] + side_ * p[axis]);
        }
        return std::move(mesh_);
    }

private:
    static constexpr double share_below[3] = {0.467, 0.533, 0.481};
    static constexpr int rows_at_once = 16384;
    static constexpr std::size_t grain = 1024;

    void add_layer() {
        layers_.emplace_back(points_[1], points_[0]);
        slabs_.emplace_back(points_[1], points_[0]);
    }

    /// Keeps the highest layer, and the slab below it.
    void drop_layers() {
        layers_.erase(layers_.begin(), layers_.end() - 1);
        slabs_.erase(slabs_.begin(), slabs_.end() - 1);
    }

    [[nodiscard]] Vec3 position(int x, int y, int z) const {
        return {static_cast<float>(low_[0] + side_ * x), static_cast<float>(low_[1] + side_ * y),
                static_cast<float>(low_[2] + side_ * z)};
    }
    [[nodiscard]] Vec3 along(int axis) const {
        Vec3 direction;
        direction[axis] = static_cast<float>(side_);
        return direction;
    }

    /// Finds inside points of the new layers.
    void look_inside() {
        const auto rows = static_cast<std::size_t>(points_[1]);
        parallel_for(rows * (layers_.size() - 1), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<std::uint64_t*> bits;
            for (std::size_t i = begin; i < end; ++i) {
                const int y = static_cast<int>(i % rows), layer = static_cast<int>(i / rows) + 1;
                rays.push_back({position(0, y, lowest_ + layer), along(0)});
                bits.push_back(layers_[static_cast<std::size_t>(layer)].inside.row(y));
            }
            inside(shape_, rays, points_[0], bits);
        });
    }

    /// Finds crossed edges of layer i and of the slab below it, and crossed cells of the slab.
    void find_crossed(std::size_t i) {
        const Bits &below = layers_[i - 1].inside, &above = layers_[i].inside;
        Layer& layer = layers_[i];
        Slab& slab = slabs_[i];
        const int words = above.words(), rows = points_[1];
        const auto along_x = [words](const std::uint64_t* row, int w) {
            return row[w] ^ (row[w] >> 1 | (w + 1 < words ? row[w + 1] << (word_bits - 1) : 0));
        };
        for (int y = 0; y < rows; ++y) {
            const bool has_next = y + 1 < rows;
            for (int w = 0; w < words; ++w) {
                layer.crossed[0].row(y)[w] = along_x(above.row(y), w);
                slab.crossed.row(y)[w] = below.row(y)[w] ^ above.row(y)[w];
                if (!has_next) continue;
                layer.crossed[1].row(y)[w] = above.row(y)[w] ^ above.row(y + 1)[w];
                const std::uint64_t a = below.row(y)[w], b = below.row(y + 1)[w], c = above.row(y)[w], d = above.row(y + 1)[w];
                slab.cells.row(y)[w] = along_x(below.row(y), w) | along_x(below.row(y + 1), w) | along_x(above.row(y), w) |
                                       along_x(above.row(y + 1), w) | (a ^ b) | (a ^ c) | (a ^ d);
            }
        }
        for (std::size_t axis = 0; axis < 2; ++axis) layer.crossings[axis].resize(layer.crossed[axis].number());
        slab.crossings.resize(slab.crossed.number());
        const std::size_t cells = slab.cells.number();
        slab.places.clear(), slab.corners.clear();
        slab.places.reserve(cells), slab.corners.reserve(cells);
        slab.cells.for_each([&](int x, int y) {
            int corners = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const Bits& points = corner & 4 ? above : below;
                corners |= points(x + (corner & 1), y + (corner >> 1 & 1)) << corner;
            }
            slab.places.push_back({x, y});
            slab.corners.push_back(static_cast<std::uint8_t>(corners));
        });
    }

    /// Computes crossings of the new edges.
    void find_crossings() {
        std::vector<Ray> rays;
        std::vector<Crossing*> found;
        const auto add = [&](const Bits& crossed, std::vector<Crossing>& crossings, int axis, int z) {
            Crossing* to = crossings.data();
            crossed.for_each([&](int x, int y) {
                rays.push_back({position(x, y, z), along(axis)});
                found.push_back(to++);
            });
        };
        for (std::size_t i = 1; i < layers_.size(); ++i) {
            const int z = lowest_ + static_cast<int>(i);
            // A sharp edge may cut a cell without crossing its edges; a diagonal often meets it.
            Slab& slab = slabs_[i];
            slab.diagonals.assign(slab.places.size(), {});
            for (std::size_t cell = 0; cell < slab.places.size(); ++cell) {
                const auto [x, y] = slab.places[cell];
                const int corners = slab.corners[cell];
                for (int k = 0; k < 4; ++k) {
                    Crossing& crossing = slab.diagonals[cell][static_cast<std::size_t>(k)];
                    crossing.t = std::numeric_limits<float>::quiet_NaN();
                    if (all_sheets()[slab.corners[cell]].count > 1 || (corners >> k & 1) == (corners >> (7 - k) & 1)) continue;
                    const auto step = static_cast<float>(side_);
                    rays.push_back({position(x + (k & 1), y + (k >> 1), z - 1), {k & 1 ? -step : step, k >> 1 ? -step : step, step}});
                    found.push_back(&crossing);
                }
            }
            add(slabs_[i].crossed, slabs_[i].crossings, 2, z - 1);
            for (int axis = 0; axis < 2; ++axis) {
                const auto a = static_cast<std::size_t>(axis);
                add(layers_[i].crossed[a], layers_[i].crossings[a], axis, z);
            }
        }
        parallel_for(rays.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> met(rays.begin() + static_cast<std::ptrdiff_t>(begin), rays.begin() + static_cast<std::ptrdiff_t>(end));
            std::vector<Hit> hits(end - begin);
            std::vector<std::size_t> from;
            shape_.closest_hits(met, hits);
            for (std::size_t i = 0; i < hits.size(); ++i) {
                // The edge has a root. Rounding may put it just beyond one end, where the normal matters little.
                *found[begin + i] = {0.5f, {}};
                if (!(hits[i].t <= 1.01f)) continue;
                met[from.size()] = met[i], hits[from.size()] = hits[i];
                from.push_back(begin + i);
            }
            std::vector<Vec3> normals(from.size());
            shape_.normals({met.data(), from.size()}, {hits.data(), from.size()}, normals);
            for (std::size_t i = 0; i < from.size(); ++i) *found[from[i]] = {std::min(hits[i].t, 1.f), normals[i]};
        });
    }

    /// The point and normal where the surface crosses an edge of a cell in slab i.
    [[nodiscard]] std::pair<Point, Vec3> crossing(std::size_t i, int x, int y, int edge) const {
        const int axis = edge / 4, low = edge & 1, high = edge >> 1 & 1;
        std::array<int, 3> at{x, y, lowest_ + static_cast<int>(i) - 1};
        at[axis == 0 ? 1 : 0] += low;
        at[axis == 2 ? 1 : 2] += high;
        const Layer& layer = layers_[axis == 2 || !high ? i - 1 : i];
        const auto a = static_cast<std::size_t>(axis);
        const Crossing& found = axis == 2 ? slabs_[i].crossings[slabs_[i].crossed.number_of(at[0], at[1])]
                                          : layer.crossings[a][layer.crossed[a].number_of(at[0], at[1])];
        Point p{static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])};
        p[a] += found.t;
        return {p, found.normal};
    }

    void place_vertices(std::size_t i) {
        Slab& slab = slabs_[i];
        slab.first_of_all = static_cast<std::int32_t>(mesh_.vertices.size());
        std::int32_t count = slab.first_of_all;
        slab.first.clear();
        for (const std::uint8_t corners : slab.corners) {
            slab.first.push_back(count);
            count += all_sheets()[corners].count;
        }
        mesh_.vertices.resize(static_cast<std::size_t>(count));
        slab.quadrics.assign(static_cast<std::size_t>(count - slab.first_of_all), {});
        const double z = lowest_ + static_cast<int>(i) - 1;
        parallel_for(slab.places.size(), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t cell = begin; cell < end; ++cell) {
                const auto [x, y] = slab.places[cell];
                const Sheets& sheets = all_sheets()[slab.corners[cell]];
                Point middle[4] = {};
                int crossings[4] = {};
                const std::int32_t first = slab.first[cell];
                for (int edge = 0; edge < 12; ++edge) {
                    const int sheet = sheets.of_edge[static_cast<std::size_t>(edge)];
                    if (sheet < 0) continue;
                    const auto [p, normal] = crossing(i, x, y, edge);
                    for (std::size_t axis = 0; axis < 3; ++axis) middle[sheet][axis] += p[axis];
                    ++crossings[sheet];
                    slab.quadrics[static_cast<std::size_t>(first + sheet - slab.first_of_all)].add(p, normal);
                }
                const Point low{static_cast<double>(x), static_cast<double>(y), z};
                for (std::size_t k = 0; k < 4; ++k) {
                    const auto [t, normal] = slab.diagonals[cell][k];
                    if (!(t >= 0)) continue;
                    const Point p{low[0] + (k & 1 ? 1 - t : t), low[1] + (k >> 1 ? 1 - t : t), low[2] + t};
                    for (std::size_t axis = 0; axis < 3; ++axis) middle[0][axis] += p[axis];
                    ++crossings[0];
                    slab.quadrics[static_cast<std::size_t>(first - slab.first_of_all)].add(p, normal);
                }
                const auto [from, to] = room_of(low, slab.corners[cell]);
                for (int sheet = 0; sheet < sheets.count; ++sheet) {
                    for (double& m : middle[sheet]) m /= crossings[sheet];
                    const Quadric& quadric = slab.quadrics[static_cast<std::size_t>(first + sheet - slab.first_of_all)];
                    Point& vertex = mesh_.vertices[static_cast<std::size_t>(first + sheet)];
                    vertex = meeting_point(quadric, middle[sheet]);
                    keep_within(vertex, from, to, quadric, middle[sheet]);
                }
            }
        });
    }

    /// A cell next to an edge, and the edge's index in the cell.
    struct Beside {
        const Slab* slab;
        std::size_t number;
        int edge;

        [[nodiscard]] const Sheets& sheets() const { return all_sheets()[slab->corners[number]]; }
        [[nodiscard]] std::int32_t vertex() const {
            return slab->first[number] + sheets().of_edge[static_cast<std::size_t>(edge)];
        }
    };

    /// A polygon around each crossed edge of slab i, and of the layer below it.
    void join(std::size_t i) {
        const int z = lowest_ + static_cast<int>(i) - 1;
        slabs_[i].crossed.for_each([&](int x, int y) { join_around(i, 2, x, y, z); });
        for (int axis = 0; axis < 2; ++axis) {
            layers_[i - 1].crossed[static_cast<std::size_t>(axis)].for_each([&](int x, int y) { join_around(i, axis, x, y, z); });
        }
    }

    /// Around the edge along `axis` from the point (x, y, z) on, which is on layer i - 1.
    void join_around(std::size_t i, int axis, int x, int y, int z) {
        constexpr int around[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};
        const int b = next(axis), c = last(axis);
        std::array<Beside, 4> cells;
        for (std::size_t k = 0; k < 4; ++k) {
            std::array<int, 3> offset{};
            offset[static_cast<std::size_t>(b)] = around[k][0], offset[static_cast<std::size_t>(c)] = around[k][1];
            const Slab& slab = slabs_[offset[2] < 0 ? i - 1 : i];
            const int corner = -around[k][0] << b | -around[k][1] << c;
            cells[k] = {&slab, slab.cells.number_of(x + offset[0], y + offset[1]), edge_between(corner, corner | 1 << axis)};
        }
        const Beside& own = cells[2];  // the edge starts at its lowest corner
        const bool begins_inside = own.slab->corners[own.number] & 1;
        // The cells' vertices, and additional ones on faces crossed twice: an edge for each crossing.
        std::vector<std::int32_t>& polygon = polygon_;
        polygon.clear();
        int extra = -1;
        for (std::size_t k = 0; k < 4; ++k) {
            polygon.push_back(cells[k].vertex());
            const int face_axis = k % 2 ? c : b, side = k < 2;
            const Beside &here = cells[k], &there = cells[(k + 1) % 4];
            if (!(here.sheets().doubled >> (2 * face_axis + side) & 1)) continue;
            if (!(there.sheets().doubled >> (2 * face_axis + !side) & 1)) continue;
            // The face has two inside corners; the crossing around the lower one gets an additional vertex. The edge lies in the
            // face, and ends inside at one of its corners.
            const std::int64_t end[3] = {x + (axis == 0 && !begins_inside), y + (axis == 1 && !begins_inside),
                                         z + (axis == 2 && !begins_inside)};
            std::int64_t low[3] = {x, y, z};  // corner of the face
            const int across = 3 - axis - face_axis;  // the face's other axis
            // The two cells around the edge that share this face.
            const int which = across == b ? around[k][0] : around[k][1];
            low[across] += which;
            if (end[next(face_axis)] != low[next(face_axis)]) continue;
            const std::int64_t key = ((low[2] * max_points + low[1]) * max_points + low[0]) * 3 + face_axis;
            const auto [known, is_new] = between_.try_emplace(key, static_cast<std::int32_t>(mesh_.vertices.size()));
            if (is_new) mesh_.vertices.push_back(crossing(i, x, y, 4 * axis).first);
            extra = static_cast<int>(polygon.size());
            polygon.push_back(known->second);
        }
        if (!begins_inside) {
            std::reverse(polygon.begin(), polygon.end());
            if (extra >= 0) extra = static_cast<int>(polygon.size()) - 1 - extra;
        }
        if (mesh_.triangles.size() + polygon.size() > Triangulation::max_triangles) {
            throw std::invalid_argument("more than " + std::to_string(Triangulation::max_triangles) + " triangles");
        }
        // Fan around an additional vertex, so no diagonal is an edge; otherwise the diagonal closer to the surface.
        std::size_t from = static_cast<std::size_t>(std::max(extra, 0));
        if (extra < 0) from = (bend(cells, 0) <= bend(cells, 1)) == begins_inside ? 0 : 1;
        const std::size_t count = polygon.size();
        for (std::size_t k = 1; k + 1 < count; ++k) {
            mesh_.triangles.push_back({polygon[from], polygon[(from + k) % count], polygon[(from + k + 1) % count]});
        }
    }

    /// Distance of the midpoint between two opposite cells' vertices from the planes of both.
    [[nodiscard]] double bend(const std::array<Beside, 4>& cells, std::size_t k) const {
        const Point &p = mesh_.vertices[static_cast<std::size_t>(cells[k].vertex())],
                    &q = mesh_.vertices[static_cast<std::size_t>(cells[k + 2].vertex())];
        const Point middle{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
        double sum = 0;
        for (const Beside& cell : {cells[k], cells[k + 2]}) {
            sum += cell.slab->quadrics[static_cast<std::size_t>(cell.vertex() - cell.slab->first_of_all)](middle);
        }
        return sum;
    }

    static constexpr std::int64_t max_points = max_lattice + 2;

    const Implicit& shape_;
    const double side_;  // of a cell, in the coordinates of rays
    double low_[3];      // of the lattice
    int points_[3];      // along each axis

    // Slab i lies below layer i.
    int lowest_ = 0;  // the z of layers_[0]
    std::vector<Layer> layers_;
    std::vector<Slab> slabs_;
    std::unordered_map<std::int64_t, std::int32_t> between_;  // vertices on faces crossed twice by a sheet, by face
    std::vector<std::int32_t> polygon_;
    Triangulation mesh_;
};

}  // namespace

Triangulation dual_contour(const Implicit& shape, double step) { return Contouring(shape, step).run(); }

}  // namespace bob
