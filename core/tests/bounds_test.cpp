/// The formula evaluators over boxes, compared with samples: bounds of values, decisions, and narrowing by slopes.
#include "formula/text.h"
#include "formulas.h"

namespace {

using bob::BoxBatch;
using bob::Decision;
using bob::Op;
using test::estimate;
using test::infinity;
using test::Point;
using test::Random;
using test::values;

/// Boxes of all sizes: points, flat ones, through zero, with corners where functions have their edges.
BoxBatch random_boxes(Random& random) {
    BoxBatch boxes{};
    for (int lane = 0; lane < bob::max_lanes; ++lane) {
        constexpr float corners[] = {0, 1, -1, 0.5f, -0.5f, 1.5707964f, 3.1415927f};
        const float size = std::array{0.f, 1e-6f, 1e-3f, 0.03f, 0.3f, 1.f, 10.f, 1e4f}[test::pick(random, 8)];
        for (int axis = 0; axis < 3; ++axis) {
            const float corner = random() < 0.3f ? corners[test::pick(random, std::size(corners))] : random(-2, 2);
            const float side = random() < 0.1f ? 0 : size * random();
            const bool from = random() < 0.5f;
            boxes.low[axis][lane] = from ? corner : corner - side;
            boxes.high[axis][lane] = from ? corner + side : corner;
        }
    }
    return boxes;
}

/// Points of a box: its corners, on its faces, where coordinates are 0, and within.
std::vector<Point> samples(Random& random, const BoxBatch& boxes, int lane, int count) {
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
        Point p;
        for (int axis = 0; axis < 3; ++axis) {
            const float low = boxes.low[axis][lane], high = boxes.high[axis][lane];
            p[axis] = i < 8                                               ? (i >> axis & 1 ? high : low)
                      : random() < 0.1f                                   ? low
                      : random() < 0.1f                                   ? high
                      : random() < 0.1f && low <= 0 && high >= 0          ? 0
                                                                          : random(low, high);
            p[axis] = std::clamp(p[axis], low, high);
        }
        points.push_back(p);
    }
    return points;
}

std::string told(const bob::Expression& f, const BoxBatch& boxes, int lane, const Point& p, float value) {
    std::ostringstream text;
    text.precision(9);
    text << value << " at " << p[0] << ", " << p[1] << ", " << p[2] << " of the box";
    for (int axis = 0; axis < 3; ++axis) text << " " << boxes.low[axis][lane] << ".." << boxes.high[axis][lane];
    text << " with bounds " << boxes.least[lane] << ".." << boxes.most[lane] << " of " << to_text(f) << ", "
         << name(bob::isa());
    return text.str();
}

/// Calls body(tape, boxes, decisions) for random formulas and boxes, bounded.
template <class Body>
void for_random_boxes(std::uint64_t seed, int count, Body body) {
    test::for_each_isa([&] {
        Random random(seed);
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        for (int i = 0; i < count; ++i) {
            const bob::Expression f = test::simplified(test::random_expression(random, 1 + i % 20));
            Random another(seed + static_cast<std::uint64_t>(i));
            const bob::Tape tape(i % 8 == 7   ? test::corner(f, test::simplified(test::random_expression(another, 8)))
                                 : i % 8 == 3 ? test::random_mesh_formula(another)
                                              : f);
            BoxBatch boxes = random_boxes(random);
            std::vector<Decision> decisions(tape.decisions().size());
            kernels.bounds(tape.code(), boxes, decisions.data(), bob::scratch(tape.code().registers));
            body(random, tape, boxes, decisions);
        }
    });
}

}  // namespace

