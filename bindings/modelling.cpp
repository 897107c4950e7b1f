/// The modelling language: its words as data, and calls with Python values.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.h"
#include "modelling/region.h"
#include "modelling/vocabulary.h"

using namespace nb::literals;

namespace {

using bob::Object;

constexpr int max_depth = 4;  // of nested lists

double to_double(nb::handle value) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1 && PyErr_Occurred()) {
        if (!PyErr_ExceptionMatches(PyExc_OverflowError)) throw nb::python_error();
        PyErr_Clear();
        return std::numeric_limits<double>::infinity();
    }
    return number + 0.0;  // removes the sign of zeros: Python's integers have no -0
}

std::string unusable(nb::handle value) {
    const auto type = nb::cast<std::string>(value.type().attr("__name__"));
    return "expected a number, a vector, a shape or an easing function, got " + type;
}

Object to_object(nb::handle value, int depth = 0) {
    if (value.is_none()) return {bob::None{}};
    if (nb::isinstance<nb::bool_>(value)) return {value.is(nb::handle(Py_True))};
    if (nb::isinstance<bob::Sdf>(value)) return {nb::cast<const bob::Sdf&>(value)};
    if (nb::isinstance<bob::Easing>(value)) return {nb::cast<const bob::Easing&>(value)};
    if (nb::isinstance<bob::ColorFormula>(value)) {
        return {bob::Color{std::make_shared<const bob::ColorFormula>(nb::cast<const bob::ColorFormula&>(value))}};
    }
    if (nb::isinstance<nb::str>(value)) return {nb::cast<std::string>(value)};
    if (nb::isinstance<nb::float_>(value) || nb::isinstance<nb::int_>(value)) return {to_double(value)};
    const bool list = nb::hasattr(value, "__len__") && nb::hasattr(value, "__getitem__") && !nb::isinstance<nb::dict>(value);
    const bool no_axes = nb::hasattr(value, "ndim") && nb::cast<int>(value.attr("ndim")) == 0;
    if (list && !no_axes && depth < max_depth) {
        Object::List items;
        for (const nb::handle item : nb::iter(value)) items.push_back(to_object(item, depth + 1));
        return {std::make_shared<const Object::List>(std::move(items))};
    }
    if (nb::hasattr(value, "__float__")) return {to_double(value)};
    throw bob::CallTypeError(unusable(value));
}

nb::object to_python(const Object& object) {
    return std::visit([](const auto& value) -> nb::object {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, bob::None>) {
            return nb::none();
        } else if constexpr (std::is_same_v<T, std::shared_ptr<const Object::List>>) {
            nb::list items;
            for (const Object& item : *value) items.append(to_python(item));
            return nb::tuple(items);
        } else if constexpr (std::is_same_v<T, bob::Color>) {
            return nb::cast(*value.formula);
        } else {
            return nb::cast(value);
        }
    }, object.value);
}

const char* type_name(bob::Type type) {
    switch (type) {
        case bob::Type::number: return "number";
        case bob::Type::integer: return "integer";
        case bob::Type::vector: return "vector";
        case bob::Type::size: return "size";
        case bob::Type::numbers: return "numbers";
        case bob::Type::points: return "points";
        case bob::Type::easing: return "easing";
        case bob::Type::color: return "color";
        case bob::Type::sdf: return "sdf";
    }
    return "";
}

const char* kind_name(bob::Word::Kind kind) {
    switch (kind) {
        case bob::Word::Kind::shape: return "shape";
        case bob::Word::Kind::operation: return "operation";
        case bob::Word::Kind::easing: return "easing";
    }
    return "";
}

/// The default of an easing, always ease.linear, is left out.
nb::typed<nb::list, AnyTuple> vocabulary() {
    nb::list words;
    for (const bob::Word& word : bob::vocabulary()) {
        nb::list parameters;
        for (const bob::Parameter& p : word.parameters) {
            const bool required = !p.default_value && !p.variadic;
            const bool stated = p.default_value && p.type != bob::Type::easing;
            const nb::object value = stated ? to_python(*p.default_value) : nb::none();
            parameters.append(nb::make_tuple(p.name, type_name(p.type), required, value, p.variadic));
        }
        words.append(nb::make_tuple(word.name, kind_name(word.kind), word.dimensions, word.result_dimensions,
                                    nb::tuple(parameters), word.meaning));
    }
    return words;
}

struct Call {
    std::vector<Object> positional;
    std::vector<bob::Keyword> keywords;

