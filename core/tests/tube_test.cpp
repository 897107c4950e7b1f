#include "shapes/tube/tube.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "check.h"

using bob::Hit;
using bob::NurbsCurve;
using bob::Ray;
using bob::Tube;
using bob::Vec3;

namespace {

using Ball = std::array<double, 4>;

NurbsCurve<4> clamped(int degree, const std::vector<Ball>& balls, const std::vector<double>& weights = {}) {
    NurbsCurve<4> curve{degree, {}, {}};
    const int n = static_cast<int>(balls.size());
    for (int i = 0; i < n + degree + 1; ++i) curve.knots.push_back(std::clamp(i - degree, 0, n - degree));
    for (std::size_t i = 0; i < balls.size(); ++i) {
        const double w = weights.empty() ? 1 : weights[i];
        curve.control_points.push_back({w * balls[i][0], w * balls[i][1], w * balls[i][2], w * balls[i][3], w});
    }
    return curve;
}

Hit trace(const Tube& tube, const Ray& ray) {
    Hit hit;
    tube.closest_hits({&ray, 1}, {&hit, 1});
    return hit;
}

bool found(const Hit& hit) { return hit.primitive != bob::no_primitive; }

Vec3 random_direction(test::Random& random) {
    while (true) {
        const Vec3 d{random(-1, 1), random(-1, 1), random(-1, 1)};
        if (dot(d, d) > 0.01f && dot(d, d) < 1) return bob::normalized(d);
    }
}

Vec3 random_point(test::Random& random, float size) {
    return {random(-size, size), random(-size, size), random(-size, size)};
}

/// The boundary of the union of a dense row of balls along rays, by another way than the tracer's: samples, each span
/// of them sharpened by parabolas through neighbours.
class Sampled {
public:
    Sampled(const NurbsCurve<4>& curve, int count) {
        const double low = curve.knots[static_cast<std::size_t>(curve.degree)];
        const double high = curve.knots[curve.control_points.size()];
        for (int i = 0; i <= count; ++i) balls.push_back(curve_point(curve, low + (high - low) * i / count));
    }

    struct Answer {
        bool sure = true;  // not where the ray grazes, or starts next to the boundary
        double t = HUGE_VAL;
    };

    [[nodiscard]] Answer operator()(const Ray& ray) const {
        const std::size_t count = balls.size();
        std::vector<OnRay> at;
        for (const Ball& ball : balls) at.push_back(on_ray(ball, ray));
        const auto graze = [&](std::size_t i, double q) { return std::fabs(q) < 3e-5 * balls[i][3]; };
        Answer answer;
        answer.sure = !graze(0, at[0].q) && !graze(count - 1, at[count - 1].q);
        for (std::size_t i = 1; i + 1 < count; ++i) {
            const double before = at[i - 1].q, q = at[i].q, after = at[i + 1].q;
            if ((q > before) != (q >= after)) continue;
            const double bend = before - 2 * q + after;
            const double top = bend == 0 ? q : q - (after - before) * (after - before) / (8 * bend);
            if (graze(i, q) || graze(i, top) || (q < 0) != (top < 0)) answer.sure = false;
        }

        struct Segment {
            double low, high;
        };
        std::vector<Segment> spans;
        for (std::size_t i = 0; i < count; ++i) {
            if (at[i].q < 0) continue;
            std::size_t first = i, last = i;
            for (; i < count && at[i].q >= 0; ++i) {
                if (at[i].end(-1) < at[first].end(-1)) first = i;
                if (at[i].end(1) > at[last].end(1)) last = i;
            }
            spans.push_back({sharpened(first, ray, -1), sharpened(last, ray, 1)});
        }
        std::sort(spans.begin(), spans.end(), [](const Segment& a, const Segment& b) { return a.low < b.low; });
        double reach = 0;
        for (const Segment& s : spans) {
            if (std::fabs(s.low - reach) < 1e-5 || std::fabs(s.high) < 1e-5) answer.sure = false;
            if (s.low <= reach && s.high > reach) reach = s.high;
        }
        if (reach > 0) {
            answer.t = reach;
        } else {
            for (const Segment& s : spans) {
                if (s.low > 0) answer.t = std::min(answer.t, s.low);
            }
        }
        return answer;
    }

