#include "shapes/implicit/painting.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "check.h"
#include "formula/pruning.h"
#include "formula/scratch.h"

namespace {

struct Scene {
    bob::Expression shape;
    bob::ColorFormula color;
};

/// The distance from a right angle between two planes, as the modelling words have it.
bob::Value corner(bob::Value a, bob::Value b) { return select(min(a, b), max(a, b), hypot(max(a, 0), max(b, 0))); }

/// Many balls and corners, each with another pattern, with all ops that boxes decide; some square roots are NaN in places.
Scene many_shapes(int count, bool has_roots) {
    bob::Graph g;
    const bob::Value x = g.x(), y = g.y(), z = g.z();
    test::Random random(7);
    bob::Value nearest = g.constant(9);
    std::array<bob::Value, 3> color{g.constant(0), g.constant(0), g.constant(0)};
    for (int i = 0; i < count; ++i) {
        const bob::Value u = x - random(-1, 1), v = y - random(-1, 1), w = z - random(-1, 1);
        const double size = random(0.05f, 0.2f);
        const bob::Value distance = i % 2 ? hypot(hypot(u, v), w) - size : corner(max(abs(u) - size, abs(w) - size), abs(v) - size);
        const std::array<bob::Value, 3> own{abs(floor(u * 9)) * 0.2 + 0.05 * (i % 7), max(min(v * 4, w * 3), round(u * 5) * 0.1),
                                            has_roots ? min(g.constant(0.1), sqrt(u) + 1) : select(w, g.constant(0.3), v * v)};
        const bob::Value is_nearer = distance - nearest;
        for (std::size_t k = 0; k < 3; ++k) color[k] = select(is_nearer, own[k], color[k]);
        nearest = min(nearest, distance);
    }
    return {g.expression(nearest), g.color_formula(color)};
}

std::array<std::uint32_t, 3> bits_of(bob::Vec3 v) {
    return {std::bit_cast<std::uint32_t>(v.x), std::bit_cast<std::uint32_t>(v.y), std::bit_cast<std::uint32_t>(v.z)};
}

/// By the whole formula.
bob::Vec3 color_at(const bob::Code& code, std::span<const int> results, bob::Vec3 p) {
    const float point[3] = {p.x, p.y, p.z};
    float color[3];
    const float* const axes[3] = {point, point + 1, point + 2};
    float* const components[3] = {color, color + 1, color + 2};
    bob::best_formula_kernels().colors(code, results.data(), axes, 1, components, bob::scratch(code.registers));
    return {bob::color_component(color[0]), bob::color_component(color[1]), bob::color_component(color[2])};
}

}  // namespace

TEST(paintings_have_the_colors_of_the_whole_formula) {
    for (const bool has_roots : {false, true}) {
        const Scene scene = many_shapes(60, has_roots);
        const bob::ColorTape tape(scene.color);
        const bob::Painting painting(bob::ColorTape(scene.color), bob::Cells(scene.shape));
        test::Random random(1);
        std::vector<bob::Vec3> points;
        for (int i = 0; i < 5000; ++i) points.push_back({random(-1, 1), random(-1, 1), random(-1, 1)});
        for (int i = 0; i < 500; ++i) {  // on the sides of boxes
            points.push_back({0.125f * std::round(8 * random(-1, 1)), 0.125f * std::round(8 * random(-1, 1)), random(-1, 1)});
        }
        for (int i = 0; i < 500; ++i) points.push_back({random(-2, 2), random(-2, 2), random(-2, 2)});  // and beyond them
        points.push_back({1, 1, 1}), points.push_back({-1, -1, -1}), points.push_back({0, std::nanf(""), 0});
        std::vector<bob::Vec3> colors(points.size());
        painting(points, colors);
        std::size_t differ = 0, lit = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            differ += bits_of(colors[i]) != bits_of(color_at(tape.code(), tape.results(), points[i]));
            lit += colors[i].x > 0 && colors[i].y > 0;
        }
        CHECK_EQ(differ, 0u);
        CHECK_LT(points.size() / 10, lit);
        painting(points, points);  // in place
        for (std::size_t i = 0; i < points.size(); ++i) CHECK(bits_of(points[i]) == bits_of(colors[i]));
    }
}

TEST(boxes_need_few_of_many_shapes) {
    const Scene scene = many_shapes(60, false);
    const bob::ColorTape tape(scene.color);
    const bob::Code code = tape.code();
    std::vector<bob::Decision> decisions(bob::decision_count(code));
    bob::BoxBatch boxes{};
    const int lanes = bob::best_formula_kernels().lanes;
    test::Random random(2);
    for (int lane = 0; lane < lanes; ++lane) {
        for (int axis = 0; axis < 3; ++axis) {
            boxes.low[axis][lane] = random(-0.8f, 0.7f);
            boxes.high[axis][lane] = boxes.low[axis][lane] + 0.1f;
        }
    }
    bob::best_formula_kernels().bounds(code, boxes, decisions.data(), bob::scratch(code.registers));
    CHECK_EQ(boxes.partly, 0u);
    std::size_t instructions = 0;
    for (int lane = 0; lane < lanes; ++lane) {
        bob::LoweredCode pruned;
        bob::prune(code, tape.results(), decisions, lane, pruned);
        instructions += pruned.instructions.size();
        CHECK(pruned.registers <= code.registers);
        for (int i = 0; i < 200; ++i) {
            float p[3];
            for (int axis = 0; axis < 3; ++axis) p[axis] = random(boxes.low[axis][lane], boxes.high[axis][lane]);
            const bob::Vec3 point{p[0], p[1], p[2]};
            CHECK(bits_of(color_at(pruned.code(), pruned.results, point)) == bits_of(color_at(code, tape.results(), point)));
        }
    }
    CHECK_LT(instructions, code.count * static_cast<std::size_t>(lanes) / 4);
}
