/// Rays to the first root of a formula, compared with dense sampling and with known roots.
#include <ctime>

#include "formula/text.h"
#include "formulas.h"

namespace {

using bob::Segment;
using bob::Value;
using test::infinity;
using test::Random;
using test::values;

struct Ray {
    double origin[3], direction[3];
    double t_end = 4;
    double finest = 1e-5;
};

struct Root {
    float t;
    bool found, unresolved;

    friend bool operator==(const Root&, const Root&) = default;
};

/// First roots along all rays, `at_once` of them in a call.
std::vector<Root> first_roots(const bob::Tape& tape, const std::vector<Ray>& rays, std::size_t at_once = 64,
                              const std::vector<float>& least_slope = {}, const std::vector<float>& most_slope = {}) {
    std::vector<Root> roots;
    for (std::size_t first = 0; first < rays.size(); first += at_once) {
        std::vector<Segment> segments(std::min(rays.size() - first, at_once));
        std::fill_n(reinterpret_cast<unsigned char*>(segments.data()), segments.size() * sizeof(Segment),
                    static_cast<unsigned char>(0xff));  // NaN, and so are the slopes: unknown
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const Ray& ray = rays[first + i];
            for (int axis = 0; axis < 3; ++axis) {
                segments[i].origin[axis] = static_cast<float>(ray.origin[axis]);
                segments[i].direction[axis] = static_cast<float>(ray.direction[axis]);
            }
            segments[i].t_end = static_cast<float>(ray.t_end);
            segments[i].finest = static_cast<float>(ray.finest);
            if (least_slope.empty()) continue;
            segments[i].least_slope = least_slope[first + i], segments[i].most_slope = most_slope[first + i];
        }
        bob::formula_kernels_for(segments.size()).first_roots(tape.code(), segments.data(), segments.size(),
                                                              bob::scratch(tape.code().registers));
        for (const Segment& s : segments) roots.push_back({s.found ? s.t : infinity, s.found, s.unresolved});
    }
    return roots;
}

Ray random_ray(Random& random, double t_end, double finest) {
    return {{random(-1, 1), random(-1, 1), random(-1, 1)},
            {random(-1, 1), random(-1, 1), random(-1, 1)},
            t_end,
            finest};
}

template <class Build>
bob::Tape tape_of(Build build) {
    bob::Graph g;
    // In separate statements: the order of the operands of max(x, y) decides the slope where both are equal.
    const Value z = g.z(), y = g.y(), x = g.x();
    return bob::Tape(g.expression(build(g, x, y, z)));
}

/// The root along the x axis from x = `from` on.
template <class Build>
Root along_x(Build build, double from, double t_end, double finest = 1e-5) {
    return first_roots(tape_of(build), {{{from, 0, 0}, {1, 0, 0}, t_end, finest}})[0];
}

#define FORMULA(formula)                                                                                              \
    [](bob::Graph& g, Value x, Value y, Value z) -> Value {                                                           \
        static_cast<void>(g), static_cast<void>(x), static_cast<void>(y), static_cast<void>(z);                       \
        return formula;                                                                                               \
    }

