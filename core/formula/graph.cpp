#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "formula/expression.h"
#include "formula/mesh_distance.h"

namespace bob {
namespace {

constexpr std::uint32_t no_node = 0xffffffff;

bool commutes(Op op) {
    return op == Op::add || op == Op::multiply || op == Op::minimum || op == Op::maximum || op == Op::hypot;
}

/// Independent products. A constant is hashed by its bits, so that 0 and -0 differ.
std::size_t hash(Op op, std::uint32_t a, std::uint32_t b, std::uint32_t c, double value) {
    const std::uint64_t of_op = static_cast<std::uint64_t>(op) << 32 | a, of_others = static_cast<std::uint64_t>(b) << 32 | c;
    const std::uint64_t h = of_op * 0x9e3779b97f4a7c15 + of_others * 0xbf58476d1ce4e5b9 +
                            std::bit_cast<std::uint64_t>(value) * 0x94d049bb133111eb;
    return h ^ (h >> 32);
}

}  // namespace

// ---- Nodes ----------------------------------------------------------------------------------------

Value Graph::add(Op op, Operands operands, double value) {
    const auto [a, b, c] = operands;
    if (2 * (nodes_.size() + 1) > slots_.size()) grow();
    const std::size_t mask = slots_.size() - 1;
    const auto bits = std::bit_cast<std::uint64_t>(value);
    std::size_t slot = hash(op, a, b, c, value) & mask;
    for (; slots_[slot] != no_node; slot = (slot + 1) & mask) {
        const Node& node = nodes_[slots_[slot]];
        if (node.op == op && node.operand[0] == a && node.operand[1] == b && node.operand[2] == c &&
            std::bit_cast<std::uint64_t>(node.value) == bits) {
            return {this, slots_[slot]};
        }
    }
    if (nodes_.size() == max_nodes) throw TooLarge();
    const auto index = slots_[slot] = static_cast<std::uint32_t>(nodes_.size());
    Node& node = nodes_.emplace_back();
    node.op = op;
    node.operand[0] = a, node.operand[1] = b, node.operand[2] = c;
    node.value = value;
    return {this, index};
}

void Graph::grow() {
    slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), no_node);
    const std::size_t mask = slots_.size() - 1;
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
        const auto& [op, operand, value] = nodes_[i];
        std::size_t slot = hash(op, operand[0], operand[1], operand[2], value) & mask;
        while (slots_[slot] != no_node) slot = (slot + 1) & mask;
        slots_[slot] = i;
    }
}

void Graph::clear() {
    const std::size_t size = std::bit_ceil(std::max<std::size_t>(64, 4 * nodes_.size()));
    nodes_.clear();
    meshes_.clear();
    slots_.assign(std::min(slots_.size(), size), no_node);
}

Expression Graph::expression(Value root) const {
    // Nodes of a graph are in order; only their numbers, which the caller chose, are checked.
    for (std::uint32_t i = 0; i <= root.index; ++i) check_numbers(nodes_[i], i);
    std::uint32_t roots[] = {root.index};
    Expression result;
    result.nodes_ = needed(nodes_, roots);
    if (!meshes_.empty()) result.meshes_ = meshes_of(result.nodes_);
    return result;
}

ColorFormula Graph::color_formula(const std::array<Value, 3>& rgb) const {
    ColorFormula result;
    for (std::size_t i = 0; i < 3; ++i) result.roots_[i] = rgb[i].index;
    result.nodes_ = needed(nodes_, result.roots_);
    for (std::uint32_t i = 0; i < result.nodes_.size(); ++i) check_numbers(result.nodes_[i], i);
    if (!meshes_.empty()) result.meshes_ = meshes_of(result.nodes_);
    return result;
}

Value Graph::like(const Node& node, const Value operand[3]) {
    switch (operands(node.op)) {
        case 0: return add(node.op, {}, node.value);
        case 1: return unary(node.op, operand[0], node.value);
        case 2: return binary(node.op, operand[0], operand[1]);
        default:
            return node.op == Op::mesh_distance ? mesh_distance(node.value, operand[0], operand[1], operand[2])
                                                : choice(operand[0], operand[1], operand[2], node.value);
    }
}

