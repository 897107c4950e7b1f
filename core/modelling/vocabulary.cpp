#include "modelling/vocabulary.h"

#include <algorithm>
#include <cstdio>

#include "base/color.h"
#include "modelling/words.h"

namespace bob {
namespace {

using List = Object::List;
using ListPointer = std::shared_ptr<const List>;

std::string text(double number) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%g", number);
    return buffer;
}

/// The value itself if it is short, else its description.
std::string value_text(const Object& object) {
    if (const double* number = std::get_if<double>(&object.value)) return text(*number);
    if (const std::string* string = std::get_if<std::string>(&object.value)) {
        const bool plain = std::all_of(string->begin(), string->end(), [](char c) { return c >= ' ' && c <= '~'; });
        return plain && string->size() <= 20 ? '"' + *string + '"' : describe(object);
    }
    const ListPointer* list = std::get_if<ListPointer>(&object.value);
    if (!list || (*list)->size() > 4) return describe(object);
    std::string result = "(";
    for (const Object& item : **list) result += (result.size() > 1 ? ", " : "") + value_text(item);
    return result + ")";
}

bool is_number(const Object& object) { return std::holds_alternative<double>(object.value); }

bool is_numbers(const Object& object) {
    const ListPointer* list = std::get_if<ListPointer>(&object.value);
    return list && std::all_of((*list)->begin(), (*list)->end(), is_number);
}

bool is_vector(const Object& object, int dimensions) {
    return is_numbers(object) && std::get<ListPointer>(object.value)->size() == static_cast<std::size_t>(dimensions);
}

bool has_type(const Object& object, Type type, int dimensions) {
    switch (type) {
        case Type::number:
        case Type::integer: return is_number(object);
        case Type::vector: return is_vector(object, dimensions);
        case Type::size: return is_number(object) || is_vector(object, dimensions);
        case Type::numbers: return is_number(object) || is_numbers(object);
        case Type::points: {
            const ListPointer* list = std::get_if<ListPointer>(&object.value);
            const auto is_point = [&](const Object& item) { return is_vector(item, dimensions); };
            return list && std::all_of((*list)->begin(), (*list)->end(), is_point);
        }
        case Type::easing: return std::holds_alternative<Easing>(object.value);
        case Type::color:
            return std::holds_alternative<Color>(object.value) || std::holds_alternative<std::string>(object.value) ||
                   is_vector(object, 3);
        case Type::sdf: {
            const Sdf* sdf = std::get_if<Sdf>(&object.value);
            return sdf && sdf->dimensions == dimensions;
        }
    }
    return false;
}

std::string expected(Type type, int dimensions) {
    const std::string d = std::to_string(dimensions) + "D ";
    switch (type) {
        case Type::number: return "a number";
        case Type::integer: return "a whole number";
        case Type::vector: return "a " + d + "vector";
        case Type::size: return "a number or a " + d + "vector";
        case Type::numbers: return "a number or a list of numbers";
        case Type::points: return "a list of " + d + "points";
        case Type::easing: return "an easing function";
        case Type::color: return "#rrggbb, a CSS name or 3 numbers";
        case Type::sdf: return "a " + d + "shape";
    }
    return "";
}

bool is_finite(const Object& object) {
    if (const double* number = std::get_if<double>(&object.value)) return std::isfinite(*number);
    const ListPointer* list = std::get_if<ListPointer>(&object.value);
    return !list || std::all_of((*list)->begin(), (*list)->end(), is_finite);
}

bool is_none(const Object& object) { return std::holds_alternative<None>(object.value); }

std::string place(const Word& word, const Parameter& parameter) {
    return std::string(word.name) + ": " + std::string(parameter.name) + ": ";
}

void check(const Word& word, const Parameter& parameter, const Object& object) {
    if (is_none(object) && parameter.default_value && is_none(*parameter.default_value)) return;
    if (!has_type(object, parameter.type, word.dimensions)) {
        const std::string want = expected(parameter.type, word.dimensions);
        throw CallTypeError(place(word, parameter) + "expected " + want + ", got " + describe(object));
    }
    if (!is_finite(object)) {
        throw CallError(place(word, parameter) + "expected finite numbers, got " + value_text(object));
    }
    const double* number = std::get_if<double>(&object.value);
    if (parameter.type == Type::integer && *number != std::floor(*number)) {
        throw CallError(place(word, parameter) + "expected a whole number, got " + text(*number));
    }
}

/// Removes the colours of all shapes in a list, and returns whether there were any.
bool without_colors(std::vector<Object>& values) {
    bool found = false;
    for (Object& value : values) {
        if (Sdf* sdf = std::get_if<Sdf>(&value.value)) {
            found |= sdf->color != nullptr;
            sdf->color = nullptr;
        } else if (const ListPointer* list = std::get_if<ListPointer>(&value.value)) {
            List items = **list;
            if (!without_colors(items)) continue;
            found = true;
            value.value = std::make_shared<const List>(std::move(items));
        }
    }
    return found;
}

std::string names(const Word& word) {
    std::string result;
    for (const Parameter& parameter : word.parameters) {
        result += (result.empty() ? "" : ", ") + std::string(parameter.variadic ? "*" : "") + std::string(parameter.name);
    }
    return result.empty() ? "none" : result;
}

/// The arguments in the order of the parameters, bound as in Python and checked.
std::vector<Object> bind(const Word& word, std::span<const Object> positional, std::span<const Keyword> keywords) {
    const std::vector<Parameter>& parameters = word.parameters;
    std::vector<std::optional<Object>> values(parameters.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < parameters.size() && !parameters[i].variadic; ++i) {
        if (next < positional.size()) values[i] = positional[next++];
    }
    const auto variadic = std::find_if(parameters.begin(), parameters.end(), [](const auto& p) { return p.variadic; });
    if (variadic != parameters.end()) {
        List rest(positional.begin() + static_cast<std::ptrdiff_t>(next), positional.end());
        for (const Object& item : rest) check(word, *variadic, item);
        values[static_cast<std::size_t>(variadic - parameters.begin())] = {std::make_shared<const List>(std::move(rest))};
    } else if (next < positional.size()) {
        throw CallTypeError(std::string(word.name) + ": expected at most " + std::to_string(parameters.size()) +
                            " arguments (" + names(word) + "), got " + std::to_string(positional.size()));
    }
    for (const auto& [name, object] : keywords) {
        const auto is_it = [&](const Parameter& p) { return p.name == name && !p.variadic; };
        const auto parameter = std::find_if(parameters.begin(), parameters.end(), is_it);
        if (parameter == parameters.end()) {
            throw CallTypeError(std::string(word.name) + ": expected an argument named one of " + names(word) +
                                ", got " + name);
        }
        auto& value = values[static_cast<std::size_t>(parameter - parameters.begin())];
        if (value) throw CallTypeError(place(word, *parameter) + "expected one argument, got two");
        value = object;
    }
    std::vector<Object> bound;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        const Parameter& parameter = parameters[i];
        if (!values[i] && !parameter.default_value) {
            const std::string want = expected(parameter.type, word.dimensions);
            throw CallTypeError(place(word, parameter) + "expected " + want + ", got nothing");
        }
        bound.push_back(values[i] ? *values[i] : *parameter.default_value);
        if (!parameter.variadic) check(word, parameter, bound.back());
    }
    return bound;
}

