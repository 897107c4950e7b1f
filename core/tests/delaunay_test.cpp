/// Triangulations: exact areas, empty circles, and edges that go through points.
#include "nurbs/delaunay.h"

#include <stdexcept>

#include "check.h"

namespace {

using bob::PlanePoint;
using Edge = std::array<std::int32_t, 2>;

std::int64_t doubled_area(const std::vector<PlanePoint>& points, const std::vector<std::array<std::int32_t, 3>>& triangles) {
    std::int64_t sum = 0;
    for (const auto& t : triangles) {
        const auto &a = points[static_cast<std::size_t>(t[0])], &b = points[static_cast<std::size_t>(t[1])], &c = points[static_cast<std::size_t>(t[2])];
        const std::int64_t area = std::int64_t{b[0] - a[0]} * (c[1] - a[1]) - std::int64_t{b[1] - a[1]} * (c[0] - a[0]);
        CHECK_LT(0, area);
        sum += area;
    }
    return sum;
}

TEST(grids_whose_points_lie_on_circles_are_covered) {
    std::vector<PlanePoint> points;
    constexpr int n = 40;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) points.push_back({1000 * x, 1000 * y});
    }
    // Along the border, from corner to corner through all points between.
    const std::vector<Edge> edges = {{0, n - 1}, {n - 1, n * n - 1}, {n * n - 1, n * (n - 1)}, {n * (n - 1), 0}};
    const auto triangles = bob::triangulate(points, edges);
    CHECK_EQ(triangles.size(), std::size_t{2 * (n - 1) * (n - 1)});
    CHECK_EQ(doubled_area(points, triangles), std::int64_t{2} * 1000 * 1000 * (n - 1) * (n - 1));
}

TEST(holes_are_left_out_and_edges_that_are_there_twice_are_none) {
    const std::vector<PlanePoint> points = {{0, 0}, {100, 0}, {100, 100}, {0, 100}, {20, 20}, {40, 20}, {40, 40}, {20, 40}};
    std::vector<Edge> edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}};
    CHECK_EQ(doubled_area(points, bob::triangulate(points, edges)), 2 * (10000 - 400));
    edges.insert(edges.end(), {{4, 5}, {5, 6}, {6, 7}, {7, 4}});
    CHECK_EQ(doubled_area(points, bob::triangulate(points, edges)), 2 * 10000);
}

TEST(long_edges_through_many_points_are_kept) {
    test::Random random(5);
    std::vector<PlanePoint> points = {{0, 0}, {bob::max_plane, 7}, {bob::max_plane - 3, bob::max_plane}, {5, bob::max_plane - 1}};
    for (int i = 0; i < 3000; ++i) {
        points.push_back({1000 + static_cast<std::int32_t>(random() * 33000000), 1000 + static_cast<std::int32_t>(random() * 33000000)});
    }
    // A quarter: both sides of it meet at a point within.
    const std::vector<Edge> edges = {{0, 1}, {1, 100}, {100, 0}};
    const auto triangles = bob::triangulate(points, edges);
    const auto& corner = points[100];
    const std::int64_t area = std::int64_t{points[1][0]} * corner[1] - std::int64_t{points[1][1]} * corner[0];
    CHECK_EQ(doubled_area(points, triangles), area);
}

TEST(crossing_edges_are_refused) {
    const std::vector<PlanePoint> points = {{0, 0}, {9, 0}, {9, 9}, {0, 9}};
    bool refused = false;
    try {
        (void)bob::triangulate(points, std::vector<Edge>{{0, 2}, {1, 3}});
    } catch (const std::invalid_argument&) {
        refused = true;
    }
    CHECK(refused);
}

}  // namespace
