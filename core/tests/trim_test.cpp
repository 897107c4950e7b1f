#include "nurbs/trim.h"

#include <algorithm>
#include <chrono>
#include <numbers>
#include <random>
#include <vector>

#include "base/parallel.h"
#include "check.h"

namespace {

using Point = std::array<double, 2>;
using Coverage = bob::TrimRegion::Coverage;
using std::numbers::pi;

constexpr bob::Domain unit{0, 1, 0, 1};
constexpr bob::Domain wide{-10, 10, -10, 10};

bob::TrimRegion region(const std::vector<bob::TrimLoop>& loops, const bob::Domain& domain = wide) {
    return {loops, domain};
}

/// Its knots are simple and evenly spaced, but for the ends of a clamped one.
bob::NurbsCurve<2> curve(int degree, const std::vector<Point>& points, const std::vector<double>& weights = {},
                         bool clamped = true) {
    bob::NurbsCurve<2> c;
    c.degree = degree;
    const auto spans = static_cast<int>(points.size()) - degree;
    for (int i = -degree; i <= spans + degree; ++i) c.knots.push_back(clamped ? std::clamp(i, 0, spans) : i);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = weights.empty() ? 1 : weights[i];
        c.control_points.push_back({w * points[i][0], w * points[i][1], w});
    }
    return c;
}

bob::TrimLoop polygon(std::vector<Point> corners) {
    corners.push_back(corners[0]);
    return {curve(1, corners)};
}

bob::TrimLoop rectangle(const bob::Domain& r) {
    return polygon({{r.low_u, r.low_v}, {r.high_u, r.low_v}, {r.high_u, r.high_v}, {r.low_u, r.high_v}});
}

/// The circle of nine control points (The NURBS Book, figure 7.16), from `angle` on.
bob::TrimLoop circle(Point centre, double radius, double angle = 0) {
    const double r = std::sqrt(0.5);
    const double c = std::cos(angle), s = std::sin(angle);
    std::vector<Point> points{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    for (Point& p : points) {
        p = {centre[0] + radius * (c * p[0] - s * p[1]), centre[1] + radius * (s * p[0] + c * p[1])};
    }
    auto result = curve(2, points, {1, r, 1, r, 1, r, 1, r, 1});
    result.knots = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    return {result};
}

std::vector<Point> random_points(std::size_t count, std::mt19937_64& random, double low = -1, double high = 1) {
    std::uniform_real_distribution<double> coordinate(low, high);
    std::vector<Point> points(count);
    for (Point& p : points) p = {coordinate(random), coordinate(random)};
    return points;
}

/// Even-odd, by the ray in the direction of v.
bool in_polygon(const std::vector<Point>& corners, Point p) {
    bool inside = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Point a = corners[i], b = corners[(i + 1) % corners.size()];
        if ((a[0] <= p[0]) == (b[0] <= p[0])) continue;
        inside ^= a[1] + (p[0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) > p[1];
    }
    return inside;
}

double distance(const std::vector<Point>& corners, Point p) {
    double nearest = 1e300;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Point a = corners[i], b = corners[(i + 1) % corners.size()];
        const double x = b[0] - a[0], y = b[1] - a[1], length2 = x * x + y * y;
        const double t = length2 > 0 ? std::clamp(((p[0] - a[0]) * x + (p[1] - a[1]) * y) / length2, 0., 1.) : 0;
        nearest = std::min(nearest, std::hypot(a[0] + t * x - p[0], a[1] + t * y - p[1]));
    }
    return nearest;
}

std::vector<Point> polyline(const bob::TrimLoop& loop, int steps) {
    std::vector<Point> points;
    for (const auto& c : loop) {
        const double low = c.knots[static_cast<std::size_t>(c.degree)], high = c.knots[c.control_points.size()];
        for (int i = 0; i <= steps; ++i) points.push_back(bob::curve_point(c, low + (high - low) * i / steps));
    }
    return points;
}

