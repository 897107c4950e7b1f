/// Edges of boundary representations.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/interruption.h"
#include "nurbs/loop_pieces.h"
#include "shapes/brep/brep.h"

namespace bob {
namespace {

/// Tolerance of curves, in radii of the shape: CAD systems write at least seven digits.
constexpr EdgeTolerance exact{1e-7, 1e-7};

/// Steps along a Bezier piece: few for lines and circles, many for free curves. Their points are then within about 1e-4 of their length.
constexpr int few = 8, many = 64;

/// Pieces of one curve that meet at a larger angle are two edges.
constexpr double kink_degrees = 2;

struct Border {
    ShapeEdge edge;
    std::uint32_t face;  // its number
    bool is_left_out = false;
};

/// A piece of a loop in space.
class Curve {
public:
    Curve(const NurbsSurface& surface, LoopPiece piece) : surface_(&surface), piece_(std::move(piece)) {}

    [[nodiscard]] Vec3d operator()(double t) const {
        const At place = at(piece_, t);
        return surface_derivatives(*surface_, place.u, place.v, 0)[0];
    }
    /// Unit directions at its ends, from chords.
    [[nodiscard]] Vec3d direction(bool at_end) const {
        constexpr double near = 1e-4;
        const Vec3d way = at_end ? (*this)(1) - (*this)(1 - near) : (*this)(near) - (*this)(0);
        const double size = length(way);
        return size > 0 ? 1 / size * way : Vec3d{};
    }

private:
    const NurbsSurface* surface_;
    LoopPiece piece_;
};

std::vector<Vec3d> points_of(std::span<const Curve> curves, int steps) {
    std::vector<Vec3d> points{curves.front()(0)};
    for (const Curve& curve : curves) {
        for (int i = 1; i <= steps; ++i) points.push_back(curve(static_cast<double>(i) / steps));
    }
    return points;
}

/// The pieces of a loop's curve, or the four sides of a surface without loops.
std::vector<std::vector<LoopPiece>> curves_of(const Face& face) {
    std::vector<std::vector<LoopPiece>> curves;
    for (const TrimLoop& loop : face.loops) {
        for (const NurbsCurve<2>& curve : loop) curves.push_back(decompose(curve));
    }
    if (!curves.empty()) return curves;
    const NurbsSurface& s = face.surface;
    const double low_u = s.knots_u[static_cast<std::size_t>(s.degree_u)], high_u = s.knots_u[s.size_u()];
    const double low_v = s.knots_v[static_cast<std::size_t>(s.degree_v)], high_v = s.knots_v[s.size_v()];
    const std::array<Homogeneous<2>, 4> corners{{{low_u, low_v, 1}, {high_u, low_v, 1}, {high_u, high_v, 1}, {low_u, high_v, 1}}};
    for (std::size_t i = 0; i < 4; ++i) curves.push_back({{0, 1, {corners[i], corners[(i + 1) % 4]}}});
    return curves;
}

void add_borders(const Face& face, std::uint32_t number, std::vector<Border>& borders) {
    static const double cos_kink = std::cos(kink_degrees * std::numbers::pi / 180);
    std::vector<Curve> joined;
    const auto flush = [&] {
        if (joined.empty()) return;
        std::vector<Vec3d> points = points_of(joined, few);
        double along = 0;
        for (std::size_t i = 1; i < points.size(); ++i) along += length(points[i] - points[i - 1]);
        if (along > 10 * exact.length) {  // no pole
            ShapeEdge edge = edge_through(std::move(points), exact);
            if (!edge.is_straight && !edge.circle) edge = edge_through(points_of(joined, many), exact);
            borders.push_back({std::move(edge), number});
        }
        joined.clear();
    };
    for (const std::vector<LoopPiece>& pieces : curves_of(face)) {
        Interruption::check();
        for (const LoopPiece& piece : pieces) {
            Curve curve(face.surface, piece);
            if (!joined.empty() && dot(joined.back().direction(true), curve.direction(false)) < cos_kink) flush();
            joined.push_back(std::move(curve));
        }
        flush();
    }
}

/// Cells of space, to find equal places.
class Places {
public:
    explicit Places(double near) : near_(near) {}

    void add(const Vec3d& place, std::uint32_t item) { cells_[key(cell(place))].push_back(item); }

