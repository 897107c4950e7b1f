/// The formula evaluators at points: elementary functions, values and gradients, against double precision.
#include "formula/text.h"
#include "formulas.h"

namespace {

using bob::Op;
using test::infinity;
using test::not_a_number;
using test::Point;
using test::Random;
using test::same;
using test::estimate;
using test::values;

bob::Tape tape_of(Op op) {
    bob::Graph g;
    if (op == Op::mesh_distance) {
        return bob::Tape(bob::Expression({{.op = Op::x}, {.op = Op::y}, {.op = Op::z},
                                          {.op = op, .operand = {0, 1, 2}, .value = test::some_mesh()->number()}}));
    }
    return bob::Tape(g.expression(operands(op) == 1   ? g.unary(op, g.x())
                                  : operands(op) == 2 ? g.binary(op, g.x(), g.y())
                                                      : g.select(g.x(), g.y(), g.z())));
}

float value(const bob::Tape& tape, float x, float y = 0, float z = 0) { return values(tape, {{x, y, z}})[0]; }

/// Floats of all sizes from 2^low to 2^high and both signs.
std::vector<float> floats_of_all_sizes(Random& random, int count, float low, float high) {
    std::vector<float> result;
    for (int i = 0; i < count; ++i) {
        result.push_back((random() < 0.5f ? -1 : 1) * std::exp2(random(low, high)) * random(1, 2));
    }
    return result;
}

/// Tolerance of a kernel's result: units in the last place, and an absolute error.
struct Tolerance {
    double ulps, size;
};

/// The worst error of an op at points, in units of its tolerance; infinite where one is NaN and the other is not.
double worst_error(Op op, const std::vector<Point>& points, Tolerance tolerance) {
    const std::vector<float> got = values(tape_of(op), points);
    double worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double expected = evaluate(op, 0, points[i][0], points[i][1], points[i][2]);
        if (same(got[i], static_cast<float>(expected))) continue;
        const double allowed = tolerance.ulps * 0x1p-23 * std::fabs(expected) + tolerance.size;
        const double error = std::fabs(got[i] - expected) / allowed;
        if (!(error <= worst)) worst = std::isnan(error) ? infinity : error;
    }
    return worst;
}

}  // namespace

TEST(elementary_functions_match_double_precision) {
    struct Range {
        Op op;
        float low, high;  // exponents of 2 of the operand
        Tolerance tolerance;
    };
    // Absolute errors are for results near zero: sines near multiples of pi, where the reduced operand has an error, and
    // results below the least normal float. Beyond 1e4, sines have the error of pi / 2 in three parts.
    constexpr double denormal = 2e-45;
    const Range ranges[] = {
        {Op::square, -80, 70, {0.5, denormal}}, {Op::sqrt, -140, 127, {0.5, 0}},   {Op::sin, -140, 12, {1, 2e-7}},
        {Op::cos, -140, 12, {1, 2e-7}},         {Op::sin, 13, 16, {1, 3e-6}},      {Op::cos, 13, 16, {1, 3e-6}},
        {Op::tan, -140, 0, {3, denormal}},      {Op::asin, -140, 1, {4, denormal}}, {Op::acos, -140, 1, {4, 2e-7}},
        {Op::atan, -140, 127, {3, denormal}},   {Op::exp, -140, 7, {2, denormal}}, {Op::log, -140, 127, {2, 1e-7}},
        {Op::floor, -140, 40, {0, 0}},          {Op::ceil, -140, 40, {0, 0}},      {Op::round, -140, 40, {0, 0}},
        {Op::absolute, -140, 127, {0, 0}},      {Op::negate, -140, 127, {0, 0}},
    };
    test::for_each_isa([&] {
        Random random(1);
        for (const auto& [op, low, high, tolerance] : ranges) {
            std::vector<Point> points;
            for (const float x : floats_of_all_sizes(random, 20000, low, high)) points.push_back({x, 0, 0});
            const double worst = worst_error(op, points, tolerance);
            if (!(worst <= 1)) {
                test::fail(__FILE__, __LINE__, std::string(name(op)) + " is off by " + std::to_string(worst) +
                                                   " of its tolerance");
            }
        }
    });
}