    /// `names`: of the positional arguments, for messages.
    Call(std::string_view word, const std::vector<bob::Parameter>& names, const AnyTuple& args, const Keywords& kwargs) {
        const auto convert = [&](std::string_view name, nb::handle value) {
            const std::string place = std::string(word) + ": " + std::string(name) + ": ";
            try {
                return to_object(value);
            } catch (const bob::CallTypeError& error) {
                throw bob::CallTypeError(place + error.what());
            } catch (const nb::python_error& error) {  // from the value's methods
                if (!error.matches(PyExc_Exception)) throw;
            } catch (const std::bad_cast&) {  // for a text with an unpaired surrogate
            }
            throw bob::CallTypeError(place + unusable(value));
        };
        for (const nb::handle value : args) {
            const std::size_t place = std::min(positional.size(), names.empty() ? 0 : names.size() - 1);
            positional.push_back(convert(names.empty() ? "argument" : names[place].name, value));
        }
        for (const auto& [key, value] : kwargs) {
            const auto name = nb::cast<std::string>(key);
            keywords.emplace_back(name, convert(name, value));
        }
    }
};

AnyObject call(std::size_t index, const AnyTuple& args, const Keywords& kwargs) {
    const auto words = bob::vocabulary();
    expect(index < words.size(), "index: expected that of a word");
    const Call call(words[index].name, words[index].parameters, args, kwargs);
    return to_python(bob::call(words[index], call.positional, call.keywords));
}

AnyObject call_method(const bob::Sdf& sdf, std::string_view name, const AnyTuple& args, const Keywords& kwargs) {
    const Call call(name, {}, args, kwargs);
    return to_python(bob::call_method(sdf, name, call.positional, call.keywords));
}

/// Rows of x, y and the bulge of the piece to the next row's place. The last row leads to the first.
using Outline = Array<const double, -1, 3>;

std::optional<bob::Expression> region(const std::vector<Outline>& outlines) {
    std::vector<bob::Loop> loops;
    for (const Outline& outline : outlines) {
        const auto rows = items<std::array<double, 3>>(outline);
        bob::Loop& loop = loops.emplace_back();
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto& [x, y, bulge] = rows[i];
            const std::array<double, 3>& next = rows[i + 1 < rows.size() ? i + 1 : 0];
            if (x != next[0] || y != next[1]) loop.push_back({{x, y}, {next[0], next[1]}, bulge});
        }
    }
    std::optional<bob::Expression> result;
    interruptible([&] {
        bob::Graph graph;
        const std::optional<bob::Value> distance = bob::region(graph, loops, bob::Winding::nonzero);
        if (distance) result = graph.expression(*distance);
    });
    return result;
}

void init_model(bob::Sdf* self, int dimensions, const bob::Expression& expression, std::optional<double> k,
                const bob::ColorFormula* color) {
    new (self) bob::Sdf{dimensions, std::make_shared<const bob::Expression>(expression), k,
                        color ? std::make_shared<const bob::ColorFormula>(*color) : nullptr};
}

void init_easing(bob::Easing* self, const bob::Expression& expression) {
    new (self) bob::Easing{std::make_shared<const bob::Expression>(expression)};
}

}  // namespace

void bind_modelling(nb::module_& m) {
    nb::exception<bob::CallError>(m, "CallError", PyExc_ValueError);
    nb::exception<bob::CallTypeError>(m, "CallTypeError", PyExc_TypeError);

    nb::class_<bob::Sdf>(m, "Sdf", "A shape of the modelling language, of 2 or 3 dimensions; k is set by `.k()`.")
        .def("__init__", &init_model, "dimensions"_a, "expression"_a, "k"_a = nb::none(), "color"_a.none() = nb::none())
        .def_ro("dimensions", &bob::Sdf::dimensions)
        .def_prop_ro("expression", [](const bob::Sdf& sdf) { return *sdf.expression; }, nb::rv_policy::move)
        .def_ro("k", &bob::Sdf::k)
        .def_prop_ro("color", [](const bob::Sdf& sdf) { return sdf.color ? std::optional(*sdf.color) : std::nullopt; },
                     nb::rv_policy::move);
    nb::class_<bob::Easing>(m, "Easing", "A function of t, an expression in x.")
        .def("__init__", &init_easing, "expression"_a)
        .def_prop_ro("expression", [](const bob::Easing& easing) { return *easing.expression; }, nb::rv_policy::move);

    m.def("vocabulary", &vocabulary,
          "(name, kind, dimensions, result dimensions, parameters, meaning) of each word.\n\n"
          "A parameter is (name, type, required, default, variadic).");
    m.def("call", &call, "index"_a, "args"_a, "kwargs"_a,
          "Calls a word of the vocabulary. Raises CallError, CallTypeError or TooLargeError.");
    m.def("call_method", &call_method, "sdf"_a, "name"_a, "args"_a, "kwargs"_a);
    m.def("combine", [](char op, const bob::Sdf& a, const bob::Sdf& b) -> AnyObject { return to_python({bob::combine(op, a, b)}); },
          "op"_a, "a"_a, "b"_a, "Union \"|\", intersection \"&\" or difference \"-\".");
    m.def("region", &region, "outlines"_a,
          "The signed distance in x and y from what closed outlines wind around; None where that is nothing.\n\n"
          "An outline is (n, 3): x, y and the bulge of the piece from there to the next row's place, from the last to the first: the "
          "tangent of a quarter of an arc's angle, positive anticlockwise, 0 of a straight line. TooLargeError where the formula grows "
          "too large.");
}
