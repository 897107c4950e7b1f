#include "modelling/script_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <type_traits>

namespace bob::script {
namespace {

[[noreturn]] void fail(std::string_view what, const std::string& message) {
    throw CallError((what.empty() ? "" : std::string(what) + ": ") + message);
}

std::string text(double number) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.6g", number);
    return buffer;
}

/// A number or truth value as a number; True is 1, as in Python.
const double* as_number(const Value& value, double& storage) {
    if (const bool* truth = std::get_if<bool>(&value.value)) return storage = *truth, &storage;
    return std::get_if<double>(&value.value);
}

bool is_number(const Value& value) {
    return std::holds_alternative<double>(value.value) || std::holds_alternative<bool>(value.value);
}

double number(std::string_view what, const Value& value) {
    double storage;
    const double* number = as_number(value, storage);
    if (!number) fail(what, "expected a number, got " + describe(value));
    return *number;
}

/// An integer that float64 holds exactly.
double whole(std::string_view what, const Value& value) {
    const double result = number(what, value);
    if (result != std::floor(result) || std::fabs(result) > 0x1p53) {
        fail(what, "expected a whole number, got " + text(result));
    }
    return result;
}

double finite(std::string_view what, double number) {
    if (!std::isfinite(number)) fail(what, "the result is too large or not a real number");
    return number;
}

const std::shared_ptr<const List>* as_list(const Value& value) {
    return std::get_if<std::shared_ptr<const List>>(&value.value);
}

[[noreturn]] void too_long() {
    fail("", "expected at most " + std::to_string(ScriptLimits::items) + " items in a list, got more");
}

// ---- Arithmetic ------------------------------------------------------------------------------------------

std::string_view symbol(Operator op) {
    switch (op) {
        case Operator::add: return "+";
        case Operator::subtract: return "-";
        case Operator::multiply: return "*";
        case Operator::divide: return "/";
        case Operator::floor_divide: return "//";
        case Operator::modulo: return "%";
        case Operator::power: return "**";
        case Operator::unite: return "|";
        case Operator::intersect: return "&";
        case Operator::less: return "<";
        case Operator::less_equal: return "<=";
        case Operator::greater: return ">";
        case Operator::greater_equal: return ">=";
        case Operator::equal: return "==";
        case Operator::not_equal: return "!=";
        case Operator::logical_and: return "and";
        case Operator::logical_or: return "or";
    }
    return "";
}

/// The remainder with the sign of b, as in Python.
double python_modulo(double a, double b) {
    const double remainder = std::fmod(a, b);
    return remainder != 0 && (remainder < 0) != (b < 0) ? remainder + b : remainder;
}

/// The quotient rounded down: a == b * quotient + python_modulo(a, b), as nearly as possible. The plain quotient may
/// round up to the next integer.
double python_floor_divide(double a, double b) { return std::round((a - python_modulo(a, b)) / b); }

double compute(Operator op, double a, double b) {
    const bool divides = op == Operator::divide || op == Operator::floor_divide || op == Operator::modulo;
    if (b == 0 && divides) fail(symbol(op), "division by zero");
    const auto result = [&] {
        switch (op) {
            case Operator::add: return a + b;
            case Operator::subtract: return a - b;
            case Operator::multiply: return a * b;
            case Operator::divide: return a / b;
            case Operator::floor_divide: return python_floor_divide(a, b);
            case Operator::modulo: return python_modulo(a, b);
            default: return std::pow(a, b);
        }
    };
    return finite(symbol(op), result());
}

std::size_t count(const Value& value) { return is_number(value) ? 1 : length("", value); }

/// Element by element; a single number combines with each element of a vector.
Value vector_arithmetic(Operator op, const Value& a, const Value& b) {
    const std::size_t n = count(a), m = count(b);
    if (!is_number(a) && !is_number(b) && n != m) {
        fail(symbol(op), "expected vectors of one length, got " + std::to_string(n) + " and " +
             std::to_string(m) + " numbers");
    }
    const auto at = [&](const Value& value, std::size_t i) {
        return number(symbol(op), is_number(value) ? value : item(value, i));
    };
    std::vector<double> result(is_number(a) ? m : n);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = compute(op, at(a, i), at(b, i));
    return make_vector(std::move(result));
}

Value concatenated(const List& a, const List& b) {
    if (a.size + b.size > ScriptLimits::items) too_long();
    std::vector<Value> items = a.items;
    items.insert(items.end(), b.items.begin(), b.items.end());
    return make_list(std::move(items));
}

Value repeated(const List& list, const Value& times) {
    const double count = std::max(0.0, whole("*", times));
    if (count * static_cast<double>(list.size) > static_cast<double>(ScriptLimits::items)) too_long();
    std::vector<Value> items;
    for (double i = 0; i < count && !list.items.empty(); ++i) {
        items.insert(items.end(), list.items.begin(), list.items.end());
    }
    return make_list(std::move(items));
}

// ---- Functions -------------------------------------------------------------------------------------------

using Name = std::string_view;
using Arguments = std::span<const Value>;

/// A function of real numbers.
template <double (*f)(double)>
Value real(Name name, Arguments arguments) {
    return {finite(name, f(number(name, arguments[0])))};
}

template <double (*f)(double, double)>
Value real(Name name, Arguments arguments) {
    return {finite(name, f(number(name, arguments[0]), number(name, arguments[1])))};
}

Value absolute(Name name, Arguments arguments) {
    if (!std::holds_alternative<Vector>(arguments[0].value)) return {std::fabs(number(name, arguments[0]))};
    std::vector<double> result = *std::get<Vector>(arguments[0].value).numbers;
    for (double& x : result) x = std::fabs(x);
    return make_vector(std::move(result));
}

bool less(double a, double b) { return a < b; }
bool greater(double a, double b) { return a > b; }

/// The first of the arguments, or of the items of a single list, that precedes all others.
template <bool (*before)(double, double)>
Value first(Name name, Arguments arguments) {
    const bool items = arguments.size() == 1;
    const std::size_t n = items ? length(name, arguments[0]) : arguments.size();
    if (n == 0) fail(name, "expected at least one number, got an empty list");
    double best = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = number(name, items ? item(arguments[0], i) : arguments[i]);
        if (i == 0 || before(x, best)) best = x;
    }
    return {best};
}