#define CHECK_ROOT(formula, from, t_end, expected)                                                     \
    do {                                                                                               \
        const Root root = along_x(FORMULA(formula), from, t_end);                                      \
        if (!root.found || !(std::fabs(root.t - (expected)) <= 1e-5) || root.unresolved) {             \
            test::fail(__FILE__, __LINE__, std::string(#formula) + (root.found ? ": found " : ": lost ") + \
                                               std::to_string(root.t) + (root.unresolved ? ", unresolved" : "")); \
        }                                                                                              \
    } while (false)

#define CHECK_NO_ROOT(formula, from, t_end, told)                                                      \
    do {                                                                                               \
        const Root root = along_x(FORMULA(formula), from, t_end);                                      \
        if (root.found || root.unresolved != (told)) {                                                 \
            test::fail(__FILE__, __LINE__, std::string(#formula) + (root.found ? ": found " : ": ") +  \
                                               std::to_string(root.t) + (root.unresolved ? ", unresolved" : "")); \
        }                                                                                              \
    } while (false)

constexpr bool silent = false, unresolved = true;

}  // namespace

TEST(roots_along_the_axis) {
    test::for_each_isa([] {
        CHECK_ROOT(square(x) + square(y) + square(z) - 1, -2, 4, 1);
        CHECK_ROOT(x - 0.5, -1, 3, 1.5);
        CHECK_ROOT(0.5 - x, -1, 3, 1.5);
        CHECK_ROOT(hypot(hypot(x, y) - 0.5, z) - 0.25, -2, 4, 1.25);
        CHECK_ROOT(square(square(x) + square(y) + square(z) + 0.1875) - square(x) - square(y), -2, 4, 1.25);
        CHECK_ROOT(abs(x - 0.25) - 5e-4, -1, 3, 1.2495);                       // a slab of thickness 1e-3
        CHECK_ROOT(abs(hypot(hypot(x, y), z) - 0.75) - 5e-4, -2, 4, 1.2495);   // a shell
        CHECK_ROOT(abs(abs(hypot(x, y) - 0.75) - 0.01) - 5e-4, -2, 4, 1.2395); // two nested shells
        CHECK_ROOT((x - 0.5) * (x - 0.5001), 0, 1, 0.5);                       // two roots 1e-4 apart
        CHECK_ROOT(power(x - 0.5, 3), -1, 3, 1.5);                             // a triple one
        CHECK_ROOT(max(max(abs(x), abs(y)), abs(z)) - 0.5, -2, 4, 1.5);
        CHECK_ROOT(sin(20 * x) - 0.999, 0, 1, std::asin(0.999) / 20);
        CHECK_ROOT(exp(x) - 2, -3, 6, 3 + std::log(2));
        CHECK_ROOT(tan(x) - 1, 0, 1.5, 0.785398);
        CHECK_ROOT(atan2(x, g.constant(0.5)) - 0.5, 0, 1, 0.5 * std::tan(0.5));
        CHECK_ROOT(log(x) + 1, 0.01, 2, std::exp(-1) - 0.01);
    });
}

TEST(roots_at_the_ends_of_a_segment) {
    test::for_each_isa([] {
        CHECK_ROOT(-x, 0, 1, 0);             // from 0, which is outside, to below
        CHECK_NO_ROOT(x, 0, 1, silent);      // outside from the start
        CHECK_ROOT(x - 1, 0, 1, 1);          // to 0, which is outside
        CHECK_NO_ROOT(1 - x, 0, 1, silent);  // to 0 from outside
        CHECK_NO_ROOT(x - 1.5, 0, 1, silent);
        CHECK_NO_ROOT(x + 0.5, 0, 1, silent);
    });
}

TEST(poles_are_no_roots_and_jumps_are) {
    test::for_each_isa([] {
        CHECK_NO_ROOT(1 / x, -1, 2, silent);
        CHECK_NO_ROOT(1 / (x - 0.3), -1, 2, silent);
        CHECK(!along_x(FORMULA(tan(x)), 1, 1.5).found);
        CHECK(!along_x(FORMULA(-tan(x)), 1, 1.5).found);
        CHECK_NO_ROOT(1 / power(x - 0.1, 3), -1, 2, silent);
        CHECK_ROOT(1 / x - 2, -1, 3, 1.5);                 // after a pole
        CHECK_ROOT(floor(x) - 0.5, 0.3, 2, 0.7);
        CHECK_ROOT(ceil(x) - 1.5, 0.3, 2, 0.7);
        CHECK_ROOT(round(x) - 0.5, 0.1, 2, 0.4);
        CHECK_ROOT(select(x - 0.3, g.constant(1), g.constant(-1)), 0, 2, 0.3);
        CHECK_ROOT(modulo(x, 0.7) - 0.699, 0, 2, 0.699);
        CHECK_ROOT(0.1 - modulo(x - 0.2, 0.7), 0.35, 2, 0.55);  // up to the jump from 0.7 to 0
        CHECK_ROOT(atan(1 / x), -1, 2, 1);
        CHECK_ROOT(atan2(x, g.constant(-1)), -1, 2, 1);
        CHECK_ROOT(modulo(x, y + 0.7) - 0.35, 0, 2, 0.35);
    });
}

TEST(edges_of_the_domain_are_no_roots) {
    test::for_each_isa([] {
        CHECK_NO_ROOT(sqrt(x), -1, 2, silent);
        CHECK_NO_ROOT(-1 - sqrt(x), -1, 2, silent);
        CHECK_NO_ROOT(sqrt(-x) - 2, -1, 2, silent);
        CHECK_ROOT(sqrt(x) - 0.5, -1, 2, 1.25);
        CHECK_ROOT(log(x), -1, 3, 2);
        CHECK_ROOT(acos(x) - 0.5, -2, 4, 2 + std::cos(0.5));
        CHECK_NO_ROOT(min(x, sqrt(x - 0.5)) - 0.1, 0, 0.4, silent);  // NaN all the way
        CHECK_NO_ROOT(min(x - 0.2, sqrt(x - 0.5)), 0, 1, silent);    // NaN where x - 0.2 is 0
    });
}

TEST(constant_and_infinite_formulas_have_no_roots) {
    test::for_each_isa([] {
        CHECK_NO_ROOT(g.constant(1), -1, 2, silent);
        CHECK_NO_ROOT(g.constant(-1), -1, 2, silent);
        CHECK_NO_ROOT(g.constant(0), -1, 2, silent);
        CHECK_NO_ROOT(g.constant(infinity), -1, 2, silent);
        CHECK_NO_ROOT(x - x, -1, 2, silent);
        CHECK_NO_ROOT(max(x, y) - max(x, z), -1, 2, silent);
        CHECK_NO_ROOT(square(x), -1, 2, silent);
        CHECK_ROOT(exp(-100 * x) - 1, -1, 2, 1);               // from infinite values
        CHECK_ROOT(exp(-300 * x) - exp(g.constant(30)), -1, 2, 0.9);
        CHECK_ROOT(1 - exp(100 * x), -1, 2, 1);
        CHECK_NO_ROOT(exp(200 * x) - exp(400 * x) + 1e30, 0.5, 0.4, unresolved);  // inf - inf
    });
}

TEST(thin_parts_behind_infinite_values_are_found) {
    // The slab of thickness 0.01 lies in a piece that begins with an infinite value and an infinite slope.
    test::for_each_isa([] {
        CHECK_ROOT(exp(-100 * x) + (abs(x - 0.5) - 0.005), -1, 2, 1.495);
    });
}

TEST(tangent_rays_are_unresolved_and_others_are_not) {
    test::for_each_isa([] {
        const bob::Tape sphere = tape_of(FORMULA(square(x) + square(y) + square(z) - 1));
        std::vector<Ray> rays;
        for (const double y : {1 + 1e-3, 1 - 1e-3, 1., 0.999999, 0.3}) rays.push_back({{-2, y, 0}, {1, 0, 0}});
        const std::vector<Root> roots = first_roots(sphere, rays);
        CHECK(!roots[0].found && !roots[0].unresolved);
        CHECK(roots[1].found && !roots[1].unresolved);
        CHECK_NEAR(roots[1].t, 2 - std::sqrt(1 - 0.999 * 0.999), 1e-4);
        CHECK(!roots[2].found);  // touches it at most
        CHECK(roots[3].found && !roots[3].unresolved);
        CHECK(roots[4].found && !roots[4].unresolved);
        // Two roots closer together than `finest`, and farther apart.
        const auto twins = FORMULA((x - 0.5) * (x - 0.500001));
        const Root close = along_x(twins, 0, 1, 1e-4);
        CHECK(!close.found && close.unresolved);
    });
}

TEST(lanes_do_not_know_of_each_other) {
    // A ray's result is the same to the bit alone, among others, and in another order.
    test::for_each_isa([] {
        Random random(7);
        for (int i = 0; i < 60; ++i) {
            const bob::Tape tape(test::random_formula(random));
            std::vector<Ray> rays;
            for (int k = 0; k < 32; ++k) {
                rays.push_back(random_ray(random, random(0.1f, 3), 1e-3));
            }
            const std::vector<Root> together = first_roots(tape, rays), alone = first_roots(tape, rays, 1);
            std::reverse(rays.begin(), rays.end());
            std::vector<Root> backwards = first_roots(tape, rays, 3);
            std::reverse(backwards.begin(), backwards.end());
            CHECK(together == alone);
            CHECK(together == backwards);
        }
    });
}

TEST(many_rays_see_every_step_as_one_does) {
    // Single steps around a root: the kernel evaluates two positions of many rays together, and of few rays one by one.
    test::for_each_isa([] {
        std::vector<bob::Expression> steps;
        for (int i = static_cast<int>(bob::Op::negate); i < bob::op_count; ++i) {
            bob::Graph g;
            const Value operand[] = {g.x(), g.y(), g.z()};
            const auto op = static_cast<bob::Op>(i);
            if (op == bob::Op::mesh_distance) {
                steps.emplace_back(g.expression(g.mesh_distance(test::some_mesh(), operand[0], operand[1], operand[2])));
            } else if (!bob::may_jump(op)) {
                const double value = bob::evaluate(op, 3, 0.4, 0.3, 0.2);
                steps.emplace_back(g.expression(g.like({.op = op, .value = 3}, operand) - value));
            }
        }
        bob::Graph g;
        const bob::Expression x = g.expression(g.x() - 0.4), y = g.expression(g.y() - 0.3);
        steps.emplace_back(test::corner(x, y));
        Random random(12);
        for (const bob::Expression& step : steps) {
            const bob::Tape tape(step);
            CHECK(!tape.code().may_jump);
            std::vector<Ray> rays;
            for (int k = 0; k < 64; ++k) {
                rays.push_back(random_ray(random, 1, 1e-3));
                auto& [origin, direction, t_end, finest] = rays.back();
                for (int axis = 0; axis < 3; ++axis) origin[axis] = 0.4 - 0.1 * axis - random(0.2f, 0.8f) * direction[axis];
            }
            const std::vector<Root> together = first_roots(tape, rays), alone = first_roots(tape, rays, 1);
            CHECK(together == alone);
            CHECK_LT(4, std::count_if(alone.begin(), alone.end(), [](const Root& root) { return root.found; }));
        }
    });
}

TEST(every_segment_is_searched_however_many_there_are) {
    // Rays with equally many pieces, and a few rays with far more, in queues of about as many rays as lanes.
    test::for_each_isa([] {
        const bob::Tape ball = tape_of(FORMULA(square(x) + square(y) - 1));
        const bob::Tape shell = tape_of(FORMULA(abs(hypot(x, y) - 0.75) - 1e-4));
        for (const std::size_t count : {1, 3, 4, 5, 8, 9, 15, 16, 17, 33, 64}) {
            std::vector<Ray> alike, unlike;
            for (std::size_t i = 0; i < count; ++i) {
                alike.push_back({{-2, 0.5, 0}, {1, 0, 0}});
                unlike.push_back({{i % 5 ? -0.7 : -2, i % 5 ? 0.1 : 0.7499, 0}, {1, 0, 0}});
            }
            for (const Root& root : first_roots(ball, alike)) {
                CHECK(root.found && std::fabs(root.t - (2 - std::sqrt(0.75))) < 1e-5);
            }
            const std::vector<Root> together = first_roots(shell, unlike), alone = first_roots(shell, unlike, 1);
            for (std::size_t i = 0; i < count; ++i) CHECK(together[i].found && together[i] == alone[i]);
        }
    });
}

TEST(slopes_that_are_known_change_nothing) {
    // Segments in a box with bounded slopes, like rays in cells. Results differ by rounding only where all is resolved.
    int known = 0, settled = 0;
    test::for_each_isa([&] {
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        Random random(10);
        for (int i = 0; i < 3000; ++i) {
            const bob::Tape tape(test::random_formula(random));
            bob::BoxBatch boxes{};
            const float half = random(0.01f, 0.3f);
            float center[3];
            for (int axis = 0; axis < 3; ++axis) {
                center[axis] = random(-1, 1);
                std::fill_n(boxes.low[axis], bob::max_lanes, center[axis] - half);
                std::fill_n(boxes.high[axis], bob::max_lanes, center[axis] + half);
            }
            std::vector<bob::Decision> decisions(tape.decisions().size());
            kernels.bounds(tape.code(), boxes, decisions.data(), bob::scratch(tape.code().registers));
            kernels.narrow(tape.code(), boxes, bob::scratch(tape.code().registers));
            std::vector<Ray> rays;
            std::vector<float> least, most;
            for (int k = 0; k < 8; ++k) {
                Ray& ray = rays.emplace_back();
                ray = {{}, {}, 1, 1e-5};
                least.push_back(0), most.push_back(0);
                for (int axis = 0; axis < 3; ++axis) {
                    const float a = center[axis] + random(-0.99f, 0.99f) * half;
                    const float b = center[axis] + random(-0.99f, 0.99f) * half;
                    ray.origin[axis] = a, ray.direction[axis] = b - a;
                    const float p = boxes.least_slope[axis][0] * (b - a), q = boxes.most_slope[axis][0] * (b - a);
                    const float slack = 1e-6f * (std::fabs(p) + std::fabs(q));
                    least.back() += std::min(p, q) - slack, most.back() += std::max(p, q) + slack;
                }
                known += std::fabs(least.back()) + std::fabs(most.back()) < infinity;
                settled += least.back() > 0 || most.back() < 0;
            }
            const std::vector<Root> plain = first_roots(tape, rays), quick = first_roots(tape, rays, 64, least, most);
            CHECK(quick == first_roots(tape, rays, 1, least, most));
            std::vector<float> of_some = least;
            for (std::size_t k = 0; k < rays.size(); k += 2) of_some[k] = NAN;
            const std::vector<Root> mixed = first_roots(tape, rays, 64, of_some, most);
            for (std::size_t k = 0; k < rays.size(); ++k) CHECK(mixed[k] == (k % 2 ? quick : plain)[k]);
            for (std::size_t k = 0; k < rays.size(); ++k) {
                if (plain[k].unresolved || quick[k].unresolved || plain[k] == quick[k]) continue;
                if (plain[k].found && quick[k].found && std::fabs(plain[k].t - quick[k].t) <= 1e-6f) continue;
                test::fail(__FILE__, __LINE__, "found " + std::to_string(plain[k].t) + ", with slopes " +
                                                   std::to_string(quick[k].t) + " of " + to_text(tape.expression()));
            }
        }
    });
    CHECK_LT(10000, known);
    CHECK_LT(1000, settled);
}

TEST(the_first_root_is_found_in_whatever_part_it_is) {
    test::for_each_isa([] {
        CHECK_ROOT((x - 0.1) * (x - 0.1002) * (x - 0.6), 0, 1, 0.1);  // two before the part whose ends differ
        CHECK_ROOT((x - 0.4) * (x - 0.4002) * (x - 0.9), 0, 1, 0.4);
        CHECK_ROOT(1 / (x - 0.4) - 2, 0, 1, 0.9);                     // behind a pole
        CHECK_ROOT(1 / (x - 0.1) - 2, 0, 1, 0.6);
        CHECK_ROOT((x - 0.2) * square(x - 0.9), 0, 1, 0.2);           // a later touch of zero causes no doubt
        CHECK_NO_ROOT(-square(x - 0.9), 0, 1, unresolved);
        CHECK_ROOT((0.5 - x) * square(x - 0.1) + 0 * y, 0.2, 0.8, 0.3);
    });
}

TEST(jumps_in_any_part_of_a_segment_are_found) {
    test::for_each_isa([] {
        for (const double at : {0.05, 0.3, 0.333333, 0.35, 0.5, 0.65, 0.666667, 0.7, 0.95}) {
            const auto ray = [&](auto build) { return first_roots(tape_of(build), {{{0, 0, 0}, {1, 0, 0}, 1}})[0]; };
            const auto found = [&](const Root& root) { return root.found && !root.unresolved && std::fabs(root.t - at) <= 1e-5; };
            // One jump, an even number of them, and one before a root that a later part's ends show.
            CHECK(found(ray([&](bob::Graph&, Value x, Value, Value) { return floor(x - at) + 0.5; })));
            CHECK(found(ray([&](bob::Graph& g, Value x, Value, Value) {
                return select(max(at - x, x - (at + 0.01)), g.constant(-1), g.constant(1));
            })));
            CHECK(found(ray([&](bob::Graph&, Value x, Value, Value) { return (floor(x - at) + 0.5) * (0.98 - x); })));
        }
        CHECK_ROOT(select(x - 0.3, 1 / (x - 0.2), x - 0.7), 0, 1, 0.3);       // a jump behind a pole
        CHECK_NO_ROOT(1 / (x - 0.2) + 2 * floor(x + 0.5), 0, 1, silent);      // and one that changes no sign
        CHECK_ROOT(select(x - 0.4, 1 / (x - 0.1), x - 0.5), 0.2, 0.7, 0.2);   // in the rest behind a part, and the first of two
    });
}

TEST(selects_that_meet_have_slopes) {
    // |x - 0.2| - 0.1 in two pieces; the plain select is thought to jump, and takes more bounds.
    const bob::Tape meets = tape_of(FORMULA(piecewise(x - 0.2, 0.2 - x, x - 0.2) - 0.1));
    const bob::Tape plain = tape_of(FORMULA(select(x - 0.2, 0.2 - x, x - 0.2) - 0.1));
    CHECK(std::none_of(meets.decisions().begin(), meets.decisions().end(), bob::may_jump));
    CHECK(std::any_of(plain.decisions().begin(), plain.decisions().end(), bob::may_jump));
    CHECK_EQ(meets.code().count, plain.code().count);
    test::for_each_isa([&] {
        const bob::FormulaKernels& kernels = bob::best_formula_kernels();
        for (const bob::Tape* tape : {&meets, &plain}) {
            bob::BoxBatch boxes{};
            for (int axis = 0; axis < 3; ++axis) {
                std::fill_n(boxes.low[axis], bob::max_lanes, 0.f), std::fill_n(boxes.high[axis], bob::max_lanes, 1.f);
            }
            bob::Decision decision;
            kernels.bounds(tape->code(), boxes, &decision, bob::scratch(tape->code().registers));
            CHECK_EQ(decision.first | decision.second, 0u);
            kernels.narrow(tape->code(), boxes, bob::scratch(tape->code().registers));
            if (tape == &plain) {
                CHECK(!std::isfinite(boxes.least_slope[0][0]));
                continue;
            }
            CHECK_EQ(boxes.least_slope[0][0], -1);
            CHECK_EQ(boxes.most_slope[0][0], 1);
            CHECK_EQ(boxes.most_slope[1][0], 0);
        }
        for (const bob::Tape* tape : {&meets, &plain}) {
            const Root root = first_roots(*tape, {{{0, 0, 0}, {1, 0, 0}, 1}})[0];
            CHECK(root.found && std::fabs(root.t - 0.1) < 1e-5);
            CHECK(!first_roots(*tape, {{{0.12, 0, 0}, {1, 0, 0}, 0.15}})[0].found);
        }
    });
}

TEST(values_that_overflow_and_are_left_out_leave_slopes_trusted) {
    // Terms in x + 1 cancel each other but for 1e-5 of them, which slopes alone show.
    test::for_each_isa([] {
        CHECK_NO_ROOT(min((x + 1) - 0.99999 * (x + 1) + 1e-7, exp(100 + 10 * x)), -0.99, 1, silent);
        CHECK_NO_ROOT(min((x + 1) - 0.99999 * (x + 1) + 1e-7, exp(100 + 10 * x) * 3 - 7), -0.99, 1, silent);
        CHECK_ROOT(min(x - 0.3, log(exp(100 + 10 * x) + exp(95 - 10 * x))), -1, 2, 1.3);
    });
}

TEST(wild_formulas_take_bounded_time) {
    test::for_each_isa([] {
        const std::clock_t start = std::clock();  // of the processor: other programs must not fail the test
        for (const bob::Tape& tape :
             {tape_of(FORMULA(sin(1e6 * x) * sin(1e5 * y + z) + 1e-3 * sin(3e4 * z))), tape_of(FORMULA(sin(1 / x))),
              tape_of(FORMULA(tan(1e3 * x * y) * floor(1e4 * z))), tape_of(FORMULA(max(x, y) - max(x, y + 0 * z))),
              tape_of(FORMULA(exp(1e3 * x) - exp(1e3 * y) * modulo(x, y)))}) {
            Random random(8);
            std::vector<Ray> rays;
            for (int k = 0; k < 16; ++k) {
                rays.push_back(random_ray(random, 2, k % 2 ? 1e-5 : 1e-9));
            }
            first_roots(tape, rays);
        }
        CHECK_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 2);
    });
}