/// One to three random curves of a degree, some of them rational, some without a gap between them; or a periodic one.
bob::TrimLoop random_loop(int degree, std::mt19937_64& random) {
    if (random() % 4 == 0) {
        auto points = random_points(static_cast<std::size_t>(degree) + 2, random);
        for (int i = 0; i < degree; ++i) points.push_back(points[static_cast<std::size_t>(i)]);
        return {curve(degree, points, {}, false)};
    }
    bob::TrimLoop loop;
    Point joint = random_points(1, random)[0];
    for (std::size_t i = 0, curves = 1 + random() % 3; i < curves; ++i) {
        auto points = random_points(static_cast<std::size_t>(degree) + 1 + random() % 4, random);
        std::vector<double> weights;
        if (random() % 2) {
            for (std::size_t k = 0; k < points.size(); ++k) {
                weights.push_back(0.2 + static_cast<double>(random() % 100) / 20);
            }
        }
        if (random() % 2) points.front() = joint;
        joint = points.back();
        loop.push_back(curve(degree, points, weights));
    }
    return loop;
}

/// A square of 10 x 10, and in it a circle in each of rows * rows squares.
std::vector<bob::TrimLoop> plate(int rows) {
    std::vector<bob::TrimLoop> loops{rectangle({0, 10, 0, 10})};
    const double step = 10. / rows;
    for (int i = 0; i < rows * rows; ++i) {
        loops.push_back(circle({(i % rows + 0.5) * step, (i / rows + 0.5) * step}, 0.3 * step, 0.1 * i));
    }
    return loops;
}

}  // namespace

TEST(without_loops_everything_is_inside) {
    const auto all = region({});
    CHECK(all.contains(3, -4));
    CHECK(all.coverage(unit) == Coverage::all);
    CHECK_EQ(all.bytes(), std::size_t{0});
}

TEST(a_circle_ends_where_its_radius_says) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-1.2, 1.2), turn(0, 2 * pi);
    for (const double start : {0., 0.3, 2.}) {
        const auto disk = region({circle({0, 0}, 1, start)});
        int wrong = 0;
        for (int i = 0; i < 100000; ++i) {
            const double u = coordinate(random), v = coordinate(random), r = std::hypot(u, v);
            if (std::fabs(r - 1) > 1e-14) wrong += disk.contains(u, v) != (r < 1);
            const double angle = turn(random), c = std::cos(angle), s = std::sin(angle);
            wrong += !disk.contains((1 - 1e-9) * c, (1 - 1e-9) * s) + disk.contains((1 + 1e-9) * c, (1 + 1e-9) * s);
        }
        CHECK_EQ(wrong, 0);
        // At the heights of the pieces' ends.
        for (const double v : {-std::sqrt(0.5), 0., std::sqrt(0.5), std::sin(start), std::cos(start)}) {
            const double u = std::sqrt(1 - v * v);
            if (u < 1e-3) continue;
            CHECK(disk.contains(u - 1e-9, v));
            CHECK(disk.contains(1e-9 - u, v));
            CHECK(!disk.contains(u + 1e-9, v));
            CHECK(!disk.contains(-1e-9 - u, v));
        }
        CHECK(!disk.contains(0, 1 + 1e-9));
        CHECK(!disk.contains(-5, 1));
        CHECK(!disk.contains(-5, -1));
    }
}

TEST(polygons_agree_with_rays_in_the_other_direction) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> coordinate(-1.1, 1.1);
    int wrong = 0;
    for (int round = 0; round < 200; ++round) {
        auto corners = random_points(3 + random() % 30, random);
        // Corners and points on a grid put ends of edges, and whole edges, at the points' heights.
        const bool grid = round % 2;
        if (grid) {
            for (Point& p : corners) p = {std::round(4 * p[0]) / 4, std::round(4 * p[1]) / 4};
        }
        const auto shape = region({polygon(corners)});
        for (int i = 0; i < 500; ++i) {
            Point p{coordinate(random), coordinate(random)};
            if (grid) p = {std::round(16 * p[0]) / 16, std::round(16 * p[1]) / 16};
            if (distance(corners, p) < 1e-12) continue;
            wrong += shape.contains(p[0], p[1]) != in_polygon(corners, p);
        }
    }
    CHECK_EQ(wrong, 0);
}

