#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>

#include "base/vec3d.h"
#include "base/work.h"
#include "shapes/brep/pieces.h"

namespace bob {
namespace {

// Cost of visiting a node, in tests of a packet.
constexpr float node_cost = 0.25f;

// Maximum distance of a piece's control points from the bilinear patch of its corners, in half sizes of the piece. Then
// the maximum tangent of the deviation of its normals. With 0.3 the teapot's rays take a tenth longer, as more need
// tests; with 0.2 a twentieth less, but memory and build time grow by a third.
constexpr double max_curve = 0.5, max_lean = 0.25;

// Rays closer to tangent than this sine are not left to Newton's method, for any piece.
constexpr double least_slant = 0.05;

// Each side is halved at most this number of times, and not below this size. A remaining curved piece, such as a pole
// or a cusp, is subdivided for each ray.
constexpr int max_halvings = 8;
constexpr double smallest = 2e-3;
constexpr std::size_t max_pieces = 4096;  // per patch

// Work units for all patches (work.h). Once they are spent, larger pieces are subdivided for each ray.
constexpr std::uint64_t budget = 1'200'000'000;
constexpr std::uint64_t units_of_part = 200, units_of_angle = 8, units_of_trim = 50;

// Maximum ratio of the largest to the smallest weight of a patch. Parameters and weighted points are in float32, so
// small weights multiply the error of hits by this ratio: to at most 6e-6 of the shape's radius
// (tests/nurbs_oracle.py).
constexpr double max_weight_ratio = 16;
constexpr std::uint64_t units_to_cut_weights = 1'000'000'000, units_of_cut = 500;  // per control point

// A narrower part is invisible.
constexpr double narrowest = 1e-7;

// Margins of boxes around their pieces, in half sizes and in units.
constexpr double box_margin = 1e-3, rounding = 1e-6;

/// The data of one piece in a packet, and its box in the hierarchy.
struct Piece {
    double to_box[3][4];
    double half[2];
    double lean[2];
    double low[2], size[2];
    std::optional<TrimCells> trim;
    Box bounds;
    std::uint32_t patch = 0, trim_index = PiecePacket::no_trim;  // among the visible ones
};

/// A part of a patch: its parameters and control points.
struct SubPatch {
    double low[2] = {0, 0}, high[2] = {1, 1};
    int halvings[2] = {0, 0};
    std::size_t rows = 0, columns = 0;
    std::vector<Homogeneous<3>> homogeneous;
    std::vector<Vec3d> points;

    void set_net(BezierPatch net) {
        rows = static_cast<std::size_t>(net.degree_u) + 1, columns = static_cast<std::size_t>(net.degree_v) + 1;
        homogeneous = std::move(net.control_points);
        set_points();
    }

    /// The lower and the upper half along u (0) or v (1).
    [[nodiscard]] std::pair<SubPatch, SubPatch> halves(int along) const {
        std::pair<SubPatch, SubPatch> result{*this, *this};
        auto& [lower, upper] = result;
        ++lower.halvings[along], ++upper.halvings[along];
        lower.high[along] = upper.low[along] = (low[along] + high[along]) / 2;
        const std::size_t count = along ? columns : rows, step = along ? 1 : columns;
        for (std::size_t line = 0; line < homogeneous.size() / count; ++line) {
            Homogeneous<3>*const below = &lower.homogeneous[along ? line * columns : line], *const above = &upper.homogeneous[below - lower.homogeneous.data()];
            for (std::size_t last = count - 1; last > 0; --last) {  // de Casteljau's algorithm; above[0..last] are its points
                for (std::size_t i = 0; i < last; ++i) {
                    for (std::size_t k = 0; k < 4; ++k) above[i * step][k] = 0.5 * (above[i * step][k] + above[(i + 1) * step][k]);
                }
                std::copy_n(above, 1, below + (count - last) * step);
            }
        }
        lower.set_points(), upper.set_points();
        return result;
    }

