#include "modelling/vocabulary.h"

#include <set>
#include <string>
#include <utility>

#include "check.h"

namespace {

using bob::Keyword;
using bob::Object;
using bob::Type;
using bob::Word;

Object list(std::vector<Object> items) { return {std::make_shared<const Object::List>(std::move(items))}; }

Object number(double value) { return {value}; }

/// The message of the CallError that a call throws, or "" without an error.
std::string refusal(std::string_view name, const std::vector<Object>& positional, const std::vector<Keyword>& keywords = {}) {
    try {
        static_cast<void>(bob::call(*bob::find_word(name, 0), positional, keywords));
    } catch (const bob::CallError& error) {
        return error.what();
    }
    return "";
}

void check_says(const std::string& said, const std::string& expected) {
    if (said != expected) test::fail(__FILE__, __LINE__, "expected \"" + expected + "\", got \"" + said + "\"");
}

bob::Sdf made(std::string_view name, const std::vector<Object>& positional = {}, int dimensions = 0) {
    return std::get<bob::Sdf>(bob::call(*bob::find_word(name, dimensions), positional, {}).value);
}

bool fits(const Object& object, Type type, int dimensions) {
    const auto* items = std::get_if<std::shared_ptr<const Object::List>>(&object.value);
    const bool is_number = std::holds_alternative<double>(object.value);
    const bool is_vector = items && (*items)->size() == static_cast<std::size_t>(dimensions);
    switch (type) {
        case Type::number:
        case Type::integer:
        case Type::numbers: return is_number;
        case Type::vector: return is_vector;
        case Type::size: return is_number || is_vector;
        case Type::easing: return std::holds_alternative<bob::Easing>(object.value);
        case Type::points:
        case Type::color:
        case Type::sdf: return false;
    }
    return false;
}

}  // namespace

TEST(words_are_told_apart_and_their_meanings_are_lines) {
    std::set<std::pair<std::string_view, int>> names;
    for (const Word& word : bob::vocabulary()) {
        CHECK(names.emplace(word.name, word.dimensions).second);
        CHECK(!word.meaning.empty() && word.meaning.back() == '.');
        CHECK(word.meaning.find('\n') == std::string_view::npos);
        CHECK_EQ(bob::find_word(word.name, word.dimensions), &word);
        CHECK(word.kind == Word::Kind::easing ? word.dimensions == 0 : word.dimensions == 2 || word.dimensions == 3);
    }
    CHECK_EQ(names.size(), bob::vocabulary().size());
}

TEST(parameters_are_told_apart_and_their_defaults_fit) {
    for (const Word& word : bob::vocabulary()) {
        std::set<std::string_view> names;
        bool optional = false;
        for (const bob::Parameter& parameter : word.parameters) {
            CHECK(names.insert(parameter.name).second);
            if (!parameter.default_value) {
                CHECK(parameter.variadic || !optional);  // as in Python, no required parameter follows an optional one
                continue;
            }
            optional = true;
            const Object& value = *parameter.default_value;
            CHECK(std::holds_alternative<bob::None>(value.value) || fits(value, parameter.type, word.dimensions));
        }
        if (word.kind == Word::Kind::operation) CHECK(word.parameters.front().type == Type::sdf);
    }
}

TEST(find_word_prefers_three_dimensions) {
    CHECK_EQ(bob::find_word("union", 0)->dimensions, 3);
    CHECK_EQ(bob::find_word("circle", 0)->dimensions, 2);
    CHECK_EQ(bob::find_word("in_quad", 0)->dimensions, 0);
    CHECK(bob::find_word("circle", 3) == nullptr);
    CHECK(bob::find_word("nothing", 0) == nullptr);
}