    std::vector<Ball> balls;

private:
    /// A ball along a ray, in units of length.
    struct OnRay {
        double a, q;
        [[nodiscard]] double end(int side) const { return a + side * std::sqrt(std::max(q, 0.0)); }
    };

    static OnRay on_ray(const Ball& ball, const Ray& ray) {
        const double x = ball[0] - ray.origin.x, y = ball[1] - ray.origin.y, z = ball[2] - ray.origin.z;
        const double dx = ray.direction.x, dy = ray.direction.y, dz = ray.direction.z;
        const double square = dx * dx + dy * dy + dz * dz, share = (x * dx + y * dy + z * dz) / square;
        const double px = x - share * dx, py = y - share * dy, pz = z - share * dz;
        return {share * std::sqrt(square), ball[3] * ball[3] - px * px - py * py - pz * pz};
    }

    [[nodiscard]] double sharpened(std::size_t i, const Ray& ray, int side) const {
        const std::size_t around = std::clamp<std::size_t>(i, 1, balls.size() - 2);
        const Ball &a = balls[around - 1], &b = balls[around], &c = balls[around + 1];
        const auto value = [&](double x) {  // x in -1..1
            Ball ball;
            for (std::size_t k = 0; k < 4; ++k) {
                ball[k] = b[k] + x * (c[k] - a[k]) / 2 + x * x * (c[k] - 2 * b[k] + a[k]) / 2;
            }
            const OnRay on = on_ray(ball, ray);
            return on.q < 0 ? -HUGE_VAL : side * on.end(side);
        };
        double middle = i < around ? -1 : i > around ? 1 : 0;
        double best = value(middle);
        for (double step = 0.5; step > 1e-6; step /= 2) {
            for (const double x : {std::max(middle - step, -1.0), std::min(middle + step, 1.0)}) {
                const double v = value(x);
                if (v > best) best = v, middle = x;
            }
        }
        return side * best;
    }
};

struct Difference {
    int compared = 0, hits = 0, misses = 0;
    double worst = 0;  // of t, in units of length

    void add(const Hit& hit, double scale, double want) {
        ++compared;
        hits += found(hit);
        if (found(hit) != (want < HUGE_VAL)) {
            ++misses;
        } else if (found(hit)) {
            worst = std::max(worst, std::fabs(hit.t * scale - want));
        }
    }
};

/// Half of the rays start outside, half near the curve.
Difference compare(const NurbsCurve<4>& curve, int rays, int samples, std::uint64_t seed) {
    const Tube tube(curve);
    const Sampled sampled(curve, samples);
    test::Random random(seed);
    Difference result;
    for (int i = 0; i < rays; ++i) {
        const Ball& near = sampled.balls[static_cast<std::size_t>(random() * static_cast<float>(samples))];
        const Vec3 centre{static_cast<float>(near[0]), static_cast<float>(near[1]), static_cast<float>(near[2])};
        const float r = static_cast<float>(near[3]);
        const Vec3 direction = random_direction(random);
        const Vec3 target = centre + random_point(random, i % 4 == 0 ? 0.5f : 1.2f * r);
        const Ray ray{i % 2 ? target : target - 3 * direction, direction};
        const auto want = sampled(ray);
        if (want.sure) result.add(trace(tube, ray), length(ray.direction), want.t);
    }
    return result;
}

/// The distance of a point from a row of balls, negative inside: exact where centre and radius vary linearly. Convex,
/// where they do so over all of the row.
double distance_from_cones(const std::vector<Ball>& balls, const double (&p)[3]) {
    double result = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < balls.size(); ++i) {
        const Ball &a = balls[i], &b = balls[i + 1];
        double along = 0, square = 0, across = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            along += (p[k] - a[k]) * (b[k] - a[k]);
            square += (b[k] - a[k]) * (b[k] - a[k]);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const double d = p[k] - a[k] - along / square * (b[k] - a[k]);
            across += d * d;
        }
        // |p - c(s)| - r(s) is least where the line from p meets the segment at an angle whose cosine is the slope.
        const double size = std::sqrt(square), slope = (b[3] - a[3]) / size;
        const double shift = std::sqrt(across) * slope / std::sqrt(std::max(1 - slope * slope, 1e-300));
        const double s = std::clamp((along / size + shift) / size, 0.0, 1.0);
        double distance = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double d = p[k] - a[k] - s * (b[k] - a[k]);
            distance += d * d;
        }
        result = std::min(result, std::sqrt(distance) - a[3] - s * (b[3] - a[3]));
    }
    return result;
}