    [[nodiscard]] bool weights_are_products() const {
        for (std::size_t i = 0; i < homogeneous.size(); ++i) {
            const double row = homogeneous[i - i % columns][3], column = homogeneous[i % columns][3];
            const double expected = row * column, found = homogeneous[i][3] * homogeneous[0][3];
            if (std::fabs(found - expected) > 1e-9 * expected) return false;
        }
        return true;
    }

private:
    void set_points() {
        points.clear();
        for (const auto& [x, y, z, w] : homogeneous) points.push_back({x / w, y / w, z / w});
    }
};

/// A bilinear fit of a part and its deviation. The fit is center + x along_u + y along_v + x y twist, with x and y from
/// -1 to 1.
struct Fit {
    Vec3d center, along_u, along_v, twist;
    Vec3d normal{};         // unit length, or 0 if the area is negligible
    Vec3d dual_u, dual_v;   // their dot products with p - center are x and y
    double deviation[2] = {0, 0};              // of the control points: in x, in y
    double lowest = HUGE_VAL, highest = -HUGE_VAL;  // and along the normal, from the centre
    double curve = 0;                          // deviation of the control points, in x and y, from the bilinear patch
    double bend[2] = {0, 0};                   // deviation that a cut of u, or of v, would remove
    bool is_flat = false;                      // normals deviate by at most max_lean
    double lean[2] = {HUGE_VAL, HUGE_VAL};     // if so: bounds of their products with along_u and along_v, relative to the product with `normal`

    /// If `leans` is false, omits the deviation of normals, the slowest part.
    Fit(const SubPatch& part, bool leans, Work& work) {
        const std::size_t last_column = part.columns - 1, last_row = part.points.size() - part.columns;
        const Vec3d &a = part.points[0], &b = part.points[last_column];
        const Vec3d &c = part.points[last_row], &d = part.points[last_row + last_column];
        center = 0.25 * (a + b + c + d);
        along_u = 0.25 * (c + d - a - b);
        along_v = 0.25 * (b + d - a - c);
        twist = 0.25 * (a + d - b - c);
        const Vec3d n = cross(along_u, along_v);
        const double area = length(n);
        if (area > 1e-4 * (dot(along_u, along_u) + dot(along_v, along_v))) {
            normal = 1 / area * n;
            dual_u = 1 / area * cross(along_v, normal);
            dual_v = 1 / area * cross(normal, along_u);
        } else {
            use_axes(part);
        }
        measure(part);
        if (has_area() && curve <= max_curve && leans) measure_lean(part, work);
    }

    [[nodiscard]] bool has_area() const { return dot(normal, normal) > 0; }
    [[nodiscard]] double size() const { return std::max(length(along_u), length(along_v)); }

private:
    /// Takes the coordinate axes for pieces that are lines or points, long enough to contain them.
    void use_axes(const SubPatch& part) {
        Vec3d low = part.points[0], high = low;
        for (const Vec3d& x : part.points) {
            for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
        }
        center = 0.5 * (low + high);
        const double size = std::max(length(high - low), 1e-12);
        along_u = {size, 0, 0}, along_v = {0, size, 0}, twist = {};
        dual_u = {1 / size, 0, 0}, dual_v = {0, 1 / size, 0};
    }

    void measure(const SubPatch& part) {
        const Vec3d z = has_area() ? normal : Vec3d{0, 0, 1};
        const auto p = static_cast<double>(part.rows - 1), q = static_cast<double>(part.columns - 1);
        for (std::size_t i = 0; i < part.rows; ++i) {
            for (std::size_t j = 0; j < part.columns; ++j) {
                const Vec3d* point = &part.points[i * part.columns + j];
                const Vec3d from_center = *point - center;
                const double x = 2 * static_cast<double>(i) / p - 1, y = 2 * static_cast<double>(j) / q - 1;
                const Vec3d from_bilinear = from_center - x * along_u - y * along_v - x * y * twist;
                deviation[0] = std::max(deviation[0], std::fabs(dot(dual_u, from_center) - x));
                deviation[1] = std::max(deviation[1], std::fabs(dot(dual_v, from_center) - y));
                const double above = dot(z, from_center);
                lowest = std::min(lowest, above), highest = std::max(highest, above);
                curve = std::max({curve, std::fabs(dot(dual_u, from_bilinear)), std::fabs(dot(dual_v, from_bilinear))});
                const auto second_difference = [&](std::size_t step) {
                    return length(point[2 * step] - 2 * point[step] + point[0]);
                };
                if (i + 2 < part.rows) bend[0] = std::max(bend[0], second_difference(part.columns));
                if (j + 2 < part.columns) bend[1] = std::max(bend[1], second_difference(1));
            }
        }
        // Either cut halves the twist; cutting the longer side leaves the better shape.
        const double u = length(along_u), v = length(along_v), twisted = length(twist) / std::max(u + v, 1e-30);
        bend[0] = p * p * bend[0] + u * twisted, bend[1] = q * q * bend[1] + v * twisted;
    }

