/// Tools for writing words: arguments by name, points of values, and results.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formula/sequenced.h"
#include "modelling/colored.h"
#include "modelling/vocabulary.h"

namespace bob {

// Each file of words adds its entries to the table.
void add_shapes_3d(std::vector<Word>& words);
void add_shapes_2d(std::vector<Word>& words);
void add_operations(std::vector<Word>& words);
void add_easings(std::vector<Word>& words);

template <std::size_t n>
using Vector = std::array<double, n>;
template <std::size_t n>
using Point = std::array<Value, n>;

/// The arguments of a call, by the names of the parameters. Types are already checked; other requirements are checked
/// here, with a CallError that names the value given.
class Arguments {
public:
    Arguments(const Word& word, std::vector<Object> values) : word_(word), values_(std::move(values)) {}

    [[nodiscard]] bool has(std::string_view name) const { return !std::holds_alternative<None>(at(name).value); }
    [[nodiscard]] double number(std::string_view name) const { return std::get<double>(at(name).value); }
    [[nodiscard]] double at_least(double low, std::string_view name) const;
    [[nodiscard]] double nonzero(std::string_view name) const;
    [[nodiscard]] int whole(int low, int high, std::string_view name) const;
    [[nodiscard]] std::optional<double> optional(std::string_view name) const;

    template <std::size_t n>
    [[nodiscard]] Vector<n> vector(std::string_view name) const;
    /// A single number applies to all axes.
    template <std::size_t n>
    [[nodiscard]] Vector<n> size(std::string_view name) const;
    template <std::size_t n>
    [[nodiscard]] Vector<n> nonzero_size(std::string_view name) const;
    /// A vector, scaled to length 1.
    template <std::size_t n>
    [[nodiscard]] Vector<n> direction(std::string_view name) const;
    template <std::size_t n>
    [[nodiscard]] std::vector<Vector<n>> points(std::string_view name) const;

    [[nodiscard]] const Sdf& sdf(std::string_view name) const { return std::get<Sdf>(at(name).value); }
    [[nodiscard]] std::vector<Sdf> sdfs(std::string_view name) const;
    [[nodiscard]] std::shared_ptr<const ColorFormula> color(std::string_view name) const;
    [[nodiscard]] const Expression& easing(std::string_view name) const {
        return *std::get<Easing>(at(name).value).expression;
    }

    [[noreturn]] void reject(std::string_view name, std::string_view expected) const;
    [[noreturn]] void reject(std::string_view what) const;

private:
    [[nodiscard]] const Object& at(std::string_view name) const;
    [[nodiscard]] const Object::List& list(std::string_view name) const {
        return *std::get<std::shared_ptr<const Object::List>>(at(name).value);
    }