TEST(bounds_hold_every_value) {
    // To the last bit, with no tolerance. Bounds would be no use if they were always infinite, so some are counted.
    int bounded = 0, all = 0;
    for_random_boxes(1, 20000, [&](Random& random, const bob::Tape& tape, const BoxBatch& boxes, const auto&) {
        for (int lane = 0; lane < bob::best_formula_kernels().lanes; ++lane) {
            const bool partly = boxes.partly >> lane & 1, nowhere = boxes.nowhere >> lane & 1;
            const float least = boxes.least[lane], most = boxes.most[lane];
            bounded += nowhere || most - least < infinity;
            ++all;
            const std::vector<Point> points = samples(random, boxes, lane, 24);
            const std::vector<float> got = values(tape, points);
            for (std::size_t k = 0; k < points.size(); ++k) {
                const bool outside = got[k] < least || got[k] > most;  // false where a bound is NaN
                const bool within = std::isnan(got[k]) ? partly || nowhere : !nowhere && !outside;
                if (!within) {
                    test::fail(__FILE__, __LINE__, told(tape.expression(), boxes, lane, points[k], got[k]) +
                                                       (partly ? ", partly" : "") + (nowhere ? ", nowhere" : ""));
                }
            }
        }
    });
    CHECK_LT(all * 0.6, bounded);
}

TEST(bounds_are_sharp_where_each_variable_stands_once) {
    // Ops over a box, against the hull of samples: no wider than a little.
    test::for_each_isa([] {
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        Random random(2);
        for (int i = static_cast<int>(Op::negate); i < bob::op_count; ++i) {
            const Op op = static_cast<Op>(i);
            if (op == Op::mesh_distance) continue;  // bounded over the ball around the box
            bob::Node node{.op = op, .operand = {0, 1, 2}, .value = 3};
            if (op == Op::modulo) node.operand[1] = 3;
            const bob::Tape tape(bob::Expression(
                {{.op = Op::x}, {.op = Op::y}, {.op = Op::z}, {.op = Op::constant, .value = 1.5}, node}));
            BoxBatch boxes{};
            for (int lane = 0; lane < kernels.lanes; ++lane) {
                for (int axis = 0; axis < 3; ++axis) {
                    const float a = random(0.05f, 0.95f), b = random(0.05f, 0.95f);
                    boxes.low[axis][lane] = std::min(a, b);
                    boxes.high[axis][lane] = std::max(a, b);
                }
            }
            Decision decision;
            kernels.bounds(tape.code(), boxes, &decision, bob::scratch(tape.code().registers));
            for (int lane = 0; lane < kernels.lanes; ++lane) {
                float least = infinity, most = -infinity;
                for (const float value : values(tape, samples(random, boxes, lane, 8))) {
                    least = std::min(least, value), most = std::max(most, value);
                }
                CHECK_EQ(boxes.partly >> lane & 1, 0u);
                CHECK(boxes.least[lane] >= least - 1e-4f * (1 + std::fabs(least)));
                CHECK(boxes.most[lane] <= most + 1e-4f * (1 + std::fabs(most)));
            }
        }
    });
}

TEST(narrowed_bounds_hold_every_value) {
    // Slopes bound f itself. The kernels' values differ from f by rounding, at the sample and at the centre.
    int narrowed = 0, all = 0;
    for_random_boxes(3, 10000, [&](Random& random, const bob::Tape& tape, BoxBatch& boxes, const auto&) {
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        BoxBatch narrow = boxes;
        kernels.narrow(tape.code(), narrow, bob::scratch(tape.code().registers));
        for (int lane = 0; lane < kernels.lanes; ++lane) {
            CHECK(!(narrow.least[lane] < boxes.least[lane]) && !(narrow.most[lane] > boxes.most[lane]));
            if (boxes.nowhere >> lane & 1) continue;
            ++all;
            if (test::same(narrow.least[lane], boxes.least[lane]) && test::same(narrow.most[lane], boxes.most[lane])) {
                continue;
            }
            ++narrowed;
            Point center;
            for (int axis = 0; axis < 3; ++axis) {
                center[axis] = 0.5f * (boxes.low[axis][lane] + boxes.high[axis][lane]);
            }
            const double at_center = estimate(tape.expression(), center).error;
            const std::vector<Point> points = samples(random, boxes, lane, 16);
            const std::vector<float> got = values(tape, points);
            for (std::size_t k = 0; k < points.size(); ++k) {
                // Slopes of angles vanish where squares of distances, beyond 1e19, are infinite.
                const double error = estimate(tape.expression(), points[k]).error + at_center + 1e-15;
                if (got[k] + error < narrow.least[lane] || got[k] - error > narrow.most[lane]) {
                    test::fail(__FILE__, __LINE__,
                               "narrowed: " + told(tape.expression(), narrow, lane, points[k], got[k]));
                }
            }
        }
    });
    CHECK_LT(all * 0.05, narrowed);
}