Value Graph::again(const Node& node, const Value operand[3]) {
    const int count = operands(node.op);
    // Nodes may be in another order of age here.
    if (commutes(node.op) && operand[1].index < operand[0].index) return like(node, operand);
    if (node.op == Op::mesh_distance) return like(node, operand);  // which keeps the mesh
    return add(node.op, {count > 0 ? operand[0].index : 0, count > 1 ? operand[1].index : 0, count > 2 ? operand[2].index : 0},
               node.value);
}

Value Graph::copy(const Expression& f) {
    return rebuild(f, [&](std::uint32_t i, const Value* operand) { return like(f.nodes()[i], operand); }).back();
}

template <class Formula>
std::vector<Value> Graph::substituted(const Formula& f, Value x, Value y, Value z) {
    return rebuild(f, [&](std::uint32_t i, const Value* operand) {
        switch (f.nodes()[i].op) {
            case Op::x: return x;
            case Op::y: return y;
            case Op::z: return z;
            default: return like(f.nodes()[i], operand);
        }
    });
}

Value Graph::substitute(const Expression& f, Value x, Value y, Value z) { return substituted(f, x, y, z).back(); }

std::array<Value, 3> Graph::substitute(const ColorFormula& f, Value x, Value y, Value z) {
    const std::vector<Value> values = substituted(f, x, y, z);
    return {values[f.roots()[0]], values[f.roots()[1]], values[f.roots()[2]]};
}

// ---- Algebra --------------------------------------------------------------------------------------
//
// A view of a value's node, so that rules read like the algebra they state.

namespace {

struct Term {
    Graph& graph;
    Value value;

    [[nodiscard]] const Node& node() const { return graph.node(value); }
    [[nodiscard]] bool is(Op op) const { return node().op == op; }
    [[nodiscard]] bool is_constant() const { return is(Op::constant); }
    [[nodiscard]] bool is_constant(double c) const { return is_constant() && node().value == c; }
    [[nodiscard]] double constant() const { return node().value; }
    [[nodiscard]] Term operand(int k) const { return {graph, {&graph, node().operand[k]}}; }
    /// Finite constants can be combined; with infinite ones, inf - inf would become a permanent NaN.
    [[nodiscard]] bool is_finite_constant() const { return is_constant() && std::isfinite(constant()); }
    /// Whether it is `op` of a value and a finite constant, which canonical order puts second.
    [[nodiscard]] bool is_with_constant(Op op) const { return is(op) && operand(1).is_finite_constant(); }

    [[nodiscard]] bool is_never_negative() const {
        switch (node().op) {
            case Op::absolute:
            case Op::square:
            case Op::sqrt:
            case Op::exp:
            case Op::hypot: return true;
            case Op::constant: return constant() >= 0;
            case Op::power: return std::fmod(node().value, 2) == 0;
            case Op::maximum: return operand(1).is_constant() && operand(1).constant() >= 0;
            default: return false;
        }
    }
    /// Whether it is certainly never infinite or NaN.
    [[nodiscard]] bool is_finite() const {
        return is(Op::x) || is(Op::y) || is(Op::z) || is_finite_constant();
    }
};

/// Whether the two are negatives of each other, up to the last bits of a constant.
bool opposite(Term a, Term b) {
    const auto about = [](double p, double q) { return std::fabs(p - q) <= 1e-15 * std::fabs(p); };
    if (a.is(Op::negate) || b.is(Op::negate)) {
        return (a.is(Op::negate) && a.operand(0).value == b.value) || (b.is(Op::negate) && b.operand(0).value == a.value);
    }
    if (b.is(Op::subtract) && !a.is(Op::subtract)) std::swap(a.value, b.value);
    if (a.is(Op::subtract) && b.is(Op::subtract)) {
        return a.operand(0).value == b.operand(1).value && a.operand(1).value == b.operand(0).value;
    }
    if (a.is(Op::subtract) && a.operand(0).is_constant() && b.is_with_constant(Op::add)) {
        return a.operand(1).value == b.operand(0).value &&
               about(a.operand(0).constant(), -b.operand(1).constant());
    }
    const bool products = a.is_with_constant(Op::multiply) && b.is_with_constant(Op::multiply);
    const bool sums = a.is_with_constant(Op::add) && b.is_with_constant(Op::add);
    if (products) {
        return a.operand(0).value == b.operand(0).value && about(a.operand(1).constant(), -b.operand(1).constant());
    }
    return sums && about(a.operand(1).constant(), -b.operand(1).constant()) && opposite(a.operand(0), b.operand(0));
}

/// Sums of more squares keep their root, so that no sum takes long; a vector has three.
constexpr std::size_t max_squares = 64;

bool has_few_summands(Term sum) {
    std::vector<Value> open{sum.value};
    for (std::size_t summands = 0; !open.empty();) {
        const Term part{sum.graph, open.back()};
        open.pop_back();
        if (part.is(Op::add)) {
            open.insert(open.end(), {part.operand(0).value, part.operand(1).value});
        } else {
            ++summands;
        }
        if (summands + open.size() > max_squares) return false;
    }
    return true;
}

/// The root of a sum of squares as a chain of hypot; false if a summand is not a square.
bool root_of_squares(Term sum, Value& chain, bool& started) {
    if (sum.is(Op::add)) {
        return root_of_squares(sum.operand(0), chain, started) && root_of_squares(sum.operand(1), chain, started);
    }
    Value side;
    if (sum.is(Op::square)) {
        side = sum.operand(0).value;
    } else if (sum.is_constant() && sum.constant() >= 0) {
        side = sum.graph.constant(std::sqrt(sum.constant()));
    } else {
        return false;
    }
    chain = started ? hypot(chain, side) : side;
    started = true;
    return true;
}

}  // namespace

