/// Formulas, and shapes other than meshes, in the WebAssembly module; core.mesh.wasm omits them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "formula/arrays.h"
#include "formula/expression.h"
#include "formula/vm.h"
#include "modelling/script.h"
#include "shapes/brep/brep.h"
#include "shapes/implicit/bounds.h"
#include "shapes/implicit/implicit.h"
#include "shapes/implicit/vm_solid.h"
#include "shapes/tube/tube.h"
#include "tracing/scene.h"
#include "wasm.h"
#include "wasm_shape.h"

namespace {

template <class T>
const T* take(const T*& from, std::size_t count) {
    return std::exchange(from, from + count);
}

/// The knots for `count` control points of a degree.
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

/// A formula, and optionally one for its surface's colour.
struct Formula {
    bob::Expression f;
    std::shared_ptr<const bob::ColorFormula> color = nullptr;
};

/// ops: (n,), operands: (n, 3), values: (n,), as for bob::nodes_of.
void read_nodes(const std::vector<bob::Node>& nodes, std::uint8_t* ops, std::uint32_t* operands, double* values) {
    for (const bob::Node& node : nodes) {
        *ops++ = static_cast<std::uint8_t>(node.op);
        operands = std::copy_n(node.operand, 3, operands);
        *values++ = node.value;
    }
}

Shape* surface_of(const bob::Expression& formula, const bob::Bounds& box, const bob::ColorFormula* color = nullptr) {
    for (int axis = 0; axis < 3; ++axis) expect(box.low[axis] < box.high[axis], "bounds: expected each low below its high");
    auto shape = std::make_shared<const bob::Implicit>(formula, box, color);
    expect(!shape->cells().cells().empty(), "shape: expected a surface within the bounds, got none");
    const bool is_coarse = shape->cells().is_coarse();
    return new Shape{.core = std::move(shape), .is_coarse = is_coarse};
}

bob::Bounds corners(const double* bounds) {
    return {{bounds[0], bounds[1], bounds[2]}, {bounds[3], bounds[4], bounds[5]}};
}

bob::Bounds some(const std::optional<bob::Bounds>& bounds) {
    expect(bounds.has_value(), "shape: expected a formula that is negative somewhere within 1e9 of the origin, got one that never is");
    return *bounds;
}

}  // namespace

// ---- Formulas --------------------------------------------------------------------------------------------

/// sizes: (meshes, 2), vertices: (v, 3), triangles: (t, 3), as in bob::MeshArrays.
EXPORT(make_meshes)
bob::Meshes* make_meshes(const std::uint32_t* sizes, std::size_t meshes, const float* vertices, std::size_t v,
                         const std::uint32_t* triangles, std::size_t t) {
    return attempt([&] {
        return new bob::Meshes(bob::meshes_of({{sizes, 2 * meshes}, {vertices, 3 * v}, {triangles, 3 * t}}));
    });
}

EXPORT(free_meshes) void free_meshes(bob::Meshes* meshes) { delete meshes; }

/// `meshes` may be null if the formula has no meshes.
EXPORT(make_expression)
Formula* make_expression(const std::uint8_t* ops, const std::uint32_t* operands, const double* values, std::size_t count,
                         const bob::Meshes* meshes) {
    return attempt([&] {
        return new Formula{bob::Expression(bob::nodes_of(ops, operands, values, count, meshes ? *meshes : bob::Meshes{}))};
    });
}

/// Sets the colour of the formula's surface; roots: (3,).
EXPORT(color_expression)
bool color_expression(Formula* formula, const std::uint8_t* ops, const std::uint32_t* operands, const double* values,
                      std::size_t count, const std::uint32_t* roots, const bob::Meshes* meshes) {
    return attempt([&] {
        auto nodes = bob::nodes_of(ops, operands, values, count, meshes ? *meshes : bob::Meshes{});
        formula->color = std::make_shared<const bob::ColorFormula>(std::move(nodes), std::array{roots[0], roots[1], roots[2]});
        return true;
    });
}

EXPORT(parse_vm) Formula* parse_vm(const char* text, std::size_t size) {
    return attempt([&] { return new Formula{bob::parse_vm({text, size})}; });
}

EXPORT(run_script) Formula* run_script(const char* source, std::size_t size) {
    return attempt([&] {
        const bob::Sdf sdf = bob::run_script({source, size});
        return new Formula{*sdf.expression, sdf.color};
    });
}

EXPORT(expression_size) std::size_t expression_size(const Formula* formula) { return formula->f.nodes().size(); }

/// ops: (n,), operands: (n, 3), values: (n,), as for make_expression.
EXPORT(read_expression)
void read_expression(const Formula* formula, std::uint8_t* ops, std::uint32_t* operands, double* values) {
    read_nodes(formula->f.nodes(), ops, operands, values);
}