/// Where f, a distance or less, negative inside, first changes its sign along a ray of length 1 (Hart, "Sphere
/// Tracing", 1996).
template <class Distance>
Sampled::Answer first_crossing(const Ray& ray, Distance f) {
    const auto value = [&](double t) {
        const double p[3] = {ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y,
                             ray.origin.z + t * ray.direction.z};
        return f(p);
    };
    const double side = value(0) < 0 ? -1 : 1;
    bool sure = std::fabs(value(0)) > 1e-5;
    double before = 0;
    bool closer = false;
    for (double t = 0; sure && t < 10;) {
        const double d = side * value(t);
        if (d < 1e-9) return {d - side * value(t + 1e-5) > 1e-7, t};
        if (closer && d > before && before < 1e-5) sure = false;
        closer = d < before, before = d;
        t += d;
    }
    return {sure, HUGE_VAL};
}

/// Rays of both origins that disagree with a distance.
template <class Distance>
Difference compare_distance(const Tube& tube, int rays, float size, std::uint64_t seed, Distance f) {
    test::Random random(seed);
    Difference result;
    for (int i = 0; i < rays; ++i) {
        const Vec3 direction = random_direction(random), target = random_point(random, size);
        const Ray ray{i % 2 ? target : target - 3 * direction, direction};
        const auto want = first_crossing(ray, f);
        if (want.sure) result.add(trace(tube, ray), 1, want.t);
    }
    return result;
}

void check(const Difference& d, int at_least, double tolerance) {
    CHECK_LT(at_least, d.compared);
    CHECK_LT(0, d.hits);
    CHECK_EQ(d.misses, 0);
    CHECK_LT(d.worst, tolerance);
}

