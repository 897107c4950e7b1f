/// Shapes in two dimensions, with the values of fogleman/sdf's; see shapes_3d.cpp for the style of formulas.
#include <algorithm>

#include "modelling/region.h"
#include "modelling/shapes_nd.h"
#include "modelling/words.h"

namespace bob {
namespace {

constexpr Vector<2> origin_2d{0, 0}, up_2d{0, 1};
const double sqrt3 = std::sqrt(3.0);

Object line(const Arguments& a) {
    Graph graph;
    return sdf<2>(graph, dot(point<2>(graph) - a.vector<2>("point"), a.direction<2>("normal") * -1));
}

Object rounded_rectangle(const Arguments& a) {
    const Vector<4> radius = a.size<4>("radius");
    Graph graph;
    const Point<2> p = point<2>(graph) - a.vector<2>("center");
    const auto [x, y] = p;
    const auto choose = [&](Value coordinate, Value above, Value below) { return select(-coordinate, above, below); };
    const auto r = [&](std::size_t i) { return graph.constant(radius[i]); };
    const Value r2 = r(2), r3 = r(3), left = choose(y, r3, r2);
    const Value r1 = r(1), r0 = r(0), right = choose(y, r0, r1);
    const Value rounding = choose(x, right, left);
    const Point<2> q = abs(p) - a.size<2>("size") * 0.5;
    const Value above = q[1] + rounding;
    return sdf<2>(graph, corner(q[0] + rounding, above) - rounding);
}

Object equilateral_triangle(const Arguments&) {
    Graph graph;
    // Mirrored until the lower edge, from (-2, 0) to (0, 0), is the nearest; the inside is above it.
    Value x = abs(graph.x()) - 1, y = graph.y() + 1 / sqrt3;
    const Value over = max(x + sqrt3 * y, 0) / 2;
    x = x - over, y = y - sqrt3 * over;
    const Value below = -y;
    return sdf<2>(graph, corner(abs(x + 1) - 1, below));
}

Object hexagon(const Arguments& a) {
    const double r = a.at_least(0, "r") * sqrt3 / 2;  // from the corners to the edges
    Graph graph;
    auto [x, y] = abs(point<2>(graph));
    // Mirrored until the upper edge is the nearest.
    const Value aside = x * (sqrt3 / 2), over = 2 * min(y * 0.5 - aside, 0);
    x = x + over * (sqrt3 / 2), y = y - over * 0.5;
    const Value beside = abs(x) - r / sqrt3, beyond = y - r;  // inside, no point lies past the edge's ends
    const Value up = max(beyond, 0);
    return sdf<2>(graph, piecewise(beside, beyond, hypot(max(beside, 0), up)));
}

Object rounded_x(const Arguments& a) {
    const double half = a.number("w") / 2;
    Graph graph;
    const auto [x, y] = abs(point<2>(graph));
    // Minus the nearest point of the diagonal, which is half of min(x + y, w) in both coordinates.
    const Value across = (x - y) / 2;
    const Value beyond_y = y - half, dy = max(-across, beyond_y);
    return sdf<2>(graph, hypot(max(across, x - half), dy) - a.number("r"));
}

/// A point relative to an edge of a polygon.
struct Edge {
    Vector<2> from, direction;
    double length;
    Value run;   // along it, from its start
    Value left;  // distance to its left
};

std::vector<Edge> edges(Graph& graph, const std::vector<Vector<2>>& corners) {
    std::vector<Edge> result;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vector<2> span = corners[(i + 1) % corners.size()] - corners[i];
        const Vector<2> direction = normalized(span), across{-direction[1], direction[0]};
        const Point<2> p = point<2>(graph) - corners[i];
        result.push_back({corners[i], direction, length(span), dot(p, direction), dot(p, across)});
    }
    return result;
}

/// 1 if a convex polygon turns left, -1 if right; 0 if it is not convex.
int convex_turn(const std::vector<Edge>& edges) {
    double total = 0, least = 0, most = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Vector<2> a = edges[i].direction, b = edges[(i + 1) % edges.size()].direction;
        const double turn = std::atan2(a[0] * b[1] - a[1] * b[0], dot(a, b));
        total += turn, least = std::min(least, turn), most = std::max(most, turn);
    }
    if (std::fabs(total) > 7) return 0;  // more than one turn
    return least >= 0 ? 1 : most <= 0 ? -1 : 0;
}