TEST(arguments_bind_as_in_python) {
    const bob::Expression ball = *made("sphere", {number(2), list({number(1), number(0), number(0)})}).expression;
    const Word& sphere = *bob::find_word("sphere", 3);
    const std::vector<Keyword> keywords{{"center", list({number(1), number(0), number(0)})}, {"radius", number(2)}};
    const bob::Object named = bob::call(sphere, {}, keywords);
    CHECK(*std::get<bob::Sdf>(named.value).expression == ball);
    CHECK_EQ(ball(4, 0, 0), 1.0);
    const Object shape{made("sphere")};
    const std::vector<Object> three{shape, {made("box")}, {made("pyramid", {number(1)})}};
    check_says(refusal("union", three, {{"k", number(0.5)}}), "");
    check_says(refusal("union", three, {{"bs", shape}}), "union: expected an argument named one of a, *bs, k, got bs");
}

TEST(wrong_arguments_are_named) {
    const Object ball{made("sphere")};
    check_says(refusal("sphere", {ball}), "sphere: radius: expected a number, got a 3D shape");
    check_says(refusal("torus", {number(1)}), "torus: r2: expected a number, got nothing");
    check_says(refusal("torus", {number(1), number(2), number(3)}), "torus: expected at most 2 arguments (r1, r2), got 3");
    check_says(refusal("torus", {number(1)}, {{"r1", number(2)}}), "torus: r1: expected one argument, got two");
    check_says(refusal("cylinder", {number(INFINITY)}), "cylinder: radius: expected finite numbers, got inf");
    check_says(refusal("cylinder", {list({})}), "cylinder: radius: expected a number, got a list of 0");
    check_says(refusal("translate", {ball, list({number(1), number(2)})}), "translate: offset: expected a 3D vector, got a list of 2 numbers");
    check_says(refusal("circular_array", {ball, number(2.5)}), "circular_array: count: expected a whole number, got 2.5");
    check_says(refusal("slice", {{std::string("ball")}}), "slice: other: expected a 3D shape, got a string");
}

TEST(numbers_that_overflow_are_refused) {
    const auto huge = list({number(1e308), number(1e308), number(-1e308)});
    const auto far = list({number(-1e308), number(1e308), number(1e308)});
    CHECK(!refusal("capped_cone", {huge, far, number(1), number(2)}).empty());
}

TEST(methods_are_operations_and_k) {
    const bob::Sdf ball = made("sphere"), box = made("box");
    const std::vector<Object> offset{list({number(1), number(2), number(3)})};
    const Object moved = bob::call_method(ball, "translate", offset, {});
    CHECK(*std::get<bob::Sdf>(moved.value).expression == *made("translate", {{ball}, offset[0]}).expression);

    const std::vector<Object> quarter{number(0.25)};
    const auto rounded = std::get<bob::Sdf>(bob::call_method(ball, "k", quarter, {}).value);
    CHECK_EQ(rounded.k.value_or(0), 0.25);
    CHECK(*rounded.expression == *ball.expression);
    const std::vector<Object> both{{box}, {ball}};
    const std::vector<Keyword> k{{"k", quarter[0]}};
    for (const auto& [op, word] : {std::pair('|', "union"), std::pair('&', "intersection"), std::pair('-', "difference")}) {
        const Object named = bob::call(*bob::find_word(word, 3), both, k);
        const Object combined = bob::combine(op, box, rounded);
        CHECK(*std::get<bob::Sdf>(combined.value).expression == *std::get<bob::Sdf>(named.value).expression);
        CHECK(!std::get<bob::Sdf>(combined.value).k);
    }
    std::string message;
    try {
        static_cast<void>(bob::call_method(ball, "extrude", quarter, {}));
    } catch (const bob::CallTypeError& error) {
        message = error.what();
    }
    check_says(message, "a 3D shape has no method extrude");
}

