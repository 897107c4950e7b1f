/// Implicit surfaces met by many rays: their cells' codes, and that rays do not know of each other.
#include "shapes/implicit/implicit.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "formula/scratch.h"
#include "formulas.h"

namespace {

using bob::Cells;
using bob::Hit;
using bob::Value;
using test::Random;

bob::Expression expression(Value (*build)(bob::Graph&, Value, Value, Value)) {
    bob::Graph g;
    const Value x = g.x(), y = g.y(), z = g.z();
    return g.expression(build(g, x, y, z));
}

/// Formulas whose cells share many codes, few, no codes, and codes without instructions.
std::vector<bob::Expression> formulas() {
    return {
        // Three faces of a cube's corner: in most cells the code is no more than x, y or z.
        expression([](bob::Graph&, Value x, Value y, Value z) { return max(max(x, y), z); }),
        expression([](bob::Graph&, Value x, Value y, Value z) {
            const Value ball = sqrt(square(x) + square(y) + square(z)) - 0.9;
            const Value hole = hypot(x, y) - 0.4;
            return max(max(ball, abs(z) - 0.7), 0 - hole);
        }),
        expression([](bob::Graph& g, Value x, Value y, Value z) {
            Value nearest = g.constant(1);
            for (int i = 0; i < 12; ++i) {
                const double a = std::sin(3 * i), b = std::sin(5 * i + 1), c = std::sin(7 * i + 2);
                const Value far = square(x - 0.7 * a) + square(y - 0.7 * b);
                nearest = min(nearest, sqrt(far + square(z - 0.7 * c)) - (0.1 + 0.01 * i));
            }
            return nearest;
        }),
        expression([](bob::Graph&, Value x, Value y, Value z) {
            const Value waves = sin(9 * x) * cos(9 * y), more = sin(9 * z) * cos(9 * x);
            return abs(waves + more) - 0.2;
        }),
        // A smooth union, whose exponentials overflow.
        expression([](bob::Graph&, Value x, Value y, Value z) {
            const Value a = 200 * (hypot(x, y) - 0.3), b = 200 * (hypot(y, z) - 0.2);
            const Value both = exp(-1 * a) + exp(-1 * b);
            return log(both) * -0.005;
        }),
    };
}

bob::Implicit surface(const bob::Expression& f) { return {f, bob::Bounds{{-1, -1, -1}, {1, 1, 1}}}; }

/// Towards the surface from all around, along axes too, neighbours one after the other.
std::vector<bob::Ray> rays_around(int count) {
    Random random(11);
    std::vector<bob::Ray> rays;
    for (int i = 0; i < count; ++i) {
        const bob::Vec3 from = normalized(bob::Vec3{random(-1, 1), random(-1, 1), random(-1, 1)});
        const bob::Vec3 to{random(-0.8f, 0.8f), random(-0.8f, 0.8f), random(-0.8f, 0.8f)};
        rays.push_back({2.f * from, (i % 3 ? 1.f : 0.5f) * (to - 2.f * from)});
        if (i % 16 == 0) rays.back() = {{to.x, to.y, 2}, {0, 0, -1}};
    }
    return rays;
}

std::vector<Hit> closest_hits(const bob::Implicit& shape, const std::vector<bob::Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    shape.closest_hits(rays, hits);
    return hits;
}

bool same(const Hit& a, const Hit& b) { return a.t == b.t && a.primitive == b.primitive; }

}  // namespace

TEST(codes_of_cells_are_the_formula_there_and_stand_once) {
    for (const bob::Expression& f : formulas()) {
        const Cells cells(f);
        const bob::Tape whole(f);
        std::map<std::pair<std::string_view, int>, std::uint32_t> seen;
        for (std::uint32_t number = 0; number < cells.codes(); ++number) {
            const bob::Code code = cells.code(number);
            const std::string_view bytes(reinterpret_cast<const char*>(code.instructions),
                                         code.count * sizeof(bob::Instruction));
            CHECK(seen.emplace(std::pair{bytes, code.result}, number).second);
        }
        CHECK_LT(cells.codes(), cells.cells().size());
        Random random(12);
        for (const Cells::Cell& cell : cells.cells()) {
            const bob::Box box = Cells::box(cell);
            std::vector<test::Point> points(4);
            for (test::Point& p : points) {
                for (int axis = 0; axis < 3; ++axis) {
                    p[static_cast<std::size_t>(axis)] = random(box.low[axis], box.high[axis]);
                }
            }
            float at[3][4], value[4], gradient[3][4];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (std::size_t i = 0; i < 4; ++i) at[axis][i] = points[i][axis];
            }
            const float* const axes[3] = {at[0], at[1], at[2]};
            float* const slopes[3] = {gradient[0], gradient[1], gradient[2]};
            bob::best_formula_kernels().gradients(cells.code(cell.code), axes, 4, false, value, slopes,
                                                  bob::scratch(cells.max_registers()));
            const std::vector<float> expected = test::values(whole, points);
            for (std::size_t i = 0; i < 4; ++i) {
                CHECK_NEAR(value[i], expected[i], 1e-5f);
                for (int axis = 0; axis < 3; ++axis) {
                    const float slope = gradient[axis][i], slack = 1e-4f * (1 + std::fabs(slope));
                    CHECK(!(slope < cell.least_slope[axis] - slack) && !(slope > cell.most_slope[axis] + slack));
                }
            }
        }
    }
}

