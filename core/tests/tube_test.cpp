#include "shapes/tube.h"

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

/// Where rays meet a dense row of balls: the union of their segments, sure to be within `tolerance` (t, for rays of
/// length 1), or not sure where the ray grazes.
struct Sampled {
    std::vector<Ball> balls;

    explicit Sampled(const NurbsCurve<4>& curve, int count) {
        const double low = curve.knots[static_cast<std::size_t>(curve.degree)];
        const double high = curve.knots[curve.control_points.size()];
        for (int i = 0; i <= count; ++i) balls.push_back(curve_point(curve, low + (high - low) * i / count));
    }

    struct Answer {
        bool sure = true;
        double t = HUGE_VAL;
    };

    [[nodiscard]] Answer operator()(const Ray& ray) const {
        const double ox = ray.origin.x, oy = ray.origin.y, oz = ray.origin.z;
        const double dx = ray.direction.x, dy = ray.direction.y, dz = ray.direction.z;
        const double scale = std::sqrt(dx * dx + dy * dy + dz * dz);
        struct Segment { double low, high; };
        std::vector<Segment> spans;
        Answer answer;
        double before = -1, before_that = -1;
        bool open = false;
        for (const Ball& b : balls) {
            const double x = b[0] - ox, y = b[1] - oy, z = b[2] - oz;
            const double a = (x * dx + y * dy + z * dz) / scale;
            const double px = x - a * dx / scale, py = y - a * dy / scale, pz = z - a * dz / scale;
            const double q = b[3] * b[3] - px * px - py * py - pz * pz;
            // The greatest or least q along the curve is next to 0: a graze.
            const double band = 3e-5 * b[3];
            if (std::fabs(before) < band && (before >= q) == (before >= before_that)) answer.sure = false;
            before_that = before, before = q;
            if (q < 0) {
                open = false;
                continue;
            }
            const Segment s{a - std::sqrt(q), a + std::sqrt(q)};
            if (open) {
                spans.back().low = std::min(spans.back().low, s.low), spans.back().high = std::max(spans.back().high, s.high);
            } else {
                spans.push_back(s);
                if (std::fabs(q) < band) answer.sure = answer.sure && &b != &balls.front();
            }
            open = true;
        }
        if (std::fabs(before) < 3e-5 * balls.back()[3]) answer.sure = false;
        std::sort(spans.begin(), spans.end(), [](const Segment& a, const Segment& b) { return a.low < b.low; });
        double reach = 0;
        for (const Segment& s : spans) {
            // Near either way, to sampling: an origin on the surface, or spans that hardly touch.
            if (std::fabs(s.low - reach) < 1e-5 || (reach == 0 && std::fabs(s.high) < 1e-5)) answer.sure = false;
            if (s.low <= reach && s.high > reach) reach = s.high;
        }
        if (reach > 0) {
            answer.t = reach;
        } else {
            for (const Segment& s : spans) {
                if (s.low > 0) answer.t = std::min(answer.t, s.low);
            }
        }
        answer.t /= scale;
        return answer;
    }
};

struct Difference {
    int compared = 0, misses = 0;
    double worst = 0;
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
        if (!want.sure) continue;
        ++result.compared;
        const Hit hit = trace(tube, ray);
        if (found(hit) != (want.t < HUGE_VAL)) {
            ++result.misses;
        } else if (found(hit)) {
            result.worst = std::max(result.worst, std::fabs(hit.t - want.t));
        }
    }
    return result;
}

}  // namespace

TEST(tubes_of_random_curves_equal_dense_balls) {
    test::Random random(3);
    for (int shape = 0; shape < 20; ++shape) {
        std::vector<Ball> balls;
        const float thick = shape % 3 == 0 ? 0.02f : shape % 3 == 1 ? 0.1f : 0.5f;
        for (int i = 0; i < 7; ++i) {
            balls.push_back({random(-1, 1), random(-1, 1), random(-1, 1), thick * random(0.2f, 1)});
        }
        const auto d = compare(clamped(3, balls), 200, 100000, static_cast<std::uint64_t>(shape) + 10);
        std::printf("%d thick %g: %d compared, %d misses, worst %g pieces %zu\n", shape, thick, d.compared, d.misses, d.worst, Tube(clamped(3, balls)).pieces());
        CHECK_EQ(d.misses, 0);
        CHECK_LT(d.worst, 1e-5);
    }
}
