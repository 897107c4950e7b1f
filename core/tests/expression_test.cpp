#include "formula/expression.h"

#include <array>
#include <limits>

#include "formula/text.h"
#include "formulas.h"

namespace {

using bob::Op;
using bob::Value;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Whether Expression refuses the nodes, saying `why`.
bool refused(std::vector<bob::Node> nodes, std::string_view why) {
    try {
        const bob::Expression expression(std::move(nodes));
    } catch (const std::invalid_argument& error) {
        return std::string_view(error.what()).find(why) != std::string_view::npos;
    }
    return false;
}

/// A formula after simplification, as text.
template <class Build>
std::string made(Build build) {
    bob::Graph g;
    const Value x = g.x(), y = g.y(), z = g.z();
    return to_text(g.expression(build(g, x, y, z)));
}

#define CHECK_MADE(formula, text)                                                                               \
    do {                                                                                                        \
        const std::string got = made([]([[maybe_unused]] bob::Graph& g, [[maybe_unused]] Value x,               \
                                        [[maybe_unused]] Value y, [[maybe_unused]] Value z) { return formula; }); \
        if (got != (text)) test::fail(__FILE__, __LINE__, #formula " became " + got);                           \
    } while (false)

/// A random formula as plain nodes, which nothing simplifies.
std::vector<bob::Node> random_nodes(test::Random& random) {
    constexpr double numbers[] = {0, 1, -1, 2, 0.5, -3, 1.25};
    const auto pick = [&](std::size_t count) {
        return std::min(count - 1, static_cast<std::size_t>(random() * static_cast<float>(count)));
    };
    std::vector<bob::Node> nodes{{.op = Op::x}, {.op = Op::y}, {.op = Op::z}};
    for (int i = 0; i < 4; ++i) nodes.push_back({.op = Op::constant, .value = numbers[pick(std::size(numbers))]});
    for (int i = 0; i < 25; ++i) {
        bob::Node node{.op = test::random_op(random)};
        for (int k = 0; k < operands(node.op); ++k) {
            // Near the end more often, so that formulas grow deep.
            const std::size_t back = pick(1 + pick(nodes.size()));
            node.operand[k] = static_cast<std::uint32_t>(nodes.size() - 1 - back);
        }
        if (node.op == Op::power) node.value = std::array{-4, -3, -2, -1, 1, 2, 3, 4, 5}[pick(9)];
        nodes.push_back(node);
    }
    return nodes;
}

/// Nodes evaluated one by one, each result changed by `change`.
template <class Change>
double evaluate_each(const std::vector<bob::Node>& nodes, const double* p, Change change) {
    std::vector<double> values;
    for (const bob::Node& node : nodes) {
        const auto operand = [&](int k) { return k < operands(node.op) ? values[node.operand[k]] : 0; };
        const bool coordinate = node.op == Op::x || node.op == Op::y || node.op == Op::z;
        values.push_back(coordinate ? p[static_cast<int>(node.op) - static_cast<int>(Op::x)]
                                    : change(evaluate(node.op, node.value, operand(0), operand(1), operand(2))));
    }
    return values.back();
}

}  // namespace

TEST(ops_pass_nan_on) {
    for (int i = static_cast<int>(Op::negate); i < bob::op_count; ++i) {
        const Op op = static_cast<Op>(i);
        for (int k = 0; k < operands(op); ++k) {
            const double a[] = {k == 0 ? no_number : -1, k == 1 ? no_number : 2, k == 2 ? no_number : 3};
            // A select depends only on the chosen branch: here b, since a is -1.
            const double value = op == Op::mesh_distance ? test::some_mesh()->number() : 2;
            CHECK(std::isnan(evaluate(op, value, a[0], a[1], a[2])) == !(op == Op::select && k == 2));
        }
    }
}

TEST(ops_worked_values) {
    CHECK_EQ(evaluate(Op::modulo, 0, -1, 3, 0), 2);
    CHECK_EQ(evaluate(Op::modulo, 0, 1, -3, 0), -2);
    CHECK_EQ(evaluate(Op::modulo, 0, 7.5, 2, 0), 1.5);
    CHECK(!std::signbit(evaluate(Op::modulo, 0, -3, 3, 0)) && std::signbit(evaluate(Op::modulo, 0, 3, -3, 0)));
    CHECK(std::isnan(evaluate(Op::modulo, 0, 1, 0, 0)));
    CHECK_EQ(evaluate(Op::round, 0, 2.5, 0, 0), 2);
    CHECK_EQ(evaluate(Op::round, 0, -1.5, 0, 0), -2);
    CHECK_EQ(evaluate(Op::atan2, 0, 1, 0, 0), std::atan2(1.0, 0.0));
    CHECK_EQ(evaluate(Op::power, -3, 2, 0, 0), 0.125);
    CHECK_EQ(evaluate(Op::select, 0, -1, 5, 6), 5);
    CHECK_EQ(evaluate(Op::select, 0, 0, 5, 6), 6);
    CHECK_EQ(evaluate(Op::divide, 0, -1, 0, 0), -infinity);
    CHECK(std::isnan(evaluate(Op::sqrt, 0, -1, 0, 0)));
}

TEST(expressions_are_checked) {
    CHECK(refused({}, "at least one"));
    CHECK(refused({{.op = static_cast<Op>(bob::op_count)}}, "unknown"));
    CHECK(refused({{.op = Op::x}, {.op = Op::sin, .operand = {1}}}, "come before"));
    CHECK(refused({{.op = Op::x}, {.op = Op::add, .operand = {0, 7}}}, "come before"));
    CHECK(refused({{.op = Op::x}, {.op = Op::select, .operand = {0, 0, 2}}}, "come before"));
    CHECK(refused({{.op = Op::constant, .value = no_number}}, "NaN"));
    CHECK(refused({{.op = Op::x}, {.op = Op::power, .value = 0.5}}, "whole"));
    for (const double number : {0., -1., 0.5, 1e9, no_number, infinity}) {
        CHECK(refused({{.op = Op::x}, {.op = Op::mesh_distance, .value = number}}, "number of a mesh"));
    }
    CHECK(refused({{.op = Op::x}, {.op = Op::power, .value = 1001}}, "1000"));
    CHECK(refused({{.op = Op::x}, {.op = Op::power, .value = no_number}}, "whole"));
    CHECK(!refused({{.op = Op::constant, .value = infinity}}, ""));
}

TEST(expressions_keep_what_they_need) {
    const bob::Expression f({{.op = Op::z},
                             {.op = Op::y},
                             {.op = Op::sin, .operand = {0, 9, 9}},
                             {.op = Op::constant, .value = 2},
                             {.op = Op::multiply, .operand = {1, 3}}});
    CHECK_EQ(f.nodes().size(), 3u);
    CHECK_EQ(f(5, 7, 11), 14);
    CHECK(f.uses(Op::y) && !f.uses(Op::z) && !f.uses(Op::sin));
    CHECK(f == bob::Expression(f.nodes()));
}

TEST(no_node_stands_twice) {
    bob::Graph g;
    const Value x = g.x(), y = g.y();
    CHECK(g.x() == x);
    CHECK((x + y == y + x) && (min(x, y) == min(y, x)) && (hypot(x, y) == hypot(y, x)));
    CHECK(!(x - y == y - x));
    CHECK(sin(x * y) == sin(y * x));
    CHECK(!(power(x, 3) == power(x, 5)));
    CHECK(!(g.constant(0) == g.constant(-0.0)));
    const std::size_t size = g.size();
    CHECK(sin(x * y) == sin(x * y));
    CHECK_EQ(g.size(), size);
    g.clear();
    CHECK_EQ(g.size(), 0u);
    CHECK(to_text(g.expression(g.y() + 1)) == "y + 1");
}

TEST(graphs_have_a_limit) {
    bob::Graph g;
    bool thrown = false;
    try {
        for (Value v = g.x();;) v = sin(v);
    } catch (const bob::TooLarge&) {
        thrown = true;
    }
    CHECK(thrown);
    CHECK_EQ(g.size(), bob::Graph::max_nodes);
}

TEST(algebra_makes_formulas_simpler) {
    CHECK_MADE(x + 0, "x");
    CHECK_MADE(0 - x, "-x");
    CHECK_MADE(x * 1, "x");
    CHECK_MADE(x * -1, "-x");
    CHECK_MADE(-(-x), "x");
    CHECK_MADE(-(x - y), "y - x");
    CHECK_MADE(x - -y, "x + y");
    CHECK_MADE((1 + x) + 2, "x + 3");
    CHECK_MADE(1 - (x + 2), "-1 - x");
    CHECK_MADE((x * 2) * 3, "x * 6");
    CHECK_MADE(x / 2, "x * 0.5");
    CHECK_MADE(x * x * x * x, "x**4");
    CHECK_MADE(square(-x), "x**2");
    CHECK_MADE(abs(sqrt(x)), "sqrt(x)");
    CHECK_MADE(sqrt(x * x + 4), "hypot(x, 2)");
    CHECK_MADE(power(x, -2), "1 / x**2");
    CHECK_MADE(min(x, x), "x");
    CHECK_MADE(max(abs(x), 0), "absolute(x)");
    CHECK_MADE(max(max(x, 1), 3), "maximum(x, 3)");
    CHECK_MADE(select(x, y, y), "y");
    CHECK_MADE(select(g.constant(-1), y, z), "y");
    CHECK_MADE(sin(g.constant(2)) * 0 + 7, "7");
    CHECK_MADE(max(x - 1, 0) + min(x - 1, 0), "x - 1");
}

TEST(roots_of_long_sums_take_no_longer_than_others) {
    bob::Graph g;
    bob::Value left = square(g.x()), right = square(g.y()), twice = square(g.z()) + 1, all = g.constant(0);
    for (int i = 0; i < 100'000; ++i) {
        left = left + square(g.x() - i);
        right = square(g.y() - i) + right;
        all = all + sqrt(left);
    }
    for (int i = 0; i < 64; ++i) twice = twice + twice;
    const bob::Expression f = g.expression(all + (sqrt(left) + sqrt(right)) + sqrt(twice));
    CHECK(f.uses(bob::Op::sqrt));
}

TEST(algebra_keeps_what_may_be_infinite_or_nan) {
    CHECK_MADE(x * y * 0, "x * y * 0");
    CHECK_MADE((1 / x) * 0, "1 / x * 0");
    CHECK_MADE(x / 0, "x / 0");
    CHECK_MADE(x / y * y, "y * (x / y)");
    CHECK_MADE(sqrt(x) - sqrt(x), "sqrt(x) - sqrt(x)");
    CHECK_MADE(square(sqrt(x)), "sqrt(x)**2");
    CHECK_MADE((x + infinity) - infinity, "x + inf - inf");
    CHECK_MADE((x * infinity) * 0, "x * inf * 0");
    CHECK_MADE((infinity - x) - infinity, "inf - x - inf");
    bob::Graph g;
    CHECK(std::isnan(g.expression(sqrt(g.constant(-1)) + g.x())(1, 0, 0)));
}

TEST(substitution_puts_values_in_the_place_of_coordinates) {
    bob::Graph g;
    const auto f = g.expression(select(g.x() - g.y(), power(g.z(), 3), hypot(g.x(), g.y()) + 2));
    const Value turned = g.substitute(f, g.y(), g.constant(0.5), g.x() * 2);
    CHECK_EQ(g.expression(turned)(3, 0.25, 0), 216);
    CHECK_EQ(g.expression(turned)(3, 1.2, 0), 3.3);
    CHECK(g.substitute(f, g.x(), g.y(), g.z()) == g.substitute(g.expression(g.substitute(f, g.x(), g.y(), g.z())),
                                                                g.x(), g.y(), g.z()));
}

TEST(simplified_formulas_have_the_same_values) {
    // Every step of the plain formula is disturbed a little, and zeros change signs: where that shows, rounding decides,
    // and nothing is compared; nor is where a step is so large that it overflows elsewhere when simplified, or so small.
    int compared = 0, smaller = 0;
    for (std::uint64_t seed = 0; seed < 4000; ++seed) {
        test::Random random(seed);
        const bob::Expression plain(random_nodes(random));
        bob::Graph g;
        const bob::Expression simple = g.expression(g.substitute(plain, g.x(), g.y(), g.z()));
        smaller += simple.nodes().size() < plain.nodes().size();
        for (int i = 0; i < 10; ++i) {
            const double p[] = {random(-3, 3), random(-3, 3), random(-3, 3)};
            const double want = plain(p[0], p[1], p[2]), got = simple(p[0], p[1], p[2]);
            double spread = 0;
            bool usual = true;
            for (int sample = 0; sample < 6; ++sample) {
                const double disturbed = evaluate_each(plain.nodes(), p, [&](double value) {
                    usual &= !(std::fabs(value) > 1e60) && (value == 0 || !(std::fabs(value) < 1e-60));
                    const double noise = random(-1, 1);
                    return value == 0 ? std::copysign(0, noise) : value * (1 + 1e-13 * noise);
                });
                spread = std::max(spread, same(disturbed, want) ? 0 : std::fabs(disturbed - want));
                usual &= std::isnan(disturbed) == std::isnan(want);
            }
            // A choice between equals is made without its condition, which may have been NaN.
            if (std::isnan(want) && plain.uses(Op::select)) continue;
            if (!usual || spread > 1e-9 * std::fabs(want)) continue;
            ++compared;
            if (!same(want, got) && !(std::fabs(got - want) <= 10 * spread + 1e-13 * std::fabs(want))) {
                std::ostringstream text;
                text << "seed " << seed << ": " << want << " and " << got << ", " << to_text(plain) << ", simplified "
                     << to_text(simple);
                test::fail(__FILE__, __LINE__, text.str());
            }
        }
    }
    CHECK_LT(15000, compared);
    CHECK_LT(1000, smaller);
}

TEST(formulas_read_like_formulas) {
    CHECK_MADE((x - (y - z)) / -y, "(x - (y - z)) / -y");
    CHECK_MADE(x - y - z, "x - y - z");
    CHECK_MADE((x / y) / (y / z), "x / y / (y / z)");
    CHECK_MADE(square(sin(x) + 1) - 2, "(sin(x) + 1)**2 - 2");
    CHECK_MADE(power(-x, 3), "(-x)**3");
    CHECK_MADE(select(x, y, z), "where(x < 0, y, z)");
    CHECK_MADE(modulo(x, y), "x % y");
    bob::Graph g;
    Value deep = g.x();
    for (int i = 0; i < 100000; ++i) deep = sin(deep) + g.y();
    CHECK_EQ(to_text(g.expression(deep), 50).size(), 50u);
}

TEST(graphs_refuse_the_numbers_that_expressions_refuse) {
    for (const double exponent : {2.5, 2000.}) {
        bob::Graph g;
        const bob::Value power = g.unary(bob::Op::power, g.x(), exponent);
        bool refused = false;
        try {
            [[maybe_unused]] const bob::Expression f = g.expression(power);
        } catch (const std::invalid_argument&) {
            refused = true;
        }
        CHECK(refused);
    }
}

TEST(color_formulas_hold_what_their_roots_need) {
    using bob::ColorFormula;
    const std::vector<bob::Node> nodes{
        {.op = Op::x}, {.op = Op::y}, {.op = Op::constant, .value = 0.5}, {.op = Op::sqrt, .operand = {1}},
        {.op = Op::subtract, .operand = {0, 2}}, {.op = Op::sin, .operand = {4}}};
    const ColorFormula color(nodes, {4, 2, 0});
    CHECK_EQ(color.nodes().size(), 3u);
    CHECK(color.roots() == (std::array{2u, 1u, 0u}));
    CHECK(color(0.75, 0, 0) == (std::array{0.25, 0.5, 0.75}));
    CHECK(color(3, 0, 0) == (std::array{1.0, 0.5, 1.0}));
    CHECK(color(-3, 0, 0) == (std::array{0.0, 0.5, 0.0}));
    CHECK(ColorFormula(nodes, {3, 0, 0})(1, -1, 0) == (std::array{0.0, 1.0, 1.0}));  // NaN is 0
    CHECK(ColorFormula({0.25, 0.5, 0.25})(7, 7, 7) == (std::array{0.25, 0.5, 0.25}));
    CHECK_EQ(ColorFormula({0.25, 0.5, 0.25}).nodes().size(), 2u);
    bool refused = false;
    try {
        [[maybe_unused]] const ColorFormula none(nodes, {0, 1, 6});
    } catch (const std::invalid_argument&) {
        refused = true;
    }
    CHECK(refused);
}