/// The operation of the same name for the first argument's dimensions, if there is one: `union` has both.
const Word& suited(const Word& word, std::span<const Object> positional) {
    if (word.kind != Word::Kind::operation || positional.empty()) return word;
    const Sdf* sdf = std::get_if<Sdf>(&positional.front().value);
    if (!sdf || sdf->dimensions == word.dimensions) return word;
    const Word* other = find_word(word.name, sdf->dimensions);
    return other ? *other : word;
}

}  // namespace

std::span<const Word> vocabulary() {
    static const std::vector<Word> words = [] {
        std::vector<Word> all;
        add_shapes_3d(all);
        add_shapes_2d(all);
        add_operations(all);
        add_easings(all);
        return all;
    }();
    return words;
}

const Word* find_word(std::string_view name, int dimensions) {
    const Word* found = nullptr;
    for (const Word& word : vocabulary()) {
        if (word.name != name) continue;
        if (word.dimensions == dimensions) return &word;
        if (dimensions == 0 && (!found || word.dimensions > found->dimensions)) found = &word;
    }
    return found;
}

Object call(const Word& word, std::span<const Object> positional, std::span<const Keyword> keywords) {
    const Word& callee = suited(word, positional);
    try {
        std::vector<Object> values = bind(callee, positional, keywords);
        const std::vector<Object> colored = values;
        if (!without_colors(values)) return callee.call(Arguments(callee, std::move(values)));
        // Colours share nodes with distances, which would change the numbering of these.
        Object result = callee.call(Arguments(callee, std::move(values)));
        std::get<Sdf>(result.value).color = std::get<Sdf>(callee.call(Arguments(callee, colored)).value).color;
        return result;
    } catch (const std::invalid_argument&) {  // a constant that became NaN, such as the difference of two that overflowed
        throw CallError(std::string(callee.name) + ": expected numbers small enough to compute with, got too large ones");
    }
}