Value sum(Name name, Arguments arguments) {
    Value total{0.0};
    for (std::size_t i = 0, n = length(name, arguments[0]); i < n; ++i) {
        total = arithmetic(Operator::add, total, item(arguments[0], i));
    }
    return total;
}

/// Halves go to even; with digits, the exact value of the float64 is rounded.
Value round(Name name, Arguments arguments) {
    const double x = number(name, arguments[0]);
    if (arguments.size() == 1) return {std::nearbyint(x)};
    const double digits = whole(name, arguments[1]);
    if (digits < 0 || digits > 400) fail(name, "expected 0 to 400 digits, got " + text(digits));
    char buffer[800];
    const auto [end, error] =
        std::to_chars(buffer, buffer + sizeof buffer, x, std::chars_format::fixed, static_cast<int>(digits));
    double result = x;
    if (error == std::errc()) std::from_chars(buffer, end, result);
    return {result};
}

Value length_of(Name name, Arguments arguments) { return {static_cast<double>(length(name, arguments[0]))}; }

Value range(Name name, Arguments arguments) {
    const double start = arguments.size() > 1 ? whole(name, arguments[0]) : 0;
    const double stop = whole(name, arguments[arguments.size() > 1 ? 1 : 0]);
    const double step = arguments.size() > 2 ? whole(name, arguments[2]) : 1;
    if (step == 0) fail(name, "expected a step other than 0");
    const double count = std::max(0.0, std::ceil((stop - start) / step));
    if (count > static_cast<double>(ScriptLimits::items)) too_long();
    std::vector<Value> items;
    for (double i = 0; i < count; ++i) items.push_back({start + i * step});
    return make_list(std::move(items));
}

Value enumerate(Name name, Arguments arguments) {
    const double start = arguments.size() > 1 ? whole(name, arguments[1]) : 0;
    std::vector<Value> pairs;
    for (std::size_t i = 0, n = length(name, arguments[0]); i < n; ++i) {
        pairs.push_back(make_list({Value{start + static_cast<double>(i)}, item(arguments[0], i)}));
    }
    return make_list(std::move(pairs));
}