TEST(narrowing_sees_what_cancels) {
    // x - x^2 on a small box: bounds of values are off by the box's size, slopes by its square.
    test::for_each_isa([] {
        bob::Graph g;
        const bob::Tape tape(g.expression(g.x() - square(g.x()) + 1));
        BoxBatch boxes{};
        std::fill_n(boxes.low[0], bob::max_lanes, 0.49f);
        std::fill_n(boxes.high[0], bob::max_lanes, 0.51f);
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        kernels.bounds(tape.code(), boxes, nullptr, bob::scratch(tape.code().registers));
        CHECK(boxes.most[0] - boxes.least[0] > 0.03f);
        kernels.narrow(tape.code(), boxes, bob::scratch(tape.code().registers));
        CHECK(boxes.most[0] - boxes.least[0] < 0.001f);
        CHECK(boxes.least[0] <= 1.2499f && boxes.most[0] >= 1.25f);
    });
}

TEST(slopes_that_tell_less_than_values_are_unknown) {
    // Slopes of a smooth union are quotients of sums of exponentials, and each sum may be thousands of times larger elsewhere in the box.
    test::for_each_isa([] {
        bob::Graph g;
        const bob::Value a = g.x() - 0.2, b = g.y() + 0.1;
        const bob::Tape blend(g.expression(log(exp(a * -30) + exp(b * -30)) * (-1. / 30))), sharp(g.expression(min(a, b)));
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        const auto are_known = [&](const bob::Tape& tape, float side) {
            BoxBatch boxes{};
            for (int axis = 0; axis < 3; ++axis) std::fill_n(boxes.high[axis], bob::max_lanes, side);
            kernels.narrow(tape.code(), boxes, bob::scratch(tape.code().registers));
            return !std::isnan(boxes.least_slope[0][0]) && !std::isnan(boxes.most_slope[1][0]);
        };
        CHECK(are_known(sharp, 0.3f) && are_known(sharp, 0.f));
        CHECK(are_known(blend, 0.01f) && are_known(blend, 0.f));
        CHECK(!are_known(blend, 0.3f));
    });
}

TEST(slopes_of_angles_hold_the_true_one_where_squares_overflow) {
    test::for_each_isa([] {
        bob::Graph g;
        const double large = 1e20, least = 0.4, most = 0.6;
        const bob::Value steep = g.x() * large;
        const std::pair<bob::Expression, double> cases[] = {
            {g.expression(atan(steep) * large), large * large / (1 + least * least * large * large)},
            {g.expression(atan2(g.x(), g.constant(large)) * large), 1},
        };
        for (const auto& [expression, slope] : cases) {
            const bob::Tape tape(expression);
            BoxBatch boxes{};
            std::fill_n(boxes.low[0], bob::max_lanes, static_cast<float>(least));
            std::fill_n(boxes.high[0], bob::max_lanes, static_cast<float>(most));
            bob::best_formula_kernels().narrow(tape.code(), boxes, bob::scratch(tape.code().registers));
            CHECK(!(boxes.most_slope[0][0] < static_cast<float>(0.999 * slope)));
        }
    });
}