TEST(random_rays_match_dense_sampling) {
    // Before the reported root, or along the whole ray without one, the sign never changes between neighbours of 2048
    // samples, except at poles and within rounding. At a reported root, the sign changes nearby.
    constexpr int dense = 2048;
    int hits = 0, misses = 0, vague = 0;
    test::for_each_isa([&] {
        Random random(9);
        for (int i = 0; i < 2500; ++i) {
            // Minus its value at some point, so that many rays have a root.
            const bob::Expression plain = test::random_formula(random);
            const test::Point somewhere{random(-1, 1), random(-1, 1), random(-1, 1)};
            const double level = plain(somewhere[0], somewhere[1], somewhere[2]);
            bob::Graph g;
            const bob::Expression f = g.expression(g.substitute(plain, g.x(), g.y(), g.z()) -
                                                   (std::fabs(level) < 1e9 ? level : 0));
            const bob::Tape tape(f);
            std::vector<Ray> rays;
            for (int k = 0; k < 4; ++k) {
                rays.push_back(random_ray(random, random(0.1f, 3), 1e-4));
            }
            const std::vector<Root> roots = first_roots(tape, rays);
            for (std::size_t k = 0; k < rays.size(); ++k) {
                const auto at = [&](double t) {
                    test::Point p;
                    for (int axis = 0; axis < 3; ++axis) {
                        p[axis] = static_cast<float>(rays[k].origin[axis]) +
                                  static_cast<float>(t) * static_cast<float>(rays[k].direction[axis]);
                    }
                    return p;
                };
                const auto complain = [&](const char* what, double t) {
                    std::ostringstream text;
                    text << "formula " << i << ", ray " << k << ": " << what << " at " << t << ", found "
                         << roots[k].found << " at " << roots[k].t << " of " << to_text(f) << " from "
                         << rays[k].origin[0] << ", " << rays[k].origin[1] << ", " << rays[k].origin[2] << " along "
                         << rays[k].direction[0] << ", " << rays[k].direction[1] << ", " << rays[k].direction[2]
                         << " to " << rays[k].t_end << ", " << name(bob::isa());
                    test::fail(__FILE__, __LINE__, text.str());
                };
                const auto exact = [&](double t) { return f(at(t)[0], at(t)[1], at(t)[2]); };
                // The sign of f if it is certain, else 0.
                const auto sign = [&](double t) {
                    const auto [value, error] = test::estimate(f, at(t));
                    return value < -4 * error ? -1 : value > 4 * error ? 1 : 0;
                };
                if (roots[k].unresolved) ++vague;
                (roots[k].found ? hits : misses) += 1;
                std::vector<test::Point> points;
                const double end = roots[k].found ? roots[k].t : rays[k].t_end;
                for (int s = 0; s <= dense; ++s) points.push_back(at(end * s / dense));
                const std::vector<float> got = values(tape, points);
                for (int s = 0; s < dense && !roots[k].unresolved; ++s) {
                    const float a = got[static_cast<std::size_t>(s)], b = got[static_cast<std::size_t>(s) + 1];
                    if (!((a < 0 && b >= 0) || (a >= 0 && b < 0))) continue;
                    double from = end * s / dense, to = end * (s + 1) / dense;
                    if (roots[k].found && to > end - 2e-4) continue;
                    if (sign(from) * sign(to) >= 0) continue;
                    // A root closes in on 0 or jumps between finite values; at a pole the values grow, at an edge of
                    // the domain they end.
                    bool number = true;
                    for (int step = 0; step < 24 && number; ++step) {
                        const double middle = (from + to) / 2, value = exact(middle);
                        number = !std::isnan(value);
                        ((value < 0) == (a < 0) ? from : to) = middle;
                    }
                    const double left = exact(from), right = exact(to);
                    const double highest = std::min(100., 10. * std::max(std::fabs(a), std::fabs(b)));
                    if (number && std::fabs(left) + std::fabs(right) < highest) complain("missed a change", from);
                }
                if (roots[k].found) {
                    // Somewhere around the root f is below zero, and somewhere it is not.
                    std::vector<test::Point> around;
                    for (double off = 1e-7; off < 1.1e-4; off = std::min(2 * off, off + 2e-6)) {
                        around.push_back(at(std::max(0., roots[k].t - off)));
                        around.push_back(at(std::min(rays[k].t_end, roots[k].t + off)));
                    }
                    const std::vector<float> near = values(tape, around);
                    const auto below = std::count_if(near.begin(), near.end(), [](float f_near) { return f_near < 0; });
                    const bool zero = std::find(near.begin(), near.end(), 0.f) != near.end();
                    const bool changes = zero || (below > 0 && below < static_cast<long>(near.size()));
                    if (!changes) complain("no change", roots[k].t);
                }
            }
        }
    });
    CHECK_LT(150, hits);
    CHECK_LT(150, misses);
    CHECK_LT(vague, (hits + misses) / 10);
}

