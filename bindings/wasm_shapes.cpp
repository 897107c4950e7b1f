/// Formulas, and shapes other than meshes, in the WebAssembly module: what core.mesh.wasm does without.
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

#include "wasm.h"
#include "wasm_shape.h"
#include "formula/expression.h"
#include "formula/vm.h"
#include "modelling/script.h"
#include "shapes/bounds.h"
#include "shapes/brep.h"
#include "shapes/implicit.h"
#include "shapes/tube.h"
#include "shapes/vm_solid.h"

namespace {

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

Shape* surface_of(const bob::Expression& formula, const bob::Bounds& box) {
    for (int axis = 0; axis < 3; ++axis) expect(box.low[axis] < box.high[axis], "bounds: expected each low below its high");
    auto shape = std::make_shared<const bob::Implicit>(formula, box);
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

EXPORT(expression_size) std::size_t expression_size(const bob::Expression* expression) { return expression->nodes().size(); }

/// ops: (n,), operands: (n, 3), values: (n,), as make_expression takes them.
EXPORT(read_expression)
void read_expression(const bob::Expression* expression, std::uint8_t* ops, std::uint32_t* operands, double* values) {
    for (const bob::Node& node : expression->nodes()) {
        *ops++ = static_cast<std::uint8_t>(node.op);
        operands = std::copy_n(node.operand, 3, operands);
        *values++ = node.value;
    }
}

EXPORT(free_expression) void free_expression(bob::Expression* expression) { delete expression; }

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

/// bounds: (2, 3), or null where they are to be found.
EXPORT(make_implicit) Shape* make_implicit(const bob::Expression* formula, const double* bounds) {
    return attempt([&] {
        if (bounds) return surface_of(*formula, corners(bounds));
        std::optional<bob::Bounds> found;
        try {
            found = bob::find_bounds(*formula);
        } catch (const std::invalid_argument& error) {
            throw std::invalid_argument(std::string("shape: expected ") + error.what() + "; cut it");
        }
        return surface_of(*formula, some(found));
    });
}

/// The solid of a .vm file's formula. bounds: (2, 3), or null.
EXPORT(make_vm_solid) Shape* make_vm_solid(const bob::Expression* formula, const double* bounds) {
    return attempt([&] {
        const bob::VmSolid solid = bob::vm_solid(*formula);
        return surface_of(solid.formula, bounds ? corners(bounds) : some(solid.bounds));
    });
}

/// The arrays of a scene file's brep (CONVENTIONS.md).
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