TEST(specialised_formulas_have_the_same_values_within_their_box) {
    // Equal to the bit, except where the algebra of the remaining branches reorders sums.
    int identical = 0, judged = 0, shorter = 0;
    for_random_boxes(4, 10000, [&](Random& random, const bob::Tape& tape, const BoxBatch& boxes,
                                   const std::vector<Decision>& decisions) {
        for (int lane = 0; lane < bob::best_formula_kernels().lanes; ++lane) {
            // Decisions leave out branches that may be NaN.
            if ((boxes.partly | boxes.nowhere) >> lane & 1) continue;
            const bob::Tape special(tape.specialised(decisions, lane));
            if (special.code().count == tape.code().count) continue;
            ++shorter;
            const std::vector<Point> points = samples(random, boxes, lane, 16);
            const std::vector<float> expected = values(tape, points), got = values(special, points);
            for (std::size_t k = 0; k < points.size(); ++k) {
                ++judged;
                identical += test::same(got[k], expected[k]);
                if (test::same(got[k], expected[k])) continue;
                const double error = std::max(estimate(tape.expression(), points[k]).error,
                                              estimate(special.expression(), points[k]).error);
                if (std::fabs(got[k] - expected[k]) > 2 * error) {
                    test::fail(__FILE__, __LINE__, told(tape.expression(), boxes, lane, points[k], expected[k]) +
                                                       " became " + std::to_string(got[k]) + " of " +
                                                       to_text(special.expression()));
                }
            }
        }
    });
    CHECK_LT(1000, shorter);
    CHECK_LT(judged * 0.85, identical);
}

TEST(what_is_left_out_says_what_is_left) {
    int alike = 0, unlike = 0;
    for_random_boxes(5, 4000, [&](Random&, const bob::Tape& tape, const BoxBatch&, const std::vector<Decision>& decisions) {
        const auto left_out = [&](int lane) { return tape.left_out(decisions, lane, 1); };
        for (int lane = 0; lane + 1 < bob::best_formula_kernels().lanes; ++lane) {
            CHECK(tape.left_out(decisions, lane, 0).empty());
            if (left_out(lane).empty() || left_out(lane) != left_out(lane + 1)) continue;
            ++alike;
            const bool same = tape.specialised(decisions, lane) == tape.specialised(decisions, lane + 1);
            unlike += !same;
        }
    });
    CHECK_LT(1000, alike);
    CHECK(unlike == 0);
}

TEST(boxes_decide) {
    // min(x, y), max(x, y), |x|, select(x, y, z), floor(x), round(x): decided and undecided boxes, and a select of two equal
    // branches.
    test::for_each_isa([] {
        struct Case {
            Op op;
            float x[2], y[2];
            bool first, second;
            double value = 0;
        };
        const Case cases[] = {
            {Op::minimum, {1, 2}, {3, 4}, true, false},   {Op::minimum, {3, 4}, {1, 2}, false, true},
            {Op::minimum, {1, 3}, {2, 4}, false, false},  {Op::maximum, {1, 2}, {3, 4}, false, true},
            {Op::maximum, {3, 4}, {1, 2}, true, false},   {Op::maximum, {1, 3}, {2, 4}, false, false},
            {Op::absolute, {0, 2}, {0, 0}, true, false},  {Op::absolute, {-2, -1}, {0, 0}, false, true},
            {Op::absolute, {-1, 1}, {0, 0}, false, false}, {Op::select, {-2, -1}, {0, 0}, true, false},
            {Op::select, {0, 1}, {0, 0}, false, true},    {Op::select, {-1, 0}, {0, 0}, false, false},
            {Op::select, {-2, -1}, {0, 0}, true, false, bob::meets}, {Op::select, {0, 1}, {0, 0}, false, true, bob::meets},
            {Op::select, {-1, 0}, {0, 0}, false, false, bob::meets},
            {Op::floor, {1, 1.5f}, {0, 0}, true, false},  {Op::floor, {0.5f, 1}, {0, 0}, false, true},   {Op::floor, {0.5f, 2}, {0, 0}, false, false},
            {Op::ceil, {1.5f, 2}, {0, 0}, true, false},   {Op::ceil, {1, 1.5f}, {0, 0}, false, true},
            {Op::round, {0.5f, 0.5f}, {0, 0}, true, false}, {Op::round, {1.4f, 1.6f}, {0, 0}, false, true},
            {Op::atan2, {-1, 1}, {-2, -1}, true, false},  {Op::atan2, {-1, 1}, {1, 2}, false, false},
        };
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        for (const Case& c : cases) {
            const bob::Tape tape(
                bob::Expression({{.op = Op::x}, {.op = Op::y}, {.op = Op::z}, {.op = c.op, .operand = {0, 1, 2}, .value = c.value}}));
            for (int lane = 0; lane < kernels.lanes; ++lane) {
                BoxBatch boxes{};
                boxes.low[0][lane] = c.x[0], boxes.high[0][lane] = c.x[1];
                boxes.low[1][lane] = c.y[0], boxes.high[1][lane] = c.y[1];
                Decision decision;
                kernels.bounds(tape.code(), boxes, &decision, bob::scratch(tape.code().registers));
                CHECK_EQ(decision.first >> lane & 1, c.first ? 1u : 0u);
                CHECK_EQ(decision.second >> lane & 1, c.second ? 1u : 0u);
            }
        }
    });
}