TEST(loops_of_curves_of_any_degree_agree_with_fine_polylines) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> coordinate(-1.1, 1.1);
    int wrong = 0, compared = 0;
    for (int round = 0; round < 90; ++round) {
        const auto loop = random_loop(1 + round % bob::max_degree, random);
        const auto shape = region({loop});
        const auto corners = polyline(loop, 600);
        for (int i = 0; i < 60; ++i) {
            const Point p{coordinate(random), coordinate(random)};
            if (distance(corners, p) < 1e-3) continue;
            ++compared;
            wrong += shape.contains(p[0], p[1]) != in_polygon(corners, p);
        }
    }
    CHECK_EQ(wrong, 0);
    CHECK_LT(4500, compared);
}

TEST(points_close_to_a_cubic_lie_on_the_side_that_its_normal_says) {
    // v = 3 u^2 - 2 u^3 over 0..1, level at both ends, closed by lines around the outside.
    const auto shape = region({{curve(3, {{0, 0}, {1. / 3, 0}, {2. / 3, 1}, {1, 1}}),
                                curve(1, {{1, 1}, {1, 2}, {0, 2}, {0, 0}})}});
    for (int i = 1; i < 10000; ++i) {
        const double u = i / 10000., v = u * u * (3 - 2 * u);
        CHECK(shape.contains(u, v + 1e-12));
        CHECK(!shape.contains(u, v - 1e-12));
    }
}

TEST(flat_pieces_of_high_degree_are_solved_to_the_end) {
    // u = t, v = t^9 rises by 1e-9 over the first tenth of its width. The line back lies above.
    std::vector<Point> points;
    for (int i = 0; i <= 9; ++i) points.push_back({i / 9., i < 9 ? 0. : 1.});
    const auto shape = region({{curve(9, points)}});
    for (int i = 50; i < 1000; ++i) {
        const double t = i / 1000.;
        CHECK(!shape.contains(t + 1e-8, std::pow(t, 9)));
        CHECK(shape.contains(t - 1e-8, std::pow(t, 9)));
    }
}

TEST(loops_in_loops_are_holes_and_islands) {
    const auto shape =
        region({rectangle({-4, 4, -4, 4}), circle({0, 0}, 3), rectangle({-1, 1, -1, 1}), circle({9, 9}, 0.5)});
    CHECK(shape.contains(3.9, 3.9));
    CHECK(!shape.contains(2, 0));
    CHECK(!shape.contains(-2, 1));
    CHECK(shape.contains(0.5, -0.99));
    CHECK(!shape.contains(-5, 0));
    CHECK(shape.contains(9, 9));
    CHECK(shape.coverage({-0.9, 0.9, -0.9, 0.9}) == Coverage::all);
    CHECK(shape.coverage({1.1, 2, 1.1, 2}) == Coverage::none);
    CHECK(shape.coverage({-5, 5, -5, 5}) == Coverage::some);  // the loops' ends are inside, its corners are not
}

TEST(gaps_are_closed_by_lines) {
    const auto shape = region({{curve(1, {{0, 0}, {1, 0}}), curve(1, {{1, 1}, {0, 2}})}});
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> coordinate(-0.5, 2.5);
    const std::vector<Point> corners{{0, 0}, {1, 0}, {1, 1}, {0, 2}};
    for (int i = 0; i < 1000; ++i) {
        const double u = coordinate(random), v = coordinate(random);
        CHECK_EQ(shape.contains(u, v), in_polygon(corners, {u, v}));
    }
    // Gaps of rounding errors let no ray through, whatever its height.
    bob::TrimLoop loose;
    const auto around = random_points(40, random, -1e-13, 1e-13);
    for (std::size_t i = 0; i < 40; ++i) {
        const double a = 2 * pi * static_cast<double>(i) / 40, b = 2 * pi * static_cast<double>(i + 1) / 40;
        const Point end{std::cos(b) + around[i][0], std::sin(b) + around[i][1]};
        loose.push_back(curve(1, {{std::cos(a), std::sin(a)}, end}));
    }
    const auto disk = region({loose});
    for (std::size_t i = 0; i < 40; ++i) {
        for (int k = -20; k <= 20; ++k) {
            const double v = std::sin(2 * pi * static_cast<double>(i) / 40) + k * 1e-14;
            CHECK(!disk.contains(-2, v));
            if (std::fabs(v) < 0.999) CHECK(disk.contains(0, v));
        }
    }
}

