#include "shapes/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace bob {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// A larger turn is a corner. Circles of eleven segments turn by 33 degrees, octagons by 45.
constexpr double corner_degrees = 35;

/// Shorter arcs may be anything smooth.
constexpr double least_arc_degrees = 45;

/// Least squares of fewer points would find circles in noise: three values leave one of four points to disagree.
constexpr std::size_t least_fitted = 8;

/// Straight pieces in a row that are a free curve: two are the sides of a slight bend.
constexpr std::size_t least_free = 3;

double distance_from_line(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d along = b - a;
    return length(cross(p - a, along)) / length(along);
}

bool are_on_line(std::span<const Vec3d> points, double tolerance) {
    if (!(length(points.back() - points.front()) > tolerance)) return false;
    return std::all_of(points.begin(), points.end(), [&](const Vec3d& p) { return distance_from_line(p, points.front(), points.back()) <= tolerance; });
}

/// The point at a share of a chain's length: near it, where points are far apart.
const Vec3d& point_at(std::span<const Vec3d> points, double share) {
    double whole = 0;
    for (std::size_t i = 1; i < points.size(); ++i) whole += length(points[i] - points[i - 1]);
    std::size_t i = 0;
    for (double so_far = 0; i + 2 < points.size() && so_far < share * whole * (1 - 1e-9);) ++i, so_far += length(points[i] - points[i - 1]);
    return points[i];
}

/// Moves a circle within its plane to the least squares of the points' distances from it.
EdgeCircle fitted(const EdgeCircle& circle, std::span<const Vec3d> points) {
    const Vec3d x = 1 / circle.radius * (points.front() - circle.center), y = cross(circle.axis, x);
    std::array<std::array<double, 4>, 3> sums{};  // the normal equations
    for (const Vec3d& p : points) {
        const Vec3d from = p - circle.center;
        const double far = length(from);
        const std::array<double, 4> row{dot(from, x) / far, dot(from, y) / far, 1, far - circle.radius};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 4; ++k) sums[i][k] += row[i] * row[k];
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        if (!(sums[i][i] > 1e-9 * static_cast<double>(points.size()))) return circle;
        for (std::size_t j = 0; j < 3; ++j) {
            const double times = j == i ? 0 : sums[j][i] / sums[i][i];
            for (std::size_t k = i; k < 4; ++k) sums[j][k] -= times * sums[i][k];
        }
    }
    const auto moved = [&](std::size_t i) { return sums[i][3] / sums[i][i]; };
    return {circle.center + moved(0) * x + moved(1) * y, circle.axis, circle.radius + moved(2)};
}

/// The circle through all points, if there is one. Its first estimate is that through three points which are far apart: neighbours, of
/// which there may be many at one place, would multiply their errors.
std::optional<EdgeCircle> circle_through(std::span<const Vec3d> points, const EdgeTolerance& tolerance) {
    if (points.size() < 4) return std::nullopt;
    const std::size_t last = points.size() - 1;
    const bool is_closed = length(points[last] - points[0]) <= tolerance.length;
    const Vec3d a = points[0], ab = point_at(points, is_closed ? 1 / 3. : 0.5) - a, ac = (is_closed ? point_at(points, 2 / 3.) : points[last]) - a;
    const Vec3d normal = cross(ab, ac);
    const double size = length(normal);
    if (!(size > 1e-9 * dot(ac, ac))) return std::nullopt;
    const Vec3d to_center = 1 / (2 * size * size) * (dot(ac, ac) * cross(normal, ab) + dot(ab, ab) * cross(ac, normal));
    EdgeCircle circle{a + to_center, 1 / size * normal, length(to_center)};
    if (points.size() >= least_fitted) circle = fitted(circle, points);
    const double most = tolerance.length + tolerance.relative * circle.radius;
    const bool fits = std::all_of(points.begin(), points.end(), [&](const Vec3d& p) {
        const Vec3d from = p - circle.center;
        return std::abs(dot(from, circle.axis)) <= most && std::abs(length(from) - circle.radius) <= most;
    });
    return fits ? std::optional(circle) : std::nullopt;
}

/// The angle from the first point of an arc to its last, against the clock about `axis` if above 0.
double angle_of_arc(std::span<const Vec3d> points, const EdgeCircle& circle) {
    const Vec3d x = points.front() - circle.center, y = cross(circle.axis, x);
    const auto angle = [&](const Vec3d& p) {
        const double found = std::atan2(dot(p - circle.center, y), dot(p - circle.center, x));
        return found < 0 ? found + 2 * std::numbers::pi : found;
    };
    const double whole = angle(points.back());
    return angle(points[points.size() / 2]) <= whole ? whole : whole - 2 * std::numbers::pi;
}