/// 0 if the surface has no colour.
EXPORT(color_size) std::size_t color_size(const Formula* formula) { return formula->color ? formula->color->nodes().size() : 0; }

/// As for color_expression; the surface must have a colour.
EXPORT(read_color)
void read_color(const Formula* formula, std::uint8_t* ops, std::uint32_t* operands, double* values, std::uint32_t* roots) {
    read_nodes(formula->color->nodes(), ops, operands, values);
    std::ranges::copy(formula->color->roots(), roots);
}

EXPORT(free_expression) void free_expression(Formula* formula) { delete formula; }

/// bounds: (2, 3), NaN if the formula is positive everywhere. Fails if it has no bounds.
EXPORT(find_bounds) bool find_bounds(const Formula* formula, double* bounds) {
    return attempt([&] {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        const bob::Bounds found = bob::find_bounds(formula->f).value_or(bob::Bounds{{nan, nan, nan}, {nan, nan, nan}});
        for (int axis = 0; axis < 3; ++axis) bounds[axis] = found.low[axis], bounds[3 + axis] = found.high[axis];
        return true;
    });
}

// ---- Shapes ----------------------------------------------------------------------------------------------

/// bounds: (2, 3), or null to find them.
EXPORT(make_implicit) Shape* make_implicit(const Formula* formula, const double* bounds) {
    return attempt([&] {
        const bob::ColorFormula* const color = formula->color.get();
        if (bounds) return surface_of(formula->f, corners(bounds), color);
        std::optional<bob::Bounds> found;
        try {
            found = bob::find_bounds(formula->f);
        } catch (const std::invalid_argument& error) {
            throw std::invalid_argument(std::string("shape: expected ") + error.what() + "; cut it");
        }
        return surface_of(formula->f, some(found), color);
    });
}

/// The solid of a .vm file's formula. bounds: (2, 3), or null.
EXPORT(make_vm_solid) Shape* make_vm_solid(const Formula* formula, const double* bounds) {
    return attempt([&] {
        const bob::VmSolid solid = bob::vm_solid(formula->f);
        return surface_of(solid.formula, bounds ? corners(bounds) : some(solid.bounds));
    });
}

/// The arrays of a scene file's brep (docs/reference/scene-files.md); colors: (face_count, 3), or null.
EXPORT(make_brep)
Shape* make_brep(const std::int32_t* faces, std::size_t face_count, const double* control_points, const double* knots,
                 const std::int32_t* loops, const std::int32_t* trims, const double* trim_control_points,
                 const double* trim_knots, double tolerance, const float* colors) {
    return attempt([&] {
        std::vector<bob::Face> converted(face_count);
        for (bob::Face& face : converted) {
            const std::int32_t* row = take(faces, 5);
            if (const float* rgb = colors ? take(colors, 3) : nullptr) face.color = bob::Vec3{rgb[0], rgb[1], rgb[2]};
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
        auto shape = std::make_shared<const bob::Brep>(bob::Brep::of_weighted_points(std::move(converted), tolerance));
        const bool is_coarse = shape->pieces().is_coarse;
        return new Shape{.core = std::move(shape), .is_coarse = is_coarse};
    });
}

/// control_points: (count, 5), (x, y, z, radius, weight); knots: (count + degree + 1,).
EXPORT(make_tube)
Shape* make_tube(const double* control_points, std::int32_t count, const double* knots, std::int32_t degree) {
    return attempt([&] {
        auto curve_knots = take_knots(knots, count, degree);
        return new Shape{std::make_shared<const bob::Tube>(bob::Tube::of_weighted_points(
            {degree, std::move(curve_knots), take_points<4>(control_points, static_cast<std::size_t>(count))}))};
    });
}

/// Writes the area and volume of a brep's faces from `begin` to `end`, (2,), in the scene's units; NaN if unknown: the volume of open faces,
/// and both of other shapes, of too many faces, and where the shape is stretched.
EXPORT(measure_brep)
bool measure_brep(const bob::Scene* scene, std::uint32_t number, std::uint32_t begin, std::uint32_t end, const bob::Sphere* sphere, double* measures) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    constexpr std::uint32_t most_faces = 1000;  // about a second, for which the picture waits
    return attempt([&] {
        std::fill_n(measures, 2, unknown);
        const bob::Instance& instance = (*scene)[number];
        const auto* const brep = dynamic_cast<const bob::Brep*>(instance.shape.get());
        const auto [largest, second, smallest] = bob::singular_values(bob::inverse(instance.to_shape));
        if (!brep || end - begin > most_faces || largest > (1 + 1e-9) * smallest) return true;
        const bob::Brep::Amount found = brep->amount(begin, end);
        const double scale = largest * sphere->radius;
        measures[0] = scale * scale * found.area;
        if (found.volume) measures[1] = scale * scale * scale * *found.volume;
        return true;
    });
}
