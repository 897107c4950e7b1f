/// Random formulas, and their values in double precision with a bound of single precision's error.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "check.h"
#include "formula/mesh_distance.h"
#include "formula/scratch.h"
#include "formula/tape.h"

namespace test {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

using Point = std::array<float, 3>;

/// Equal, or both NaN. Zeros of either sign are equal.
inline bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

inline std::size_t pick(Random& random, std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(random() * static_cast<float>(count)));
}

/// Numbers that formulas are made of, and numbers where they go wrong.
inline double random_constant(Random& random) {
    constexpr double numbers[] = {0,    1,     -1,     2,    0.5,        -3,  0.1,   1e-3, -1e-4, 10,   100,
                                  1e-7, 3e-20, 1e30, -1e30, 0x1p-130, -0.0, 1e-30, 7.25, -12.5, 0x1p24, infinity};
    return random() < 0.5f ? random(-2, 2) : numbers[pick(random, std::size(numbers))];
}

/// An octahedron with a corner pushed in.
inline const std::shared_ptr<const bob::MeshDistance>& some_mesh() {
    static const auto mesh = [] {
        const std::vector<bob::Vec3> vertices{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -0.25f}, {0, 0, -1}};
        const std::vector<bob::MeshDistance::Triangle> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                                 {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
        return bob::MeshDistance::of(vertices, triangles);
    }();
    return mesh;
}

/// Ops of one to three numbers, without meshes; formulas of meshes follow below.
inline bob::Op random_op(Random& random) {
    constexpr auto first = static_cast<std::size_t>(bob::Op::negate), last = static_cast<std::size_t>(bob::Op::select);
    return static_cast<bob::Op>(first + pick(random, last + 1 - first));
}

/// A random formula of all ops and `steps` steps at most, as plain nodes that nothing simplifies.
inline bob::Expression random_expression(Random& random, int steps) {
    using bob::Op;
    std::vector<bob::Node> nodes{{.op = Op::x}, {.op = Op::y}, {.op = Op::z}};
    for (int i = 0; i < 3; ++i) nodes.push_back({.op = Op::constant, .value = random_constant(random)});
    for (int i = 0; i < steps; ++i) {
        bob::Node node{.op = random_op(random)};
        for (int k = 0; k < operands(node.op); ++k) {
            // Near the end more often, so that formulas grow deep.
            const std::size_t back = pick(random, 1 + pick(random, nodes.size()));
            node.operand[k] = static_cast<std::uint32_t>(nodes.size() - 1 - back);
        }
        if (node.op == Op::power) node.value = std::array{-3, -2, -1, 1, 2, 3, 4, 5, 8, 11}[pick(random, 10)];
        nodes.push_back(node);
    }
    return bob::Expression(std::move(nodes));
}

/// As graphs hold it.
inline bob::Expression simplified(const bob::Expression& f) {
    bob::Graph g;
    return g.expression(g.substitute(f, g.x(), g.y(), g.z()));
}

/// The distance to a right angle as modelling words write it, which tapes recognise if `zero` is 0. A number that is 0 only
/// as a float keeps several steps of the same values.
inline bob::Expression corner(const bob::Expression& a, const bob::Expression& b, double zero = 0) {
    bob::Graph g;
    const bob::Value p = g.copy(a), q = g.copy(b), beyond_q = max(q, zero), outside = hypot(max(p, zero), beyond_q);
    const bob::Value inside = max(q, p);
    return g.expression(select(min(p, q), inside, outside));
}

/// Most of them simplified, some as they stand.
inline bob::Expression random_formula(Random& random) {
    const bob::Expression plain = random_expression(random, 1 + static_cast<int>(pick(random, 16)));
    return random() < 0.7f ? simplified(plain) : plain;
}

/// The distance of random values from a mesh, and an op of it and of others.
inline bob::Expression random_mesh_formula(Random& random) {
    using bob::Op, bob::Value;
    bob::Graph g;
    Value p[3] = {g.x(), g.y(), g.z()};
    for (Value& axis : p) {
        if (random() < 0.3f) axis = g.copy(random_expression(random, 3));
        if (random() < 0.5f) axis = axis * random(-3, 3) + random(-1, 1);
    }
    const Value distance = g.mesh_distance(some_mesh(), p[0], p[1], p[2]), other = g.copy(random_expression(random, 3));
    const Op ops[] = {Op::minimum, Op::maximum, Op::add, Op::subtract, Op::multiply, Op::hypot};
    return g.expression(random() < 0.3f ? distance : g.binary(ops[pick(random, std::size(ops))], distance, other));
}

