/// Shapes, scenes and pixel orders in the WebAssembly module: convert and call. The modules of viewer/ check arguments, in
/// better words; here only what would read or write out of bounds.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "wasm.h"
#include "formula/expression.h"
#include "formula/vm.h"
#include "modelling/script.h"
#include "shapes/bounds.h"
#include "shapes/brep.h"
#include "shapes/extent.h"
#include "shapes/implicit.h"
#include "shapes/mesh.h"
#include "shapes/tube.h"
#include "picture/order.h"
#include "tracing/scene.h"
#include "tracing/trace.h"

namespace {

/// A shape as scenes hold it, and what only its own type can tell.
struct Shape {
    std::shared_ptr<const bob::Shape> core;
    void (*bounds)(const bob::Shape&, const double* map, double* bounds) = nullptr;
    double (*radius)(const bob::Shape&, const double* map, const double* center, double largest_singular_value) = nullptr;
};

template <class S>
Shape* measured(std::shared_ptr<const S> shape) {
    return new Shape{std::move(shape),
                     [](const bob::Shape& core, const double* map, double* bounds) {
                         bob::placed_bounds(static_cast<const S&>(core), map, bounds);
                     },
                     [](const bob::Shape& core, const double* map, const double* center, double largest_singular_value) {
                         return bob::placed_radius(static_cast<const S&>(core), map, center, largest_singular_value);
                     }};
}

std::span<const bob::Triangle> checked(const std::int32_t* triangles, std::size_t count, std::size_t vertex_count) {
    for (const std::int32_t index : std::span(triangles, 3 * count)) {
        expect(index >= 0 && static_cast<std::size_t>(index) < vertex_count, "triangles: index out of range");
    }
    return {reinterpret_cast<const bob::Triangle*>(triangles), count};
}

/// Vertices in a mesh's own units, (count, 3), and which of them triangles have.
struct Points {
    const double* vertices;
    const std::uint8_t* used;
    std::size_t count;