/// The circle of radius `ring` about z as a rational curve of degree 2 (The NURBS Book, section 7.5: nine points).
NurbsCurve<4> circle(double ring, double r) {
    const double h = std::sqrt(0.5);
    const double x[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[9] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    NurbsCurve<4> curve{2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, {}};
    for (int i = 0; i < 9; ++i) {
        const double w = i % 2 ? h : 1;
        curve.control_points.push_back({w * ring * x[i], w * ring * y[i], 0, w * r, w});
    }
    return curve;
}

double torus_distance(double ring, double r, const double (&p)[3]) {
    return std::hypot(std::hypot(p[0], p[1]) - ring, p[2]) - r;
}

NurbsCurve<4> random_curve(int degree, int count, float thick, bool rational, test::Random& random) {
    std::vector<Ball> balls;
    std::vector<double> weights;
    for (int i = 0; i < count; ++i) {
        balls.push_back({random(-1, 1), random(-1, 1), random(-1, 1), thick * random(0.2f, 1)});
        weights.push_back(rational ? random(0.3f, 3) : 1);
    }
    return clamped(degree, balls, weights);
}

TEST(ends_of_tubes_have_a_centre) {
    using bob::operator-;
    const Tube bent(clamped(2, {{-0.5, 0, 0, 0.1}, {0, 0.5, 0, 0.2}, {0.5, 0, 0, 0.3}}));
    const auto& ends = *bent.edges();
    CHECK(ends.size() == 2);
    const bob::Vec3d left{-0.5, 0, 0}, right{0.5, 0, 0};
    CHECK(bob::length(ends[0].circle->center - left) < 1e-9 && std::abs(ends[0].circle->radius - 0.1) < 1e-9);
    CHECK(bob::length(ends[1].circle->center - right) < 1e-9 && std::abs(ends[1].circle->radius - 0.3) < 1e-9);
    CHECK(std::abs(ends[0].circle->axis[0] - std::sqrt(0.5)) < 1e-9 && std::abs(ends[1].circle->axis[0] + std::sqrt(0.5)) < 1e-9);
    const Tube closed(clamped(1, {{0, 0, 0, 0.1}, {0.5, 0, 0, 0.1}, {0, 0.5, 0, 0.1}, {0, 0, 0, 0.1}}));
    CHECK(closed.edges()->empty());
    const Tube apart(NurbsCurve<4>{1,
                                   {0, 0, 1, 1, 2, 2, 3, 3},
                                   {{0, 0, 0, 0.1, 1},
                                    {0.5, 0, 0, 0.1, 1},
                                    {0, 0.5, 0, 0.2, 1},
                                    {0, 0.5, 0, 0.2, 1},
                                    {-0.5, 0, 0, 0.1, 1},
                                    {-0.5, 0.5, 0, 0.1, 1}}});
    CHECK(apart.edges()->size() == 5);  // the second is a ball
}

}  // namespace

TEST(capsules_and_round_cones_equal_their_distance) {
    const std::vector<Ball> shapes[] = {
        {{-0.5, 0.1, 0, 0.3}, {0.6, -0.2, 0.3, 0.3}},
        {{-0.5, 0.1, 0, 0.3}, {0.6, -0.2, 0.3, 0.1}},
        {{-0.5, 0.1, 0, 0.001}, {0.6, -0.2, 0.3, 0.4}},
        {{-0.1, 0, 0, 0.5}, {0.1, 0, 0.1, 0.1}},   // the larger ball holds the smaller one
        {{0, 0, 0, 0.5}, {0.3, 0, 0, 0.2}},        // and touches it
        {{0, 0, 0, 0.4}, {1e-7, 0, 0, 0.4}},
    };
    for (const auto& balls : shapes) {
        const Tube tube(clamped(1, balls));
        CHECK_EQ(tube.pieces(), 1u);
        const auto f = [&](const double(&p)[3]) { return distance_from_cones(balls, p); };
        test::for_each_isa([&] { check(compare_distance(tube, 2000, 0.7f, 1, f), 1500, 1e-6); });
    }
}

TEST(rays_along_a_capsules_axis_meet_its_ends) {
    const Tube tube(clamped(1, {{-0.5, 0, 0, 0.25}, {0.5, 0, 0, 0.25}}));
    for (const float scale : {1e-9f, 1e-3f, 1.f, 7.f, 1e9f}) {
        const auto t = [&](Vec3 origin, float sign) { return trace(tube, {origin, {sign * scale, 0, 0}}).t * scale; };
        CHECK_NEAR(t({-2, 0, 0}, 1), 1.25, 1e-6);
        CHECK_NEAR(t({2, 0, 0}, -1), 1.25, 1e-6);
        CHECK_NEAR(t({0.1f, 0, 0}, 1), 0.65, 1e-6);
        CHECK_NEAR(t({-0.6f, 0, 0}, 1), 1.35, 1e-6);
        CHECK_NEAR(t({-2, 0.15f, 0}, 1), 1.3, 1e-6);
        CHECK(!std::isfinite(t({1, 0, 0}, 1)));
        CHECK(!std::isfinite(t({-2, 0.2500001f, 0}, 1)));
    }
}

