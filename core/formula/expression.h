/// Expressions in x, y and z: the common form of formulas, modelled shapes and .vm files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace bob {

/// Operations of nodes. All but select propagate NaN from any operand.
enum class Op : std::uint8_t {
    constant,
    x,
    y,
    z,
    // of one operand, a
    negate,
    absolute,
    square,
    sqrt,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    exp,
    log,
    floor,
    ceil,
    round,  // to the nearest integer, halves to the even one
    power,  // a to the integer `value`
    // of a and b
    add,
    subtract,
    multiply,
    divide,
    minimum,
    maximum,
    hypot,   // sqrt(a^2 + b^2)
    atan2,   // the angle of (b, a): a is y, b is x
    modulo,  // a - b floor(a / b): the sign is b's, as in Python
    // of a, b and c
    select,  // b if a < 0, else c; the other operand has no effect, even if it is NaN
    mesh_distance,  // signed distance of the point (a, b, c) from the mesh numbered `value`, negative inside
};
constexpr int max_exponent = 1000;  // bound of a power's exponent, positive or negative
constexpr int op_count = static_cast<int>(Op::mesh_distance) + 1;

/// Number of operands, 0 to 3.
[[nodiscard]] constexpr int operands(Op op) {
    return op < Op::negate ? 0 : op < Op::add ? 1 : op < Op::select ? 2 : 3;
}

/// The op's name, which is also its name in Python and in files.
[[nodiscard]] std::string_view name(Op op);

/// The value of an op in double precision, used to fold constants. NaN if no mesh has the number.
[[nodiscard]] double evaluate(Op op, double value, double a, double b, double c);

struct Node {
    Op op = Op::constant;
    std::uint32_t operand[3] = {};  // earlier nodes; 0 if absent
    double value = 0;               // of a constant; a power's exponent; a mesh's number; for a select, `meets` or 0

    friend bool operator==(const Node&, const Node&) = default;
};

/// Marks a select whose formula does not jump.
constexpr double meets = 1;

class MeshDistance;

/// The meshes of a formula (formula/mesh_distance.h), in the order of their first nodes; the formula keeps them alive.
using Meshes = std::vector<std::shared_ptr<const MeshDistance>>;

/// A formula f(x, y, z): nodes, each after its operands. The last is the result and needs all others. Never empty.
class Expression {
public:
    /// Drops nodes that the last one does not need. Throws std::invalid_argument, with the reason, unless the nodes are
    /// in order and no number is NaN.
    explicit Expression(std::vector<Node> nodes);

    [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
    [[nodiscard]] const Meshes& meshes() const { return meshes_; }
    [[nodiscard]] bool uses(Op op) const;

    /// f at a point, in double precision, node by node: the reference for the faster evaluators.
    [[nodiscard]] double operator()(double x, double y, double z) const;

    friend bool operator==(const Expression&, const Expression&) = default;

private:
    friend class Graph;

    Expression() = default;

    std::vector<Node> nodes_;
    Meshes meshes_;
};

/// Linear RGB, each a formula of x, y and z, with shared nodes. Values are clamped to 0..1, NaN to 0. Never empty.
class ColorFormula {
public:
    /// `roots`: the nodes for red, green and blue. Drops nodes that no root needs. Throws as Expression.
    ColorFormula(std::vector<Node> nodes, const std::array<std::uint32_t, 3>& roots);

    /// A constant colour.
    explicit ColorFormula(const std::array<double, 3>& rgb);