/// f by this instruction set's kernel.
inline std::vector<float> values(const bob::Tape& tape, const std::vector<Point>& points) {
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    std::vector<float> result(points.size());
    for (std::size_t first = 0; first < points.size(); first += static_cast<std::size_t>(kernels.lanes)) {
        const int count = static_cast<int>(std::min<std::size_t>(points.size() - first, kernels.lanes));
        float p[3][bob::max_lanes];
        for (int axis = 0; axis < 3; ++axis) {
            for (int i = 0; i < count; ++i) p[axis][i] = points[first + i][axis];
        }
        const float* const axes[3] = {p[0], p[1], p[2]};
        kernels.values(tape.code(), axes, count, &result[first], bob::scratch(tape.code().registers));
    }
    return result;
}

/// A value in double precision, and how far single precision may be from it: NaN where it may be anything.
struct Estimate {
    double value, error;
};

/// The error that an op may add to its operands' errors, in single precision.
inline double own_error(bob::Op op, double result, double a, double b) {
    using bob::Op;
    constexpr double ulp = 0x1p-23, tiny = 1e-44;
    switch (op) {
        case Op::negate:
        case Op::absolute:
        case Op::floor:
        case Op::ceil:
        case Op::round:
        case Op::minimum:
        case Op::maximum:
        case Op::select: return 0;
        // Squares below 1e-45 are 0, those above 1e38 infinite.
        case Op::hypot: return std::fabs(result) < 1e18 ? 2 * ulp * std::fabs(result) + 4e-23 : not_a_number;
        case Op::modulo: return 2 * ulp * std::max(std::fabs(a), std::fabs(b)) + tiny;
        case Op::sin:
        case Op::cos: return std::fabs(a) < 1e4 ? 2e-7 : not_a_number;
        case Op::tan: return std::fabs(a) < 1e4 ? 2e-7 * (1 + result * result) : not_a_number;
        case Op::power: return 8 * ulp * std::fabs(result) + tiny;
        default: return 4 * ulp * std::fabs(result) + tiny;
    }
}

/// f at a point. Each op is tried with its operands off by their errors, so that steps, edges and poles nearby show.
inline Estimate estimate(const bob::Expression& f, const Point& p) {
    using bob::Op;
    std::vector<Estimate> at;
    for (const bob::Node& node : f.nodes()) {
        if (node.op == Op::x || node.op == Op::y || node.op == Op::z) {
            at.push_back({p[static_cast<int>(node.op) - static_cast<int>(Op::x)], 0});
            continue;
        }
        Estimate operand[3] = {};
        const int count = operands(node.op);
        for (int k = 0; k < count; ++k) operand[k] = at[node.operand[k]];
        const auto op = [&](int corner) {
            double v[3];
            for (int k = 0; k < 3; ++k) v[k] = operand[k].value + (corner >> k & 1 ? 1 : -1) * operand[k].error;
            return evaluate(node.op, node.value, v[0], v[1], v[2]);
        };
        const double value = evaluate(node.op, node.value, operand[0].value, operand[1].value, operand[2].value);
        double error = std::isinf(value)          ? 0
                       : node.op == Op::constant ? std::fabs(value - static_cast<float>(value))
                                                 : own_error(node.op, value, operand[0].value, operand[1].value);
        double farthest = 0;
        for (int corner = 0; corner < 1 << count; ++corner) {
            const double v = op(corner);
            if (v != value && !(std::isnan(v) && std::isnan(value))) {
                const double off = std::fabs(v - value);
                farthest = off > farthest || std::isnan(off) ? off : farthest;
                if (std::isnan(off)) break;
            }
        }
        bool known = !std::isnan(farthest);
        error = std::isnan(value) ? 0 : error + farthest;
        // Errors as large as the operand hide values between the corners; values near the end of floats overflow.
        for (int k = 0; k < count; ++k) {
            if (node.op == Op::select && k == (operand[0].value < 0 ? 2 : 1)) continue;
            const auto [of, off] = operand[k];
            known = known && (std::isnan(of) ? off == 0 : off <= 1e-2 * (1 + std::fabs(of)));
        }
        // The sign of a zero is not kept by all ops.
        known = known && !(node.op == Op::divide && operand[1].value == 0);
        if (node.op == Op::modulo) {
            // No farther off than a part of one turn.
            const double turns = 1 + std::fabs(operand[0].value / operand[1].value);
            known = known && !std::isinf(operand[1].value) &&
                    4 * (operand[0].error + turns * operand[1].error) < std::fabs(operand[1].value);
        }
        known = known && !(std::fabs(value) > 1e37 && !std::isinf(value));
        at.push_back({value, known ? error : not_a_number});
    }
    return at.back();
}

}  // namespace test