Value Graph::unary(Op op, Value value, double exponent) {
    const Term a{*this, value};
    if (a.is_constant()) {
        const double folded = evaluate(op, exponent, a.constant(), 0, 0);
        if (!std::isnan(folded)) return constant(folded);
    }
    switch (op) {
        case Op::negate:
            if (a.is(Op::negate)) return a.operand(0).value;
            if (a.is(Op::subtract)) return a.operand(1).value - a.operand(0).value;
            if (a.is_with_constant(Op::multiply)) return a.operand(0).value * -a.operand(1).constant();
            break;
        case Op::absolute:
            if (a.is_never_negative()) return value;
            if (a.is(Op::negate)) return abs(a.operand(0).value);
            break;
        case Op::square:
            if (a.is(Op::negate) || a.is(Op::absolute)) return square(a.operand(0).value);
            break;
        case Op::sqrt: {
            if (a.is(Op::square)) return abs(a.operand(0).value);
            Value chain;
            bool started = false;
            if (a.is(Op::add) && has_few_summands(a) && root_of_squares(a, chain, started)) return chain;
            break;
        }
        case Op::power:
            if (exponent == 0) return constant(1);
            if (exponent == 1) return value;
            if (exponent == 2) return square(value);
            if (exponent < 0) return 1 / unary(Op::power, value, -exponent);
            break;
        default: break;
    }
    return add(op, {value.index}, op == Op::power ? exponent : 0);
}