    [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
    [[nodiscard]] const std::array<std::uint32_t, 3>& roots() const { return roots_; }
    [[nodiscard]] const Meshes& meshes() const { return meshes_; }

    /// The colour at a point, in double precision.
    [[nodiscard]] std::array<double, 3> operator()(double x, double y, double z) const;

    friend bool operator==(const ColorFormula&, const ColorFormula&) = default;

private:
    friend class Graph;

    ColorFormula() = default;

    std::vector<Node> nodes_;
    std::array<std::uint32_t, 3> roots_{};
    Meshes meshes_;
};

/// A component of a displayed colour: 0 for NaN.
template <class Number>
constexpr Number color_component(Number value) {
    return value > 0 ? value < 1 ? value : Number{1} : Number{0};
}

/// Throws std::invalid_argument unless the numbers of the i-th node are valid.
void check_numbers(const Node& node, std::size_t i);

/// The meshes that nodes refer to. Throws std::invalid_argument if a mesh no longer exists.
[[nodiscard]] Meshes meshes_of(std::span<const Node> nodes);

/// Finds the mesh of a number; the end if it is absent.
[[nodiscard]] Meshes::const_iterator find_mesh(const Meshes& meshes, double number);

/// The nodes that `roots` need, in order; renumbers `roots` accordingly.
[[nodiscard]] std::vector<Node> needed(std::span<const Node> nodes, std::span<std::uint32_t> roots);

/// Thrown by a graph when a formula grows beyond `Graph::max_nodes`.
struct TooLarge : std::runtime_error {
    TooLarge();
};

class Graph;

/// A node of a graph under construction; arithmetic on values adds nodes. Values of two graphs do not mix.
struct Value {
    Graph* graph = nullptr;
    std::uint32_t index = 0;

    friend bool operator==(const Value&, const Value&) = default;
};

/// Builds expressions without duplicate nodes, with folded constants. Simplifies x + 0, -(-x), min(x, x), sums and
/// products with several constants, sqrt(x^2 + y^2) as hypot. Values change in the last bits at most; x * 0 stays, since
/// x may be infinite.
class Graph {
public:
    static constexpr std::size_t max_nodes = 1 << 20;

    Graph() = default;
    Graph(const Graph&) = delete;
    Graph& operator=(const Graph&) = delete;

    Value x() { return add(Op::x, {}); }
    Value y() { return add(Op::y, {}); }
    Value z() { return add(Op::z, {}); }
    Value constant(double value) { return add(Op::constant, {}, value); }
    Value unary(Op op, Value a, double value = 0);
    Value binary(Op op, Value a, Value b);
    /// b if a < 0, else c.
    Value select(Value a, Value b, Value c);
    /// A select in a formula that does not jump. The values b and c meet where a changes its sign, or neither is chosen
    /// in the end.
    Value piecewise(Value a, Value b, Value c);
    /// The signed distance of (x, y, z) from a mesh.
    Value mesh_distance(const std::shared_ptr<const MeshDistance>& mesh, Value x, Value y, Value z);

    /// Adds the op of a node of any expression to this graph. `operand` is ignored for an axis or a constant.
    Value like(const Node& node, const Value operand[3]);
    /// Adds a node made by another graph whose operands are unchanged, without simplification.
    Value again(const Node& node, const Value operand[3]);

    /// Adds the nodes of an expression or a colour formula, each by make(number of the node, values of its operands),
    /// in order.
    template <class Formula, class Make>
    std::vector<Value> rebuild(const Formula& f, Make make) {
        std::vector<Value> values;
        values.reserve(f.nodes().size());
        for (std::uint32_t i = 0; i < f.nodes().size(); ++i) {
            const Node& node = f.nodes()[i];
            Value operand[3];
            for (int k = 0; k < operands(node.op); ++k) operand[k] = values[node.operand[k]];
            values.push_back(make(i, operand));
        }
        return values;
    }

    /// Copies f.
    Value copy(const Expression& f);

    /// f(x, y, z) with other values substituted for x, y and z.
    Value substitute(const Expression& f, Value x, Value y, Value z);
    std::array<Value, 3> substitute(const ColorFormula& f, Value x, Value y, Value z);

    [[nodiscard]] const Node& node(Value v) const { return nodes_[v.index]; }
    [[nodiscard]] std::size_t size() const { return nodes_.size(); }

    /// Removes all nodes but keeps the memory.
    void clear();

    /// A graph for repeated use: empty at first, and without meshes afterwards.
    struct Reused {
        Graph& graph;
        explicit Reused(Graph& graph) : graph(graph) { graph.clear(); }
        ~Reused() { graph.meshes_.clear(); }
        Reused(const Reused&) = delete;
        Reused& operator=(const Reused&) = delete;
    };