TEST(polylines_have_no_gaps_at_their_corners) {
    for (const double r : {0.005, 0.1}) {
        const std::vector<Ball> balls = {{-0.5, 0, 0, r},        {0, 0.3, 0, r},     {0.1, 0.3, 0.01, r / 2},
                                         {0.1, 0.31, 0, 2 * r},  {0.5, -0.5, 0, r},  {0.5, -0.5, 0.5, r},
                                         {-0.5, 0, 0, r}};
        const Tube tube(clamped(1, balls));
        CHECK_EQ(tube.pieces(), 6u);
        const auto f = [&](const double(&p)[3]) { return distance_from_cones(balls, p); };
        check(compare_distance(tube, 3000, 0.6f, 2, f), 2500, 1e-6);
        // At the corners, and from them.
        test::Random random(3);
        Difference result;
        for (int i = 0; i < 3000; ++i) {
            const Ball& b = balls[static_cast<std::size_t>(i) % balls.size()];
            const Vec3 centre{static_cast<float>(b[0]), static_cast<float>(b[1]), static_cast<float>(b[2])};
            const Vec3 direction = random_direction(random);
            const Vec3 target = centre + random_point(random, i % 3 ? 1.2f * static_cast<float>(r) : 0);
            const Ray ray{i % 2 ? target : target - 2 * direction, direction};
            const auto want = first_crossing(ray, f);
            if (want.sure) result.add(trace(tube, ray), 1, want.t);
        }
        check(result, 2500, 1e-6);
    }
}

TEST(rational_circles_make_tori) {
    for (const auto& [ring, r] : {std::pair{0.7, 0.2}, {0.7, 0.002}, {0.4, 0.4}, {0.3, 0.5}}) {
        const Tube tube(circle(ring, r));
        const auto f = [ring = ring, r = r](const double(&p)[3]) { return torus_distance(ring, r, p); };
        test::for_each_isa([&] { check(compare_distance(tube, 2000, 1, 4, f), 1500, 2e-6); });
    }
}

TEST(tubes_of_random_curves_equal_dense_balls) {
    test::Random random(3);
    for (int shape = 0; shape < 20; ++shape) {
        const float thick = shape % 3 == 0 ? 0.02f : shape % 3 == 1 ? 0.1f : 0.5f;
        const auto seed = static_cast<std::uint64_t>(shape) + 10;
        check(compare(random_curve(3, 7, thick, false, random), 2000, 1200, seed), 1700, 1e-5);
    }
}

TEST(tubes_of_any_degree_and_weights_equal_dense_balls) {
    test::Random random(4);
    for (int degree = 2; degree <= bob::max_degree; ++degree) {
        check(compare(random_curve(degree, degree + 3, 0.1f, true, random), 500, 2000, 5), 400, 1e-5);
    }
}

TEST(tubes_thicker_than_their_bends_equal_dense_balls) {
    test::Random random(5);
    const std::vector<Ball> hairpin = {
        {-0.5, 0, 0, 0.3}, {0.5, 0.05, 0, 0.3}, {0.5, -0.05, 0, 0.2}, {-0.5, 0, 0.1, 0.3}};
    const std::vector<Ball> cusp = {{0, 0, 0, 0.05}, {1, 1, 0, 0.05}, {0, 1, 0, 0.05}, {1, 0, 0, 0.05}};
    const std::vector<Ball> balloon = {{0, 0, 0, 0.01}, {0.1, 0, 0, 1}, {0.2, 0, 0, -0.4}, {0.3, 0.1, 0, 0.3}};
    for (const auto& balls : {hairpin, cusp, balloon}) check(compare(clamped(3, balls), 2000, 2000, 6), 1700, 1e-5);
}

TEST(hairs_equal_dense_balls) {
    test::Random random(16);
    Difference all;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Difference d = compare(random_curve(3, 5, 1e-4f, false, random), 200, 2000, seed);
        all.compared += d.compared, all.hits += d.hits, all.misses += d.misses;
        all.worst = std::max(all.worst, d.worst);
    }
    check(all, 1000, 2e-6);
}