    const Word& word_;
    std::vector<Object> values_;
};

// Results in the table's types.

inline Object object(double number) { return {number}; }
template <std::size_t n>
Object object(const Vector<n>& vector) {
    Object::List list;
    for (const double number : vector) list.push_back(object(number));
    return {std::make_shared<const Object::List>(std::move(list))};
}
inline Parameter required(std::string_view name, Type type) { return {name, type, std::nullopt}; }
inline Parameter optional(std::string_view name, Type type) { return {name, type, Object{None{}}}; }
inline Parameter several(std::string_view name, Type type) { return {name, type, std::nullopt, true}; }
template <class Default>
Parameter with_default(std::string_view name, Type type, const Default& value) {
    return {name, type, object(value)};
}

// Vectors.

template <std::size_t n>
Vector<n> operator+(Vector<n> a, const Vector<n>& b) {
    for (std::size_t i = 0; i < n; ++i) a[i] += b[i];
    return a;
}

template <std::size_t n>
Vector<n> operator-(Vector<n> a, const Vector<n>& b) {
    for (std::size_t i = 0; i < n; ++i) a[i] -= b[i];
    return a;
}

template <std::size_t n>
Vector<n> operator*(Vector<n> a, double b) {
    for (double& number : a) number *= b;
    return a;
}

template <std::size_t n>
double dot(const Vector<n>& a, const Vector<n>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

template <std::size_t n>
double length(const Vector<n>& a) {
    double sum = 0;
    for (const double number : a) sum = std::hypot(sum, number);
    return sum;
}

inline Vector<3> cross(const Vector<3>& a, const Vector<3>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <std::size_t n>
Vector<n> normalized(const Vector<n>& a) {
    return a * (1 / length(a));
}

// Points.

template <std::size_t n>
Point<n> point(Graph& graph) {
    if constexpr (n == 2) {
        return {graph.x(), graph.y()};
    } else {
        return {graph.x(), graph.y(), graph.z()};
    }
}

template <std::size_t n>
Point<n> operator-(Point<n> p, const Vector<n>& v) {
    for (std::size_t i = 0; i < n; ++i) p[i] = p[i] - v[i];
    return p;
}

template <std::size_t n>
Point<n> abs(Point<n> p) {
    for (Value& value : p) value = abs(value);
    return p;
}

template <std::size_t n>
Point<n> max(Point<n> p, double low) {
    for (Value& value : p) value = max(value, low);
    return p;
}

template <std::size_t n>
Value largest(const Point<n>& p) {
    Value result = p[0];
    for (std::size_t i = 1; i < n; ++i) result = max(result, p[i]);
    return result;
}

template <std::size_t n>
Value length(const Point<n>& p) {
    Value result = hypot(p[0], p[1]);
    for (std::size_t i = 2; i < n; ++i) result = hypot(result, p[i]);
    return result;
}

/// p . v without the axes where v is 0.
template <std::size_t n>
Value dot(const Point<n>& p, const Vector<n>& v) {
    Value sum = p[0].graph->constant(0);
    for (std::size_t i = 0; i < n; ++i) {
        if (v[i] != 0) sum = sum + p[i] * v[i];
    }
    return sum;
}

/// The intersection of two surfaces at right angles, given the signed distances a and b. Equal to min(max(a, b), 0) +
/// hypot(max(a, 0), max(b, 0)), but away from the edge it reduces to a, or b, alone: flat surfaces have linear
/// formulas.
inline Value corner(const Value& a, const Value& b) {
    const Value beyond_b = max(b, 0);
    const Value outside = hypot(max(a, 0), beyond_b);
    const Value inside = max(a, b);
    return piecewise(min(a, b), inside, outside);
}
Value corner(Value&&, Value&&) = delete;  // as in formula/sequenced.h

/// The same for all coordinates of q: a box.
template <std::size_t n>
Value corner(const Point<n>& q) {
    Value result = q[0];
    for (std::size_t i = 1; i < n; ++i) result = corner(result, q[i]);
    return result;
}

/// |v - middle of 0..extent| - half the extent. Negative between 0 and `extent`, outside the distance to the nearer end.
inline Value beyond(Value v, double extent) { return abs(v - extent / 2) - extent / 2; }

// Shapes.

template <std::size_t n>
Object sdf(const Graph& graph, const Colored& made) {
    Sdf result{static_cast<int>(n), std::make_shared<const Expression>(graph.expression(made.distance)), std::nullopt, nullptr};
    if (made.color) result.color = std::make_shared<const ColorFormula>(graph.color_formula(*made.color));
    return {std::move(result)};
}

template <std::size_t n>
Object sdf(const Graph& graph, Value distance) {
    return sdf<n>(graph, Colored{distance});
}

/// A shape at a point.
template <std::size_t n>
Colored at(const Sdf& sdf, const Point<n>& p) {
    Graph& graph = *p[0].graph;
    const Value z = n == 3 ? p[n - 1] : graph.constant(0);
    Colored result{graph.substitute(*sdf.expression, p[0], p[1], z)};
    if (sdf.color) result.color = graph.substitute(*sdf.color, p[0], p[1], z);
    return result;
}

inline Value eased(const Expression& easing, Value t) {
    const Value zero = t.graph->constant(0);
    return t.graph->substitute(easing, t, zero, zero);
}

/// The distance between a and b within which their edge is rounded: the argument k, 0 if omitted.
double smoothness(const Arguments& arguments);

/// The maximum of a and b, rounded where they differ by less than k: the basis of intersections. If only one of the two
/// shapes has a colour, the result has it: the other shape only cuts.
Value smooth_max(Value a, Value b, double k);
Colored smooth_max(const Colored& a, const Colored& b, double k);

}  // namespace bob