TEST(curves_without_size_and_loops_without_area_do_no_harm) {
    const bob::TrimLoop square = rectangle({0, 2, 0, 2});
    const auto point = curve(3, {{1, 1}, {1, 1}, {1, 1}, {1, 1}});
    const auto there_and_back = curve(2, {{0.5, 0.5}, {1.5, 1.5}, {0.5, 0.5}});
    const auto along_itself = curve(1, {{0.2, 0.7}, {1.8, 0.7}, {0.2, 0.7}});
    const auto shape = region({square, {point}, {there_and_back}, {along_itself}, {}, {point, point}});
    bob::TrimLoop with_point = square;
    with_point.insert(with_point.begin(), curve(2, {{0, 0}, {0, 0}, {0, 0}}, {1, 2, 3}));
    const auto same = region({with_point});
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> coordinate(-1, 3);
    for (int i = 0; i < 10000; ++i) {
        const double u = coordinate(random), v = coordinate(random);
        const bool inside = 0 < u && u < 2 && 0 < v && v < 2;
        if (std::fabs(u - v) > 1e-9) CHECK_EQ(shape.contains(u, v), inside);
        CHECK_EQ(same.contains(u, v), inside);
    }
    CHECK(!region({{point}}).contains(1, 1));
    CHECK(!region({{}}).contains(1, 1));

    // NaN is outside, and the search ends.
    const double nan = std::nan("");
    CHECK(!shape.contains(nan, 1));
    CHECK(!shape.contains(1, nan));
    const auto broken = region(
        {{curve(3, {{0, 0}, {nan, 1}, {1, nan}, {1, 0}}), curve(2, {{1, 0}, {1e308, 1e308}, {0, 0}})}});
    CHECK(!broken.contains(-5, 0.5));
}

TEST(cusps_and_loops_of_one_curve) {
    // A cusp at the origin, where both derivatives are 0: u = t^2, v = t^3 for t in -1..1, closed by the line u = 1.
    const auto cusp = region({{curve(3, {{1, -1}, {-1. / 3, 1}, {-1. / 3, -1}, {1, 1}})}});
    // A curve that crosses itself goes around its inner part once.
    const auto crossing = region({{curve(3, {{0, 0}, {3, 2}, {-2, 2}, {1, 0}})}});
    for (int i = 1; i < 100; ++i) {
        const double t = i / 100.;
        CHECK(cusp.contains(t * t + 1e-9, t * t * t));
        CHECK(!cusp.contains(t * t - 1e-9, -t * t * t));
    }
    CHECK(!cusp.contains(-1e-9, 0));
    CHECK(crossing.contains(0.5, 1.2));
    CHECK(crossing.contains(0.5, 0.1));
    CHECK(!crossing.contains(0.5, -0.1));
}

TEST(loops_that_nearly_touch_keep_their_gap) {
    const auto shape = region({rectangle({0, 1, 0, 1}), rectangle({1 + 1e-10, 2, 0, 1}), circle({0.5, 3}, 1),
                               circle({2.5 + 1e-10, 3}, 1)});
    CHECK(shape.contains(1 - 1e-11, 0.5));
    CHECK(!shape.contains(1 + 5e-11, 0.5));
    CHECK(shape.contains(1 + 2e-10, 0.5));
    CHECK(shape.contains(1.5 - 1e-11, 3));
    CHECK(!shape.contains(1.5 + 5e-11, 3));
    CHECK(shape.contains(1.5 + 2e-10, 3));
}

