// Trimming by ray crossings. A point is inside if the loops cross its ray in the direction of u an odd number of times
// (Schollmeyer and Froehlich, "Direct Trimming of NURBS Surfaces on the GPU", 2009, with v for u).
//
// The curves are cut into Bezier pieces that are monotone in u and in v. If a point is outside a piece's box, the
// piece's ends alone determine its crossings. Pieces of a run share their ends, so the same holds for the ends of a
// run, whatever its shape between them. A tree of runs therefore leaves only the few pieces with boxes around the point
// to examine, and its memory is proportional to the pieces.

#include "nurbs/trim.h"

#include "base/interruption.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace bob {
namespace {

// Distances from the border, in sizes of the domain. Coordinates in files are off by up to 1e-7 (single precision), hits
// on the border by less. Curves near the border are moved clearly past both.
constexpr double near_border = 1e-6, beyond_border = 1e-3;
// Ends closer than this, in sizes of the domain, are equal.
constexpr double closed = 1e-9;

using Points = std::vector<Homogeneous<2>>;  // control points of a Bezier curve
using Point = std::array<double, 2>;

/// The nearest floats not above, or not below, a number.
float float_below(double x) {
    const auto nearest = static_cast<float>(x);
    return nearest <= x ? nearest : std::nextafter(nearest, -HUGE_VALF);
}
float float_above(double x) { return -float_below(-x); }

Point euclidean(const Homogeneous<2>& p) { return {p[0] / p[2], p[1] / p[2]}; }
Points line(Point a, Point b) { return {{a[0], a[1], 1}, {b[0], b[1], 1}}; }

/// Rows of Pascal's triangle, up to the degree of the polynomials below.
constexpr int max_turn_degree = 2 * max_degree - 1;
constexpr auto binomials = [] {
    std::array<std::array<double, max_turn_degree + 1>, max_turn_degree + 1> rows{};
    for (std::size_t n = 0; n < rows.size(); ++n) {
        rows[n][0] = 1;
        for (std::size_t k = 1; k <= n; ++k) rows[n][k] = rows[n - 1][k - 1] + rows[n - 1][k];
    }
    return rows;
}();

struct Polynomial {
    std::size_t degree;
    std::array<double, max_turn_degree + 1> bernstein;
    double noise;  // smaller values may be rounding errors
};

/// Appends the roots of a polynomial with parameters 0..1, mapped to low..high. Roots are possible where the signs of
/// its coefficients change (Descartes' rule in Bernstein form); it is halved there until the interval is tiny.
void append_roots(Polynomial f, double low, double high, std::vector<double>& roots) {
    double last = 0;
    bool changes = false;
    for (std::size_t i = 0; i <= f.degree; ++i) {
        const double c = f.bernstein[i];
        if (!(std::fabs(c) > f.noise)) continue;
        changes |= c * last < 0;
        last = c < 0 ? -1 : 1;
    }
    if (!changes) return;
    const double middle = (low + high) / 2;
    // A cut this close to a turning point leaves a piece that reverses by 1e-20 of its size.
    if (high - low < 1e-10) {
        roots.push_back(middle);
        return;
    }
    Polynomial left = f;
    for (std::size_t k = 1; k <= f.degree; ++k) {
        for (std::size_t i = 0; i <= f.degree - k; ++i) f.bernstein[i] = (f.bernstein[i] + f.bernstein[i + 1]) / 2;
        left.bernstein[k] = f.bernstein[0];
    }
    append_roots(left, low, middle, roots);
    if (std::fabs(f.bernstein[0]) <= f.noise) roots.push_back(middle);
    append_roots(f, middle, high, roots);
}

/// Appends the parameters of turning points of a curve's coordinate x = X / W. They are roots of X' W - X W'.
void append_turns(const Points& points, std::size_t axis, std::vector<double>& turns) {
    const std::size_t p = points.size() - 1;
    // Relative to the first point, X is as small as the curve, and so are rounding errors.
    const double origin = euclidean(points[0])[axis];
    const auto x = [&](std::size_t i) { return points[i][axis] - origin * points[i][2]; };
    double largest = 0, heaviest = 0;
    for (const auto& point : points) {
        largest = std::max(largest, std::fabs(point[axis]));
        heaviest = std::max(heaviest, std::fabs(point[2]));
    }
    Polynomial f{2 * p - 1, {}, 2e-15 * largest * heaviest};
    for (std::size_t i = 0; i < p; ++i) {
        for (std::size_t j = 0; j <= p; ++j) {
            f.bernstein[i + j] += binomials[p - 1][i] * binomials[p][j] / binomials[2 * p - 1][i + j] *
                                  ((x(i + 1) - x(i)) * points[j][2] - x(j) * (points[i + 1][2] - points[i][2]));
        }
    }
    append_roots(f, 0, 1, turns);
}

/// Appends the parts of a curve between cuts that make each piece monotone in u and in v.
void append_monotone(const BezierCurve<2>& curve, std::vector<Points>& pieces) {
    if (curve.degree() == 1) {
        pieces.push_back(line(euclidean(curve.control_points[0]), euclidean(curve.control_points[1])));
        return;
    }
    std::vector<double> cuts;
    for (const std::size_t axis : {0, 1}) append_turns(curve.control_points, axis, cuts);
    std::sort(cuts.begin(), cuts.end());
    cuts.push_back(1);
    double begin = 0;
    for (const double end : cuts) {
        if (end < 1 && (end - begin < 1e-9 || 1 - end < 1e-9)) continue;
        Points points = begin == 0 && end == 1 ? curve.control_points : part(curve, begin, end).control_points;
        const double weight = points[0][2];
        if (std::all_of(points.begin(), points.end(), [&](const auto& q) { return q[2] == weight; })) {
            for (auto& q : points) q = {q[0] / weight, q[1] / weight, 1};
        }
        pieces.push_back(std::move(points));
        begin = end;
    }
}

/// Moves a curve along the domain's border outside, as a line. Returns whether it was on the border.
bool move_outside(Points& points, const Domain& domain) {
    const std::array<std::array<double, 2>, 2> border{{{domain.low_u, domain.high_u}, {domain.low_v, domain.high_v}}};
    Point start = euclidean(points.front()), end = euclidean(points.back());
    bool moved = false;
    for (const std::size_t axis : {0, 1}) {
        const double size = border[axis][1] - border[axis][0];
        for (const std::size_t side : {0, 1}) {
            const double at = border[axis][side];
            if (!std::all_of(points.begin(), points.end(), [&](const auto& q) {
                    return std::fabs(euclidean(q)[axis] - at) <= near_border * size;
                })) {
                continue;
            }
            start[axis] = end[axis] = at + (side ? beyond_border : -beyond_border) * size;
            moved = true;
        }
    }
    if (moved) points = line(start, end);
    return moved;
}

/// The pieces of a loop, each monotone in u and in v, and the lines that close gaps.
std::vector<Points> loop_pieces(const TrimLoop& loop, const Domain& domain) {
    std::vector<Points> open;
    for (const NurbsCurve<2>& curve : loop) {
        for (BezierCurve<2>& bezier : decompose(curve)) {
            Interruption::check();
            if (move_outside(bezier.control_points, domain)) {
                open.push_back(std::move(bezier.control_points));
            } else {
                append_monotone(bezier, open);
            }
        }
    }

    std::vector<Points> pieces;
    const auto close_gap = [&](const Points& next) {
        const Point end = euclidean(pieces.back().back()), start = euclidean(next.front());
        if (std::fabs(start[0] - end[0]) > closed * (domain.high_u - domain.low_u) ||
            std::fabs(start[1] - end[1]) > closed * (domain.high_v - domain.low_v)) {
            pieces.push_back(line(end, start));
        }
    };
    for (Points& points : open) {
        if (!pieces.empty()) close_gap(points);
        pieces.push_back(std::move(points));
    }
    if (!pieces.empty()) close_gap(pieces.front());
    return pieces;
}

}  // namespace