TEST(corners_are_one_step_that_does_not_jump) {
    bob::Graph g;
    const bob::Expression x = g.expression(g.x()), y = g.expression(g.y());
    const bob::Tape tape(test::corner(x, y));
    CHECK_EQ(tape.code().count, 1u);
    CHECK(tape.decisions() == std::vector<Op>({Op::maximum, bob::corner_distance}));
    CHECK(std::none_of(tape.decisions().begin(), tape.decisions().end(), bob::may_jump));
    CHECK_LT(1u, bob::Tape(test::corner(x, y, 0.5)).code().count);  // is none

    struct Case {
        float x[2], y[2];
        const char* becomes;
        float least, most, slope_of_x[2], slope_of_y[2];
    };
    const Case cases[] = {
        {{3, 4}, {-2, -1}, "x", 3, 4, {1, 1}, {0, 0}},
        {{-2, -1}, {3, 4}, "y", 3, 4, {0, 0}, {1, 1}},
        {{-4, -1}, {-3, -2}, "maximum(x, y)", -3, -1, {0, 1}, {0, 1}},
        {{3, 3}, {4, 4}, "hypot(maximum(y, 0), maximum(x, 0))", 5, 5, {0.6f, 0.6f}, {0.8f, 0.8f}},
        {{4, 4}, {-1, 3}, "", 4, 5, {0.8f, 1}, {0, 0.75f}},
        {{-1, 3}, {-1, 4}, "", -1, 5, {0, 1}, {0, 1}},
    };
    test::for_each_isa([&] {
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        for (const Case& c : cases) {
            BoxBatch boxes{};
            std::fill_n(boxes.low[0], bob::max_lanes, c.x[0]), std::fill_n(boxes.high[0], bob::max_lanes, c.x[1]);
            std::fill_n(boxes.low[1], bob::max_lanes, c.y[0]), std::fill_n(boxes.high[1], bob::max_lanes, c.y[1]);
            Decision decisions[2];
            void* const memory = bob::scratch(tape.code().registers);
            kernels.bounds(tape.code(), boxes, decisions, memory);
            for (int lane = 0; lane < kernels.lanes; ++lane) {
                const bob::Expression special = tape.specialised(decisions, lane);
                if (*c.becomes && to_text(special) != c.becomes) test::fail(__FILE__, __LINE__, to_text(special));
                if (!*c.becomes) CHECK(special == tape.expression());
                CHECK_EQ(boxes.least[lane], c.least);
                CHECK_EQ(boxes.most[lane], c.most);
            }
            kernels.narrow(tape.code(), boxes, memory);
            for (int end = 0; end < 2; ++end) {
                const auto& slopes = end ? boxes.most_slope : boxes.least_slope;
                CHECK_NEAR(slopes[0][0], c.slope_of_x[end], 1e-5f);
                CHECK_NEAR(slopes[1][0], c.slope_of_y[end], 1e-5f);
            }
        }
    });
}
