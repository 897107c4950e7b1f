/// How far formulas reach: bounds of their inside, and extents of their surface, against looking everywhere.
#include "shapes/implicit/extent.h"

#include "check.h"
#include "formula/scratch.h"
#include "formula/tape.h"
#include "modelling/script.h"

namespace {

using bob::Box;
using bob::Graph;
using bob::Value;
using bob::Vec3;

Value ball(Graph& g, double x, double y, double z, double radius) {
    return sqrt(square(g.x() - x) + square(g.y() - y) + square(g.z() - z)) - radius;
}

/// Two balls, less a third.
bob::Expression balls(Graph& g) {
    return g.expression(max(min(ball(g, 0.4, 0, 0, 0.5), ball(g, -0.3, 0.2, 0.1, 0.6)), -ball(g, 0.6, 0, 0.2, 0.4)));
}

/// The maximum of f at the corners of the boxes that remain when each cell of the surface is halved down to the tolerance.
template <class F>
double most_of_all(const bob::Cells& cells, F f) {
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    double most = -std::numeric_limits<double>::infinity();
    for (const bob::Cells::Cell& cell : cells.cells()) {
        std::vector<Box> open{bob::Cells::box(cell)};
        std::vector<bob::Decision> decisions(cells.code(cell.code).count);
        while (!open.empty()) {
            const Box box = open.back();
            open.pop_back();
            const Vec3 half = 0.5f * (box.high - box.low);
            if (2 * half.x <= bob::Cells::tolerance) {
                for (int i = 0; i < 8; ++i) {
                    most = std::max(most, f({i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                                             i & 4 ? box.high.z : box.low.z}));
                }
                continue;
            }
            for (int i = 0; i < 8; ++i) {
                bob::BoxBatch part{};
                for (int axis = 0; axis < 3; ++axis) {
                    part.low[axis][0] = box.low[axis] + (i >> axis & 1 ? half[axis] : 0);
                    part.high[axis][0] = part.low[axis][0] + half[axis];
                }
                kernels.bounds(cells.code(cell.code), part, decisions.data(), bob::scratch(cells.max_registers()));
                if (!may_change_sign(part, 0)) continue;
                open.push_back({{part.low[0][0], part.low[1][0], part.low[2][0]},
                                {part.high[0][0], part.high[1][0], part.high[2][0]}});
            }
        }
    }
    return most;
}

}  // namespace

TEST(bounds_hold_the_inside_and_little_more) {
    for (const double size : {1e-6, 1., 1e6}) {
        for (const double far : {0., 100.}) {
            Graph g;
            const auto found = bob::find_bounds(g.expression(ball(g, far * size, -far * size, 2 * size, size)));
            CHECK(found.has_value());
            const double center[3] = {far * size, -far * size, 2 * size};
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(found->low[axis] <= center[axis] - size && found->high[axis] >= center[axis] + size);
                CHECK_LT(found->high[axis] - found->low[axis], 2.8 * size);
            }
        }
    }
}

TEST(bounds_of_what_has_no_inside_or_no_end) {
    Graph g;
    CHECK(!bob::find_bounds(g.expression(square(g.x()) + square(g.y()) + square(g.z()) + 1)).has_value());
    bool refused = false;
    try {
        [[maybe_unused]] const auto found = bob::find_bounds(g.expression(g.x() + g.y() * 0.5));
    } catch (const std::invalid_argument&) {
        refused = true;
    }
    CHECK(refused);
}

TEST(bounds_of_formulas_that_overflow_far_out_are_found_nearer) {
    Graph g;
    const Value x = g.x(), y = g.y(), z = g.z();
    const Value heart = power(square(x) + square(y) * 2.25 + square(z) - 1, 3) - (square(x) + square(y) * 0.1125) * power(z, 3);
    const auto found = bob::find_bounds(g.expression(heart));
    CHECK(found.has_value());
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(found->low[axis] < -0.6 && found->high[axis] > 0.6);
        CHECK(found->low[axis] > -3 && found->high[axis] < 3);
    }
}

TEST(bounds_of_circles_of_few_are_found_beside_their_jumps) {
    // Between two of them the formula jumps, however far out.
    for (int count = 1; count <= 6; ++count) {
        const bob::Sdf f = bob::run_script("sphere(0.3).circular_array(" + std::to_string(count) + ", 1)");
        const auto found = bob::find_bounds(*f.expression);
        CHECK(found.has_value());
        CHECK(found->high[0] >= 1.3 && found->low[2] <= -0.3);
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(found->low[axis] > -2 && found->high[axis] < 2);
        }
    }
}