    /// f(x, y, z) of each, moved by a map, (3, 4).
    template <class F>
    void for_each(const double* map, F f) const {
        for (std::size_t i = 0; i < count; ++i) {
            if (!used[i]) continue;
            const double* p = vertices + 3 * i;
            double moved[3];
            for (int axis = 0; axis < 3; ++axis) {
                const double* row = map + 4 * axis;
                moved[axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
            }
            f(moved);
        }
    }
};

template <class T>
const T* take(const T*& from, std::size_t count) {
    return std::exchange(from, from + count);
}

/// Knots in the number that `count` control points of a degree have.
std::vector<double> take_knots(const double*& from, std::int32_t count, std::int32_t degree) {
    expect(degree >= 1 && degree <= bob::max_degree && count > degree, "degree: expected 1..9, less than control points");
    const auto knots = static_cast<std::size_t>(count + degree + 1);
    const double* first = take(from, knots);
    return {first, first + knots};
}

template <std::size_t N>
std::vector<bob::Homogeneous<N>> take_points(const double*& from, std::size_t count) {
    const auto* first = reinterpret_cast<const bob::Homogeneous<N>*>(take(from, count * (N + 1)));
    return {first, first + count};
}

}  // namespace

// ---- Formulas --------------------------------------------------------------------------------------------

EXPORT(make_expression)
bob::Expression* make_expression(const std::uint8_t* ops, const std::uint32_t* operands, const double* values,
                                 std::size_t count) {
    return attempt([&] {
        std::vector<bob::Node> nodes(count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t* operand = operands + 3 * i;
            nodes[i] = {static_cast<bob::Op>(ops[i]), {operand[0], operand[1], operand[2]}, values[i]};
        }
        return new bob::Expression(std::move(nodes));
    });
}

EXPORT(parse_vm) bob::Expression* parse_vm(const char* text, std::size_t size) {
    return attempt([&] { return new bob::Expression(bob::parse_vm({text, size})); });
}

EXPORT(run_script) bob::Expression* run_script(const char* source, std::size_t size) {
    return attempt([&] { return new bob::Expression(*bob::run_script({source, size}).expression); });
}

EXPORT(free_expression) void free_expression(bob::Expression* expression) { delete expression; }

EXPORT(uses_z) bool uses_z(const bob::Expression* expression) { return expression->uses(bob::Op::z); }

/// max(f(x, y), |z| - height / 2).
EXPORT(extruded) bob::Expression* extruded(const bob::Expression* expression, double height) {
    return attempt([&] {
        bob::Graph graph;
        const bob::Value z = graph.z(), sides = graph.substitute(*expression, graph.x(), graph.y(), z);
        const bob::Value ends =
            graph.binary(bob::Op::subtract, graph.unary(bob::Op::absolute, z), graph.constant(height / 2));
        return new bob::Expression(graph.expression(graph.binary(bob::Op::maximum, sides, ends)));
    });
}

/// bounds: (2, 3), NaN where the formula is positive everywhere. Fails where it has none.
EXPORT(find_bounds) bool find_bounds(const bob::Expression* expression, double* bounds) {
    return attempt([&] {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        const bob::Bounds found = bob::find_bounds(*expression).value_or(bob::Bounds{{nan, nan, nan}, {nan, nan, nan}});
        for (int axis = 0; axis < 3; ++axis) bounds[axis] = found.low[axis], bounds[3 + axis] = found.high[axis];
        return true;
    });
}

// ---- Shapes ----------------------------------------------------------------------------------------------

/// Vertices, (vertex_count, 3), become (v - center) / size: in double precision, so that neither unit nor distance from the origin
/// costs precision. triangles: (triangle_count, 3); normals: (vertex_count, 3), or null.
EXPORT(make_mesh)
Shape* make_mesh(const double* vertices, std::size_t vertex_count, double center_x, double center_y, double center_z, double size,
                 const std::int32_t* triangles, std::size_t triangle_count, const float* normals) {
    return attempt([&] {
        expect(triangle_count > 0, "triangles: expected at least one");
        const std::span corners = checked(triangles, triangle_count, vertex_count);
        std::vector<bob::Vec3> points(vertex_count);
        for (std::size_t i = 0; i < vertex_count; ++i) {
            const double* v = vertices + 3 * i;
            points[i] = {static_cast<float>((v[0] - center_x) / size), static_cast<float>((v[1] - center_y) / size),
                         static_cast<float>((v[2] - center_z) / size)};
        }
        const auto* given = reinterpret_cast<const bob::Vec3*>(normals);
        return new Shape{std::make_shared<bob::Mesh>(points, corners, std::span(given, given ? vertex_count : 0))};
    });
}

/// used: (vertex_count,), 1 where a triangle has a vertex, else 0.
EXPORT(mark_used)
bool mark_used(const std::int32_t* triangles, std::size_t triangle_count, std::uint8_t* used, std::size_t vertex_count) {
    return attempt([&] {
        std::fill_n(used, vertex_count, std::uint8_t{0});
        for (const bob::Triangle& t : checked(triangles, triangle_count, vertex_count)) {
            for (const auto vertex : t) used[vertex] = 1;
        }
        return true;
    });
}

/// bounds: (2, 3), low and high of the used vertices moved by a map.
EXPORT(point_bounds)
void point_bounds(const double* vertices, const std::uint8_t* used, std::size_t count, const double* map, double* bounds) {
    for (int axis = 0; axis < 3; ++axis) {
        bounds[axis] = std::numeric_limits<double>::infinity(), bounds[3 + axis] = -bounds[axis];
    }
    Points{vertices, used, count}.for_each(map, [&](const double* p) {
        for (int axis = 0; axis < 3; ++axis) {
            if (p[axis] < bounds[axis]) bounds[axis] = p[axis];
            if (p[axis] > bounds[3 + axis]) bounds[3 + axis] = p[axis];
        }
    });
}

/// The distance from `center` to the farthest used vertex moved by a map; not finite where one of them is not.
EXPORT(point_radius)
double point_radius(const double* vertices, const std::uint8_t* used, std::size_t count, const double* map, const double* center) {
    const Points points{vertices, used, count};
    double largest = 0;
    points.for_each(map, [&](const double* p) {
        for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::fabs(p[axis] - center[axis]));
    });
    // In units of about the largest coordinate, so that squares stay within the range; a power of two rounds nothing.
    int exponent = 0;
    std::frexp(largest, &exponent);
    exponent = std::max(exponent, -1000);
    const double unit = std::ldexp(1, exponent);
    double farthest = 0;
    bool finite = true;
    points.for_each(map, [&](const double* p) {
        const double x = (p[0] - center[0]) / unit, y = (p[1] - center[1]) / unit, z = (p[2] - center[2]) / unit;
        const double square = x * x + y * y + z * z;
        farthest = std::max(farthest, square);
        finite = finite && std::isfinite(square);
    });
    return finite ? std::sqrt(farthest) * unit : std::numeric_limits<double>::quiet_NaN();
}

