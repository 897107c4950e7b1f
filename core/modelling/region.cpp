/// Regions as minima and maxima of distances from loops.
///
/// Islands are disjoint, and so are the holes of an island. Minima and maxima of the distances from single loops are
/// therefore exact. Boxes around loops bound these distances from below, so that bounds skip distant loops.
///
/// The distance from a loop is the distance from its nearest feature: a segment, or a corner that can be nearest to
/// points. Few features are near a small box, and there the formula reduces to little more than one of them. "Hello,
/// world", to 1e-4 of its size, takes 330 arcs and lines, ready for tracing in 0.3 s, or 960 lines, in 0.8 s and twice
/// the time per ray.
///
/// The sum of the angles subtended by the segments also gives the sign, but simplifies nowhere: with it the lines take
/// 2.7 s, and 50 times as long per ray as the arcs. Features that know their side even past their ends, where others
/// are nearer, jump there, and took a quarter more of both.
#include "modelling/region.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "modelling/arcs.h"
#include "modelling/words.h"

namespace bob {
namespace {

/// Segments that turn by less than this where they meet, in radians, need no corner. Where it would be nearest, a segment
/// seems nearer by 1e-9 of the distance.
constexpr double smooth_turn = 1e-4;

/// From this cosine of the turn on, all points nearest to a corner are on one side of it. At flatter corners other
/// features are almost as near, and the side of the common tangent decides.
constexpr double sharp_turn = 0.5;

/// Growth, relative to distances, of the penalty that keeps a feature from being nearer than a corner. This is enough
/// for the end of an arc, which is farther away than the arc's circle and its end's normal together.
constexpr double steep = 4;

/// A feature that a point may be nearest to.
struct Feature {
    Value away;             // the distance where it is nearest; elsewhere no less than the loop's distance
    Value signed_distance;  // valid where it is nearest; negative inside
};

/// A segment, at most a quarter of a circle, with the inside to its left.
Feature of_segment(Graph& graph, const Segment& segment) {
    const Point<2> p = point<2>(graph);
    const Vector<2> direction = normalized(segment.to - segment.from), right{direction[1], -direction[0]};
    const Vector<2> middle = middle_of(segment);
    const Value along = abs(dot(p, direction) - dot(middle, direction));
    Value past_ends, aside;
    if (is_straight(segment)) {
        past_ends = along - length(segment.to - segment.from) / 2;
        aside = dot(p, right) - dot(middle, right);
    } else {
        const Arc arc(segment);
        const double turn = arc.angle < 0 ? -1 : 1, half = std::fabs(arc.angle) / 2;
        const Value up = dot(p, right * turn) - dot(arc.center, right * turn);
        const Value down = -up, up_aside = up * std::sin(half);
        past_ends = max(along * std::cos(half) - up_aside, down);
        aside = (hypot(up, along) - arc.radius) * turn;
    }
    const Value farther = max(past_ends, 0) * steep;
    return {abs(aside) + farther, aside};
}

/// The corner of two segments; empty if they join smoothly.
std::optional<Feature> of_corner(Graph& graph, const Segment& before, const Segment& after) {
    const Vector<2> arriving = end_direction(before), leaving = start_direction(after);
    const double turn = std::atan2(cross(arriving, leaving), dot(arriving, leaving));
    if (std::fabs(turn) < smooth_turn) return std::nullopt;
    const Point<2> from_corner = point<2>(graph) - after.from;
    const Value away = length(from_corner), inside = -away;
    if (std::cos(turn) < sharp_turn) return Feature{away, turn > 0 ? away : inside};
    const Vector<2> on = normalized(arriving + leaving), right{on[1], -on[0]};
    return Feature{away, max(min(dot(from_corner, right) * steep, away), inside)};
}

/// The nearest of a range of features: a binary tree, so that distant groups drop out together.
Feature nearest(const std::vector<Feature>& features, std::size_t first, std::size_t last) {
    if (last - first == 1) return features[first];
    const std::size_t middle = first + (last - first) / 2;
    const Feature a = nearest(features, first, middle), b = nearest(features, middle, last);
    const Value away = min(a.away, b.away);
    return {away, piecewise(b.away - a.away, b.signed_distance, a.signed_distance)};
}

/// The signed distance from the left side of a loop, as if there were no other loops.
Value distance(Graph& graph, const Loop& loop) {
    std::vector<Feature> features;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        if (const auto corner = of_corner(graph, loop[i ? i - 1 : loop.size() - 1], loop[i])) features.push_back(*corner);
        for (const Segment& arc : quarters(loop[i])) features.push_back(of_segment(graph, arc));
    }
    return nearest(features, 0, features.size()).signed_distance;
}

/// A lower bound of the distance from a loop, outside its box.
Value distance_from_box(Graph& graph, const Loop& loop) {
    Extent box;
    box.add(loop);
    Point<2> beyond_sides = point<2>(graph);
    for (std::size_t i = 0; i < 2; ++i) {
        const double half = (box.high[i] - box.low[i]) / 2;
        beyond_sides[i] = abs(beyond_sides[i] - (box.low[i] + half)) - half;
    }
    return largest(beyond_sides);
}

}  // namespace

std::optional<Value> region(Graph& graph, const std::vector<Loop>& loops, Winding winding) {
    std::optional<Value> result;
    for (const Island& island : islands(loops, winding)) {
        const Value from_box = distance_from_box(graph, island.around);
        Value from_island = max(from_box, distance(graph, island.around));
        for (const Loop& hole : island.holes) {
            const Value from_hole = -distance_from_box(graph, hole);
            from_island = max(from_island, min(from_hole, distance(graph, hole)));
        }
        result = result ? min(*result, from_island) : from_island;
    }
    return result;
}

}  // namespace bob
