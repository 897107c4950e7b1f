#include "files/threemf/nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "files/text.h"

namespace bob::files::threemf {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string_view shape_name(std::size_t size) {
    return size == scalar ? "a scalar" : size == vector ? "a vector" : size == matrix ? "a matrix" : "a resource";
}

double constant_of(const FunctionNode& node, std::string_view name) {
    const auto found = node.get.find(name);
    if (found == node.get.end()) throw MissingInput{std::string(name)};
    const double value = number_of(trimmed(found->second));
    if (std::isnan(value)) refuse({"expected numbers in a formula, got NaN"});
    return value;
}

/// The number, of a value that does not depend on the place.
std::optional<double> constant(Value value) {
    const Node& node = value.graph->node(value);
    return node.op == Op::constant ? std::optional(node.value) : std::nullopt;
}

// ---- Scalars ---------------------------------------------------------------------------------------------

/// a < b ? c : d
Value choose(Value a, Value b, Value c, Value d) { return select(a - b, c, d); }

Value clipped(Value a, double limit) { return min(max(a, -limit), limit); }

/// The Taylor series, accurate in -1..1 to 1e-14.
Value sinh_series(Value a) {
    Value sum = a.graph->constant(1);
    for (int n = 16; n > 0; n -= 2) sum = 1 + sum * square(a) / (n * (n + 1));
    return a * sum;
}

// Near 0, a difference of exponentials loses digits by cancellation; series do not.

Value sinh(Value a) { return piecewise(abs(a) - 1, sinh_series(clipped(a, 1)), (exp(a) - exp(-a)) / 2); }

Value tanh(Value a) {
    const Value near = sinh_series(clipped(a, 1));
    return piecewise(abs(a) - 1, near / hypot(near, a.graph->constant(1)), 1 - 2 / (exp(2 * a) + 1));
}

Value sign(Value a) {
    Graph& graph = *a.graph;
    return select(a, graph.constant(-1), select(-a, graph.constant(1), graph.constant(0)));
}

Value remainder_of_c(Value a, Value b) {
    const Value size = modulo(abs(a), abs(b));
    return select(a, -size, size);
}

/// A constant 0 gives infinity even at a = 0, so that the clamp of a repetition is defined.
Value quotient(Value a, Value b) {
    if (constant(b) != 0.0) return a / b;
    return select(a, a.graph->constant(-infinity), a.graph->constant(infinity));
}

Value power_of(Value a, Value b) {
    const std::optional<double> base = constant(a), exponent = constant(b);
    if (base && exponent) {
        if (const double value = std::pow(*base, *exponent); !std::isnan(value)) return a.graph->constant(value);
    }
    if (exponent && std::isfinite(*exponent)) {
        const auto whole = [&](Value of, double number) {
            if (std::fabs(number) > max_exponent) {
                const std::string got = grouped(static_cast<std::uint64_t>(std::min(std::fabs(number), 1e18)));
                refuse({"exponent: expected a whole number in \xc2\xb1", grouped(max_exponent), ", got ", number < 0 ? "-" : "", got});
            }
            return power(of, static_cast<int>(number));
        };
        if (*exponent == std::floor(*exponent)) return whole(a, *exponent);
        if (2 * *exponent == std::floor(2 * *exponent)) return whole(sqrt(a), 2 * *exponent);
    }
    return exp(log(a) * b);
}

// ---- Kinds -----------------------------------------------------------------------------------------------

using OfOne = Value (*)(Value);
using OfTwo = Value (*)(Value, Value);

constexpr std::pair<std::string_view, OfOne> of_one[] = {
    {"sin", [](Value a) { return sin(a); }},
    {"cos", [](Value a) { return cos(a); }},
    {"tan", [](Value a) { return tan(a); }},
    {"arcsin", [](Value a) { return asin(a); }},
    {"asin", [](Value a) { return asin(a); }},
    {"arccos", [](Value a) { return acos(a); }},
    {"acos", [](Value a) { return acos(a); }},
    {"arctan", [](Value a) { return atan(a); }},
    {"atan", [](Value a) { return atan(a); }},
    {"abs", [](Value a) { return abs(a); }},
    {"sqrt", [](Value a) { return sqrt(a); }},
    {"exp", [](Value a) { return exp(a); }},
    {"log", [](Value a) { return log(a); }},
    {"log2", [](Value a) { return log(a) / std::numbers::ln2; }},
    {"log10", [](Value a) { return log(a) / std::numbers::ln10; }},
    {"cosh", [](Value a) { return (exp(a) + exp(-a)) / 2; }},
    {"sinh", sinh},
    {"tanh", tanh},
    {"round", [](Value a) { return round(a); }},
    {"ceil", [](Value a) { return ceil(a); }},
    {"floor", [](Value a) { return floor(a); }},
    {"sign", sign},
    {"fract", [](Value a) { return a - floor(a); }},
};
constexpr std::pair<std::string_view, OfTwo> of_two[] = {
    {"addition", [](Value a, Value b) { return a + b; }},
    {"subtraction", [](Value a, Value b) { return a - b; }},
    {"multiplication", [](Value a, Value b) { return a * b; }},
    {"division", quotient},
    {"min", [](Value a, Value b) { return min(a, b); }},
    {"max", [](Value a, Value b) { return max(a, b); }},
    {"fmod", remainder_of_c},
    {"mod", [](Value a, Value b) { return modulo(a, b); }},
    {"pow", power_of},
    {"arctan2", [](Value a, Value b) { return atan2(a, b); }},
    {"atan2", [](Value a, Value b) { return atan2(a, b); }},
};

template <class Kinds>
auto find_kind(const Kinds& kinds, std::string_view kind) {
    const auto found = std::ranges::find(kinds, kind, [](const auto& each) { return each.first; });
    return found == std::end(kinds) ? nullptr : found->second;
}

// ---- Vectors and matrices --------------------------------------------------------------------------------

/// Computes component by component; the operands have the shape of the first one.
template <class... Inputs>
Operand of_each(auto compute, const Operand& first, const Inputs&... others) {
    if (first.values.empty()) refuse({"expected a value, got a resource"});
    (check_shape(others, first.values.size()), ...);
    Operand result;
    for (std::size_t i = 0; i < first.values.size(); ++i) result.values.push_back(compute(first.values[i], others.values[i]...));
    return result;
}

Value dot(const Operand& a, const Operand& b) {
    check_shape(a, vector), check_shape(b, vector);
    return a.values[0] * b.values[0] + a.values[1] * b.values[1] + a.values[2] * b.values[2];
}

Operand cross(const Operand& a, const Operand& b) {
    check_shape(a, vector), check_shape(b, vector);
    Operand result;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        result.values.push_back(a.values[j] * b.values[k] - a.values[k] * b.values[j]);
    }
    return result;
}