class TrimRegion::Builder {
public:
    explicit Builder(TrimRegion& region) : nodes_(region.nodes_), coefficients_(region.coefficients_) {}

    /// Adds the pieces of a loop.
    void add(const std::vector<Points>& pieces) {
        if (pieces.empty()) return;
        const std::size_t first = leaves_.size();
        for (const Points& points : pieces) leaves_.push_back(leaf(points));
        // A piece ends exactly at the height of the next one's start: no ray passes between them or crosses both.
        for (std::size_t i = first; i < leaves_.size(); ++i) {
            Node& node = leaves_[i];
            node.end_v = leaves_[i + 1 < leaves_.size() ? i + 1 : first].start_v;
            node.low_v = float_below(std::min(node.start_v, node.end_v));
            node.high_v = float_above(std::max(node.start_v, node.end_v));
        }
        loops_.push_back({first, leaves_.size(), enclose(first, leaves_.size())});
    }

    void build() {
        if (!loops_.empty()) build_loops(loops_);
        nodes_.shrink_to_fit();
        coefficients_.shrink_to_fit();
    }

private:
    struct Loop {
        std::size_t first, last;
        Node box;
    };

    Node leaf(const Points& points) {
        const Point start = euclidean(points.front()), end = euclidean(points.back());
        Node node{};
        node.low_u = float_below(std::min(start[0], end[0]));
        node.high_u = float_above(std::max(start[0], end[0]));
        node.start_v = start[1];
        node.coefficients = static_cast<std::uint32_t>(coefficients_.size());
        node.degree = static_cast<std::uint8_t>(points.size() - 1);
        node.rational = std::any_of(points.begin(), points.end(), [](const auto& p) { return p[2] != 1; });
        const auto keep = [&](std::size_t first, std::size_t last, std::size_t axis) {
            for (std::size_t i = first; i < last; ++i) {
                coefficients_.push_back(binomials[node.degree][i] * points[i][axis]);
            }
        };
        if (node.rational) {
            for (const std::size_t axis : {0, 1, 2}) keep(0, points.size(), axis);
        } else {
            keep(0, points.size(), 0);
            keep(1, points.size() - 1, 1);
        }
        return node;
    }

