#include "base/affine.h"

#include "check.h"

namespace {

bob::AffineMap random_map(test::Random& random, float size) {
    bob::AffineMap map;
    for (auto& row : map.row) {
        for (double& x : row) x = double{random(-1, 1)} * double{size};
    }
    return map;
}

double farthest_from_identity(const bob::AffineMap& map) {
    const bob::AffineMap identity;
    double most = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) most = std::max(most, std::fabs(map.row[i][j] - identity.row[i][j]));
    }
    return most;
}

bob::AffineMap diagonal(double x, double y, double z) {
    return {{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}}};
}

}  // namespace

TEST(products_do_one_map_after_the_other) {
    test::Random random(1);
    for (int i = 0; i < 100; ++i) {
        const bob::AffineMap a = random_map(random, 2), b = random_map(random, 2), ab = a * b;
        const double p[3] = {random(-1, 1), random(-1, 1), random(-1, 1)};
        const auto moved = [](const bob::AffineMap& map, const double* x, int axis) {
            const auto& row = map.row[axis];
            return row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3];
        };
        const double q[3] = {moved(b, p, 0), moved(b, p, 1), moved(b, p, 2)};
        for (int axis = 0; axis < 3; ++axis) CHECK_NEAR(moved(ab, p, axis), moved(a, q, axis), 1e-13);
    }
}

TEST(a_map_and_its_inverse_cancel) {
    test::Random random(2);
    for (const float size : {1e-6f, 1.f, 1e6f}) {
        for (int i = 0; i < 100; ++i) {
            const bob::AffineMap map = random_map(random, size);
            const auto values = bob::singular_values(map);
            if (values[2] < 0.01 * values[0]) continue;
            CHECK_LT(farthest_from_identity(inverse(map) * map), 1e-11);
            CHECK_LT(farthest_from_identity(map * inverse(map)), 1e-11 * std::max(1.f, size));
        }
    }
    CHECK(bob::inverse({}) == bob::AffineMap{});
    CHECK(inverse(diagonal(2, 0.25, -8)) == diagonal(0.5, 4, -0.125));
    const bob::AffineMap turned{{{0, -1, 0, 3}, {0, 0, 2, 5}, {4, 0, 0, -7}}};  // needs pivots
    CHECK(inverse(turned) == (bob::AffineMap{{{0, 0, 0.25, 1.75}, {-1, 0, 0, 3}, {0, 0.5, 0, -2.5}}}));
}

TEST(singular_values_of_turned_stretches) {
    test::Random random(3);
    for (const double unit : {1e-200, 1., 1e150}) {
        for (const double small : {1e-9, 0.3, 1.}) {
            for (int i = 0; i < 50; ++i) {
                // Stretched between two turns about different axes.
                bob::AffineMap map = diagonal(unit, 2 * unit, small * unit);
                for (const bool before : {false, true}) {
                    for (int axis = 0; axis < 3; ++axis) {
                        const double angle = double{random(-3, 3)}, c = std::cos(angle), s = std::sin(angle);
                        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
                        bob::AffineMap turn;
                        turn.row[a][a] = turn.row[b][b] = c, turn.row[a][b] = -s, turn.row[b][a] = s;
                        map = before ? map * turn : turn * map;
                    }
                }
                const auto values = bob::singular_values(map);
                CHECK_NEAR(values[0] / (2 * unit), 1., 1e-14);
                CHECK_NEAR(values[1] / unit, 1., 1e-14);
                CHECK_NEAR(values[2] / (small * unit), 1., 1e-14 / small);
            }
        }
    }
    CHECK_EQ(bob::singular_values(diagonal(-0.3, 5, 0))[0], 5.);
    CHECK_EQ(bob::singular_values(diagonal(-0.3, 5, 0))[1], 0.3);
    CHECK_EQ(bob::singular_values(diagonal(-0.3, 5, 0))[2], 0.);
}

TEST(maps_of_spheres_cancel) {
    const bob::Sphere sphere{{1, -2, 30}, 0.25};
    CHECK(to_unit_sphere(sphere) * from_unit_sphere(sphere) == bob::AffineMap{});
    CHECK(to_unit_sphere(sphere) == (bob::AffineMap{{{4, 0, 0, -4}, {0, 4, 0, 8}, {0, 0, 4, -120}}}));
}

TEST(vectors_are_indexed_without_leaving_a_component) {
    // Compilers refuse this where a component is reached from another one, which some builds made wrong code of.
    constexpr bob::Vec3 v{1, 2, 3};
    static_assert(v[0] == 1 && v[1] == 2 && v[2] == 3);
    bob::Vec3 w = v;
    for (int axis = 0; axis < 3; ++axis) w[axis] += v[2 - axis];
    CHECK(w.x == 4 && w.y == 4 && w.z == 4);
}