Operand transposed(const Operand& a) {
    check_shape(a, matrix);
    Operand result;
    for (std::size_t i = 0; i < 16; ++i) result.values.push_back(a.values[4 * (i % 4) + i / 4]);
    return result;
}

/// By elimination, with the largest pivot of each column.
Operand inverse(const Operand& a) {
    check_shape(a, matrix);
    double rows[4][8] = {};
    const auto refuse_matrix = [] { refuse({"expected a matrix of constants that has an inverse, got another"}); };
    for (std::size_t i = 0; i < 16; ++i) {
        const std::optional<double> value = constant(a.values[i]);
        if (!value || !std::isfinite(*value)) refuse_matrix();
        rows[i / 4][i % 4] = *value;
        rows[i / 4][4 + i / 4] = 1;
    }
    for (std::size_t column = 0; column < 4; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column; row < 4; ++row) {
            if (std::fabs(rows[row][column]) > std::fabs(rows[pivot][column])) pivot = row;
        }
        if (rows[pivot][column] == 0) refuse_matrix();
        std::swap(rows[pivot], rows[column]);
        const double scale = 1 / rows[column][column];
        for (double& value : rows[column]) value *= scale;
        for (std::size_t row = 0; row < 4; ++row) {
            const double factor = rows[row][column];
            for (std::size_t k = 0; k < 8 && row != column; ++k) rows[row][k] -= factor * rows[column][k];
        }
    }
    Operand result;
    for (const auto& row : rows) {
        for (std::size_t k = 4; k < 8; ++k) {
            if (!std::isfinite(row[k])) refuse_matrix();
            result.values.push_back(a.values[0].graph->constant(row[k]));
        }
    }
    return result;
}

/// Three components of each of four vectors in rows, below a last row of 0, 0, 0, 1, transposed.
Operand matrix_of_rows(Graph& graph, const Operands& inputs) {
    Operand result;
    for (const std::string_view name : {"A", "B", "C", "D"}) {
        const Operand& row = input(inputs, name);
        check_shape(row, vector);
        result.values.insert(result.values.end(), row.values.begin(), row.values.end());
        result.values.push_back(graph.constant(name == "D" ? 1 : 0));
    }
    return result;
}