    /// Bounds the deviation of du x dv from the normal. The vectors du and dv are any in the cones of the control
    /// points' differences.
    ///
    /// If the determinant with a direction d has one sign for all of these, no line along d intersects the piece twice.
    /// The difference of two points of the piece is (mean of dS/du) a + (mean of dS/dv) b, and both means are in the
    /// cones. The projection along d then has a determinant of that sign. With d = x along_u + y along_v + z normal it
    /// has the sign of z while
    ///     |z| > lean[0] |x| + lean[1] |y|.
    ///
    /// Derivatives are in these cones for polynomial pieces, and for rational ones whose weights are products of a
    /// factor in u and one in v, such as surfaces of revolution: this holds for rational curves (Floater, "Derivatives
    /// of rational Bezier curves", 1992). For other pieces it holds for w (S - o), for every o on the ray: points o
    /// near the piece are as far from its centre as its points, which adds slightly to the deviation.
    void measure_lean(const SubPatch& part, Work& work) {
        double radius = 0;
        for (const Vec3d& x : part.points) radius = std::max(radius, length(x - center));
        const bool products = part.weights_are_products();
        struct Differences {  // coordinates, lengths and slacks
            double x[3][max_degree * (max_degree + 1)];
            double length[max_degree * (max_degree + 1)], slack[max_degree * (max_degree + 1)];
            std::size_t count = 0;
        } du, dv;
        const auto add = [&](Differences& to, std::size_t from, std::size_t end) {
            const Homogeneous<3>&a = part.homogeneous[from], &b = part.homogeneous[end];
            Vec3d d = part.points[end] - part.points[from];
            if (!products) {
                for (std::size_t k = 0; k < 3; ++k) d[k] = b[k] - a[k] - center[k] * (b[3] - a[3]);
            }
            for (std::size_t k = 0; k < 3; ++k) to.x[k][to.count] = d[k];
            to.length[to.count] = products ? 0 : std::sqrt(dot(d, d));
            to.slack[to.count++] = products ? 0 : radius * std::fabs(b[3] - a[3]);
        };
        for (std::size_t i = 0; i < part.points.size(); ++i) {
            if (i + part.columns < part.points.size()) add(du, i, i + part.columns);
            if ((i + 1) % part.columns != 0) add(dv, i, i + 1);
        }
        const double sizes[2] = {std::sqrt(dot(along_u, along_u)), std::sqrt(dot(along_v, along_v))};
        double leaning[2] = {0, 0};
        work.spend(units_of_angle * du.count * dv.count);
        for (std::size_t i = 0; i < du.count; ++i) {
            // The product of the normal du x dv and a direction is dv times direction x du.
            const Vec3d a{du.x[0][i], du.x[1][i], du.x[2][i]};
            const Vec3d by_normal = cross(normal, a), by_u = cross(along_u, a), by_v = cross(along_v, a);
            const double length = du.length[i], slack = du.slack[i];
            double upright[max_degree * (max_degree + 1)], leans[2][max_degree * (max_degree + 1)];
            for (std::size_t j = 0; j < dv.count; ++j) {
                const double x = dv.x[0][j], y = dv.x[1][j], z = dv.x[2][j];
                const double more = slack * dv.length[j] + dv.slack[j] * length + slack * dv.slack[j];
                upright[j] = x * by_normal[0] + y * by_normal[1] + z * by_normal[2] - more;
                const double inverse = 1 / upright[j];
                leans[0][j] = (std::fabs(x * by_u[0] + y * by_u[1] + z * by_u[2]) + more * sizes[0]) * inverse;
                leans[1][j] = (std::fabs(x * by_v[0] + y * by_v[1] + z * by_v[2]) + more * sizes[1]) * inverse;
            }
            for (std::size_t j = 0; j < dv.count; ++j) {
                if (!(upright[j] > 0)) return;  // as at poles
                for (const std::size_t k : {0, 1}) leaning[k] = std::max(leaning[k], leans[k][j]);
            }
            const double tangents[2] = {leaning[0] / sizes[0], leaning[1] / sizes[1]};
            if (!(tangents[0] * tangents[0] + tangents[1] * tangents[1] <= max_lean * max_lean)) return;
        }
        std::copy_n(leaning, 2, lean);
        is_flat = true;
    }
};

class Builder {
public:
    Builder(const BezierPatch& bezier, const Patch& patch) : bezier_(&bezier), patch_(&patch) {}