TEST(cells_share_a_long_formula_of_which_each_needs_nearly_all) {
    // In nearly every cell, |x| is x or -x.
    const Cells few(expression([](bob::Graph&, Value x, Value y, Value z) { return abs(x) + square(y) + square(z) - 0.5; }));
    const Cells many(expression([](bob::Graph&, Value x, Value y, Value z) {
        Value sum = abs(x) + square(y) + square(z) - 0.5;
        for (int i = 1; i <= 12; ++i) sum = sum + 0.001 * sin(i * x + y) * cos(z + i);
        return sum;
    }));
    CHECK_LT(1, few.codes());
    CHECK(many.codes() == 1);
}

TEST(rays_meet_alone_what_they_meet_together) {
    // To the bit, whatever else is traced with them, and with every instruction set.
    const std::vector<bob::Ray> rays = rays_around(700);
    for (const bob::Expression& f : formulas()) {
        const bob::Implicit shape = surface(f);
        const std::vector<Hit> together = closest_hits(shape, rays);
        CHECK_LT(100, std::count_if(together.begin(), together.end(), [](const Hit& h) { return h.t < test::infinity; }));
        test::for_each_isa([&] {
            std::vector<bob::Ray> backwards(rays.rbegin(), rays.rend());
            const std::vector<Hit> reversed = closest_hits(shape, backwards), again = closest_hits(shape, rays);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                CHECK(same(again[i], together[i]));
                CHECK(same(reversed[rays.size() - 1 - i], together[i]));
                if (i % 7 == 0) CHECK(same(closest_hits(shape, {rays[i]})[0], together[i]));
            }
        });
        CHECK_EQ(shape.unresolved_rays(), 0u);
    }
}

TEST(rays_that_pass_an_unresolved_place_are_counted_once_each) {
    // Two roots too close together at 0, then one at 0.5; rays that go the other way come to the solid's end first.
    const bob::Implicit shape = surface(expression([](bob::Graph&, Value x, Value, Value) { return x * (x + 2e-7) * (0.5 - x); }));
    const bob::Ray forth{{-2, 0.1f, 0.1f}, {1, 0, 0}}, back{{2, 0.1f, 0.1f}, {-1, 0, 0}}, past{{-2, 5, 0}, {1, 0, 0}};
    const std::vector<Hit> hits = closest_hits(shape, {forth, back, forth, past});
    CHECK_NEAR(hits[0].t, 2.5f, 1e-5f);
    CHECK_NEAR(hits[1].t, 1, 1e-4f);
    CHECK_EQ(shape.unresolved_rays(), 2u);
}