TEST(bounds_of_turned_shapes_are_found_whatever_the_angle) {
    // Of a box and a ball far from the axis; of turns in turns, in sums, differences and minima of many; and of two that differ.
    const char* const scripts[] = {
        "box((4, 0.6, 0.6)).bend(0.7)",
        "sphere(1).translate((2, 0, 0)).bend(3)",
        "rectangle((0.4, 3)).extrude(8).twist(20)",
        "(box((4, 0.6, 0.6)).bend(0.7) | sphere(1)).dilate(0.1).translate((5, 1, 2)).scale((1, 2, 3))",
        "(box((4, 0.6, 0.6)).bend(0.7) - sphere(1)).shell(0.05)",
        "box((4, 0.6, 0.6)).bend(0.7).twist(2.5)",
        "box((2, 0.6, 0.6)).bend(0.7).translate((5, 0, 0)).circular_array(8, 2).dilate(0.1)",
        "box((4, 0.6, 0.6)).bend(0.7) | box((3, 0.3, 0.6)).bend(-1.7).translate((0, 0, 2))",
    };
    test::Random random(5);
    for (const char* script : scripts) {
        const bob::Expression f = *bob::run_script(script).expression;
        const auto found = bob::find_bounds(f);
        CHECK(found.has_value());
        double low[3], high[3];  // of points inside, in and around the box
        for (int axis = 0; axis < 3; ++axis) low[axis] = found->high[axis], high[axis] = found->low[axis];
        for (int i = 0; i < 40'000; ++i) {
            const float reach = i % 2 ? 0.5f : 2.f;
            double p[3];
            for (int axis = 0; axis < 3; ++axis) {
                const double middle = (found->low[axis] + found->high[axis]) / 2;
                p[axis] = middle + static_cast<double>(random(-reach, reach)) * (found->high[axis] - found->low[axis]);
            }
            if (f(p[0], p[1], p[2]) > 0) continue;
            for (int axis = 0; axis < 3; ++axis) low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
        }
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(found->low[axis] <= low[axis] && found->high[axis] >= high[axis]);
            CHECK_LT(found->high[axis] - found->low[axis], 2 * (high[axis] - low[axis]));
        }
    }
}

TEST(turns_are_those_that_keep_distances_from_the_axis) {
    Graph g;
    const Value x = g.x(), y = g.y(), z = g.z(), c = cos(z * 3), s = sin(z * 3);
    const auto is_bounded = [&](Value u, Value v) {
        try {
            return bob::find_bounds(g.expression(square(u) + square(v) * 4 + square(z) - 1)).has_value();
        } catch (const std::invalid_argument&) {
            return false;
        }
    };
    CHECK(is_bounded(c * x - s * y, s * x + c * y));
    CHECK(is_bounded(c * (x - 1) + (y + 2) * s, s * (x - 1) - c * (y + 2)));
    // Both grow at the same rate, one as a multiple of the other, without end.
    CHECK(!is_bounded(c * x + s * y, s * y + c * x));
    CHECK(!is_bounded(c * x - s * y, -(s * y - c * x)));
}

TEST(extents_are_those_of_looking_everywhere) {
    Graph g;
    const bob::Expression f = balls(g);
    const bob::Implicit shape(f, bob::Bounds{{-1, -1, -1}, {1, 1, 1}});
    const double map[12] = {0.9, 0.2, 0, 3, -0.1, 1.1, 0.3, -2, 0, 0.1, 0.7, 0.5}, center[3] = {2.9, -2, 0.4};
    double bounds[6];
    bob::placed_bounds(shape, map, bounds);
    for (int axis = 0; axis < 3; ++axis) {
        const double* row = map + 4 * axis;
        const double scale = bob::stretch(row);
        const auto high = [&](Vec3 p) { return bob::mapped(row, p) / scale; };
        CHECK_EQ(bounds[3 + axis], scale * most_of_all(shape.cells(), high));
        CHECK_EQ(bounds[axis], -scale * most_of_all(shape.cells(), [&](Vec3 p) { return -high(p); }));
    }
    const auto distance = [&](Vec3 p) {
        return bob::length(bob::mapped(map, p) - center[0], bob::mapped(map + 4, p) - center[1],
                           bob::mapped(map + 8, p) - center[2]) / 1.2;
    };
    CHECK_EQ(bob::placed_radius(shape, map, center, 1.2), 1.2 * most_of_all(shape.cells(), distance));
}

TEST(lengths_of_any_size) {
    CHECK_EQ(bob::length(3, 4, 12), 13.);
    CHECK_NEAR(bob::length(3e-200, 4e-200, 0) * 1e200, 5., 1e-12);
    CHECK_NEAR(bob::length(3e200, 4e200, 0) * 1e-200, 5., 1e-12);
    CHECK_EQ(bob::length(0, 0, 0), 0.);
}

TEST(a_plane_along_an_axis_has_cells_without_instructions) {
    Graph g;
    const bob::Cells cells(g.expression(g.x()));
    CHECK_EQ(cells.cells().size(), 2u * 16 * 16);
    for (const bob::Cells::Cell& cell : cells.cells()) CHECK_EQ(cells.code(cell.code).count, 0u);
    CHECK_NEAR(cells.hull().high.x, bob::Cells::finest, 0.2f);
}