TEST(functions_of_two_match_double_precision) {
    struct Case {
        Op op;
        float low, high;
        Tolerance tolerance;
    };
    const Case cases[] = {
        {Op::add, -100, 100, {0.5, 0}},      {Op::subtract, -100, 100, {0.5, 0}}, {Op::multiply, -60, 60, {0.5, 0}},
        {Op::divide, -60, 60, {0.5, 0}},     {Op::minimum, -100, 100, {0, 0}},    {Op::maximum, -100, 100, {0, 0}},
        {Op::hypot, -50, 60, {2, 0}},        {Op::atan2, -50, 50, {4, 0}},
    };
    test::for_each_isa([&] {
        Random random(2);
        for (const auto& [op, low, high, tolerance] : cases) {
            const auto x = floats_of_all_sizes(random, 20000, low, high);
            auto y = floats_of_all_sizes(random, 20000, low, high);
            std::vector<Point> points;
            for (std::size_t i = 0; i < x.size(); ++i) {
                if (i % 2) y[i] = x[i] * random(-2, 2);  // of about one size
                points.push_back({x[i], y[i], 0});
            }
            const double worst = worst_error(op, points, tolerance);
            if (!(worst <= 1)) {
                test::fail(__FILE__, __LINE__, std::string(name(op)) + " is off by " + std::to_string(worst) +
                                                   " of its tolerance");
            }
        }
        // A remainder is as exact as its operands' quotient is.
        const bob::Tape modulo = tape_of(Op::modulo);
        for (int i = 0; i < 5000; ++i) {
            const float a = random(-100, 100), b = random(-3, 3);
            double off = std::fabs(value(modulo, a, b) - evaluate(Op::modulo, 0, a, b, 0));
            off = std::min(off, std::fabs(off - std::fabs(b)));  // on the other side of a jump
            CHECK(off <= 2e-7 * std::max(std::fabs(a), std::fabs(b)));
        }
    });
}

TEST(functions_at_special_values) {
    constexpr float denormal = 1e-42f, largest = std::numeric_limits<float>::max();
    const float specials[] = {0,     -0.f,  infinity, -infinity, not_a_number, denormal, -denormal, 1,    -1,
                              0.5f,  -0.5f, 1.5f,     -1.5f,     2.5f,         -2.5f,    largest,   -largest, 1e-20f,
                              0x1p23f, 8388607.5f, -8388607.5f, 1 + 0x1p-23f, -1 - 0x1p-23f, 4194303.5f, 3, -3};
    test::for_each_isa([&] {
        for (int i = static_cast<int>(Op::negate); i < bob::op_count; ++i) {
            const Op op = static_cast<Op>(i);
            if (op == Op::power) continue;
            const bob::Tape tape = tape_of(op);
            for (const float a : specials) {
                for (const float b : specials) {
                    if (operands(op) == 1 && !same(b, 1)) continue;
                    if ((op == Op::sin || op == Op::cos || op == Op::tan) && std::fabs(a) > 1e4f) continue;
                    const double number = op == Op::mesh_distance ? test::some_mesh()->number() : 0;
                    const auto expected = static_cast<float>(evaluate(op, number, a, b, 7));
                    const float got = value(tape, a, b, 7);
                    // Squares, quotients and products on the way may leave the range of floats.
                    if (op == Op::hypot && std::fabs(expected) > 1e18f && !std::isinf(a) && !std::isinf(b)) continue;
                    if (op == Op::hypot && std::fabs(expected) < 1e-18f) continue;
                    // Remainders have another test; here only NaN remainders.
                    if (op == Op::modulo && !(b == 0 || std::isinf(a) || std::isnan(a + b))) continue;
                    if (op == Op::atan2 && a == 0 && b == 0) {
                        CHECK_EQ(got, 0.f);
                        continue;
                    }
                    if (!same(got, expected) && !(std::fabs(got - expected) <= 3e-7f * std::fabs(expected))) {
                        std::ostringstream text;
                        text << name(op) << " of " << a << " and " << b << ": expected " << expected << ", got " << got;
                        test::fail(__FILE__, __LINE__, text.str());
                    }
                }
            }
        }
        for (const float a : {infinity, -infinity, not_a_number}) {
            for (const Op op : {Op::sin, Op::cos, Op::tan}) CHECK(std::isnan(value(tape_of(op), a)));
        }
    });
}