TEST(curves_without_length_make_balls) {
    const auto f = [](const double(&p)[3]) { return std::hypot(p[0] - 0.1, p[1], p[2]) - 0.3; };
    for (const int degree : {1, 3, 9}) {
        const std::vector<Ball> balls(static_cast<std::size_t>(degree) + 4, {0.1, 0, 0, 0.3});
        check(compare_distance(Tube(clamped(degree, balls)), 1000, 0.6f, 7, f), 800, 1e-6);
    }
}

TEST(repeated_control_points_and_knots_change_nothing) {
    const std::vector<Ball> balls = {{-0.5, 0, 0, 0.1}, {0.5, 0, 0.1, 0.1}};
    const auto f = [&](const double(&p)[3]) { return distance_from_cones(balls, p); };
    const std::vector<Ball> repeated = {balls[0], balls[0], balls[0], balls[1], balls[1], balls[1], balls[1]};
    for (const int degree : {1, 2, 3, 6}) {
        check(compare_distance(Tube(clamped(degree, repeated)), 500, 0.6f, 8, f), 400, 1e-6);
    }
}

TEST(weights_of_any_size_make_few_pieces) {
    test::Random random(9);
    for (const float exponent : {1.f, 6.f, 100.f}) {
        for (int i = 0; i < 10; ++i) {
            auto curve = random_curve(9, 10, 0.1f, false, random);
            for (auto& p : curve.control_points) {
                const double w = std::pow(10.0, random(-exponent, exponent));
                for (double& x : p) x *= w;
            }
            const Tube tube(curve);
            CHECK_LT(tube.pieces(), 2000u);
            // From each end, the ball there is left, and something of it is met from outside.
            const double end = curve.knots.front();
            const Ball b = curve_point(curve, end);
            const Vec3 centre{static_cast<float>(b[0]), static_cast<float>(b[1]), static_cast<float>(b[2])};
            CHECK(found(trace(tube, {centre, {0, 0, 1}})));
            CHECK(found(trace(tube, {centre - Vec3{0, 0, 9}, {0, 0, 1}})));
        }
    }
}

TEST(rays_along_the_outline_end) {
    // The ray touches the ball everywhere: all that is left of the discriminant is rounding.
    const double r = 0.1f;
    const std::vector<Ball> balls = {{-0.7, 0, 0, r}, {0.3, 0, 0, r}, {-0.1, 0, 0, r}, {0.9, 0, 0, r}};
    const Tube tube(clamped(3, balls));
    test::Random random(11);
    for (int i = 0; i < 300; ++i) {
        const float angle = random(0, 6.3f), y = 0.1f * std::cos(angle), z = 0.1f * std::sin(angle);
        const Hit hit = trace(tube, {{-3, y, z}, {1, random(-1e-7f, 1e-7f), 0}});
        CHECK(!found(hit) || (hit.t > 2.19f && hit.t < 4));
    }
}

TEST(places_are_parameters_of_the_curve) {
    test::Random random(12);
    for (const bool rational : {false, true}) {
        NurbsCurve<4> curve = random_curve(3, 8, 0.05f, rational, random);
        for (double& knot : curve.knots) knot = 10 + knot * knot;
        const Tube tube(curve);
        int hits = 0;
        for (int i = 0; i < 5000; ++i) {
            const Vec3 direction = random_direction(random);
            const Ray ray{random_point(random, 0.5f) - 3 * direction, direction};
            const Hit hit = trace(tube, ray);
            if (!found(hit)) continue;
            ++hits;
            const bob::Place place = tube.place(hit);
            CHECK_EQ(place.part, 0u);
            const Ball ball = curve_point(curve, place.u);
            double square = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const double d = ray.origin[axis] + static_cast<double>(hit.t) * ray.direction[axis] -
                                 ball[static_cast<std::size_t>(axis)];
                square += d * d;
            }
            CHECK_NEAR(std::sqrt(square), ball[3], 1e-6);
        }
        CHECK_LT(50, hits);
    }
}