    /// A node for the leaves first..last - 1, consecutive along a loop.
    [[nodiscard]] Node enclose(std::size_t first, std::size_t last) const {
        Node node = leaves_[first];
        for (std::size_t i = first + 1; i < last; ++i) extend(node, leaves_[i]);
        node.end_v = leaves_[last - 1].end_v;
        node.degree = 0;
        return node;
    }

    static void extend(Node& node, const Node& other) {
        node.low_u = std::min(node.low_u, other.low_u);
        node.high_u = std::max(node.high_u, other.high_u);
        node.low_v = std::min(node.low_v, other.low_v);
        node.high_v = std::max(node.high_v, other.high_v);
    }

    template <class Children>
    void append(const Node& node, Children append_children) {
        const std::size_t index = nodes_.size();
        nodes_.push_back(node);
        append_children();
        nodes_[index].next = static_cast<std::uint32_t>(nodes_.size());
    }

    void build_run(std::size_t first, std::size_t last) {
        if (last - first == 1) return append(leaves_[first], [] {});
        append(enclose(first, last), [&] {
            // Deeper trees need the same search time, and more memory.
            const std::size_t step = last - first <= 4 ? 1 : (last - first + 1) / 2;
            for (std::size_t i = first; i < last; i += step) build_run(i, std::min(i + step, last));
        });
    }

    void build_loops(std::span<Loop> loops) {
        if (loops.size() == 1) return build_run(loops[0].first, loops[0].last);
        Node node = loops[0].box;
        for (const Loop& loop : loops) extend(node, loop.box);
        append(node, [&] {
            const bool by_u = node.high_u - node.low_u > node.high_v - node.low_v;
            const auto centre = [&](const Loop& loop) {
                return by_u ? loop.box.low_u + loop.box.high_u : loop.box.low_v + loop.box.high_v;
            };
            const std::size_t half = loops.size() / 2;
            std::nth_element(loops.begin(), loops.begin() + static_cast<std::ptrdiff_t>(half), loops.end(),
                             [&](const Loop& a, const Loop& b) { return centre(a) < centre(b); });
            build_loops(loops.first(half));
            build_loops(loops.subspan(half));
        });
    }

    std::vector<Node>& nodes_;
    std::vector<double>& coefficients_;
    std::vector<Node> leaves_;
    std::vector<Loop> loops_;
};

TrimRegion::TrimRegion(std::span<const TrimLoop> loops, const Domain& domain)
    : margin_u_(2 * closed * (domain.high_u - domain.low_u)),
      margin_v_(2 * closed * (domain.high_v - domain.low_v)),
      everything_(loops.empty()) {
    Builder builder(*this);
    for (const TrimLoop& loop : loops) builder.add(loop_pieces(loop, domain));
    builder.build();
}

bool TrimRegion::contains(double u, double v) const {
    bool inside = everything_;
    for (std::size_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        if (!(u < node.high_u && node.low_v <= v && v < node.high_v)) {  // also if NaN
            i = node.next;
        } else if (u < node.low_u) {
            inside ^= node.crosses(v);
            i = node.next;
        } else {
            if (node.degree) inside ^= node.crosses(v) && right_of(node, u, v);
            ++i;
        }
    }
    return inside;
}

TrimRegion::Ends TrimRegion::ends_u(const Node& leaf) const {
    const double* const c = &coefficients_[leaf.coefficients];
    const std::size_t p = leaf.degree;
    if (!leaf.rational) return {c[0], c[p]};
    return {c[0] / c[2 * p + 2], c[p] / c[3 * p + 2]};
}