TEST(steps_of_one_op_follow_each_other_and_compute_the_same) {
    const bob::Tape tape = tape_of([](bob::Graph&, Value x, Value y, Value z) {
        Value f = x;
        for (int i = 1; i < 20; ++i) {
            const Value a = x * i + 0.5, square = a * a, other = y * i - z;
            f = max(f - square, min(other, square));
        }
        return f;
    });
    std::vector<bob::Instruction> grouped(tape.code().instructions, tape.code().instructions + tape.code().count);
    bob::Code code = tape.code();
    bob::group_steps(grouped, code.registers, code.result);
    code.instructions = grouped.data();
    const auto changes = [](const bob::Code& c) {
        int count = 0;
        for (std::size_t i = 1; i < c.count; ++i) count += c.instructions[i].op != c.instructions[i - 1].op;
        return count;
    };
    CHECK_LT(3 * changes(code), 2 * changes(tape.code()));
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    const float p[3][1] = {{0.3f}, {-0.2f}, {0.7f}};
    const float* const point[3] = {p[0], p[1], p[2]};
    float before, after;
    kernels.values(tape.code(), point, 1, &before, bob::scratch(tape.code().registers));
    kernels.values(code, point, 1, &after, bob::scratch(code.registers));
    CHECK_EQ(before, after);
}