/// The maximum distance from an edge's line; past the ends of two edges, the distance from their corner.
Value convex(Graph& graph, const std::vector<Edge>& edges, int turn) {
    Value result = edges[0].left * -turn;
    for (const Edge& edge : edges) result = max(result, edge.left * -turn);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Edge& before = edges[i ? i - 1 : edges.size() - 1];
        const Value short_of_corner = max(before.length - before.run, edges[i].run);
        result = piecewise(short_of_corner, length(point<2>(graph) - edges[i].from), result);
    }
    return result;
}

Object polygon(const Arguments& a) {
    std::vector<Vector<2>> corners = a.points<2>("points");
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
    if (corners.size() < 3) a.reject("points", "at least 3 different points");
    if (corners.size() > 10000) a.reject("points", "at most 10000 points");
    Graph graph;
    const std::vector<Edge> all = edges(graph, corners);
    if (const int turn = convex_turn(all)) return sdf<2>(graph, convex(graph, all, turn));
    Loop loop;
    for (std::size_t i = 0; i < corners.size(); ++i) loop.push_back({corners[i], corners[(i + 1) % corners.size()]});
    const std::optional<Value> distance = region(graph, {loop}, Winding::odd);
    if (!distance) a.reject("points", "corners with something between them");
    return sdf<2>(graph, *distance);
}

Object vesica(const Arguments& a) {
    const double r = a.number("r"), d = a.number("d");
    if (std::fabs(d) > std::fabs(r)) a.reject("d", "a number of at most r");
    const double b = std::sqrt(r * r - d * d);
    Graph graph;
    const auto [x, y] = abs(point<2>(graph));
    const Value from_arc = hypot(x + d, y) - r, from_tip = hypot(x, y - b);
    const Value slope = d * (y - b);
    return sdf<2>(graph, piecewise(b * x - slope, from_tip, from_arc));
}

}  // namespace

void add_shapes_2d(std::vector<Word>& words) {
    const auto shape = [&](std::string_view name, std::vector<Parameter> parameters, Object (*call)(const Arguments&),
                           std::string_view meaning) {
        words.push_back({name, Word::Kind::shape, 2, 2, std::move(parameters), meaning, call});
    };
    const auto number = Type::number;
    const Parameter r = required("r", number), center = with_default("center", Type::vector, origin_2d);

    shape("circle", {with_default("radius", number, 1.0), center}, ball<2>, "A disk.");
    shape("line", {with_default("normal", Type::vector, up_2d), with_default("point", Type::vector, origin_2d)}, line,
          "Half of the plane: the side that the normal points to.");
    shape("slab",
          {optional("x0", number), optional("y0", number), optional("x1", number), optional("y1", number),
           optional("k", number)},
          slab<2>, "The region between lines across the axes; each line is optional, and k rounds the corners.");
    shape("rectangle",
          {with_default("size", Type::size, 1.0), center, optional("a", Type::vector), optional("b", Type::vector)},
          box<2>, "A rectangle of given sides around a center, or from corner a to corner b.");
    shape("rounded_rectangle", {required("size", Type::size), required("radius", Type::numbers), center},
          rounded_rectangle,
          "A rectangle with round corners: one radius, or four, clockwise from the corner of largest x and y.");
    shape("equilateral_triangle", {}, equilateral_triangle, "A triangle of side 2 that points up, around the origin.");
    shape("hexagon", {r}, hexagon, "A regular hexagon with corners at r on the x axis.");
    shape("rounded_x", {required("w", number), r}, rounded_x,
          "Two crossed lines along the diagonals, w wide, with everything within r of them.");
    shape("polygon", {required("points", Type::points)}, polygon,
          "A polygon from its corners in order; where it crosses itself, even-odd.");
    shape("vesica", {r, required("d", number)}, vesica,
          "The intersection of two disks of radius r with centers d to the left and right of the origin.");
}

}  // namespace bob