    /// Calls body for items whose places may be within `near`.
    template <class Body>
    void for_near(const Vec3d& place, Body body) const {
        const auto low = cell(place - Vec3d{near_, near_, near_}), high = cell(place + Vec3d{near_, near_, near_});
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
            for (std::int64_t y = low[1]; y <= high[1]; ++y) {
                for (std::int64_t z = low[2]; z <= high[2]; ++z) {
                    const auto found = cells_.find(key({x, y, z}));
                    if (found == cells_.end()) continue;
                    for (const std::uint32_t item : found->second) body(item);
                }
            }
        }
    }

private:
    [[nodiscard]] std::array<std::int64_t, 3> cell(const Vec3d& place) const {
        const auto along = [&](std::size_t axis) { return static_cast<std::int64_t>(std::floor(place[axis] / (8 * near_))); };
        return {along(0), along(1), along(2)};
    }
    [[nodiscard]] static std::uint64_t key(const std::array<std::int64_t, 3>& at) {
        std::uint64_t hash = 0;
        for (const std::int64_t part : at) hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15 + (hash >> 29);
        return hash;
    }

    double near_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

double distance(const Vec3d& p, std::span<const Vec3d> curve) {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
        const Vec3d along = curve[i + 1] - curve[i];
        const double size = dot(along, along), t = size > 0 ? std::clamp(dot(p - curve[i], along) / size, 0., 1.) : 0;
        least = std::min(least, length(p - curve[i] - t * along));
    }
    return least;
}

/// Whether two edges are one curve, in either direction.
bool coincide(const ShapeEdge& a, const ShapeEdge& b, double near) {
    const auto &p = a.points, &q = b.points;
    const bool forth = length(p.front() - q.front()) <= near && length(p.back() - q.back()) <= near;
    const bool back = length(p.front() - q.back()) <= near && length(p.back() - q.front()) <= near;
    if (!forth && !back) return false;
    const double bow = 2e-2 * length(p[p.size() / 2] - p.front());  // of chords of free curves and circles
    return distance(p[p.size() / 2], q) <= near + bow;
}

bool are_one_circle(const ShapeEdge& a, const ShapeEdge& b, double near) {
    return a.circle && b.circle && length(a.circle->center - b.circle->center) <= near && std::abs(a.circle->radius - b.circle->radius) <= near;
}

}  // namespace

const std::vector<ShapeEdge>* Brep::edges() const {
    edges_.prepare([&] {
        std::vector<Border> borders;
        for (std::size_t i = 0; i < faces_.size(); ++i) add_borders(faces_[i], numbers_[i], borders);
        const double near = std::max(2 * tolerance_, 1e-6);
        // If borders of two faces coincide, the first stays; a seam has one face on both sides.
        Places middles(near);
        for (std::uint32_t i = 0; i < borders.size(); ++i) {
            Border& own = borders[i];
            const Vec3d middle = 0.5 * (own.edge.points.front() + own.edge.points.back());
            middles.for_near(middle, [&](std::uint32_t other) {
                if (own.is_left_out || !coincide(own.edge, borders[other].edge, near)) return;
                own.is_left_out = true;
                if (own.face == borders[other].face) borders[other].is_left_out = true;
            });
            if (!own.is_left_out) middles.add(middle, i);
        }
        std::erase_if(borders, [](const Border& border) { return border.is_left_out; });
        // Arcs of one circle meet without a corner.
        Places ends(near);
        for (std::uint32_t i = 0; i < borders.size(); ++i) ends.add(borders[i].edge.points.front(), i), ends.add(borders[i].edge.points.back(), i);
        std::vector<ShapeEdge> edges;
        for (const Border& own : borders) {
            ShapeEdge edge = own.edge;
            const auto is_corner = [&](const Vec3d& end) {
                bool alone = true, all = true;
                ends.for_near(end, [&](std::uint32_t i) {
                    const ShapeEdge& other = borders[i].edge;
                    const bool meets = length(other.points.front() - end) <= near || length(other.points.back() - end) <= near;
                    if (&other == &own.edge || !meets) return;
                    alone = false, all = all && are_one_circle(edge, other, near);
                });
                return alone || !all;
            };
            if (edge.circle) {
                edge.begins_at_corner = edge.begins_at_corner && is_corner(edge.points.front());
                edge.ends_at_corner = edge.ends_at_corner && is_corner(edge.points.back());
                if (!edge.begins_at_corner && !edge.ends_at_corner) edge.middle.reset();
            }
            edges.push_back(std::move(edge));
        }
        return edges;
    });
    return edges_.get();
}

}  // namespace bob