    /// Continues until it is done or has used about that number of units.
    void go_on(std::uint64_t units) {
        work_.grant(units);
        start();
        while (!open_.empty() && !work_.is_spent()) cut_next(false);
    }
    [[nodiscard]] bool is_done() const { return started_ && open_.empty(); }
    [[nodiscard]] const Work& work() const { return work_; }

    /// The pieces; remaining parts become pieces as they are.
    std::vector<Piece> finish() {
        start();
        while (!open_.empty()) cut_next(true);
        return std::move(pieces_);
    }

private:
    void start() {
        if (!started_) open_.emplace_back().set_net(*bezier_);
        started_ = true;
    }

    void cut_next(bool is_last) {
        SubPatch part = std::move(open_.back());
        open_.pop_back();
        std::size_t visited = 0;
        const TrimRegion::Coverage coverage = is_last ? TrimRegion::Coverage::some : patch_->coverage(domain(part), &visited);
        work_.spend(units_of_part + units_of_trim * visited + part.points.size() * (part.rows * part.rows + part.columns * part.columns));
        if (coverage == TrimRegion::Coverage::none) return;
        if (coverage == TrimRegion::Coverage::some && !is_last && !shrink(part)) return;
        const Fit fit(part, !is_last, work_);
        if (!is_last && (!fit.has_area() || fit.size() < narrowest) && width(part) < narrowest) return;
        // A part without area may be a strip, and cutting it across its width would leave invisible halves.
        int along = fit.has_area() ? fit.bend[1] > fit.bend[0] : side(part, 1) > side(part, 0);
        if (fit.has_area() && part.halvings[along] == max_halvings) along = 1 - along;
        if (is_last || fit.is_flat || fit.size() < smallest || part.halvings[along] == max_halvings ||
            pieces_.size() >= max_pieces) {
            return emit(part, fit, coverage == TrimRegion::Coverage::some);
        }
        auto [lower, upper] = part.halves(along);
        open_.push_back(std::move(upper));
        open_.push_back(std::move(lower));
    }

    /// Trims off invisible margins, in multiples of a step, so that parameters and their halves stay exact in float32.
    /// False if nothing is left.
    bool shrink(SubPatch& part) {
        constexpr double step = 0x1p-12, slack = 1e-6, worth_it = 0.9;
        std::size_t visited = 0;
        const Domain seen = patch_->extent(domain(part), &visited);
        work_.spend(units_of_trim * visited);
        const auto& [low_u, high_u, low_v, high_v] = patch_->domain;
        const double low[2] = {(seen.low_u - low_u) / (high_u - low_u), (seen.low_v - low_v) / (high_v - low_v)};
        const double high[2] = {(seen.high_u - low_u) / (high_u - low_u), (seen.high_v - low_v) / (high_v - low_v)};
        double from[2], to[2];
        for (std::size_t k = 0; k < 2; ++k) {
            if (low[k] > high[k]) return false;
            from[k] = std::max(part.low[k], step * std::floor((low[k] - slack) / step));
            to[k] = std::min(part.high[k], step * std::ceil((high[k] + slack) / step));
        }
        const double left = (to[0] - from[0]) * (to[1] - from[1]);
        if (left > worth_it * (part.high[0] - part.low[0]) * (part.high[1] - part.low[1])) return true;
        std::copy_n(from, 2, part.low), std::copy_n(to, 2, part.high);
        part.set_net(bob::part(*bezier_, from[0], to[0], from[1], to[1]));
        return true;
    }

