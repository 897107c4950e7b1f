/// Operations on shapes, with the values of fogleman/sdf's. Operations for any dimension are written once.
#include <algorithm>
#include <numbers>

#include "modelling/words.h"

namespace bob {

using std::numbers::pi;

namespace {

/// The material that a fillet removes from the edge. It is k h (1 - h), combined with the mix of a and b by h, so that
/// neither appears alone.
Value fillet(Value a, Value b, double k) { return square(max(k - abs(a - b), 0)) / (4 * k); }

Value smooth_min(Value a, Value b, double k) {
    if (k == 0) return min(a, b);
    const Value rounded = fillet(a, b, k);
    return min(a, b) - rounded;
}

/// The h of that mix: the weight of the colour whose `condition` is negative.
Value share(Value condition, double k) { return clamp(0.5 - condition / (2 * k), 0, 1); }

Colored smooth_min(const Colored& a, const Colored& b, double k) {
    if (k == 0) return min(a, b);
    return {smooth_min(a.distance, b.distance, k), of_both(a, b, [&](const Rgb& of_a, const Rgb& of_b) {
                return mixed(of_a, of_b, share(b.distance - a.distance, k));
            })};
}

}  // namespace

double smoothness(const Arguments& arguments) { return arguments.has("k") ? arguments.at_least(0, "k") : 0; }

Value smooth_max(Value a, Value b, double k) {
    if (k == 0) return max(a, b);
    const Value rounded = fillet(a, b, k);
    return max(a, b) + rounded;
}

Colored smooth_max(const Colored& a, const Colored& b, double k) {
    const Value distance = smooth_max(a.distance, b.distance, k);
    if (!a.color || !b.color) return {distance, a.color ? a.color : b.color};
    const Value a_is_lower = a.distance - b.distance;
    return {distance, k == 0 ? chosen(a_is_lower, *b.color, *a.color) : mixed(*a.color, *b.color, share(a_is_lower, k))};
}

namespace {

constexpr Vector<3> z_axis{0, 0, 1};

// ---- Together --------------------------------------------------------------------------------------------

/// Folds the shapes `bs` into the shape `a`, one after the other. The radius k is the argument or, if omitted, the k of
/// each of `bs`; 0 if unset.
template <std::size_t n, class Step>
Object fold(const Arguments& a, double k, Step step) {
    Graph graph;
    const Point<n> p = point<n>(graph);
    Colored result = at(a.sdf("a"), p);
    for (const Sdf& b : a.sdfs("bs")) result = step(result, at(b, p), k != 0 ? k : b.k.value_or(0));
    return sdf<n>(graph, result);
}

template <std::size_t n>
Object unite(const Arguments& a) {
    return fold<n>(a, smoothness(a), [](const Colored& x, const Colored& y, double k) { return smooth_min(x, y, k); });
}

template <std::size_t n>
Object subtract(const Arguments& a) {
    // A tool without a colour leaves cuts in the colour of the material. A tool with one paints only the cuts.
    return fold<n>(a, smoothness(a), [](const Colored& x, const Colored& y, double k) {
        return smooth_max(y.color ? painted(x) : x, -y, k);
    });
}

template <std::size_t n>
Object intersect(const Arguments& a) {
    return fold<n>(a, smoothness(a), [](const Colored& x, const Colored& y, double k) { return smooth_max(x, y, k); });
}

template <std::size_t n>
Object blend(const Arguments& a) {
    return fold<n>(a, a.number("k"), [](const Colored& x, const Colored& y, double k) -> Colored {
        const Value before = (1 - k) * x.distance;
        return {k * y.distance + before, of_both(x, y, [&](const Rgb& of_x, const Rgb& of_y) {
                    return mixed(of_x, of_y, x.distance.graph->constant(k));
                })};
    });
}

// ---- Distances -------------------------------------------------------------------------------------------

template <std::size_t n, class Change>
Object change(const Arguments& a, Change change) {
    Graph graph;
    return sdf<n>(graph, change(at(a.sdf("other"), point<n>(graph))));
}

template <std::size_t n>
Object negate(const Arguments& a) {
    return change<n>(a, [](const Colored& d) { return -d; });
}

template <std::size_t n>
Object dilate(const Arguments& a) {
    return change<n>(a, [r = a.number("r")](const Colored& d) { return d - r; });
}

template <std::size_t n>
Object erode(const Arguments& a) {
    return change<n>(a, [r = a.number("r")](const Colored& d) { return d + r; });
}

template <std::size_t n>
Object shell(const Arguments& a) {
    return change<n>(a, [thickness = a.number("thickness")](const Colored& d) { return abs(d) - thickness / 2; });
}

// ---- Colours ---------------------------------------------------------------------------------------------

Object color(const Arguments& a) {
    Sdf result = a.sdf("other");
    result.color = a.color("c");
    return {std::move(result)};
}

// ---- Places ----------------------------------------------------------------------------------------------

template <std::size_t n>
Object translate(const Arguments& a) {
    Graph graph;
    return sdf<n>(graph, at(a.sdf("other"), point<n>(graph) - a.vector<n>("offset")));
}

template <std::size_t n>
Object scale(const Arguments& a) {
    const Vector<n> factor = a.nonzero_size<n>("factor");
    Graph graph;
    Point<n> p = point<n>(graph);
    for (std::size_t i = 0; i < n; ++i) p[i] = p[i] / factor[i];
    return sdf<n>(graph, at(a.sdf("other"), p) * *std::min_element(factor.begin(), factor.end()));
}

/// Keeps the rounded cosine of a quarter turn from mixing coordinates.
double tidy(double coefficient) {
    const double nearest = std::round(coefficient);
    return std::fabs(coefficient - nearest) < 1e-15 ? nearest : coefficient;
}

Object rotated_2d(const Sdf& other, double angle) {
    const double s = tidy(std::sin(angle)), c = tidy(std::cos(angle));
    Graph graph;
    const Point<2> p = point<2>(graph);
    return sdf<2>(graph, at(other, Point<2>{dot(p, Vector<2>{c, -s}), dot(p, Vector<2>{s, c})}));
}

/// Rotates around a unit vector by an angle with sine s and cosine c.
Object rotated_3d(const Sdf& other, const Vector<3>& axis, double s, double c) {
    const auto [x, y, z] = axis;
    const double m = 1 - c;
    const auto row = [](double i, double j, double k) { return Vector<3>{tidy(i), tidy(j), tidy(k)}; };
    Graph graph;
    const Point<3> p = point<3>(graph);
    return sdf<3>(graph, at(other, Point<3>{dot(p, row(m * x * x + c, m * x * y + z * s, m * z * x - y * s)),
                                              dot(p, row(m * x * y - z * s, m * y * y + c, m * y * z + x * s)),
                                              dot(p, row(m * z * x + y * s, m * y * z - x * s, m * z * z + c))}));
}

Object rotate_2d(const Arguments& a) { return rotated_2d(a.sdf("other"), a.number("angle")); }

Object rotate_3d(const Arguments& a) {
    const double angle = a.number("angle");
    return rotated_3d(a.sdf("other"), a.direction<3>("vector"), std::sin(angle), std::cos(angle));
}

/// Rotates `from` to `to`; both of length 1.
Object turned(const Sdf& other, const Vector<3>& from, const Vector<3>& to) {
    const Vector<3> axis = cross(to, from);
    const double sine = length(axis), cosine = dot(from, to);
    if (sine > 1e-15) return rotated_3d(other, axis * (1 / sine), sine, cosine);
    if (cosine > 0) return {other};
    // Half a turn, around any perpendicular direction.
    const bool along_x = from[1] == 0 && from[2] == 0;
    return rotated_3d(other, normalized(cross(from, along_x ? Vector<3>{0, 1, 0} : Vector<3>{1, 0, 0})), 0, -1);
}

Object rotate_to(const Arguments& a) { return turned(a.sdf("other"), a.direction<3>("a"), a.direction<3>("b")); }

Object orient(const Arguments& a) { return turned(a.sdf("other"), z_axis, a.direction<3>("axis")); }

// ---- Copies ----------------------------------------------------------------------------------------------

constexpr int most_copies = 10000;

Object circular_array_2d(const Arguments& a) {
    const int count = a.whole(1, most_copies, "count");
    Graph graph;
    const Point<2> p = point<2>(graph);
    std::optional<Colored> result;
    for (int i = 0; i < count; ++i) {
        const Object copy = rotated_2d(a.sdf("other"), 2 * pi * i / count);
        const Colored d = at(std::get<Sdf>(copy.value), p);
        result = result ? min(*result, d) : d;
    }
    return sdf<2>(graph, *result);
}

/// The two copies next to a point. Rotation by an integer number of steps is linear in x and y between two copies;
/// polar coordinates would not be. For regions with many copies, these bound the distance from the axis.
Object circular_array_3d(const Arguments& a) {
    const double step = 2 * pi / a.whole(1, most_copies, "count"), offset = a.number("offset");
    const double cos_step = tidy(std::cos(step)), sin_step = tidy(std::sin(step));
    // The extreme coordinates of a circle's first step.
    const double least_x = step < pi ? cos_step : -1;
    const double least_y = step > 1.5 * pi ? -1 : std::min(sin_step, 0.0), most_y = step > pi / 2 ? 1 : sin_step;
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const auto copy = [&](Value px, Value py) { return at(a.sdf("other"), Point<3>{px - offset, py, z}); };
    const Value away = hypot(x, y);
    const Value turn = floor(atan2(y, x) / step) * step;
    const Value c = cos(turn), s = sin(turn);
    const auto between = [&](Value v, double low, double high) {
        const Value highest = away * high;
        return min(max(v, away * low), highest);
    };
    const Value sy = s * y, qx = between(c * x + sy, least_x, 1);
    const Value sx = s * x, qy = between(c * y - sx, least_y, most_y);
    const Value step_y = sin_step * qy, rx = between(cos_step * qx + step_y, least_x, 1);
    const Value step_x = sin_step * qx, ry = between(cos_step * qy - step_x, -most_y, -least_y);
    const Colored nearer = copy(qx, qy);
    return sdf<3>(graph, min(copy(rx, ry), nearer));
}

template <std::size_t n>
Object repeat(const Arguments& a) {
    const Vector<n> spacing = a.size<n>("spacing"), padding = a.size<n>("padding");
    const bool endless = !a.has("count");
    const Vector<n> count = endless ? Vector<n>{} : a.size<n>("count");
    const auto is_count = [](double v) { return v >= 0 && v == std::floor(v); };
    if (!std::all_of(count.begin(), count.end(), is_count)) a.reject("count", "whole numbers of at least 0");
    if (!std::all_of(padding.begin(), padding.end(), is_count)) a.reject("padding", "whole numbers of at least 0");

    Graph graph;
    Point<n> p = point<n>(graph);
    Vector<n> reach{};  // neighbours on each side
    double copies = 1;
    for (std::size_t i = 0; i < n; ++i) {
        if (spacing[i] == 0) continue;
        reach[i] = padding[i];
        copies *= 2 * reach[i] + 1;
        const double half = std::fabs(spacing[i]) / 2;
        const Value nearest = round(p[i] / spacing[i]);
        // Without a count, clamping changes no value but keeps intervals across many copies as narrow as one copy.
        p[i] = endless ? clamp(p[i] - spacing[i] * nearest, -half, half)
                       : p[i] - spacing[i] * clamp(nearest, -count[i], count[i]);
    }
    if (copies > most_copies) a.reject("padding", "at most " + std::to_string(most_copies) + " copies of the shape");

    std::optional<Colored> result;
    Vector<n> neighbor = Vector<n>{} - reach;
    for (std::size_t axis = 0; axis < n;) {
        Vector<n> offset;
        for (std::size_t i = 0; i < n; ++i) offset[i] = spacing[i] * neighbor[i];
        const Colored d = at(a.sdf("other"), p - offset);
        result = result ? min(*result, d) : d;
        for (axis = 0; axis < n && ++neighbor[axis] > reach[axis]; ++axis) neighbor[axis] = -reach[axis];
    }
    return sdf<n>(graph, *result);
}

// ---- Space bent ------------------------------------------------------------------------------------------

template <std::size_t n>
Object elongate(const Arguments& a) {
    Graph graph;
    const Point<n> q = abs(point<n>(graph)) - a.size<n>("size");
    const Value within = min(largest(q), 0);
    return sdf<n>(graph, at(a.sdf("other"), max(q, 0)) + within);
}

/// Rotates x and y by an angle that depends on the point.
Object turned_by(const Arguments& a, Graph& graph, Value angle) {
    const auto [x, y, z] = point<3>(graph);
    const Value c = cos(angle), s = sin(angle);
    const Value sy = s * y, across = c * x - sy;
    const Value cy = c * y, along = s * x + cy;
    return sdf<3>(graph, at(a.sdf("other"), Point<3>{across, along, z}));
}

Object twist(const Arguments& a) {
    Graph graph;
    return turned_by(a, graph, a.number("k") * graph.z());
}

Object bend(const Arguments& a) {
    Graph graph;
    return turned_by(a, graph, a.number("k") * graph.x());
}

/// The eased fraction of the way from p0 to p1, 0..1 before easing.
Value share_of_way(const Arguments& a, Graph& graph) {
    const Vector<3> p0 = a.vector<3>("p0"), way = a.vector<3>("p1") - p0;
    const double extent = length(way);
    if (extent == 0) a.reject("p1", "another point than p0");
    return eased(a.easing("e"), clamp(dot(point<3>(graph) - p0, way * (1 / extent / extent)), 0, 1));
}

/// The same from radius r0 around the z axis to radius r1.
Value share_of_radius(const Arguments& a, Graph& graph) {
    const double r0 = a.number("r0"), width = a.number("r1") - r0;
    if (width == 0) a.reject("r1", "another number than r0");
    const Value y = graph.y(), x = graph.x();
    return eased(a.easing("e"), clamp((hypot(x, y) - r0) / width, 0, 1));
}

Object bend_linear(const Arguments& a) {
    const Vector<3> v = a.vector<3>("v");
    Graph graph;
    const Value t = share_of_way(a, graph);
    Point<3> p = point<3>(graph);
    for (std::size_t i = 0; i < 3; ++i) {
        if (v[i] != 0) p[i] = p[i] - t * v[i];
    }
    return sdf<3>(graph, at(a.sdf("other"), p));
}

Object bend_radial(const Arguments& a) {
    const double dz = a.number("dz");
    Graph graph;
    const Value t = share_of_radius(a, graph);
    const auto [x, y, z] = point<3>(graph);
    return sdf<3>(graph, at(a.sdf("other"), Point<3>{x, y, z - dz * t}));
}

Object wrap_around(const Arguments& a) {
    const double x0 = a.number("x0"), width = a.number("x1") - x0;
    const double r = a.optional("r").value_or(std::fabs(width) / (2 * pi));
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Value t = eased(a.easing("e"), (atan2(y, x) + pi) / (2 * pi));
    return sdf<3>(graph, at(a.sdf("other"), Point<3>{x0 + width * t, r - hypot(x, y), z}));
}

// ---- From one shape to another ---------------------------------------------------------------------------

Colored mixed(const Colored& from, const Colored& to, Value t) {
    const Value way = (to.distance - from.distance) * t;
    return {from.distance + way, of_both(from, to, [&](const Rgb& of_from, const Rgb& of_to) {
                return mixed(of_from, of_to, t);
            })};
}

Object transition(const Arguments& a, Graph& graph, Value t) {
    const Point<3> p = point<3>(graph);
    const Colored to = at(a.sdf("f1"), p), from = at(a.sdf("f0"), p);
    return sdf<3>(graph, mixed(from, to, t));
}

Object transition_linear(const Arguments& a) {
    Graph graph;
    return transition(a, graph, share_of_way(a, graph));
}

Object transition_radial(const Arguments& a) {
    Graph graph;
    return transition(a, graph, share_of_radius(a, graph));
}

// ---- From two dimensions to three, and back --------------------------------------------------------------

/// The ends have the colour of the solid they cut.
Colored between_ends(const Colored& d, Value beyond_ends) { return {corner(d.distance, beyond_ends), d.color}; }

Object extrude(const Arguments& a) {
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Value beyond_ends = abs(z) - a.number("h") / 2;
    return sdf<3>(graph, between_ends(at(a.sdf("other"), Point<2>{x, y}), beyond_ends));
}

Object extrude_to(const Arguments& a) {
    const double h = a.nonzero("h");
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Value t = eased(a.easing("e"), clamp(z / h, -0.5, 0.5) + 0.5);
    const Colored top = at(a.sdf("b"), Point<2>{x, y}), bottom = at(a.sdf("a"), Point<2>{x, y});
    const Colored d = mixed(bottom, top, t);
    return sdf<3>(graph, between_ends(d, abs(z) - h / 2));
}

Object revolve(const Arguments& a) {
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    return sdf<3>(graph, at(a.sdf("other"), Point<2>{hypot(x, y) - a.number("offset"), z}));
}

Object slice(const Arguments& a) {
    Graph graph;
    return sdf<2>(graph, at(a.sdf("other"), Point<3>{graph.x(), graph.y(), graph.constant(0)}));
}

// ---- The table -------------------------------------------------------------------------------------------

using Call = Object (*)(const Arguments&);

/// The parameter e, by default ease.linear: t itself.
Parameter eased_evenly() {
    const auto t = std::make_shared<const Expression>(std::vector<Node>{{.op = Op::x}});
    return {"e", Type::easing, Object{Easing{t}}};
}

template <std::size_t n>
void add_operations_in(std::vector<Word>& words) {
    constexpr int dimensions = static_cast<int>(n);
    const auto operation = [&](std::string_view name, std::vector<Parameter> parameters, Call call,
                               std::string_view meaning) {
        words.push_back({name, Word::Kind::operation, dimensions, dimensions, std::move(parameters), meaning, call});
    };
    const auto number = Type::number;
    const Parameter a = required("a", Type::sdf), bs = several("bs", Type::sdf), k = optional("k", number);
    const Parameter other = required("other", Type::sdf), r = required("r", number);

    operation("union", {a, bs, k}, unite<n>, "All points in any of the shapes; k rounds the edges where they meet.");
    operation("difference", {a, bs, k}, subtract<n>, "The first shape without the others; k rounds the cuts' edges.");
    operation("intersection", {a, bs, k}, intersect<n>, "All points in every one of the shapes; k rounds the edges.");
    operation("blend", {a, bs, with_default("k", number, 0.5)}, blend<n>,
              "A weighted mean of distances: k for each next shape, 1 - k for the result so far.");
    operation("negate", {other}, negate<n>, "Inside out.");
    operation("dilate", {other, r}, dilate<n>, "Grown by r on all sides, which rounds corners.");
    operation("erode", {other, r}, erode<n>, "Shrunk by r on all sides.");
    operation("shell", {other, required("thickness", number)}, shell<n>, "Hollow: a skin around the surface.");
    operation("repeat",
              {other, required("spacing", Type::size), optional("count", Type::numbers),
               with_default("padding", Type::numbers, 0.0)},
              repeat<n>,
              "Copies at a spacing (0: no copies along that axis), endless or count on each side; padding is the number of "
              "neighbours on each side that may reach into a cell.");
    operation("translate", {other, required("offset", Type::vector)}, translate<n>, "Moved by an offset.");
    operation("scale", {other, required("factor", Type::size)}, scale<n>,
              "Larger by a factor, or one for each axis; then distances are approximate.");
    operation("elongate", {other, required("size", Type::size)}, elongate<n>,
              "Cut through the middle and pulled apart by size on each side of each axis.");
    operation("color", {other, required("c", Type::color)}, color,
              "The whole shape in a colour: \"#rrggbb\", a CSS color name, or three numbers of linear light in 0..1.");
}

void add_operations_3d(std::vector<Word>& words) {
    const auto operation = [&](std::string_view name, std::vector<Parameter> parameters, Call call,
                               std::string_view meaning) {
        words.push_back({name, Word::Kind::operation, 3, 3, std::move(parameters), meaning, call});
    };
    const auto number = Type::number, vector = Type::vector;
    const Parameter other = required("other", Type::sdf), k = required("k", number);
    const Parameter e = eased_evenly();

    operation("rotate", {other, required("angle", number), with_default("vector", vector, z_axis)}, rotate_3d,
              "Turned around a vector by an angle in radians.");
    operation("rotate_to", {other, required("a", vector), required("b", vector)}, rotate_to,
              "Turned by the angle between two vectors, from b to a.");
    operation("orient", {other, required("axis", vector)}, orient,
              "Turned by the angle between z and an axis, from the axis to z.");
    operation("circular_array", {other, required("count", Type::integer), with_default("offset", number, 0.0)},
              circular_array_3d, "Copies in a circle around the z axis, each moved outwards by an offset.");
    operation("twist", {other, k}, twist, "Turned around the z axis by k radians for each unit of height.");
    operation("bend", {other, k}, bend, "Bent around the z axis, by k radians for each unit along x.");
    operation("bend_linear",
              {other, required("p0", vector), required("p1", vector), required("v", vector), e}, bend_linear,
              "Moved by v beyond p1, not at all before p0, and by an eased share of it on the way.");
    operation("bend_radial",
              {other, required("r0", number), required("r1", number), required("dz", number), e}, bend_radial,
              "Raised by dz outside radius r1 around the z axis, by nothing inside r0, and eased between them.");
    operation("transition_linear",
              {required("f0", Type::sdf), required("f1", Type::sdf), with_default("p0", vector, z_axis * -1),
               with_default("p1", vector, z_axis), e},
              transition_linear, "From shape f0 at p0 to shape f1 at p1, eased.");
    operation("transition_radial",
              {required("f0", Type::sdf), required("f1", Type::sdf), with_default("r0", number, 0.0),
               with_default("r1", number, 1.0), e},
              transition_radial, "From shape f0 within radius r0 around the z axis to shape f1 beyond r1, eased.");
    operation("wrap_around", {other, required("x0", number), required("x1", number), optional("r", number), e},
              wrap_around,
              "The part along x from x0 to x1, wrapped around the z axis at radius r; by default it fits once.");
    words.push_back({"slice", Word::Kind::operation, 3, 2, {other}, "The section in the plane z = 0.", slice});
}

void add_operations_2d(std::vector<Word>& words) {
    const auto operation = [&](std::string_view name, int result_dimensions, std::vector<Parameter> parameters, Call call,
                               std::string_view meaning) {
        words.push_back({name, Word::Kind::operation, 2, result_dimensions, std::move(parameters), meaning, call});
    };
    const auto number = Type::number;
    const Parameter other = required("other", Type::sdf), h = required("h", number);
    const Parameter e = eased_evenly();

    operation("rotate", 2, {other, required("angle", number)}, rotate_2d,
              "Turned around the origin by an angle in radians, clockwise.");
    operation("circular_array", 2, {other, required("count", Type::integer)}, circular_array_2d,
              "Copies turned around the origin.");
    operation("extrude", 3, {other, h}, extrude, "Height h, half of it to either side of z = 0.");
    operation("extrude_to", 3, {required("a", Type::sdf), required("b", Type::sdf), h, e}, extrude_to,
              "From shape a at the bottom to shape b at the top, h above it, eased.");
    operation("revolve", 3, {other, with_default("offset", number, 0.0)}, revolve,
              "Turned around the z axis, its own y becoming z, after a move outwards by an offset.");
}

}  // namespace

void add_operations(std::vector<Word>& words) {
    add_operations_in<3>(words);
    add_operations_3d(words);
    add_operations_in<2>(words);
    add_operations_2d(words);
}

}  // namespace bob