TEST(halves_round_to_even_and_remainders_follow_the_divisor) {
    test::for_each_isa([] {
        for (int i = -50; i <= 50; ++i) {
            const float half = static_cast<float>(i) + 0.5f;
            CHECK_EQ(value(tape_of(Op::round), half), std::nearbyint(half));
            for (const float b : {-4.f, -0.25f, 0.25f, 4.f}) {
                const float r = value(tape_of(Op::modulo), half, b);
                CHECK_EQ(r, static_cast<float>(evaluate(Op::modulo, 0, half, b, 0)));
                CHECK(b > 0 ? r >= 0 && r < b : r <= 0 && r > b);
            }
        }
        CHECK_EQ(std::signbit(value(tape_of(Op::round), -0.25f)), true);
        CHECK_EQ(std::signbit(value(tape_of(Op::floor), -0.f)), true);
    });
}

TEST(powers_of_every_exponent) {
    // Plain nodes may have exponents that a graph would have made something else of.
    test::for_each_isa([] {
        for (const int n : {-5, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 12, 31, 64}) {
            const bob::Tape tape(bob::Expression({{.op = Op::x}, {.op = Op::power, .value = static_cast<double>(n)}}));
            for (const float x : {-1.5f, -1.f, -0.75f, 0.f, 0.25f, 1.f, 1.25f}) {
                const double expected = std::pow(x, n);
                const float got = value(tape, x);
                if (!same(got, static_cast<float>(expected))) {
                    CHECK(std::fabs(got - expected) <= 1e-6 * std::fabs(expected));
                }
            }
        }
    });
}

TEST(random_formulas_match_double_precision) {
    // Within the sum of the ops' errors, followed through the formula. Most points allow a judgement.
    test::for_each_isa([] {
        Random random(3);
        int judged = 0, numbers = 0, all = 0;
        for (int i = 0; i < 4000; ++i) {
            Random another(static_cast<std::uint64_t>(i));
            const bob::Expression plain = test::random_formula(random), f = i % 8 == 3 ? test::random_mesh_formula(another) : plain;
            std::vector<Point> points;
            for (int k = 0; k < 32; ++k) {
                const float size = std::array{1.f, 1.f, 1e-3f, 30.f}[test::pick(random, 4)];
                points.push_back({random(-size, size), random(-size, size), random(-size, size)});
                if (k % 8 == 0) points.back()[test::pick(random, 3)] = 0;
            }
            const std::vector<float> got = values(bob::Tape(f), points);
            for (std::size_t k = 0; k < points.size(); ++k) {
                const auto [value, error] = estimate(f, points[k]);
                ++all;
                if (std::isnan(error)) continue;
                ++judged;
                numbers += !std::isnan(value);
                const auto& [x, y, z] = points[k];
                CHECK(same(static_cast<float>(value), static_cast<float>(f(x, y, z))));
                if (same(got[k], static_cast<float>(value))) continue;
                if (!(std::fabs(got[k] - value) <= error)) {
                    std::ostringstream text;
                    text << "formula " << i << ": expected " << value << " +- " << error << ", got " << got[k] << " at "
                         << x << ", " << y << ", " << z << " of " << to_text(f);
                    test::fail(__FILE__, __LINE__, text.str());
                }
            }
        }
        CHECK_LT(all * 0.7, judged);
        CHECK_LT(all * 0.4, numbers);
    });
}