TEST(periodic_curves_are_closed) {
    // Knots that are not repeated, the first control points again at the end.
    NurbsCurve<4> curve{3, {}, {}};
    for (int i = 0; i < 12; ++i) {
        const double angle = i % 8 * std::acos(-1) / 4;
        if (i < 11) curve.control_points.push_back({0.6 * std::cos(angle), 0.6 * std::sin(angle), 0, 0.1, 1});
    }
    for (int i = 0; i < 15; ++i) curve.knots.push_back(i);
    check(compare(curve, 1000, 2000, 13), 800, 1e-5);
}

TEST(instruction_sets_agree) {
    test::Random random(14);
    const Tube tube(random_curve(4, 20, 0.1f, true, random));
    std::vector<Ray> rays;
    for (int i = 0; i < 5000; ++i) {
        const Vec3 direction = random_direction(random);
        rays.push_back({random_point(random, 0.8f) - (i % 3 ? 3.f : 0.f) * direction, direction});
    }
    std::vector<Hit> expected;
    test::for_each_isa([&] {
        std::vector<Hit> hits(rays.size());
        tube.closest_hits(rays, hits);
        if (expected.empty()) expected = hits;
        int other = 0;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const Hit &a = hits[i], &b = expected[i];
            other += a.t != b.t || a.primitive != b.primitive || a.u != b.u;
        }
        CHECK_EQ(other, 0);
    });
}

TEST(maxima_are_at_most_a_thousandth_too_large) {
    test::Random random(15);
    for (const bool rational : {false, true}) {
        const auto curve = random_curve(5, 9, 0.3f, rational, random);
        const Tube tube(curve);
        const Sampled sampled(curve, 20000);
        for (int i = 0; i < 10; ++i) {
            const Vec3 d = random_direction(random), from = random_point(random, 1);
            const std::function<double(Vec3, float)> functions[] = {
                [&](Vec3 centre, float r) { return dot(d, centre) + r; },
                [&](Vec3 centre, float r) { return length(centre - from) + r; },
            };
            for (const auto& f : functions) {
                double low = HUGE_VAL, high = -HUGE_VAL;
                for (const Ball& b : sampled.balls) {
                    const Vec3 centre{static_cast<float>(b[0]), static_cast<float>(b[1]), static_cast<float>(b[2])};
                    const double value = f(centre, static_cast<float>(b[3]));
                    low = std::min(low, value), high = std::max(high, value);
                }
                const double found = tube.maximum(f);
                CHECK_LT(high - 1e-6, found);
                CHECK_LT(found, high + 1.1e-3 * (high - low));
            }
        }
    }
    const Tube ball(clamped(2, std::vector<Ball>(3, {0.1, 0.2, 0.3, 0.25})));
    CHECK_NEAR(ball.maximum([](Vec3 centre, float r) { return centre.x + r; }), 0.35, 1e-7);
}

TEST(normals_are_of_unit_length_and_face_the_ray) {
    test::Random random(10);
    const Tube tube(random_curve(3, 8, 0.1f, true, random));
    const double ring = 0.7, r = 0.002;
    const Tube thin(circle(ring, r));
    for (int i = 0; i < 4000; ++i) {
        const Vec3 direction = 3 * random_direction(random), target = random_point(random, 0.8f);
        const Ray ray{i % 2 ? target : target - direction, direction};
        for (const Tube* t : {&tube, &thin}) {
            const Hit hit = trace(*t, ray);
            if (!found(hit)) continue;
            Vec3 normal;
            t->normals({&ray, 1}, {&hit, 1}, {&normal, 1});
            CHECK_NEAR(length(normal), 1, 1e-6);
            CHECK_LT(dot(normal, direction), 1e-5);
        }
    }
}