TEST(normals_of_a_jump_are_those_of_what_jumps) {
    // Each ends at a jump on x + y / 2 = 1/8, inside a ball.
    using Build = Value (*)(bob::Graph&, Value, Value);
    const std::pair<const char*, Build> jumps[] = {
        {"select", [](bob::Graph& g, Value f, Value ball) { return select(f, ball, g.constant(0.5)); }},
        {"select to zero", [](bob::Graph& g, Value f, Value) { return select(f, g.constant(-1), g.constant(0)); }},
        {"two selects", [](bob::Graph& g, Value f, Value ball) {
             const Value truth = select(f, g.constant(-1), g.constant(1));
             return select(max(truth, ball - 0.2), ball - 0.1, g.constant(2));
         }},
        {"floor", [](bob::Graph&, Value f, Value) { return floor(f + 1) - 0.5; }},
        {"ceil", [](bob::Graph&, Value f, Value) { return ceil(f * 0.1) - 0.5; }},
        {"round", [](bob::Graph&, Value f, Value) { return round(f + 0.5) - 0.5; }},
        {"modulo", [](bob::Graph&, Value f, Value) { return 0.5 - modulo(f, 8); }},
        {"angle", [](bob::Graph&, Value f, Value ball) { return atan2(f, ball - 1); }},
        {"quotient", [](bob::Graph&, Value f, Value) { return f / abs(f); }},
        {"angle of a quotient", [](bob::Graph&, Value f, Value) { return atan(1 / f); }},
        {"tangent", [](bob::Graph&, Value f, Value) { return -atan(tan(f + 1.5707963267948966)); }},
    };
    Random random(5);
    std::vector<bob::Ray> rays;
    for (int i = 0; i < 400; ++i) {
        const bob::Vec3 to{random(-0.4f, 0.4f), random(-0.4f, 0.4f), random(-0.4f, 0.4f)};
        const bob::Vec3 from{random(2, 4), random(-2, 2), random(-2, 2)};
        rays.push_back({from, to - from});
    }
    const bob::Vec3 expected = bob::normalized({1, 0.5f, 0});
    for (const auto& [name, build] : jumps) {
        bob::Graph g;
        const Value x = g.x(), y = g.y(), z = g.z();
        const Value ball = sqrt(square(x) + square(y) + square(z)) - 0.7;
        const Value jump = build(g, x + 0.5 * y - 0.125, ball);
        const bob::Implicit shape = surface(g.expression(max(jump, ball)));
        test::for_each_isa([&, name = name] {
            std::vector<Hit> hits = closest_hits(shape, rays);
            std::vector<bob::Vec3> normals(rays.size());
            for (Hit& hit : hits) hit.primitive = hit.t < test::infinity ? hit.primitive : 0;
            shape.normals(rays, hits, normals);
            int met = 0, wrong = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const bob::Vec3 p = rays[i].origin + hits[i].t * rays[i].direction;
                if (!(std::fabs(p.x + 0.5f * p.y - 0.125f) < 1e-5f) || bob::length(p) > 0.69f) continue;
                ++met;
                wrong += !(bob::dot(normals[i], expected) > 0.9999f);
            }
            if (met < 100 || wrong > 0) test::fail(__FILE__, __LINE__, std::string(name) + ": " + std::to_string(wrong) + " of " + std::to_string(met));
        });
    }
}

TEST(colors_change_no_hit_and_are_those_of_their_formula) {
    const std::vector<bob::Ray> rays = rays_around(300);
    const bob::Bounds box{{-3, -2, -1}, {1, 2, 3}};  // so that units differ: half as large, around (-1, 0, 1)
    bob::Graph g;
    const Value x = g.x(), y = g.y(), z = g.z();
    const Value waves = sin(3 * x) * 0.5 + 0.5, below = z - 1;
    const bob::ColorFormula color = g.color_formula({waves, select(below, y, 0.5 - y), modulo(x, 0.4) * 2 + 0.1});
    for (const bob::Expression& f : formulas()) {
        const bob::Implicit plain(f, box), colored(f, box, &color);
        CHECK(!plain.is_colored() && colored.is_colored());
        CHECK_EQ(plain.cells().codes(), colored.cells().codes());
        test::for_each_isa([&] {
            const std::vector<Hit> hits = closest_hits(colored, rays), expected = closest_hits(plain, rays);
            std::vector<bob::Ray> meeting;
            std::vector<Hit> met;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                CHECK(same(hits[i], expected[i]));
                if (hits[i].t < test::infinity) meeting.push_back(rays[i]), met.push_back(hits[i]);
            }
            std::vector<bob::Vec3> colors(met.size()), normals(met.size()), plain_normals(met.size());
            colored.normals(meeting, met, normals), plain.normals(meeting, met, plain_normals);
            colored.colors(meeting, met, std::vector<float>(met.size()), colors);
            std::size_t far = 0;
            for (std::size_t i = 0; i < met.size(); ++i) {
                const bob::Vec3 p = meeting[i].origin + met[i].t * meeting[i].direction;
                const auto rgb = color(2.0 * p.x - 1, 2.0 * p.y, 2.0 * p.z + 1);
                for (int k = 0; k < 3; ++k) {
                    CHECK(normals[i][k] == plain_normals[i][k]);
                    CHECK(colors[i][k] >= 0 && colors[i][k] <= 1);
                    far += std::fabs(colors[i][k] - rgb[static_cast<std::size_t>(k)]) > 1e-5;
                }
            }
            CHECK_LT(20u, met.size());
            CHECK_LT(far, 3u);  // where the formula jumps
        });
    }
}