Operand composed(const Operands& inputs, std::initializer_list<std::string_view> names) {
    Operand result;
    for (const std::string_view name : names) {
        const Operand& component = input(inputs, name);
        check_shape(component, scalar);
        result.values.push_back(component.values[0]);
    }
    return result;
}

Operand constant_matrix(Graph& graph, const FunctionNode& node) {
    const auto found = node.get.find("matrix");
    if (found == node.get.end()) throw MissingInput{"matrix"};
    const std::vector<double> values = numbers_of(found->second);
    if (values.size() != 16) refuse({"matrix: expected 16 numbers, got ", std::to_string(values.size())});
    Operand result;
    for (const double value : values) {
        if (std::isnan(value)) refuse({"expected numbers in a formula, got NaN"});
        result.values.push_back(graph.constant(value));
    }
    return result;
}

Operand output_of(Graph& graph, const FunctionNode& node, const Operands& inputs) {
    const std::string_view kind = node.kind;
    const auto of = [&](std::string_view name) -> const Operand& { return input(inputs, name); };
    if (const OfOne compute = find_kind(of_one, kind)) return of_each(compute, of("A"));
    if (const OfTwo compute = find_kind(of_two, kind)) return of_each(compute, of("A"), of("B"));
    if (kind == "clamp") return of_each([](Value a, Value low, Value high) { return max(low, min(a, high)); }, of("A"), of("min"), of("max"));
    if (kind == "select") return of_each(choose, of("A"), of("B"), of("C"), of("D"));
    if (kind == "dot") return {{dot(of("A"), of("B"))}};
    if (kind == "length") return {{sqrt(dot(of("A"), of("A")))}};
    if (kind == "cross") return cross(of("A"), of("B"));
    if (kind == "composevector") return composed(inputs, {"x", "y", "z"});
    if (kind == "vectorfromscalar") return composed(inputs, {"A", "A", "A"});
    if (kind == "composematrix") {
        return composed(inputs, {"m00", "m01", "m02", "m03", "m10", "m11", "m12", "m13", "m20", "m21", "m22", "m23", "m30", "m31", "m32", "m33"});
    }
    if (kind == "matrixfromrows") return matrix_of_rows(graph, inputs);
    if (kind == "matrixfromcolumns") return transposed(matrix_of_rows(graph, inputs));
    if (kind == "matvecmultiplication" || kind == "matrixvectormultiplication") return times(of("A"), of("B"));
    if (kind == "transpose") return transposed(of("A"));
    if (kind == "inverse") return inverse(of("A"));
    if (kind == "constant") return {{graph.constant(constant_of(node, "value"))}};
    if (kind == "constvec") {
        return {{graph.constant(constant_of(node, "x")), graph.constant(constant_of(node, "y")), graph.constant(constant_of(node, "z"))}};
    }
    if (kind == "constmat") return constant_matrix(graph, node);
    if (kind == "constresourceid" || kind == "resourceid") {
        const auto found = node.get.find("value");
        if (found == node.get.end()) throw MissingInput{"value"};
        return {{}, found->second};
    }
    refuse({"expected a supported kind of node, got ", kind});
}

}  // namespace

void check_shape(const Operand& operand, std::size_t size) {
    if (operand.values.size() != size) refuse({"expected ", shape_name(size), ", got ", shape_name(operand.values.size())});
}

const Operand& input(const Operands& inputs, std::string_view name) {
    const auto found = inputs.find(name);
    if (found == inputs.end()) throw MissingInput{std::string(name)};
    return found->second;
}

Operand times(const Operand& a, const Operand& b) {
    check_shape(a, matrix), check_shape(b, vector);
    const std::vector<Value>&m = a.values, &v = b.values;
    Operand result;
    for (std::size_t i = 0; i < 12; i += 4) result.values.push_back(m[i] * v[0] + m[i + 1] * v[1] + m[i + 2] * v[2] + m[i + 3]);
    return result;
}

Operands outputs_of(Graph& graph, const FunctionNode& node, const Operands& inputs) {
    if (node.kind != "decomposevector") return {{"", output_of(graph, node, inputs)}};
    const Operand& a = input(inputs, "A");
    check_shape(a, vector);
    return {{"x", {{a.values[0]}}}, {"y", {{a.values[1]}}}, {"z", {{a.values[2]}}}};
}

}  // namespace bob::files::threemf
