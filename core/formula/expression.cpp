#include "formula/expression.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "formula/mesh_distance.h"

namespace bob {
namespace {

constexpr std::string_view names[op_count] = {
    "constant", "x",    "y",   "z",   "negate", "absolute", "square", "sqrt",     "sin",      "cos",
    "tan",      "asin", "acos", "atan", "exp",  "log",      "floor",  "ceil",     "round",    "power",
    "add",      "subtract", "multiply", "divide", "minimum", "maximum", "hypot", "atan2", "modulo", "select",
    "mesh_distance",
};

}  // namespace

std::string_view name(Op op) { return names[static_cast<int>(op)]; }

double evaluate(Op op, double value, double a, double b, double c) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const int count = op == Op::select ? 1 : operands(op);
    if ((count > 0 && std::isnan(a)) || (count > 1 && std::isnan(b))) return nan;
    switch (op) {
        case Op::constant: return value;
        case Op::x:
        case Op::y:
        case Op::z: return nan;
        case Op::negate: return -a;
        case Op::absolute: return std::fabs(a);
        case Op::square: return a * a;
        case Op::sqrt: return std::sqrt(a);
        case Op::sin: return std::sin(a);
        case Op::cos: return std::cos(a);
        case Op::tan: return std::tan(a);
        case Op::asin: return std::asin(a);
        case Op::acos: return std::acos(a);
        case Op::atan: return std::atan(a);
        case Op::exp: return std::exp(a);
        case Op::log: return std::log(a);
        case Op::floor: return std::floor(a);
        case Op::ceil: return std::ceil(a);
        case Op::round: return std::nearbyint(a);
        case Op::power: return std::pow(a, value);
        case Op::add: return a + b;
        case Op::subtract: return a - b;
        case Op::multiply: return a * b;
        case Op::divide: return a / b;
        case Op::minimum: return std::min(a, b);
        case Op::maximum: return std::max(a, b);
        case Op::hypot: return std::hypot(a, b);
        case Op::atan2: return std::atan2(a, b);
        case Op::modulo: {
            const double r = std::fmod(a, b);
            if (r == 0) return std::copysign(r, b);
            return (r < 0) != (b < 0) ? r + b : r;
        }
        case Op::select: return a < 0 ? b : c;
        case Op::mesh_distance: {
            const auto mesh = MeshDistance::numbered(value);
            return mesh ? (*mesh)({a, b, c}) : nan;
        }
    }
    return nan;
}

TooLarge::TooLarge()
    : std::runtime_error("expected a formula of at most " + std::to_string(Graph::max_nodes) + " steps, got more") {}

// ---- Expression ------------------------------------------------------------------------------------------

namespace {

void refuse(std::size_t i, const char* what) {
    throw std::invalid_argument("node " + std::to_string(i) + ": " + what);
}

}  // namespace

void check_numbers(const Node& node, std::size_t i) {
    if (node.op == Op::constant && std::isnan(node.value)) refuse(i, "expected a number, got NaN");
    if (node.op == Op::power && !(std::fabs(node.value) <= max_exponent && node.value == std::floor(node.value))) {
        refuse(i, "expected a whole exponent of at most 1000");
    }
    if (node.op == Op::mesh_distance && !MeshDistance::numbered(node.value)) refuse(i, "expected the number of a mesh, got another");
}

namespace {

/// Throws unless the nodes are in order and valid.
void check(const std::vector<Node>& nodes) {
    if (nodes.empty()) throw std::invalid_argument("expected at least one node, got none");
    if (nodes.size() > Graph::max_nodes) throw TooLarge();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        if (static_cast<int>(node.op) >= op_count) refuse(i, "expected an op, got an unknown one");
        for (int k = 0; k < operands(node.op); ++k) {
            if (node.operand[k] >= i) refuse(i, "expected operands that come before it");
        }
        check_numbers(node, i);
    }
}