/// bounds: (2, 3), low and high. `sphere`, which is written, is the centre and the size of what rays meet as the unit cube
/// about the origin.
EXPORT(make_implicit) Shape* make_implicit(const bob::Expression* formula, const double* bounds, double* sphere) {
    return attempt([&] {
        bob::Bounds box;
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = bounds[axis], box.high[axis] = bounds[3 + axis];
            expect(box.low[axis] < box.high[axis], "bounds: expected each low below its high");
        }
        auto shape = std::make_shared<const bob::Implicit>(*formula, box);
        expect(!shape->cells().cells().empty(), "shape: expected a surface within the bounds, got none");
        for (int axis = 0; axis < 3; ++axis) sphere[axis] = shape->center()[axis];
        sphere[3] = shape->half_side();
        return measured(std::move(shape));
    });
}

/// The arrays of a scene file's brep (CONVENTIONS.md), but for the control points: homogeneous, (w x, w y, w z, w) and
/// (w u, w v, w), about 1 in size.
EXPORT(make_brep)
Shape* make_brep(const std::int32_t* faces, std::size_t face_count, const double* control_points, const double* knots,
                 const std::int32_t* loops, const std::int32_t* trims, const double* trim_control_points,
                 const double* trim_knots, double tolerance) {
    return attempt([&] {
        std::vector<bob::Face> converted(face_count);
        for (bob::Face& face : converted) {
            const std::int32_t* row = take(faces, 5);
            const std::int32_t size_u = row[0], size_v = row[1], degree_u = row[2], degree_v = row[3];
            bob::NurbsSurface& surface = face.surface;
            surface.degree_u = degree_u, surface.degree_v = degree_v;
            surface.knots_u = take_knots(knots, size_u, degree_u);
            surface.knots_v = take_knots(knots, size_v, degree_v);
            surface.control_points = take_points<3>(control_points, static_cast<std::size_t>(size_u) * static_cast<std::size_t>(size_v));
            for (std::int32_t loop = 0; loop < row[4]; ++loop) {
                bob::TrimLoop& curves = face.loops.emplace_back();
                for (std::int32_t curve = *take(loops, 1); curve > 0; --curve) {
                    const std::int32_t *trim = take(trims, 2), count = trim[0], degree = trim[1];
                    auto curve_knots = take_knots(trim_knots, count, degree);
                    curves.push_back({degree, std::move(curve_knots),
                                      take_points<2>(trim_control_points, static_cast<std::size_t>(count))});
                }
            }
        }
        auto shape = std::make_shared<const bob::Brep>(converted, tolerance);
        expect(shape->pieces().count > 0, "faces: expected an area that trims leave of one, got none");
        return measured(std::move(shape));
    });
}