TEST(the_border_of_the_domain_is_inside_of_loops_along_it) {
    for (const double off : {0., 1e-9, -1e-9, 9e-7}) {
        const auto face = region({rectangle({off, 1 - off, off, 1 + off})}, unit);
        for (const double u : {-1e-7, 0., 1e-10, 0.5, 1., 1 + 1e-7}) {
            for (const double v : {-1e-7, 0., 1e-10, 0.5, 1., 1 + 1e-7}) CHECK(face.contains(u, v));
        }
        CHECK(!face.contains(0.5, 1.1));
        CHECK(face.coverage(unit) == Coverage::all);
    }
    // A loop that leaves the border stays where it is elsewhere; so does a hole that touches it.
    const auto half = region({polygon({{0, 1e-9}, {0.5, 0}, {0.5, 1}, {0, 1}}), rectangle({0, 0.25, 0.25, 0.5})}, unit);
    for (const double v : {-1e-7, 0., 0.1, 0.6, 1., 1 + 1e-7}) {
        CHECK(half.contains(-1e-7, v));
        CHECK(half.contains(0.5 - 1e-9, v));
        CHECK(!half.contains(0.5 + 1e-9, v));
    }
    CHECK(!half.contains(0, 0.3));
    CHECK(!half.contains(-1e-7, 0.3));
    CHECK(half.contains(0, 0.25 - 1e-9));
    CHECK(!half.contains(0, 0.25 + 1e-9));
    CHECK(half.coverage({0, 0.49, 0, 0.24}) == Coverage::all);
    CHECK(half.coverage({0, 0.51, 0, 0.24}) == Coverage::some);
    // Relative to the size of the domain.
    const bob::Domain large{-3e5, 2e5, 1e6, 4e6};
    const auto big = region({rectangle({-3e5 + 0.1, 2e5, 1e6 + 1, 4e6 - 2})}, large);
    CHECK(big.contains(-3e5, 1e6));
    CHECK(big.contains(2e5 + 0.01, 4e6));
}

TEST(coverage_is_never_wrong_and_rarely_unsure) {
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> coordinate(-1.1, 1.1), size(0, 0.3), within(0, 1);
    int wrong = 0, sure = 0, unsure = 0, needless = 0;
    for (int round = 0; round < 100; ++round) {
        const auto loop = random_loop(1 + round % bob::max_degree, random);
        const auto shape = region({loop});
        const auto corners = polyline(loop, 300);
        for (int k = 0; k < 20; ++k) {
            const double u = coordinate(random), v = coordinate(random);
            const bob::Domain r{u, u + size(random), v, v + size(random)};
            const auto coverage = shape.coverage(r);
            if (coverage == Coverage::some) {
                ++unsure;
                bool near = false;
                for (int i = 0; i < 144 && !near; ++i) {
                    const double x = r.low_u + (r.high_u - r.low_u) * (i % 12) / 11;
                    const double y = r.low_v + (r.high_v - r.low_v) * (i / 12) / 11;
                    near = distance(corners, {x, y}) < 0.03;
                }
                needless += !near;
                continue;
            }
            ++sure;
            for (int i = 0; i < 200; ++i) {
                const double x = r.low_u + (r.high_u - r.low_u) * within(random);
                const double y = r.low_v + (r.high_v - r.low_v) * within(random);
                wrong += shape.contains(x, y) != (coverage == Coverage::all);
            }
        }
    }
    CHECK_EQ(wrong, 0);
    CHECK_EQ(needless, 0);
    CHECK_LT(500, sure);
    CHECK_LT(200, unsure);

    const auto disk = region({circle({0, 0}, 1, 0.3)});
    const double r = std::sqrt(0.5);
    CHECK(disk.coverage({-r + 1e-7, r - 1e-7, -r + 1e-7, r - 1e-7}) == Coverage::all);
    CHECK(disk.coverage({-r + 1e-7, r + 1e-7, -r + 1e-7, r - 1e-7}) == Coverage::some);
    CHECK(disk.coverage({r + 1e-7, 2, r + 1e-7, 2}) == Coverage::none);
    CHECK(disk.coverage({-2, -r, r + 1e-7, 2}) == Coverage::none);
    CHECK(disk.coverage({-2, 2, -2, 2}) == Coverage::some);
    CHECK(disk.coverage({1 + 1e-9, 2, -2, 2}) == Coverage::some);  // within the margin
    CHECK(disk.coverage({-0.1, 0.1, 0.999, 1.1}) == Coverage::some);
    // An edge that no ray crosses passes through rectangles all the same.
    CHECK(region({rectangle({0, 1, 0, 1})}).coverage({0.2, 0.8, -0.1, 0.1}) == Coverage::some);
}