constexpr Function functions[] = {
    {"abs", 1, 1, absolute},
    {"acos", 1, 1, real<[](double x) { return std::acos(x); }>},
    {"asin", 1, 1, real<[](double x) { return std::asin(x); }>},
    {"atan", 1, 1, real<[](double x) { return std::atan(x); }>},
    {"atan2", 2, 2, real<[](double y, double x) { return std::atan2(y, x); }>},
    {"ceil", 1, 1, real<[](double x) { return std::ceil(x); }>},
    {"cos", 1, 1, real<[](double x) { return std::cos(x); }>},
    {"degrees", 1, 1, real<[](double x) { return x * (180 / std::numbers::pi); }>},
    {"enumerate", 1, 2, enumerate},
    {"exp", 1, 1, real<[](double x) { return std::exp(x); }>},
    {"float", 1, 1, real<[](double x) { return x; }>},
    {"floor", 1, 1, real<[](double x) { return std::floor(x); }>},
    {"int", 1, 1, real<[](double x) { return std::trunc(x); }>},
    {"len", 1, 1, length_of},
    {"log", 1, 1, real<[](double x) { return std::log(x); }>},
    {"max", 1, ScriptLimits::items, first<greater>},
    {"min", 1, ScriptLimits::items, first<less>},
    {"radians", 1, 1, real<[](double x) { return x * (std::numbers::pi / 180); }>},
    {"range", 1, 3, range},
    {"round", 1, 2, round},
    {"sin", 1, 1, real<[](double x) { return std::sin(x); }>},
    {"sqrt", 1, 1, real<[](double x) { return std::sqrt(x); }>},
    {"sum", 1, 1, sum},
    {"tan", 1, 1, real<[](double x) { return std::tan(x); }>},
};

}  // namespace

const Function* find_function(std::string_view name) {
    const auto found = std::ranges::find(functions, name, &Function::name);
    return found == std::end(functions) ? nullptr : &*found;
}

std::span<const Constant> constants() {
    static const Constant all[] = {
        {"pi", {std::numbers::pi}},       {"X", make_vector({1, 0, 0})},      {"Y", make_vector({0, 1, 0})},
        {"Z", make_vector({0, 0, 1})},    {"UP", make_vector({0, 0, 1})},     {"ORIGIN", make_vector({0, 0, 0})},
    };
    return all;
}

// ---- Values ----------------------------------------------------------------------------------------------

Value make_list(std::vector<Value> items) {
    List list{std::move(items), 1, 0};
    for (const Value& each : list.items) {
        list.size += std::max<std::size_t>(1, size(each));
        if (list.size > ScriptLimits::items) too_long();
        if (const auto* inner = as_list(each)) list.depth = std::max(list.depth, (*inner)->depth + 1);
    }
    if (list.depth > ScriptLimits::depth) fail("", "expected less nesting of lists");
    return {std::make_shared<const List>(std::move(list))};
}

Value make_vector(std::vector<double> numbers) {
    return {Vector{std::make_shared<const std::vector<double>>(std::move(numbers))}};
}

std::size_t size(const Value& value) {
    if (const auto* list = as_list(value)) return (*list)->size;
    if (const auto* vector = std::get_if<Vector>(&value.value)) return vector->numbers->size();
    if (const auto* string = std::get_if<std::string_view>(&value.value)) return string->size();
    return 1;
}

Object to_object(const Value& value) {
    const auto convert = [](const auto& held) -> Object {
        using T = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<T, std::string_view>) {
            return {std::string(held)};
        } else if constexpr (std::is_same_v<T, Vector>) {
            Object::List list(held.numbers->size());
            for (std::size_t i = 0; i < list.size(); ++i) list[i].value = (*held.numbers)[i] + 0.0;
            return {std::make_shared<const Object::List>(std::move(list))};
        } else if constexpr (std::is_same_v<T, std::shared_ptr<const List>>) {
            Object::List list;
            for (const Value& each : held->items) list.push_back(to_object(each));
            return {std::make_shared<const Object::List>(std::move(list))};
        } else if constexpr (std::is_same_v<T, double>) {
            return {held + 0.0};  // removes the sign of zeros: Python's integers have no signed zero
        } else {
            return {held};
        }
    };
    return std::visit(convert, value.value);
}