Object call_method(const Sdf& sdf, std::string_view name, std::span<const Object> positional,
                   std::span<const Keyword> keywords) {
    if (name == "k") {
        // Not an operation: it sets how the next one treats this shape.
        static const Word set_k{"shape.k", Word::Kind::operation, 0, 0, {optional("k", Type::number)}, "", nullptr};
        const Arguments arguments(set_k, bind(set_k, positional, keywords));
        Sdf result = sdf;
        result.k = arguments.has("k") ? std::optional(arguments.at_least(0, "k")) : std::nullopt;
        return {result};
    }
    const Word* word = find_word(name, sdf.dimensions);
    if (!word || word->kind != Word::Kind::operation) {
        throw CallTypeError(describe({sdf}) + " has no method " + std::string(name));
    }
    std::vector<Object> with_sdf{{sdf}};
    with_sdf.insert(with_sdf.end(), positional.begin(), positional.end());
    return call(*word, with_sdf, keywords);
}

Object combine(char op, const Sdf& a, const Sdf& b) {
    const std::string_view name = op == '|' ? "union" : op == '&' ? "intersection" : "difference";
    return call_method(a, name, std::vector<Object>{{b}}, {});
}

std::string describe(const Object& object) {
    if (is_none(object)) return "None";
    if (const bool* truth = std::get_if<bool>(&object.value)) return *truth ? "True" : "False";
    if (is_number(object)) return "a number";
    if (std::holds_alternative<std::string>(object.value)) return "a string";
    if (const Sdf* sdf = std::get_if<Sdf>(&object.value)) {
        return "a " + std::to_string(sdf->dimensions) + "D shape";
    }
    if (std::holds_alternative<Easing>(object.value)) return "an easing function";
    if (std::holds_alternative<Color>(object.value)) return "a colour";
    const std::string count = std::to_string(std::get<ListPointer>(object.value)->size());
    return "a list of " + count + (is_numbers(object) && count != "0" ? " numbers" : "");
}

// Arguments.

const Object& Arguments::at(std::string_view name) const {
    for (std::size_t i = 0; i < values_.size(); ++i) {
        if (word_.parameters[i].name == name) return values_[i];
    }
    throw std::logic_error(std::string(word_.name) + " has no parameter " + std::string(name));
}

void Arguments::reject(std::string_view name, std::string_view expected) const {
    reject(std::string(name) + ": expected " + std::string(expected) + ", got " + value_text(at(name)));
}

void Arguments::reject(std::string_view what) const {
    throw CallError(std::string(word_.name) + ": " + std::string(what));
}

double Arguments::at_least(double low, std::string_view name) const {
    if (!(number(name) >= low)) reject(name, "a number of at least " + text(low));
    return number(name);
}