/// control_points: (count, 5), w (x, y, z, radius, 1), about 1 in size; knots: (count + degree + 1,).
EXPORT(make_tube)
Shape* make_tube(const double* control_points, std::int32_t count, const double* knots, std::int32_t degree) {
    return attempt([&] {
        auto curve_knots = take_knots(knots, count, degree);
        return measured(std::make_shared<const bob::Tube>(bob::NurbsCurve<4>{
            degree, std::move(curve_knots), take_points<4>(control_points, static_cast<std::size_t>(count))}));
    });
}

EXPORT(free_shape) void free_shape(Shape* shape) { delete shape; }

/// Of all shapes but meshes. map: (3, 4); bounds: (2, 3).
EXPORT(placed_bounds) bool placed_bounds(const Shape* shape, const double* map, double* bounds) {
    return attempt([&] {
        expect(shape->bounds, "placed_bounds: expected a shape that is no mesh");
        shape->bounds(*shape->core, map, bounds);
        return true;
    });
}

EXPORT(placed_radius)
double placed_radius(const Shape* shape, const double* map, const double* center, double largest_singular_value) {
    return attempt([&] {
        expect(shape->radius, "placed_radius: expected a shape that is no mesh");
        return shape->radius(*shape->core, map, center, largest_singular_value);
    });
}

// ---- Scenes ----------------------------------------------------------------------------------------------

/// to_shape: (count, 3, 4); boxes: (count, 2, 3); materials: (count, 7): linear RGB, ambient, diffuse, specular, shininess.
EXPORT(make_scene)
bob::Scene* make_scene(const Shape* const* shapes, std::size_t count, const double* to_shape, const float* boxes,
                       const float* materials) {
    return attempt([&] {
        std::vector<bob::Instance> instances;
        for (std::size_t i = 0; i < count; ++i) {
            const auto* map = reinterpret_cast<const bob::AffineMap*>(to_shape) + i;
            const auto* box = reinterpret_cast<const bob::Vec3*>(boxes) + 2 * i;
            const float* m = materials + 7 * i;
            instances.push_back({shapes[i]->core, *map, box[0], box[1], {{m[0], m[1], m[2]}, m[3], m[4], m[5], m[6]}});
        }
        return new bob::Scene(std::move(instances));
    });
}
EXPORT(free_scene) void free_scene(bob::Scene* scene) { delete scene; }

/// Traces pixels, (count, 2). camera: its numbers in the order of bob::Camera; samples: (count, C) of the G-buffer's layout.
EXPORT(trace)
bool trace(const bob::Scene* scene, const bob::Camera* camera, std::int32_t height, std::int32_t width,
           const std::int32_t* pixels, std::size_t count, float* samples) {
    return attempt([&] {
        const std::span all(reinterpret_cast<const bob::Pixel*>(pixels), count);
        return bob::trace(*scene, *camera, height, width, all, bob::gbuffer_layout(), samples);
    });
}

/// Writes the pixels from the start-th on, (count, 2), of an order; the seed in halves, since a page's numbers have 53 bits.
EXPORT(pixel_order)
bool pixel_order(const char* name, std::size_t name_size, std::uint32_t seed_low, std::uint32_t seed_high,
                 std::uint32_t height, std::uint32_t width, std::uint32_t start, std::int32_t* pixels, std::uint32_t count) {
    return attempt([&] {
        expect(std::uint64_t{start} + count <= std::uint64_t{height} * width, "start: beyond the last pixel");
        const std::string_view order(name, name_size);
        const std::uint64_t seed = std::uint64_t{seed_high} << 32 | seed_low;
        const std::span all(reinterpret_cast<bob::Pixel*>(pixels), count);
        if (order == "uniform") {
            bob::UniformOrder(seed, height, width)(start, all);
        } else {
            const bob::Tile* tile = bob::find_tile(order);
            expect(tile, "order: expected one of uniform, r2, lattice, blue-noise");
            bob::TiledOrder(*tile, seed, height, width)(start, all);
        }
        return true;
    });
}