    /// The longest line of a part's control points along u (0) or v (1).
    static double side(const SubPatch& part, int along) {
        const std::size_t step = along ? 1 : part.columns, count = along ? part.columns : part.rows;
        double longest = 0;
        for (std::size_t line = 0; line < part.points.size() / count; ++line) {
            const Vec3d* point = &part.points[along ? line * part.columns : line];
            double sum = 0;
            for (std::size_t i = 1; i < count; ++i) sum += length(point[i * step] - point[(i - 1) * step]);
            longest = std::max(longest, sum);
        }
        return longest;
    }

    /// An upper bound of a part's extent across its longest side.
    static double width(const SubPatch& part) {
        double longest = 0, area = 0;
        for (const Vec3d& a : part.points) longest = std::max(longest, length(a - part.points[0]));
        for (const Vec3d& a : part.points) {
            for (const Vec3d& b : part.points) {
                area = std::max(area, length(cross(a - part.points[0], b - part.points[0])));
            }
        }
        return longest > 0 ? 2 * area / longest : 0;
    }

    [[nodiscard]] Domain domain(const SubPatch& part) const {
        return {patch_->face_u(part.low[0]), patch_->face_u(part.high[0]), patch_->face_v(part.low[1]),
                patch_->face_v(part.high[1])};
    }