double Arguments::nonzero(std::string_view name) const {
    if (number(name) == 0) reject(name, "a number other than 0");
    return number(name);
}

int Arguments::whole(int low, int high, std::string_view name) const {
    if (!(number(name) >= low && number(name) <= high)) {
        reject(name, "a whole number in " + std::to_string(low) + ".." + std::to_string(high));
    }
    return static_cast<int>(number(name));
}

std::optional<double> Arguments::optional(std::string_view name) const {
    return has(name) ? std::optional(number(name)) : std::nullopt;
}

template <std::size_t n>
Vector<n> Arguments::vector(std::string_view name) const {
    Vector<n> result;
    for (std::size_t i = 0; i < n; ++i) result[i] = std::get<double>(list(name)[i].value);
    return result;
}

template <std::size_t n>
Vector<n> Arguments::size(std::string_view name) const {
    if (const double* number = std::get_if<double>(&at(name).value)) {
        Vector<n> result;
        result.fill(*number);
        return result;
    }
    if (list(name).size() != n) reject(name, "a number or " + std::to_string(n) + " numbers");
    return vector<n>(name);
}

template <std::size_t n>
Vector<n> Arguments::nonzero_size(std::string_view name) const {
    const Vector<n> result = size<n>(name);
    if (std::count(result.begin(), result.end(), 0)) reject(name, "numbers other than 0");
    return result;
}

template <std::size_t n>
Vector<n> Arguments::direction(std::string_view name) const {
    Vector<n> result = vector<n>(name);
    // Scaled first, so that very long and very short vectors have correct lengths.
    double largest = 0;
    for (const double number : result) largest = std::max(largest, std::fabs(number));
    if (largest == 0) reject(name, "a vector of a length above 0");
    for (double& number : result) number /= largest;
    return normalized(result);
}

template <std::size_t n>
std::vector<Vector<n>> Arguments::points(std::string_view name) const {
    std::vector<Vector<n>> result;
    for (const Object& item : list(name)) {
        const List& numbers = *std::get<ListPointer>(item.value);
        Vector<n>& point = result.emplace_back();
        for (std::size_t i = 0; i < n; ++i) point[i] = std::get<double>(numbers[i].value);
    }
    return result;
}

std::shared_ptr<const ColorFormula> Arguments::color(std::string_view name) const {
    const Object& object = at(name);
    if (const Color* color = std::get_if<Color>(&object.value)) return color->formula;
    if (const std::string* string = std::get_if<std::string>(&object.value)) {
        const auto rgb = linear_color(*string);
        if (!rgb) reject(name, "#rrggbb, a CSS name or 3 numbers");
        return std::make_shared<const ColorFormula>(*rgb);
    }
    const Vector<3> rgb = vector<3>(name);
    if (!std::all_of(rgb.begin(), rgb.end(), [](double c) { return c >= 0 && c <= 1; })) reject(name, "numbers in 0..1");
    return std::make_shared<const ColorFormula>(rgb);
}

std::vector<Sdf> Arguments::sdfs(std::string_view name) const {
    std::vector<Sdf> result;
    for (const Object& item : list(name)) result.push_back(std::get<Sdf>(item.value));
    return result;
}

template Vector<2> Arguments::vector<2>(std::string_view) const;
template Vector<3> Arguments::vector<3>(std::string_view) const;
template Vector<2> Arguments::size<2>(std::string_view) const;
template Vector<3> Arguments::size<3>(std::string_view) const;
template Vector<4> Arguments::size<4>(std::string_view) const;
template Vector<2> Arguments::nonzero_size<2>(std::string_view) const;
template Vector<3> Arguments::nonzero_size<3>(std::string_view) const;
template Vector<2> Arguments::direction<2>(std::string_view) const;
template Vector<3> Arguments::direction<3>(std::string_view) const;
template std::vector<Vector<2>> Arguments::points<2>(std::string_view) const;

}  // namespace bob