Value Graph::binary(Op op, Value left, Value right) {
    Term a{*this, left}, b{*this, right};
    if (a.is_constant() && b.is_constant()) {
        const double folded = evaluate(op, 0, a.constant(), b.constant(), 0);
        if (!std::isnan(folded)) return constant(folded);
    }
    // Constants second, so that the rules below find them there; else the older value first.
    if (commutes(op) && (a.is_constant() || (!b.is_constant() && right.index < left.index))) {
        std::swap(left, right);
        std::swap(a.value, b.value);
    }
    switch (op) {
        case Op::add:
            if (b.is_constant(0)) return left;
            if (b.is_constant() && a.is_with_constant(Op::add)) {
                return a.operand(0).value + (a.operand(1).constant() + b.constant());
            }
            if (b.is_constant() && a.is(Op::subtract) && a.operand(0).is_finite_constant()) {
                return (a.operand(0).constant() + b.constant()) - a.operand(1).value;
            }
            if (b.is(Op::negate)) return left - b.operand(0).value;
            if (a.is(Op::negate)) return right - a.operand(0).value;
            // max(u, 0) + min(u, 0) is u: the remainder of a box near one face.
            if (((a.is(Op::maximum) && b.is(Op::minimum)) || (a.is(Op::minimum) && b.is(Op::maximum))) &&
                a.operand(1).is_constant(0) && b.operand(1).is_constant(0) &&
                a.operand(0).value == b.operand(0).value) {
                return a.operand(0).value;
            }
            break;
        case Op::subtract:
            if (b.is_constant()) return left + -b.constant();
            if (b.is(Op::negate)) return left + b.operand(0).value;
            if (a.is_constant(0)) return -right;
            if (a.is_constant() && b.is_with_constant(Op::add)) {
                return (a.constant() - b.operand(1).constant()) - b.operand(0).value;
            }
            if (a.is_constant() && b.is(Op::subtract) && b.operand(0).is_finite_constant()) {
                return b.operand(1).value + (a.constant() - b.operand(0).constant());
            }
            break;
        case Op::multiply:
            if (b.is_constant(1)) return left;
            if (b.is_constant(-1)) return -left;
            if (b.is_constant(0) && a.is_finite()) return right;
            if (b.is_finite_constant()) {
                const double c = b.constant();
                if (a.is(Op::negate)) return a.operand(0).value * -c;
                if (a.is_with_constant(Op::multiply)) return a.operand(0).value * (a.operand(1).constant() * c);
                if (a.is_with_constant(Op::add)) return a.operand(0).value * c + a.operand(1).constant() * c;
            }
            if (left == right) return square(left);
            if (a.is(Op::negate) && b.is(Op::negate)) return a.operand(0).value * b.operand(0).value;
            // Powers have tighter bounds than products: x * x * x rises everywhere.
            if (a.is(Op::square) && a.operand(0).value == right) return power(right, 3);
            if (b.is(Op::square) && b.operand(0).value == left) return power(left, 3);
            if (a.is(Op::power) && a.operand(0).value == right && a.node().value < max_exponent) {
                return unary(Op::power, right, a.node().value + 1);
            }
            if (b.is(Op::power) && b.operand(0).value == left && b.node().value < max_exponent) {
                return unary(Op::power, left, b.node().value + 1);
            }
            break;
        case Op::divide:
            if (b.is_constant() && std::isfinite(1 / b.constant())) return left * (1 / b.constant());
            break;
        case Op::minimum:
        case Op::maximum:
            if (left == right) return left;
            // The remainder of a solid cut along its own face: never negative, so empty.
            if (opposite(a, b)) return op == Op::maximum ? abs(left) : -abs(left);
            if (op == Op::maximum && b.is_constant() && b.constant() <= 0 && a.is_never_negative()) return left;
            if (b.is_constant() && a.is_with_constant(op)) {
                return binary(op, a.operand(0).value,
                              constant(evaluate(op, 0, a.operand(1).constant(), b.constant(), 0)));
            }
            break;
        case Op::hypot:
            if (b.is_constant(0)) return abs(left);
            if (a.is(Op::negate) || a.is(Op::absolute)) return hypot(a.operand(0).value, right);
            if (b.is(Op::negate) || b.is(Op::absolute)) return hypot(left, b.operand(0).value);
            break;
        default: break;
    }
    return add(op, {left.index, right.index});
}

Value Graph::select(Value a, Value b, Value c) { return choice(a, b, c, 0); }
Value Graph::piecewise(Value a, Value b, Value c) { return choice(a, b, c, meets); }

Value Graph::choice(Value a, Value b, Value c, double value) {
    const Term condition{*this, a};
    if (condition.is_constant()) return condition.constant() < 0 ? b : c;
    if (b == c) return b;
    return add(Op::select, {a.index, b.index, c.index}, value);
}

Value Graph::mesh_distance(const std::shared_ptr<const MeshDistance>& mesh, Value x, Value y, Value z) {
    if (std::find(meshes_.begin(), meshes_.end(), mesh) == meshes_.end()) meshes_.push_back(mesh);
    const Term a{*this, x}, b{*this, y}, c{*this, z};
    if (a.is_constant() && b.is_constant() && c.is_constant()) return constant((*mesh)({a.constant(), b.constant(), c.constant()}));
    return add(Op::mesh_distance, {x.index, y.index, z.index}, mesh->number());
}

Value Graph::mesh_distance(double number, Value x, Value y, Value z) {
    const auto known = find_mesh(meshes_, number);
    return mesh_distance(known != meshes_.end() ? *known : MeshDistance::numbered(number), x, y, z);
}

}  // namespace bob