    void emit(const SubPatch& part, const Fit& fit, bool trimmed) {
        Piece piece;
        const Vec3d normal = fit.has_area() ? fit.normal : Vec3d{0, 0, 1};
        const double height = 0.5 * (fit.highest - fit.lowest) + box_margin * fit.size() + rounding;
        const Vec3d axes[3] = {fit.dual_u, fit.dual_v, 1 / height * normal};
        const Vec3d center = fit.center + 0.5 * (fit.lowest + fit.highest) * normal;
        for (std::size_t k = 0; k < 3; ++k) {
            std::copy(axes[k].begin(), axes[k].end(), piece.to_box[k]);
            piece.to_box[k][3] = -dot(axes[k], center);
        }
        for (std::size_t k = 0; k < 2; ++k) {
            piece.half[k] = 1 + fit.deviation[k] + box_margin + rounding * length(axes[k]);
            piece.low[k] = part.low[k];
            piece.size[k] = part.high[k] - part.low[k];
            const double along = length(k == 0 ? fit.along_u : fit.along_v);
            piece.lean[k] = std::max(fit.lean[k], least_slant * along) / height;
        }
        if (trimmed) classify(part, piece.trim.emplace(), 0, 0, TrimCells::side);
        for (const auto& [x, y, z] : part.points) {
            piece.bounds.extend(Vec3{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
        }
        pieces_.push_back(piece);
    }

    /// Classifies the cells u.. and v.., `count` in each direction. Cells are slightly enlarged to allow for rounding.
    void classify(const SubPatch& part, TrimCells& cells, int u, int v, int count) {
        constexpr double beyond = 1e-3 / TrimCells::side, rounding = 2e-7;  // in sizes of the piece, and in parameters of the patch
        const auto at = [&](std::size_t k, int cell, double sign) {
            const double size = part.high[k] - part.low[k];
            return part.low[k] + size * cell / TrimCells::side + sign * (beyond * size + rounding);
        };
        std::size_t visited = 0;
        const TrimRegion::Coverage coverage = patch_->coverage(
            {patch_->face_u(at(0, u, -1)), patch_->face_u(at(0, u + count, 1)), patch_->face_v(at(1, v, -1)),
             patch_->face_v(at(1, v + count, 1))}, &visited);
        work_.spend(units_of_trim * visited);
        if (coverage == TrimRegion::Coverage::some && count > 1) {
            for (const int below : {0, count / 2}) {
                for (const int left : {0, count / 2}) classify(part, cells, u + left, v + below, count / 2);
            }
        } else if (coverage != TrimRegion::Coverage::none) {
            auto& bits = coverage == TrimRegion::Coverage::all ? cells.seen : cells.crossed;
            for (int row = v; row < v + count; ++row) {
                for (int column = u; column < u + count; ++column) bits |= std::uint64_t{1} << (TrimCells::side * row + column);
            }
        }
    }

    const BezierPatch* bezier_;
    const Patch* patch_;
    Work work_;
    bool started_ = false;
    std::vector<SubPatch> open_;
    std::vector<Piece> pieces_;
};

/// The ratio of the largest to the smallest of positive numbers.
double ratio(std::span<const double> numbers) {
    const auto [least, most] = std::minmax_element(numbers.begin(), numbers.end());
    return *most / *least;
}

/// Where to cut a line of control points: at the minimum of the larger weight ratio of both parts.
double place_of_cut(std::span<const double> weights) {
    double best = 0.5, least = HUGE_VAL;
    for (int k = 1; k <= 20; ++k) {
        for (const double at : {std::ldexp(1., -k), 1 - std::ldexp(1., -k)}) {
            std::vector<double> upper(weights.begin(), weights.end()), lower;
            for (std::size_t count = upper.size(); count > 0; --count) {  // de Casteljau's algorithm
                lower.push_back(upper[0]);
                for (std::size_t i = 0; i + 1 < count; ++i) upper[i] = (1 - at) * upper[i] + at * upper[i + 1];
            }
            const double larger = std::max(ratio(lower), ratio(upper));
            if (larger < least) best = at, least = larger;
        }
    }
    return best;
}

/// Cuts patches with widely different weights.
class WeightCuts {
public:
    /// The patch, or parts of it that live as long as this object. Once the budget is spent, weights stay as they are.
    std::vector<const BezierPatch*> parts(const BezierPatch& patch) {
        if (is_even(patch)) return {&patch};
        std::vector<const BezierPatch*> result;
        std::vector<BezierPatch> open{patch};
        while (!open.empty()) {
            const BezierPatch next = std::move(open.back());
            open.pop_back();
            const Cut cut = is_even(next) || work_.is_spent() ? Cut{} : best_cut(next);
            if (cut.at == 0) {
                result.push_back(&made_.emplace_back(next));
                continue;
            }
            work_.spend(units_of_cut * next.control_points.size());
            open.push_back(cut.along_v ? part(next, 0, 1, cut.at, 1) : part(next, cut.at, 1, 0, 1));
            open.push_back(cut.along_v ? part(next, 0, 1, 0, cut.at) : part(next, 0, cut.at, 0, 1));
        }
        return result;
    }

private:
    struct Cut {
        bool along_v = false;
        double at = 0;  // 0 if double precision leaves no parameter between the ends
    };

    static bool is_even(const BezierPatch& patch) {
        double least = HUGE_VAL, most = 0;
        for (const auto& point : patch.control_points) least = std::min(least, point[3]), most = std::max(most, point[3]);
        return most <= max_weight_ratio * least;
    }

    /// The cut for the line of control points with the largest weight ratio.
    static Cut best_cut(const BezierPatch& patch) {
        const auto rows = static_cast<std::size_t>(patch.degree_u) + 1, columns = static_cast<std::size_t>(patch.degree_v) + 1;
        std::vector<double> worst;
        bool along_v = false;
        for (std::size_t line = 0; line < rows + columns; ++line) {
            std::vector<double> weights;
            for (std::size_t i = 0; i < (line < rows ? columns : rows); ++i) {
                weights.push_back(patch.control_points[line < rows ? line * columns + i : i * columns + line - rows][3]);
            }
            if (worst.empty() || ratio(weights) > ratio(worst)) worst = weights, along_v = line < rows;
        }
        const double at = place_of_cut(worst), low = along_v ? patch.low_v : patch.low_u, high = along_v ? patch.high_v : patch.high_u;
        const double middle = std::lerp(low, high, at);
        return {along_v, low < middle && middle < high ? at : 0};
    }

    Work work_{units_to_cut_weights};
    std::deque<BezierPatch> made_;
};

/// The mean length of a patch's lines of control points along u, or along v.
double mean_length(const BezierPatch& patch, bool along_v) {
    const auto rows = static_cast<std::size_t>(patch.degree_u) + 1, columns = static_cast<std::size_t>(patch.degree_v) + 1;
    double sum = 0;
    for (std::size_t i = along_v ? 0 : 1; i < rows; ++i) {
        for (std::size_t j = along_v ? 1 : 0; j < columns; ++j) {
            const auto& a = patch.control_points[i * columns + j];
            const auto& b = patch.control_points[along_v ? i * columns + j - 1 : (i - 1) * columns + j];
            sum += std::hypot(a[0] / a[3] - b[0] / b[3], a[1] / a[3] - b[1] / b[3], a[2] / a[3] - b[2] / b[3]);
        }
    }
    return sum / static_cast<double>(along_v ? rows : columns);
}

/// A patch without its control points, which follow once it is known to be visible.
Patch patch_of(const BezierPatch& bezier, std::uint32_t face, const TrimRegion* region, double tolerance) {
    // The tolerance in parameters, as if they were spaced evenly over the patch.
    const auto margin = [&](double size, bool along_v) {
        return static_cast<float>(tolerance > 0 ? size * std::min(1., tolerance / mean_length(bezier, along_v)) : 0);
    };
    Box box;
    for (const auto& [x, y, z, w] : bezier.control_points) {
        box.extend(Vec3{static_cast<float>(x / w), static_cast<float>(y / w), static_cast<float>(z / w)});
    }
    const Vec3 center = 0.5f * (box.low + box.high);
    return {{center.x, center.y, center.z},
            0,
            static_cast<std::uint16_t>(bezier.degree_u),
            static_cast<std::uint16_t>(bezier.degree_v),
            0,
            face,
            region,
            {bezier.low_u, bezier.high_u, bezier.low_v, bezier.high_v},
            margin(bezier.high_u - bezier.low_u, false),
            margin(bezier.high_v - bezier.low_v, true)};
}

/// Appends a patch and its control points, relative to its centre, with weights of at most 1.
void append(Pieces& pieces, Patch patch, const BezierPatch& bezier) {
    double heaviest = 0;
    for (const auto& point : bezier.control_points) heaviest = std::max(heaviest, point[3]);
    patch.control_points = static_cast<std::uint32_t>(pieces.control_points.size());
    for (const auto& [x, y, z, w] : bezier.control_points) {
        const auto moved = [&, w = w](double coordinate, float center) {
            return static_cast<float>((coordinate - w * static_cast<double>(center)) / heaviest);
        };
        pieces.control_points.push_back({moved(x, patch.center[0]), moved(y, patch.center[1]),
                                         moved(z, patch.center[2]), static_cast<float>(w / heaviest)});
    }
    const auto same = std::find_if(pieces.patches.begin(), pieces.patches.end(), [&](const Patch& other) {
        return other.degree_u == patch.degree_u && other.degree_v == patch.degree_v;
    });
    patch.degrees = same == pieces.patches.end() ? pieces.pairs_of_degrees++ : same->degrees;
    pieces.patches.push_back(patch);
}

PiecePacket packed(std::span<const Piece> pieces, const Packet& indices) {
    PiecePacket packet;
    for (std::size_t lane = 0; lane < indices.size(); ++lane) {
        const Piece& piece = pieces[indices[lane]];
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 4; ++column) {
                packet.to_box[row][column][lane] = static_cast<float>(piece.to_box[row][column]);
            }
        }
        for (int k = 0; k < 2; ++k) {
            packet.half[k][lane] = static_cast<float>(piece.half[k]);
            packet.lean[k][lane] = static_cast<float>(piece.lean[k]);
            packet.low[k][lane] = static_cast<float>(piece.low[k]);
            packet.size[k][lane] = static_cast<float>(piece.size[k]);
        }
        packet.patch[lane] = piece.patch;
        packet.trim[lane] = piece.trim_index;
        if (lane > 0 && indices[lane] == indices[0]) {  // absent: every ray misses its box
            for (auto& row : packet.to_box) {
                for (auto& column : row) column[lane] = 0;
            }
            packet.to_box[0][3][lane] = 2 * packet.half[0][lane];
        }
    }
    return packet;
}

}  // namespace

TrimRegion::Coverage Patch::coverage(const Domain& d, std::size_t* visited) const {
    return region->coverage({d.low_u - margin_u, d.high_u + margin_u, d.low_v - margin_v, d.high_v + margin_v}, visited);
}

Domain Patch::extent(const Domain& d, std::size_t* visited) const {
    const auto [low_u, high_u, low_v, high_v] =
        region->extent({d.low_u - margin_u, d.high_u + margin_u, d.low_v - margin_v, d.high_v + margin_v}, visited);
    return {std::max(d.low_u, low_u - margin_u), std::min(d.high_u, high_u + margin_u),
            std::max(d.low_v, low_v - margin_v), std::min(d.high_v, high_v + margin_v)};
}

TrimRegion::Coverage Patch::coverage(double u, double v) const {
    const double at_u = face_u(u), at_v = face_v(v);
    if (region->contains(at_u, at_v)) return TrimRegion::Coverage::all;
    const bool near = margin_u > 0 && coverage({at_u, at_u, at_v, at_v}) != TrimRegion::Coverage::none;
    return near ? TrimRegion::Coverage::some : TrimRegion::Coverage::none;
}

std::size_t Pieces::bytes() const {
    return patches.size() * sizeof(Patch) + control_points.size() * sizeof(control_points[0]) +
           nodes.size() * sizeof(BvhNode) + packets.size() * sizeof(PiecePacket) + trims.size() * sizeof(TrimCells);
}

Pieces build_pieces(std::span<const FacePatches> faces, double tolerance) {
    struct Source {
        const BezierPatch* bezier;
        Patch patch;
    };
    WeightCuts cuts;
    std::vector<Source> sources;
    for (std::uint32_t face = 0; face < faces.size(); ++face) {
        for (const BezierPatch& whole : faces[face].patches) {
            for (const BezierPatch* bezier : cuts.parts(whole)) {
                sources.push_back({bezier, patch_of(*bezier, face, faces[face].region, tolerance)});
            }
        }
    }
    std::vector<Builder> builders;
    for (const Source& source : sources) builders.emplace_back(*source.bezier, source.patch);

    Pieces result;
    result.is_coarse = !do_in_turns(builders, budget);
    result.tolerance = static_cast<float>(tolerance);
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const Source& source = sources[i];
        const std::vector<Piece> own = builders[i].finish();
        if (own.empty()) continue;
        const auto index = static_cast<std::uint32_t>(result.patches.size());
        append(result, source.patch, *source.bezier);
        for (Piece piece : own) {
            piece.patch = index;
            if (piece.trim) {
                piece.trim_index = static_cast<std::uint32_t>(result.trims.size());
                result.trims.push_back(*piece.trim);
            }
            pieces.push_back(piece);
        }
    }
    result.count = pieces.size();
    if (pieces.empty()) return result;

    std::vector<Box> boxes(pieces.size());
    std::transform(pieces.begin(), pieces.end(), boxes.begin(), [](const Piece& piece) { return piece.bounds; });
    Bvh bvh = build_bvh(boxes, node_cost);
    result.nodes = std::move(bvh.nodes);
    for (const Packet& packet : bvh.packets) result.packets.push_back(packed(pieces, packet));
    return result;
}

}  // namespace bob