TEST(gradients_match_differences_of_values) {
    test::for_each_isa([] {
        Random random(4);
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        int judged = 0;
        for (int i = 0; i < 1500; ++i) {
            Random another(static_cast<std::uint64_t>(i));
            const bob::Expression plain = test::simplified(test::random_expression(random, 1 + i % 16));
            const bob::Expression f = i % 8 == 3 ? test::random_mesh_formula(another) : plain;
            const auto is_infinite = [](const bob::Expression& formula) {
                return std::any_of(formula.nodes().begin(), formula.nodes().end(), [](const bob::Node& node) {
                    return node.op == Op::constant && std::isinf(node.value);
                });
            };
            if (is_infinite(plain) || is_infinite(f)) continue;  // slopes are NaN then
            const bob::Tape tape(f);
            float p[3][bob::max_lanes], value[bob::max_lanes], gradient[3][bob::max_lanes];
            for (auto& axis : p) {
                for (float& coordinate : axis) coordinate = random(-2, 2);
            }
            const float* const points[3] = {p[0], p[1], p[2]};
            float* const gradients[3] = {gradient[0], gradient[1], gradient[2]};
            kernels.gradients(tape.code(), points, kernels.lanes, false, value, gradients,
                              bob::scratch(tape.code().registers));
            for (int k = 0; k < kernels.lanes; ++k) {
                const Point point{p[0][k], p[1][k], p[2][k]};
                CHECK(same(value[k], values(tape, {point})[0]));
                for (int axis = 0; axis < 3; ++axis) {
                    const auto at = [&](double step) {
                        double q[3] = {point[0], point[1], point[2]};
                        q[axis] += step;
                        return f(q[0], q[1], q[2]);
                    };
                    // Where steps of three sizes, and to either side, agree, f is smooth.
                    const auto slope = [&](double h) {
                        return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
                    };
                    const double fine = slope(1e-5), middle = slope(1e-4), coarse = slope(1e-3);
                    const double right = (at(2e-5) - at(0)) / 2e-5, left = (at(0) - at(-2e-5)) / 2e-5;
                    const double size = std::fabs(middle), close = 1e-4 * size + 1e-7;
                    if (!(std::fabs(fine - middle) <= close && std::fabs(coarse - middle) <= close &&
                          std::fabs(right - left) <= 1e-2 * size + 1e-5 && size < 1e6)) {
                        continue;
                    }
                    // What rounding does to the value it does to the slope, if there is enough of either.
                    const auto [exact, error] = estimate(f, point);
                    if (!(error <= 1e-5 * (std::fabs(exact) + size) && std::fabs(exact) < 1e9 * close)) continue;
                    ++judged;
                    if (!(std::fabs(gradient[axis][k] - middle) <= 2e-3 * size + 1e-4)) {
                        std::ostringstream text;
                        text << "formula " << i << ": expected a slope of " << middle << ", got " << gradient[axis][k]
                             << " along " << axis << " at " << point[0] << ", " << point[1] << ", " << point[2]
                             << " of " << to_text(f);
                        test::fail(__FILE__, __LINE__, text.str());
                    }
                }
            }
        }
        CHECK_LT(1500 * kernels.lanes, judged);
    });
}

TEST(corners_have_the_values_and_gradients_of_their_steps) {
    test::for_each_isa([] {
        Random random(9);
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        int compared = 0;
        for (int i = 0; i < 2000; ++i) {
            const bob::Expression a = test::random_formula(random), b = test::random_formula(random);
            const bob::Tape corner(test::corner(a, b)), steps(test::corner(a, b, 1e-300));
            float p[3][bob::max_lanes], value[2][bob::max_lanes], slope[2][3][bob::max_lanes];
            for (auto& axis : p) {
                for (float& x : axis) x = random() < 0.1f ? 0 : random(-2, 2);
            }
            const float* const points[3] = {p[0], p[1], p[2]};
            for (int k = 0; k < 2; ++k) {
                const bob::Tape& tape = k ? steps : corner;
                float* const slopes[3] = {slope[k][0], slope[k][1], slope[k][2]};
                kernels.gradients(tape.code(), points, kernels.lanes, false, value[k], slopes, bob::scratch(tape.code().registers));
            }
            for (int lane = 0; lane < kernels.lanes; ++lane) {
                CHECK(same(value[0][lane], value[1][lane]));
                if (value[0][lane] == 0) continue;  // no one slope
                for (int axis = 0; axis < 3; ++axis) {
                    const float whole = slope[0][axis][lane], by_steps = slope[1][axis][lane];
                    if (std::isnan(whole) || std::isnan(by_steps)) continue;  // where a or b has no slope and is 0
                    CHECK_EQ(whole, by_steps);
                    ++compared;
                }
            }
        }
        CHECK_LT(2000 * kernels.lanes, compared);
    });
}