bool TrimRegion::right_of(const Node& leaf, double u, double v) const {
    const auto [start_u, end_u] = ends_u(leaf);
    if (leaf.degree == 1) return start_u + (v - leaf.start_v) / (leaf.end_v - leaf.start_v) * (end_u - start_u) > u;

    const double* const c = &coefficients_[leaf.coefficients];

    const std::size_t p = leaf.degree;
    const auto point = [&](double t) -> Point {
        const double s = 1 - t;
        double x = c[0], y = leaf.rational ? c[p + 1] : leaf.start_v, w = leaf.rational ? c[2 * p + 2] : 1, power = 1;
        for (std::size_t i = 1; i <= p; ++i) {
            power *= t;
            x = x * s + power * c[i];
            y = y * s + power * (leaf.rational ? c[p + 1 + i] : i < p ? c[p + i] : leaf.end_v);
            if (leaf.rational) w = w * s + power * c[2 * p + 2 + i];
        }
        return leaf.rational ? Point{x / w, y / w} : Point{x, y};
    };

    // The piece reaches height v between the parameters a and b. It is monotone: if it is right of u at both, it is
    // right of u at v. The bracket shrinks by regula falsi in its Illinois form (the value of a retained end is
    // halved). Every fourth step bisects, for pieces where that is slow: 53 halvings exhaust a double.
    double a = 0, b = 1, value_a = leaf.start_v - v, value_b = leaf.end_v - v;
    const bool rising = value_a < value_b;
    bool right_a = start_u > u, right_b = end_u > u;
    enum { neither, at_a, at_b } stayed = neither;
    for (int step = 1; right_a != right_b && step < 256; ++step) {
        double t = a + (b - a) * value_a / (value_a - value_b);
        if (step % 4 == 0 || !(a < t && t < b)) t = (a + b) / 2;
        if (t == a || t == b) break;
        const Point at = point(t);
        const double value = at[1] - v;
        const bool right = at[0] > u;
        if ((value < 0) == rising) {
            a = t, value_a = value, right_a = right;
            if (stayed == at_b) value_b /= 2;
            stayed = at_b;
        } else {
            b = t, value_b = value, right_b = right;
            if (stayed == at_a) value_a /= 2;
            stayed = at_a;
        }
    }
    return right_a;
}

bool TrimRegion::passes(const Node& leaf, const Domain& r) const {
    // The piece passes on one side of the rectangle if it does not reach the nearest corner there. Corners outside the
    // piece's box are reached, or the rectangle would not overlap the box.
    const auto [start_u, end_u] = ends_u(leaf);
    const bool rising = (start_u < end_u) == (leaf.start_v < leaf.end_v);
    const bool low_inside = r.low_v > std::min(leaf.start_v, leaf.end_v);
    const bool high_inside = r.high_v < std::max(leaf.start_v, leaf.end_v);
    if (r.low_u > std::min(start_u, end_u) && (rising ? high_inside : low_inside) &&
        !right_of(leaf, r.low_u, rising ? r.high_v : r.low_v)) {
        return false;
    }
    return !(r.high_u < std::max(start_u, end_u) && (rising ? low_inside : high_inside) &&
             right_of(leaf, r.high_u, rising ? r.low_v : r.high_v));
}

TrimRegion::Coverage TrimRegion::coverage(const Domain& rectangle, std::size_t* visited) const {
    const auto& [low_u, high_u, low_v, high_v] = rectangle;
    const Domain wide{low_u - margin_u_, high_u + margin_u_, low_v - margin_v_, high_v + margin_v_};
    for (std::size_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        if (visited) ++*visited;
        if (wide.high_u < node.low_u || node.high_u < wide.low_u || wide.high_v < node.low_v ||
            node.high_v < wide.low_v) {
            i = node.next;
        } else {
            if (node.degree && passes(node, wide)) return Coverage::some;
            ++i;
        }
    }
    return contains((low_u + high_u) / 2, (low_v + high_v) / 2) ? Coverage::all : Coverage::none;
}

Domain TrimRegion::extent(const Domain& rectangle, std::size_t* visited) const {
    const auto& [low_u, high_u, low_v, high_v] = rectangle;
    Domain found{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
    const auto extend = [&](double u, double v) {
        found.low_u = std::min(found.low_u, u), found.high_u = std::max(found.high_u, u);
        found.low_v = std::min(found.low_v, v), found.high_v = std::max(found.high_v, v);
    };
    // The inside is widest at a curve, or at a corner of the rectangle.
    for (std::size_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        if (visited) ++*visited;
        const double from_u = std::max(low_u, double{node.low_u}), to_u = std::min(high_u, double{node.high_u});
        const double from_v = std::max(low_v, double{node.low_v}), to_v = std::min(high_v, double{node.high_v});
        if (from_u > to_u || from_v > to_v) {
            i = node.next;
        } else {
            if (node.degree && passes(node, rectangle)) extend(from_u, from_v), extend(to_u, to_v);
            ++i;
        }
    }
    for (const double u : {low_u, high_u}) {
        for (const double v : {low_v, high_v}) {
            if (contains(u, v)) extend(u, v);
        }
    }
    return found;
}

std::size_t TrimRegion::bytes() const {
    return nodes_.capacity() * sizeof(Node) + coefficients_.capacity() * sizeof(double);
}

}  // namespace bob