TEST(colors_follow_their_shapes) {
    const Object red{std::string("#f00")}, blue = list({number(0), number(0), number(1)});
    const bob::Sdf ball = made("color", {{made("sphere")}, red}), box = made("color", {{made("box")}, blue});
    const Object aside = list({number(1), number(0), number(0)});
    const auto both = made("union", {{ball}, {made("translate", {{box}, aside})}});
    const auto plain = made("union", {{made("sphere")}, {made("translate", {{made("box")}, aside})}});
    CHECK((*both.color)(-1, 0, 0) == (std::array{1.0, 0.0, 0.0}));
    CHECK((*both.color)(1.5, 0, 0) == (std::array{0.0, 0.0, 1.0}));
    CHECK(*both.expression == *plain.expression);  // node by node
    CHECK(plain.color == nullptr);
    // A painted shape has one colour and loses its earlier ones.
    CHECK((*made("color", {{both}, {std::string("#0f0")}}).color)(1.5, 0, 0) == (std::array{0.0, 1.0, 0.0}));
    // A tool without a colour paints nothing; one with a colour its cuts, and leaves the rest white.
    CHECK((*made("difference", {{ball}, {made("box")}}).color)(0.5, 0, 0) == (std::array{1.0, 0.0, 0.0}));
    const auto cut = made("difference", {{made("sphere")}, {box}});
    CHECK((*cut.color)(0.5, 0, 0) == (std::array{0.0, 0.0, 1.0}));
    CHECK((*cut.color)(1, 0, 0) == (std::array{1.0, 1.0, 1.0}));
    CHECK((*made("intersection", {{made("sphere")}, {box}}).color)(1, 0, 0) == (std::array{0.0, 0.0, 1.0}));
    // .k() and .color() leave each other.
    const auto rounded = std::get<bob::Sdf>(bob::call_method(ball, "k", std::vector{number(0.5)}, {}).value);
    CHECK_EQ(made("color", {{rounded}, blue}).k.value_or(0), 0.5);
    CHECK(rounded.color == ball.color);
    check_says(refusal("color", {{ball}, {std::string("rot")}}), "color: c: expected #rrggbb, a CSS name or 3 numbers, got \"rot\"");
    check_says(refusal("color", {{ball}, list({number(1), number(2), number(0)})}), "color: c: expected numbers in 0..1, got (1, 2, 0)");
    check_says(refusal("color", {{ball}, list({number(1), number(0)})}), "color: c: expected #rrggbb, a CSS name or 3 numbers, got a list of 2 numbers");
    check_says(refusal("color", {{ball}, number(1)}), "color: c: expected #rrggbb, a CSS name or 3 numbers, got a number");
    check_says(refusal("color", {{ball}, {std::string("a\nb")}}), "color: c: expected #rrggbb, a CSS name or 3 numbers, got a string");
}

TEST(operations_suit_the_dimensions_of_the_first_model) {
    const Object disk{made("circle")}, square{made("rectangle")};
    CHECK_EQ(made("union", {disk, square}, 3).dimensions, 2);
    CHECK_EQ(made("extrude", {disk, number(1)}).dimensions, 3);
    check_says(refusal("union", {disk, {made("sphere")}}), "union: bs: expected a 2D shape, got a 3D shape");
}

TEST(easings_are_values_and_functions) {
    const Word& word = *bob::find_word("in_quad", 0);
    const auto easing = std::get<bob::Easing>(bob::call(word, {}, {}).value);
    CHECK_EQ((*easing.expression)(3, 0, 0), 9.0);
    const std::vector<Object> half{number(0.5)};
    CHECK_EQ(std::get<double>(bob::call(word, half, {}).value), 0.25);
}

TEST(descriptions_name_types) {
    check_says(bob::describe({bob::None{}}), "None");
    check_says(bob::describe({true}), "True");
    check_says(bob::describe(number(1)), "a number");
    check_says(bob::describe({std::string("x")}), "a string");
    check_says(bob::describe({made("circle")}), "a 2D shape");
    check_says(bob::describe(list({number(1), number(2)})), "a list of 2 numbers");
    check_says(bob::describe(bob::call(*bob::find_word("linear", 0), {}, {})), "an easing function");
}