Value from_object(const Object& object) {
    const auto convert = [](const auto& held) -> Value {
        using T = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, Color>) {
            return {};  // no word returns colours or texts, and values only refer to the script's
        } else if constexpr (std::is_same_v<T, std::shared_ptr<const Object::List>>) {
            std::vector<Value> items;
            for (const Object& each : *held) items.push_back(from_object(each));
            return make_list(std::move(items));
        } else {
            return {held};
        }
    };
    return std::visit(convert, object.value);
}

std::string describe(const Value& value) {
    if (const auto* vector = std::get_if<Vector>(&value.value)) {
        return "a vector of " + std::to_string(vector->numbers->size()) + " numbers";
    }
    if (const auto* list = as_list(value)) return "a list of " + std::to_string((*list)->items.size());
    if (std::holds_alternative<std::string_view>(value.value)) return "a string";
    return describe(to_object(value));
}

bool truth(const Value& value) {
    double storage;
    if (const double* number = as_number(value, storage)) return *number != 0;
    if (std::holds_alternative<None>(value.value)) return false;
    if (std::holds_alternative<std::string_view>(value.value) || as_list(value)) return size(value) > 0;
    fail("", "expected something true or false, got " + describe(value));
}

Value arithmetic(Operator op, const Value& a, const Value& b) {
    if (is_number(a) && is_number(b)) return {compute(op, number("", a), number("", b))};
    const auto vector_or = [](const Value& v, bool other) { return std::holds_alternative<Vector>(v.value) || other; };
    const bool some_vector = vector_or(a, vector_or(b, false));
    const auto fits = [&](const Value& v) { return vector_or(v, is_number(v) || as_list(v)); };
    if (some_vector && fits(a) && fits(b)) return vector_arithmetic(op, a, b);
    const auto *first = as_list(a), *second = as_list(b);
    if (op == Operator::add && first && second) return concatenated(**first, **second);
    if (op == Operator::multiply && first && is_number(b)) return repeated(**first, b);
    if (op == Operator::multiply && second && is_number(a)) return repeated(**second, a);
    const bool lists = first || second;
    fail(symbol(op), "expected numbers or vectors, got " + describe(a) + " and " + describe(b) +
         (lists ? "; X, Y and Z make vectors, as in 2 * X + Z" : ""));
}

Value negative(const Value& a) {
    if (!is_number(a) && !std::holds_alternative<Vector>(a.value)) {
        fail("-", "expected a number or a vector, got " + describe(a));
    }
    return arithmetic(Operator::multiply, a, {-1.0});
}

bool compare(Operator op, const Value& a, const Value& b) {
    if (is_number(a) && is_number(b)) {
        const double x = number("", a), y = number("", b);
        switch (op) {
            case Operator::less: return x < y;
            case Operator::less_equal: return x <= y;
            case Operator::greater: return x > y;
            case Operator::greater_equal: return x >= y;
            case Operator::equal: return x == y;
            default: return x != y;
        }
    }
    const bool none = std::holds_alternative<None>(a.value) || std::holds_alternative<None>(b.value);
    if (none && (op == Operator::equal || op == Operator::not_equal)) {
        return (a.value.index() == b.value.index()) == (op == Operator::equal);
    }
    fail(symbol(op), "expected numbers, got " + describe(a) + " and " + describe(b));
}

std::size_t length(std::string_view what, const Value& value) {
    if (const auto* list = as_list(value)) return (*list)->items.size();
    if (const auto* vector = std::get_if<Vector>(&value.value)) return vector->numbers->size();
    fail(what, "expected a list, got " + describe(value));
}

Value item(const Value& value, std::size_t index) {
    if (const auto* list = as_list(value)) return (*list)->items[index];
    return {(*std::get<Vector>(value.value).numbers)[index]};
}

Value element(const Value& list, const Value& index) {
    const auto n = static_cast<double>(length("[]", list));
    const double i = whole("[]", index);
    if (i < -n || i >= n) fail("[]", "expected an index in " + text(-n) + ".." + text(n - 1) + ", got " + text(i));
    return item(list, static_cast<std::size_t>(i < 0 ? i + n : i));
}

}  // namespace bob::script