    /// The expression of `root`.
    [[nodiscard]] Expression expression(Value root) const;
    [[nodiscard]] ColorFormula color_formula(const std::array<Value, 3>& rgb) const;

private:
    struct Operands {
        std::uint32_t a = 0, b = 0, c = 0;
    };
    Value add(Op op, Operands operands, double value = 0);
    Value choice(Value a, Value b, Value c, double value);
    Value mesh_distance(double number, Value x, Value y, Value z);
    void grow();
    template <class Formula>
    std::vector<Value> substituted(const Formula& f, Value x, Value y, Value z);

    std::vector<Node> nodes_;
    Meshes meshes_;                     // that its nodes refer to
    std::vector<std::uint32_t> slots_;  // open addressing: the node of each hash; no_node if free
};

// Arithmetic that reads like the formula. A number next to a value becomes a constant of its graph.

inline Value operator-(Value a) { return a.graph->unary(Op::negate, a); }
inline Value operator+(const Value& a, const Value& b) { return a.graph->binary(Op::add, a, b); }
inline Value operator-(const Value& a, const Value& b) { return a.graph->binary(Op::subtract, a, b); }
inline Value operator*(const Value& a, const Value& b) { return a.graph->binary(Op::multiply, a, b); }
inline Value operator/(const Value& a, const Value& b) { return a.graph->binary(Op::divide, a, b); }
inline Value operator+(Value a, double b) { return a + a.graph->constant(b); }
inline Value operator-(Value a, double b) { return a - a.graph->constant(b); }
inline Value operator*(Value a, double b) { return a * a.graph->constant(b); }
inline Value operator/(Value a, double b) { return a / a.graph->constant(b); }
inline Value operator+(double a, Value b) { return b.graph->constant(a) + b; }
inline Value operator-(double a, Value b) { return b.graph->constant(a) - b; }
inline Value operator*(double a, Value b) { return b.graph->constant(a) * b; }
inline Value operator/(double a, Value b) { return b.graph->constant(a) / b; }

inline Value abs(Value a) { return a.graph->unary(Op::absolute, a); }
inline Value square(Value a) { return a.graph->unary(Op::square, a); }
inline Value sqrt(Value a) { return a.graph->unary(Op::sqrt, a); }
inline Value sin(Value a) { return a.graph->unary(Op::sin, a); }
inline Value cos(Value a) { return a.graph->unary(Op::cos, a); }
inline Value tan(Value a) { return a.graph->unary(Op::tan, a); }
inline Value asin(Value a) { return a.graph->unary(Op::asin, a); }
inline Value acos(Value a) { return a.graph->unary(Op::acos, a); }
inline Value atan(Value a) { return a.graph->unary(Op::atan, a); }
inline Value exp(Value a) { return a.graph->unary(Op::exp, a); }
inline Value log(Value a) { return a.graph->unary(Op::log, a); }
inline Value floor(Value a) { return a.graph->unary(Op::floor, a); }
inline Value ceil(Value a) { return a.graph->unary(Op::ceil, a); }
inline Value round(Value a) { return a.graph->unary(Op::round, a); }
inline Value power(Value a, int exponent) { return a.graph->unary(Op::power, a, exponent); }
inline Value min(const Value& a, const Value& b) { return a.graph->binary(Op::minimum, a, b); }
inline Value max(const Value& a, const Value& b) { return a.graph->binary(Op::maximum, a, b); }
inline Value min(Value a, double b) { return min(a, a.graph->constant(b)); }
inline Value max(Value a, double b) { return max(a, a.graph->constant(b)); }
inline Value hypot(const Value& a, const Value& b) { return a.graph->binary(Op::hypot, a, b); }
inline Value atan2(const Value& y, const Value& x) { return y.graph->binary(Op::atan2, y, x); }
inline Value modulo(const Value& a, const Value& b) { return a.graph->binary(Op::modulo, a, b); }
inline Value modulo(Value a, double b) { return modulo(a, a.graph->constant(b)); }
/// b if a < 0, else c.
inline Value select(const Value& a, const Value& b, const Value& c) { return a.graph->select(a, b, c); }
/// The same for a formula that does not jump there (Graph::piecewise).
inline Value piecewise(const Value& a, const Value& b, const Value& c) { return a.graph->piecewise(a, b, c); }
inline Value clamp(Value a, double low, double high) { return min(max(a, low), high); }

}  // namespace bob