std::vector<double> values_at(const std::vector<Node>& nodes, const Meshes& meshes, double x, double y, double z) {
    std::vector<double> values(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        const auto operand = [&](int k) { return values[node.operand[k]]; };
        if (node.op == Op::mesh_distance) {
            values[i] = (**find_mesh(meshes, node.value))({operand(0), operand(1), operand(2)});
            continue;
        }
        values[i] = node.op == Op::x   ? x
                    : node.op == Op::y ? y
                    : node.op == Op::z ? z
                                       : evaluate(node.op, node.value, i ? operand(0) : 0, i ? operand(1) : 0,
                                                  i ? operand(2) : 0);
    }
    return values;
}

}  // namespace

Expression::Expression(std::vector<Node> nodes) {
    check(nodes);
    std::uint32_t root[] = {static_cast<std::uint32_t>(nodes.size() - 1)};
    nodes_ = needed(nodes, root);
    meshes_ = meshes_of(nodes_);
}

Meshes meshes_of(std::span<const Node> nodes) {
    Meshes meshes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].op != Op::mesh_distance) continue;
        auto mesh = MeshDistance::numbered(nodes[i].value);
        if (!mesh) refuse(i, "expected the number of a mesh, got another");
        if (std::find(meshes.begin(), meshes.end(), mesh) == meshes.end()) meshes.push_back(std::move(mesh));
    }
    return meshes;
}

Meshes::const_iterator find_mesh(const Meshes& meshes, double number) {
    return std::ranges::find_if(meshes, [=](const auto& mesh) { return mesh->number() == number; });
}

std::vector<Node> needed(std::span<const Node> nodes, std::span<std::uint32_t> roots) {
    const std::uint32_t last = *std::max_element(roots.begin(), roots.end());
    std::vector<std::uint32_t> place(last + 1, 0);
    for (const std::uint32_t root : roots) place[root] = 1;
    std::size_t count = 0;
    for (std::uint32_t i = last + 1; i-- > 0;) {
        if (!place[i]) continue;
        ++count;
        for (int k = 0; k < operands(nodes[i].op); ++k) place[nodes[i].operand[k]] = 1;
    }
    std::vector<Node> result;
    result.reserve(count);
    for (std::uint32_t i = 0; i <= last; ++i) {
        if (!place[i]) continue;
        place[i] = static_cast<std::uint32_t>(result.size());
        Node node = nodes[i];
        for (int k = 0; k < 3; ++k) node.operand[k] = k < operands(node.op) ? place[node.operand[k]] : 0;
        result.push_back(node);
    }
    for (std::uint32_t& root : roots) root = place[root];
    return result;
}

bool Expression::uses(Op op) const {
    return std::any_of(nodes_.begin(), nodes_.end(), [op](const Node& node) { return node.op == op; });
}

double Expression::operator()(double x, double y, double z) const { return values_at(nodes_, meshes_, x, y, z).back(); }

// ---- Colour formulas -------------------------------------------------------------------------------------

ColorFormula::ColorFormula(std::vector<Node> nodes, const std::array<std::uint32_t, 3>& roots) : roots_(roots) {
    check(nodes);
    for (const std::uint32_t root : roots) {
        if (root >= nodes.size()) throw std::invalid_argument("expected red, green and blue among the nodes, got a later one");
    }
    nodes_ = needed(nodes, roots_);
    meshes_ = meshes_of(nodes_);
}

ColorFormula::ColorFormula(const std::array<double, 3>& rgb) {
    Graph graph;
    std::array<Value, 3> values;
    for (std::size_t i = 0; i < 3; ++i) values[i] = graph.constant(rgb[i]);
    *this = graph.color_formula(values);
}

std::array<double, 3> ColorFormula::operator()(double x, double y, double z) const {
    const std::vector<double> values = values_at(nodes_, meshes_, x, y, z);
    std::array<double, 3> rgb;
    for (std::size_t i = 0; i < 3; ++i) rgb[i] = color_component(values[roots_[i]]);
    return rgb;
}

}  // namespace bob
