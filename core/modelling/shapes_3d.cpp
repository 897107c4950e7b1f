/// Shapes in three dimensions, with the values of fogleman/sdf's, many of them Inigo Quilez's
/// (iquilezles.org/articles/distfunctions). The formulas are arranged to stay tight in interval arithmetic, with smooth
/// derivatives on the surface: distances along and across, each linear in x, y and z.
#include <algorithm>

#include "modelling/shapes_nd.h"
#include "modelling/words.h"

namespace bob {
namespace {

constexpr Vector<3> origin_3d{0, 0, 0}, up_3d{0, 0, 1};

/// A point relative to the line from a to b. Its distance along the line from a, and its distance from the line.
struct Axial {
    Value along, away;
    double length;  // from a to b
};

/// Checks that the arguments `a` and `b` are two distinct points.
Axial axial(Graph& graph, const Arguments& arguments) {
    const Vector<3> a = arguments.vector<3>("a"), b = arguments.vector<3>("b");
    const double span = length(b - a);
    if (span == 0) arguments.reject("b", "another point than a");
    const Vector<3> axis = (b - a) * (1 / span);
    // Two perpendicular directions, the first also perpendicular to the coordinate axis farthest from the line. Along a
    // coordinate axis, all three are coordinate axes.
    Vector<3> farthest{};
    const auto by_size = [](double p, double q) { return std::fabs(p) < std::fabs(q); };
    farthest[static_cast<std::size_t>(std::min_element(axis.begin(), axis.end(), by_size) - axis.begin())] = 1;
    const Vector<3> u = normalized(cross(farthest, axis)), v = cross(u, axis);
    const Point<3> p = point<3>(graph) - a;
    const Value along = dot(p, axis), across = dot(p, v);
    return {along, hypot(dot(p, u), across), span};
}

/// The half space behind the plane through `point` with outward `normal`: (point - p) . normal.
Value half_space(const Point<3>& p, const Vector<3>& point, const Vector<3>& normal) {
    return dot(p - point, normal * -1);
}

Object plane(const Arguments& a) {
    Graph graph;
    return sdf<3>(graph, half_space(point<3>(graph), a.vector<3>("point"), a.direction<3>("normal")));
}

Object rounded_box(const Arguments& a) {
    const double radius = a.number("radius");
    Graph graph;
    const Vector<3> flat = a.size<3>("size") * 0.5 - Vector<3>{radius, radius, radius};
    return sdf<3>(graph, corner(abs(point<3>(graph)) - flat) - radius);
}

Object wireframe_box(const Arguments& a) {
    const double half = a.number("thickness") / 2;
    Graph graph;
    // p: inwards from the outer faces; q: from the middle line of each bar.
    const Point<3> from_middle = abs(point<3>(graph)) - a.size<3>("size") * 0.5;
    const Vector<3> halves{half, half, half};
    const Point<3> p = from_middle - halves, q = abs(from_middle) - halves;
    const Value x = corner<3>({p[0], q[1], q[2]}), y = corner<3>({q[0], p[1], q[2]}), z = corner<3>({q[0], q[1], p[2]});
    return sdf<3>(graph, min(min(x, y), z));
}

Object torus(const Arguments& a) {
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    return sdf<3>(graph, hypot(hypot(x, y) - a.number("r1"), z) - a.number("r2"));
}

Object capsule(const Arguments& a) {
    Graph graph;
    const auto [along, away, length] = axial(graph, a);
    return sdf<3>(graph, hypot(away, max(beyond(along, length), 0)) - a.number("radius"));
}

Object cylinder(const Arguments& a) {
    Graph graph;
    const Value y = graph.y(), x = graph.x();
    return sdf<3>(graph, hypot(x, y) - a.number("radius"));
}

Object capped_cylinder(const Arguments& a) {
    Graph graph;
    const auto [along, away, length] = axial(graph, a);
    const Value cap = beyond(along, length);
    return sdf<3>(graph, corner(away - a.number("radius"), cap));
}

Object rounded_cylinder(const Arguments& a) {
    const double rb = a.number("rb");
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Value cap = abs(z) - (a.number("h") / 2 - rb);
    return sdf<3>(graph, corner(hypot(x, y) - (a.number("ra") - rb), cap) - rb);
}

Object capped_cone(const Arguments& a) {
    const double ra = a.number("ra"), rb = a.number("rb");
    Graph graph;
    const auto [along, away, length] = axial(graph, a);
    const double slope = std::hypot(length, rb - ra);
    // cap: from the nearer cap's plane; rim: outwards from its rim; side: from the side; run: along the side past its
    // ends.
    const Value cap = beyond(along, length);
    const Value radius_b = graph.constant(rb), radius_a = graph.constant(ra);
    const Value rim = away - piecewise(along - length / 2, radius_a, radius_b);
    const Value narrower = along * ((rb - ra) / slope), side = (away - ra) * (length / slope) - narrower;
    const Value farther = along * (length / slope), run = beyond((away - ra) * ((rb - ra) / slope) + farther, slope);
    // A rim is nearest only outwards of it and past an end.
    const Value from_side = hypot(side, run), to_rim = min(hypot(rim, cap), from_side);
    const Value to_face = max(side, cap);
    return sdf<3>(graph, piecewise(min(rim, run), to_face, to_rim));
}

Object rounded_cone(const Arguments& a) {
    const double r1 = a.number("r1"), r2 = a.number("r2"), h = a.nonzero("h");
    if (std::fabs(r1 - r2) > std::fabs(h)) a.reject("h", "a number of at least |r1 - r2|");
    const double sine = (r1 - r2) / h, cosine = std::sqrt(1 - sine * sine);
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Value away = hypot(x, y), back = away * sine, along = z * cosine - back;
    const Value below = hypot(away, z) - r1, above = hypot(away, z - h) - r2;
    const Value outwards = z * sine, side = away * cosine + outwards - r1;
    if (h < 0) return sdf<3>(graph, select(along, below, select(cosine * h - along, above, side)));  // a jump
    return sdf<3>(graph, piecewise(along, below, piecewise(cosine * h - along, above, side)));
}

Object ellipsoid(const Arguments& a) {
    const Vector<3> size = a.nonzero_size<3>("size");
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Point<3> scaled{x / size[0], y / size[1], z / size[2]};
    const Point<3> twice{x / (size[0] * size[0]), y / (size[1] * size[1]), z / (size[2] * size[2])};
    const Value k0 = length(scaled), k1 = length(twice);
    // k0 / k1 is a mean of the semi-axes. Clamping it to their range keeps it finite at the centre, and intervals
    // around it tight.
    const auto [low, high] = std::minmax({std::fabs(size[0]), std::fabs(size[1]), std::fabs(size[2])});
    const Value mean = clamp(k0 / max(k1, 1e-300), low, high);
    return sdf<3>(graph, (k0 - 1) * mean);
}

Object pyramid(const Arguments& a) {
    const double h = a.number("h"), m2 = h * h + 0.25, m = std::sqrt(m2);
    Graph graph;
    const Value x = abs(graph.x()) - 0.5, y = abs(graph.y()) - 0.5, z = graph.z();
    const Value px = max(x, y), pz = min(x, y);
    // Across a face, upwards from the base's edge, and along the edge.
    const Value half_z = 0.5 * z, across = h * px + half_z;
    const Value half_x = 0.5 * px, upwards = h * z - half_x;
    const Value t = clamp((upwards - 0.5 * pz) / (m2 + 0.25), 0, 1);
    const Value to_base = hypot(m * max(pz, 0), upwards);
    const Value above = upwards - m2 * t, to_edge = hypot(m * (pz + 0.5 * t), above);
    const Value half_up = 0.5 * upwards, over_face = min(upwards, -m2 * pz - half_up);
    const Value from_rim = hypot(min(to_base, to_edge), across);
    const Value from_face = select(z, abs(across), across);
    const Value inside = -from_rim, elsewhere = select(max(across, -z), inside, from_rim);
    return sdf<3>(graph, select(-over_face, from_face, elsewhere) / m);
}

// The Platonic solids other than the cube.

Object tetrahedron(const Arguments& a) {
    Graph graph;
    const auto [x, y, z] = point<3>(graph);
    const Value lower = abs(x - y) + z;
    return sdf<3>(graph, (max(abs(x + y) - z, lower) - a.number("r")) / std::sqrt(3));
}

Object octahedron(const Arguments& a) {
    Graph graph;
    const auto [x, y, z] = abs(point<3>(graph));
    return sdf<3>(graph, (x + y + z - a.number("r")) / std::sqrt(3));
}

/// The maximum of p . n over the cyclic permutations of n = (x, y, z).
Value over_turns(const Point<3>& p, const Vector<3>& n) {
    const auto [x, y, z] = n;
    const Value second = dot(p, Vector<3>{y, z, x}), first = dot(p, Vector<3>{z, x, y});
    return max(max(dot(p, n), first), second);
}

Object dodecahedron(const Arguments& a) {
    const Vector<3> n = normalized(Vector<3>{(1 + std::sqrt(5)) / 2, 1, 0});
    const double r = a.nonzero("r");
    Graph graph;
    return sdf<3>(graph, (over_turns(abs(point<3>(graph)), n) - n[0] * std::fabs(r)) * std::copysign(1, r));
}

Object icosahedron(const Arguments& a) {
    const Vector<3> n = normalized(Vector<3>{(std::sqrt(5) + 3) / 2, 1, 0});
    // r is the circumradius; this is the midradius, as for the dodecahedron.
    const double r = a.nonzero("r") * 0.8506507174597755;
    Graph graph;
    const Point<3> p = abs(point<3>(graph));
    const Value diagonal = (p[0] + p[1] + p[2]) / std::sqrt(3), faces = max(over_turns(p, n), diagonal);
    return sdf<3>(graph, (faces - n[0] * std::fabs(r)) * std::copysign(1, r));
}

}  // namespace

void add_shapes_3d(std::vector<Word>& words) {
    const auto shape = [&](std::string_view name, std::vector<Parameter> parameters, Object (*call)(const Arguments&),
                           std::string_view meaning) {
        words.push_back({name, Word::Kind::shape, 3, 3, std::move(parameters), meaning, call});
    };
    const auto number = Type::number;
    const Parameter a = required("a", Type::vector), b = required("b", Type::vector), r = required("r", number);
    const Parameter radius = required("radius", number), h = required("h", number), size = required("size", Type::size);
    const Parameter center = with_default("center", Type::vector, origin_3d);

    shape("sphere", {with_default("radius", number, 1.0), center}, ball<3>, "A ball.");
    shape("plane", {with_default("normal", Type::vector, up_3d), with_default("point", Type::vector, origin_3d)}, plane,
          "Half of space: the side that the normal points to.");
    shape("slab",
          {optional("x0", number), optional("y0", number), optional("z0", number), optional("x1", number),
           optional("y1", number), optional("z1", number), optional("k", number)},
          slab<3>,
          "The region between planes across the axes; each plane is optional, and k rounds the edges.");
    shape("box",
          {with_default("size", Type::size, 1.0), center, optional("a", Type::vector), optional("b", Type::vector)},
          box<3>, "A box of given sides around a center, or from corner a to corner b.");
    shape("rounded_box", {size, radius}, rounded_box, "A box around the origin with round edges and corners.");
    shape("wireframe_box", {size, required("thickness", number)}, wireframe_box, "The twelve edges of a box as bars.");
    shape("torus", {required("r1", number), required("r2", number)}, torus,
          "A ring around the z axis: r1 to the middle of the tube, whose radius is r2.");
    shape("capsule", {a, b, radius}, capsule, "All points within a radius of the line from a to b.");
    shape("cylinder", {radius}, cylinder, "A cylinder around the z axis without ends.");
    shape("capped_cylinder", {a, b, radius}, capped_cylinder, "A cylinder from a to b with flat ends.");
    shape("rounded_cylinder", {required("ra", number), required("rb", number), h}, rounded_cylinder,
          "A cylinder around the z axis of radius ra and height h, its edges rounded with radius rb.");
    shape("capped_cone", {a, b, required("ra", number), required("rb", number)}, capped_cone,
          "A cone from radius ra at a to radius rb at b, with flat ends.");
    shape("rounded_cone", {required("r1", number), required("r2", number), h}, rounded_cone,
          "The hull of two balls: radius r1 at the origin, radius r2 at height h.");
    shape("ellipsoid", {size}, ellipsoid, "An ellipsoid with these semi-axes; its distances are approximate.");
    shape("pyramid", {h}, pyramid, "A pyramid of height h on a square of side 1.");
    shape("tetrahedron", {r}, tetrahedron, "A regular tetrahedron with a corner at (r, r, r).");
    shape("octahedron", {r}, octahedron, "A regular octahedron with corners at r on the axes.");
    shape("dodecahedron", {r}, dodecahedron, "A regular dodecahedron with edges that touch the sphere of radius r.");
    shape("icosahedron", {r}, icosahedron, "A regular icosahedron with corners on the sphere of radius r.");
}

}  // namespace bob