Vec3d middle_of_arc(std::span<const Vec3d> points, const EdgeCircle& circle) {
    const Vec3d x = points.front() - circle.center, y = cross(circle.axis, x);
    const double half = 0.5 * angle_of_arc(points, circle);
    return circle.center + std::cos(half) * x + std::sin(half) * y;
}

/// The edges along a chain without corners.
void split(std::span<const Vec3d> chain, const EdgeTolerance& tolerance, std::vector<ShapeEdge>& edges) {
    const std::size_t first_edge = edges.size(), last = chain.size() - 1;
    std::vector<std::pair<std::size_t, std::size_t>> straight;  // the first and last point of each since the last arc
    const auto add = [&](std::size_t begin, std::size_t end) {
        const auto points = chain.subspan(begin, end - begin + 1);
        edges.push_back(edge_through({points.begin(), points.end()}, tolerance));
    };
    const auto add_straight = [&] {
        if (straight.size() >= least_free) {
            add(straight.front().first, straight.back().second);
        } else {
            for (const auto& [begin, end] : straight) add(begin, end);
        }
        straight.clear();
    };
    enum Arc : std::uint8_t { none, slight, whole };
    const auto arc = [&](std::size_t begin, std::size_t end) {
        const auto points = chain.subspan(begin, end - begin + 1);
        const auto circle = circle_through(points, tolerance);
        if (!circle) return none;
        return chain[end] == chain[begin] || std::abs(angle_of_arc(points, *circle)) >= least_arc_degrees * degree ? whole : slight;
    };
    for (std::size_t i = 0; i < last;) {
        std::size_t end = arc(i, last) == whole ? last : i;  // first all the rest, since each test looks at all points
        for (std::size_t j = i + 3; end < last && j <= last; ++j) {
            const Arc found = arc(i, j);
            if (found == none) break;
            if (found == whole) end = j;
        }
        if (end > i) {
            add_straight();
            add(i, end);
        } else {
            for (end = i + 1; end < last && are_on_line(chain.subspan(i, end - i + 2), tolerance.length);) ++end;
            straight.emplace_back(i, end);
        }
        i = end;
    }
    add_straight();
    if (chain.front() == chain.back() && edges.size() == first_edge + 1) {
        edges.back().begins_at_corner = edges.back().ends_at_corner = false;
    }
}

}  // namespace

ShapeEdge edge_through(std::vector<Vec3d> points, const EdgeTolerance& tolerance) {
    ShapeEdge edge{std::move(points), std::nullopt};
    edge.is_straight = are_on_line(edge.points, tolerance.length);
    if (edge.is_straight) {
        edge.middle = 0.5 * (edge.points.front() + edge.points.back());
    } else {
        edge.circle = circle_through(edge.points, tolerance);
        const bool is_closed = length(edge.points.back() - edge.points.front()) <= tolerance.length;
        if (is_closed) edge.begins_at_corner = edge.ends_at_corner = !edge.circle;
        if (edge.circle && !is_closed) edge.middle = middle_of_arc(edge.points, *edge.circle);
    }
    return edge;
}

std::vector<ShapeEdge> edges_between(std::span<const Vec3d> points, std::span<const Link> segments, const EdgeTolerance& tolerance) {
    const Meetings meetings(points.size(), segments);
    const double cos_corner = std::cos(corner_degrees * degree);
    const auto other = [&](std::uint32_t segment, std::uint32_t point) {
        const auto& [a, b] = segments[segment];
        return points[a == point ? b : a];
    };
    const auto passes = [&](std::uint32_t point) {
        if (meetings.count(point) != 2) return false;
        const std::uint32_t* const at = &meetings.at[meetings.start[point]];
        const Vec3d before = points[point] - other(at[0], point), after = other(at[1], point) - points[point];
        return dot(before, after) >= cos_corner * length(before) * length(after);
    };
    std::vector<ShapeEdge> edges;
    std::vector<Vec3d> chain;
    for_each_chain(meetings, segments, passes, [&](std::vector<std::uint32_t>& numbers) {
        if (numbers.front() == numbers.back() && passes(numbers.front())) {  // begins with the longest segment: not within an arc
            std::size_t longest = 0;
            const auto size = [&](std::size_t i) { return length(points[numbers[i + 1]] - points[numbers[i]]); };
            for (std::size_t i = 1; i + 1 < numbers.size(); ++i) {
                if (size(i) > (1 + 1e-3) * size(longest)) longest = i;
            }
            numbers.pop_back();
            std::rotate(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(longest), numbers.end());
            numbers.push_back(numbers.front());
        }
        chain.clear();
        for (const std::uint32_t number : numbers) chain.push_back(points[number]);
        split(chain, tolerance, edges);
    });
    return edges;
}

}  // namespace bob