TEST(extents_hold_what_is_inside_and_little_more) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> coordinate(-1.1, 1.1), size(0, 0.6), within(0, 1);
    int outside = 0, held = 0;
    for (int round = 0; round < 100; ++round) {
        const auto shape = region({random_loop(1 + round % bob::max_degree, random)});
        for (int k = 0; k < 20; ++k) {
            const double u = coordinate(random), v = coordinate(random);
            const bob::Domain r{u, u + size(random), v, v + size(random)}, e = shape.extent(r);
            for (int i = 0; i < 200; ++i) {
                const double x = r.low_u + (r.high_u - r.low_u) * within(random);
                const double y = r.low_v + (r.high_v - r.low_v) * within(random);
                if (!shape.contains(x, y)) continue;
                ++held;
                outside += !(e.low_u <= x && x <= e.high_u && e.low_v <= y && y <= e.high_v);
            }
        }
    }
    CHECK_EQ(outside, 0);
    CHECK_LT(10000, held);

    const auto disk = region({circle({0, 0}, 1, 0.3)});
    const auto is = [&](const bob::Domain& of, const bob::Domain& expected) {
        const bob::Domain found = disk.extent(of);
        CHECK_NEAR(found.low_u, expected.low_u, 1e-6);
        CHECK_NEAR(found.high_u, expected.high_u, 1e-6);
        CHECK_NEAR(found.low_v, expected.low_v, 1e-6);
        CHECK_NEAR(found.high_v, expected.high_v, 1e-6);
    };
    is({-2, 2, -2, 2}, {-1, 1, -1, 1});
    is({-0.1, 0.2, -0.3, 0.4}, {-0.1, 0.2, -0.3, 0.4});
    const bob::Domain part = disk.extent({0.5, 2, -2, 2});  // of the arcs' boxes, not of the arcs
    CHECK(part.low_u == 0.5 && std::fabs(part.high_u - 1) < 1e-6);
    CHECK(part.low_v >= -1.000001 && part.low_v < -0.866 && part.high_v > 0.866 && part.high_v <= 1.000001);
    const bob::Domain beside = disk.extent({1.5, 2, -2, 2});
    CHECK(beside.low_u > beside.high_u);
}

TEST(a_hundred_holes_cost_little_more_than_one) {
    const auto one = region(plate(1)), many = region(plate(10));
    std::mt19937_64 random(7);
    const auto points = random_points(20000, random, 0, 10);
    for (const Point p : points) {
        const double u = std::fmod(p[0], 1.) - 0.5, v = std::fmod(p[1], 1.) - 0.5, r = std::hypot(u, v);
        CHECK_EQ(many.contains(p[0], p[1]), r > 0.3);
    }
    const auto seconds = [&](const bob::TrimRegion& shape) {
        const auto start = std::chrono::steady_clock::now();
        std::size_t inside = 0;
        for (const Point p : points) inside += shape.contains(p[0], p[1]);
        CHECK_LT(std::size_t{0}, inside);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    double ratio = 1e300;  // at best, since other work may get in the way of either
    for (int round = 0; round < 20; ++round) ratio = std::min(ratio, seconds(many) / seconds(one));
    CHECK_LT(ratio, 5);
    CHECK_LT(many.bytes(), 100 * one.bytes());
}

TEST(threads_may_ask_at_once) {
    const auto shape = region(plate(5));
    std::mt19937_64 random(8);
    const auto points = random_points(20000, random, 0, 10);
    std::vector<char> alone(points.size()), together(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) alone[i] = shape.contains(points[i][0], points[i][1]);
    bob::parallel_for(points.size(), 100, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) together[i] = shape.contains(points[i][0], points[i][1]);
    });
    CHECK(alone == together);
}
