#include "shapes/brep/brep.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "check.h"

using bob::Brep;
using bob::Face;
using bob::Hit;
using bob::NurbsSurface;
using bob::Ray;
using bob::Vec3;
using std::numbers::pi;
using test::Random;

namespace {

// Largest distance of hits from the surface, in scene units: float32's rounding of t, origin and control points.
constexpr double near_surface = 1e-6;

/// Failures name the case.
template <class... Words>
void expect(bool condition, const Words&... words) {
    if (condition) return;
    std::ostringstream text;
    (text << ... << words) << ", " << name(bob::isa());
    test::fail(__FILE__, 0, text.str());
}

// ---- Points in double precision ---------------------------------------------------------------------------------

using Point = std::array<double, 3>;

Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point operator*(double s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Point& a) { return std::sqrt(dot(a, a)); }
Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Point point(Vec3 a) { return {a.x, a.y, a.z}; }
Vec3 rounded(const Point& a) {
    return {static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
}
Point along(const Ray& ray, double t) { return point(ray.origin) + t * point(ray.direction); }

// ---- Surfaces -----------------------------------------------------------------------------------------------

bob::Domain domain(const NurbsSurface& s) {
    return {s.knots_u[static_cast<std::size_t>(s.degree_u)], s.knots_u[s.size_u()],
            s.knots_v[static_cast<std::size_t>(s.degree_v)], s.knots_v[s.size_v()]};
}

Point at(const NurbsSurface& surface, double u, double v) { return surface_derivatives(surface, u, v, 0)[0]; }

std::vector<double> clamped(int degree, int count) {
    std::vector<double> knots;
    for (int i = 0; i < count + degree + 1; ++i) knots.push_back(std::clamp(i - degree, 0, count - degree));
    return knots;
}

/// Control points position(i, j) with weights weight(i, j).
template <class Position, class Weight>
NurbsSurface surface(int p, int q, std::vector<double> knots_u, std::vector<double> knots_v, Position position,
                     Weight weight) {
    NurbsSurface s{p, q, std::move(knots_u), std::move(knots_v), {}};
    for (std::size_t i = 0; i < s.size_u(); ++i) {
        for (std::size_t j = 0; j < s.size_v(); ++j) {
            const Point x = position(static_cast<int>(i), static_cast<int>(j));
            const double w = weight(static_cast<int>(i), static_cast<int>(j));
            s.control_points.push_back({w * x[0], w * x[1], w * x[2], w});
        }
    }
    return s;
}

constexpr auto not_rational = [](int, int) { return 1.0; };

/// A sheet above -1..1 in x and y, of random heights and, if so, of weights from 0.01 to 100.
NurbsSurface sheet(int p, int q, std::vector<double> knots_u, std::vector<double> knots_v, std::uint64_t seed,
                   bool rational = false) {
    const int n = static_cast<int>(knots_u.size()) - p - 1, m = static_cast<int>(knots_v.size()) - q - 1;
    Random random(seed);
    return surface(
        p, q, std::move(knots_u), std::move(knots_v),
        [&](int i, int j) {
            return Point{2.0 * i / (n - 1) - 1, 2.0 * j / (m - 1) - 1, random(-0.7f, 0.7f)};
        },
        [&](int, int) { return rational ? std::pow(10.0, random(-2, 2)) : 1.0; });
}

// A quarter of the unit circle is the rational quadratic with these control points and weights (The NURBS Book, 7.3).
constexpr double circle_x[] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, circle_y[] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
const std::vector<double> circle_knots{0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
double circle_weight(int i) { return i % 2 ? std::sqrt(0.5) : 1; }

/// Control points (distance from the z axis, z) with weights, turned about the axis: u along the profile, v around.
NurbsSurface revolved(int degree, std::vector<double> knots, const std::vector<std::array<double, 3>>& profile) {
    return surface(
        degree, 2, std::move(knots), circle_knots,
        [&](int i, int j) {
            const auto& [r, z, w] = profile[static_cast<std::size_t>(i)];
            return Point{r * circle_x[j], r * circle_y[j], z};
        },
        [&](int i, int j) { return profile[static_cast<std::size_t>(i)][2] * circle_weight(j); });
}

NurbsSurface moved(NurbsSurface s, const Point& offset, double scale = 1) {
    for (auto& [x, y, z, w] : s.control_points) {
        x = scale * x + w * offset[0], y = scale * y + w * offset[1], z = scale * z + w * offset[2];
    }
    return s;
}

NurbsSurface unit_sphere() {
    std::vector<std::array<double, 3>> half;
    for (int i = 6; i <= 10; ++i) half.push_back({circle_x[i % 8], circle_y[i % 8], circle_weight(i)});
    return revolved(2, {0, 0, 0, 1, 1, 2, 2, 2}, half);
}

constexpr double spine = 0.7, thickness = 0.25;
NurbsSurface torus() {
    std::vector<std::array<double, 3>> circle;
    for (int i = 0; i < 9; ++i) {
        circle.push_back({spine + thickness * circle_x[i], thickness * circle_y[i], circle_weight(i)});
    }
    return revolved(2, circle_knots, circle);
}

bob::TrimLoop circle(double u, double v, double radius) {
    bob::NurbsCurve<2> curve{2, circle_knots, {}};
    for (int i = 0; i < 9; ++i) {
        const double w = circle_weight(i);
        curve.control_points.push_back({w * (u + radius * circle_x[i]), w * (v + radius * circle_y[i]), w});
    }
    return {curve};
}

/// x and y are the parameters, -1..1.
NurbsSurface square(double z) {
    const std::vector<double> knots{-1, -1, 1, 1};
    return surface(1, 1, knots, knots, [=](int i, int j) { return Point{2. * i - 1, 2. * j - 1, z}; }, not_rational);
}

/// Of three faces; the caps are squares that circles trim.
constexpr double can_radius = 0.7, can_low = -0.6, can_high = 0.4;
std::vector<Face> can() {
    return {{revolved(1, {0, 0, 1, 1}, {{can_radius, can_low, 1}, {can_radius, can_high, 1}}), {}},
            {square(can_low), {circle(0, 0, can_radius)}},
            {square(can_high), {circle(0, 0, can_radius)}}};
}

/// Six bilinear patches, whichever way their u and v turn.
std::vector<Face> cube(double half) {
    std::vector<Face> faces;
    for (const std::size_t axis : {0, 1, 2}) {
        for (const double side : {-half, half}) {
            faces.push_back({surface(
                                 1, 1, {0, 0, 1, 1}, {0, 0, 1, 1},
                                 [&](int i, int j) {
                                     Point x;
                                     x[axis] = side, x[(axis + 1) % 3] = (2 * i - 1) * half;
                                     x[(axis + 2) % 3] = (2 * j - 1) * half;
                                     return x;
                                 },
                                 not_rational),
                             {}});
        }
    }
    return faces;
}

/// A bicubic B-spline that closes both ways, of unclamped knots: a bent ring whose inside holds the circle of radius
/// 0.6 in z = 0.
NurbsSurface ring() {
    constexpr int around = 7, across = 6;
    const auto knots = [](int count) {
        std::vector<double> all;
        for (int i = 0; i < count + 4; ++i) all.push_back(i);
        return all;
    };
    return surface(
        3, 3, knots(around + 3), knots(across + 3),
        [&](int i, int j) {
            const double a = 2 * pi * (i % around) / around, b = 2 * pi * (j % across) / across;
            const double wide = 0.35 + (i % around % 3) * 0.05, from_axis = 0.75 + wide * std::cos(b);
            return Point{from_axis * std::cos(a), from_axis * std::sin(a), wide * std::sin(b)};
        },
        not_rational);
}

// ---- Rays ---------------------------------------------------------------------------------------------------

Vec3 random_direction(Random& random) {
    while (true) {
        const Vec3 d{random(-1, 1), random(-1, 1), random(-1, 1)};
        if (dot(d, d) > 0.01f && dot(d, d) < 1) return bob::normalized(d);
    }
}

Vec3 random_point(Random& random, float size) {
    return {random(-size, size), random(-size, size), random(-size, size)};
}

Ray towards(const Point& target, Vec3 direction, float from) {
    return {rounded(target) - from * direction, direction};
}

/// From outside of the unit sphere and from within.
std::vector<Ray> random_rays(std::uint64_t seed, int count, float size = 0.9f) {
    Random random(seed);
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i) {
        const Vec3 direction = random_direction(random), target = random_point(random, size);
        rays.push_back({target - (i % 4 ? 3.f : 0.f) * direction, direction});
    }
    return rays;
}

std::vector<Hit> trace(const Brep& brep, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    brep.closest_hits(rays, hits);
    return hits;
}

/// Of an orthographic picture, row by row: neighbours go the same way.
std::vector<Ray> picture_rays(Vec3 direction, int side) {
    const Vec3 right = bob::normalized(Vec3{direction.y, -direction.x, 0}), up = cross(right, direction);
    std::vector<Ray> rays;
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) {
            const auto at = [&](int i) { return 2.f * (static_cast<float>(i) + 0.5f) / static_cast<float>(side) - 1; };
            rays.push_back({at(column) * right + at(row) * up - 2 * direction, direction});
        }
    }
    return rays;
}

Hit trace(const Brep& brep, const Ray& ray) { return trace(brep, {&ray, 1})[0]; }

Vec3 normal(const Brep& brep, const Ray& ray, const Hit& hit) {
    Vec3 n;
    brep.normals({&ray, 1}, {&hit, 1}, {&n, 1});
    return n;
}

bool found(const Hit& hit) { return hit.primitive != bob::no_primitive; }

Brep brep_of(NurbsSurface s) { return Brep(std::vector<Face>{{std::move(s), {}}}); }

// ---- Closed forms -------------------------------------------------------------------------------------------

using Distance = double (*)(const Point&);  // signed

double sphere_distance(const Point& p) { return length(p) - 1; }
double torus_distance(const Point& p) {
    return std::hypot(std::hypot(p[0], p[1]) - spine, p[2]) - thickness;
}
double can_distance(const Point& p) {
    const double out = std::hypot(p[0], p[1]) - can_radius;
    const double up = std::fabs(p[2] - (can_low + can_high) / 2) - (can_high - can_low) / 2;
    return std::min(std::max(out, up), 0.0) + std::hypot(std::max(out, 0.0), std::max(up, 0.0));
}

struct Root {
    double t = HUGE_VAL;
    bool sure = true;  // not where the ray grazes before
};

/// Sphere tracing in double precision.
Root first_root(Distance distance, const Ray& ray) {
    Root root;
    const double size = length(point(ray.direction));
    const double sign = distance(point(ray.origin)) < 0 ? -1 : 1;
    double t = 0, before = HUGE_VAL;
    bool receding = false;
    while (t * size < 20) {
        const double d = sign * distance(along(ray, t));
        if (d < 1e-10) {
            root.t = t;
            return root;
        }
        receding = receding || d > before;
        if (d > before && before < 2e-5) root.sure = false;
        before = d;
        t += d / size;
    }
    return root;
}

// ---- Dense search -------------------------------------------------------------------------------------------

/// Where a ray meets a surface, found by Newton's method in double precision from every triangle of a fine grid that
/// the ray meets or nearly meets.
class Dense {
public:
    static constexpr int steps = 72;

    explicit Dense(const NurbsSurface& surface) : surface_(surface), domain_(domain(surface)) {
        for (int i = 0; i <= steps; ++i) {
            for (int j = 0; j <= steps; ++j) grid_.push_back(at(surface, u(i), v(j)));
        }
    }

    /// The least t above 0 of roots that are not near tangent, and that keep(u, v) leaves; infinite without any.
    template <class Keep>
    [[nodiscard]] double nearest(const Ray& ray, Keep keep) const {
        double nearest = HUGE_VAL;
        const auto index = [](int i, int j) { return static_cast<std::size_t>(i * (steps + 1) + j); };
        for (int i = 0; i < steps; ++i) {
            for (int j = 0; j < steps; ++j) {
                const Point &a = grid_[index(i, j)], &b = grid_[index(i + 1, j)], &c = grid_[index(i, j + 1)],
                            &d = grid_[index(i + 1, j + 1)];
                if (!(is_near(ray, a, b, c) || is_near(ray, d, b, c))) continue;
                double u = 0.5 * (this->u(i) + this->u(i + 1)), v = 0.5 * (this->v(j) + this->v(j + 1));
                const double t = newton(ray, u, v);
                if (t > 0 && t < nearest && keep(u, v)) nearest = t;
            }
        }
        return nearest;
    }

private:
    [[nodiscard]] double u(int i) const { return domain_.low_u + (domain_.high_u - domain_.low_u) * i / steps; }
    [[nodiscard]] double v(int j) const { return domain_.low_v + (domain_.high_v - domain_.low_v) * j / steps; }

    static bool is_near(const Ray& ray, const Point& a, const Point& b, const Point& c) {
        const Point d = point(ray.direction), ab = b - a, ac = c - a, to = point(ray.origin) - a;
        const Point x = cross(d, ac), y = cross(to, ab);
        const double det = dot(ab, x);
        if (det == 0) return false;
        const double s = dot(to, x) / det, r = dot(d, y) / det;
        constexpr double margin = 0.1;
        return s > -margin && r > -margin && s + r < 1 + margin;
    }

    /// NaN where it does not converge, leaves the domain or is near tangent.
    double newton(const Ray& ray, double& u, double& v) const {
        const Point d = point(ray.direction);
        double t = NAN;
        for (int step = 0; step < 12; ++step) {
            const auto s = surface_derivatives(surface_, u, v, 1);  // S, S_v, S_u, and nothing
            const Point to = point(ray.origin) - s[0], n = cross(s[2], s[1]);
            const double det = dot(n, d);
            if (!(std::fabs(det) > 0.01 * length(n) * length(d))) return NAN;
            t = -dot(to, n) / det;
            const Point rest = along(ray, t) - s[0];
            const double square = dot(n, n);
            const double du = dot(cross(rest, s[1]), n) / square, dv = dot(cross(s[2], rest), n) / square;
            u += du, v += dv;
            const auto& [low_u, high_u, low_v, high_v] = domain_;
            if (!(u >= low_u && u <= high_u && v >= low_v && v <= high_v)) return NAN;
            if (length(rest) < 1e-11) return t;
        }
        return NAN;
    }

    const NurbsSurface& surface_;
    bob::Domain domain_;
    std::vector<Point> grid_;
};

constexpr auto everything = [](double, double) { return true; };

/// Distances of a hit from the surface, and from the point of its parameters as a share of the tolerance.
struct Miss {
    double above, aside;
};

Miss missed_by(const Brep& brep, const NurbsSurface& surface, const Ray& ray, const Hit& hit) {
    const bob::Place place = brep.place(hit);
    const auto s = surface_derivatives(surface, place.u, place.v, 1);
    const Point off = along(ray, hit.t) - s[0], n = cross(s[2], s[1]);
    // Parameters are in float32, 0..1 in their patch.
    const bob::Domain& patch = brep.pieces().patches[hit.primitive].domain;
    const double in_u = length(s[2]) * (patch.high_u - patch.low_u), in_v = length(s[1]) * (patch.high_v - patch.low_v);
    const double allowed = near_surface + 1e-7 * (in_u + in_v);
    return {dot(n, n) > 0 ? std::fabs(dot(off, n)) / length(n) : 0, length(off) / allowed};
}

struct Named {
    const char* what;
    NurbsSurface surface;
};

/// Shapes that are hard to intersect, all within -1..1.
std::vector<Named> zoo() {
    std::vector<Named> all;
    const auto bezier = [](int degree) { return clamped(degree, degree + 1); };
    all.push_back({"saddle", surface(
                                 1, 1, bezier(1), bezier(1),
                                 [](int i, int j) { return Point{2. * i - 1, 2. * j - 1, i == j ? 0.7 : -0.7}; },
                                 not_rational)});
    all.push_back({"wave", sheet(3, 3, clamped(3, 9), clamped(3, 8), 1)});
    all.push_back({"degree 9, 9", sheet(9, 9, bezier(9), bezier(9), 2)});
    all.push_back({"degree 1, 9", sheet(1, 9, clamped(1, 4), bezier(9), 3)});
    all.push_back({"degree 2, 9, of weights 0.01 to 100", sheet(2, 9, clamped(2, 5), clamped(9, 12), 4, true)});
    all.push_back({"weights 0.01 to 100", sheet(3, 2, clamped(3, 7), clamped(2, 6), 5, true)});
    all.push_back({"unclamped", sheet(3, 2, {-3, -2.5, -1, 0, 1, 1.5, 3, 4, 4.5, 9}, {0, 1, 2, 3, 4, 5, 6, 7}, 6)});
    all.push_back({"jumps", sheet(2, 3, {0, 0, 0, 1, 1, 1, 2, 2, 2}, {0, 0, 0, 0, 1, 2, 2, 2, 2, 3, 3, 3, 3}, 7)});
    all.push_back({"sphere", unit_sphere()});
    all.push_back({"torus", torus()});
    all.push_back({"ring", ring()});
    all.push_back({"rolled up", surface(
                                    3, 2, clamped(3, 12), clamped(2, 3),
                                    [](int i, int j) {
                                        const double r = 0.1 + 0.07 * i;
                                        return Point{r * std::cos(1.3 * i), r * std::sin(1.3 * i), 0.8 * (j - 1)};
                                    },
                                    not_rational)});
    Random random(8);
    all.push_back({"tangled", surface(
                                  4, 3, clamped(4, 8), clamped(3, 8),
                                  [&](int, int) { return point(random_point(random, 0.9f)); }, not_rational)});
    all.push_back({"a triangle, one edge a point",
                   surface(
                       3, 3, bezier(3), bezier(3),
                       [](int i, int j) { return Point{i / 3.0, i / 3.0 * (j / 3.0 - 0.5), 0.3 * i * j / 9}; },
                       not_rational)});
    return all;
}

}  // namespace

TEST(brep_meets_closed_forms) {
    struct Solid {
        std::vector<Face> faces;
        Distance distance;
    };
    const Solid solids[] = {
        {{{unit_sphere(), {}}}, sphere_distance}, {{{torus(), {}}}, torus_distance}, {can(), can_distance}};
    for (const auto& [faces, distance] : solids) {
        const Brep brep(faces);
        const auto rays = random_rays(1, 3000);
        std::vector<Root> roots;
        for (const Ray& ray : rays) roots.push_back(first_root(distance, ray));
        test::for_each_isa([&] {
            const auto hits = trace(brep, rays);
            int sure = 0, met = 0;
            double worst = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (found(hits[i])) worst = std::max(worst, std::fabs(distance(along(rays[i], hits[i].t))));
                if (!roots[i].sure) continue;
                ++sure, met += found(hits[i]);
                CHECK_EQ(found(hits[i]), roots[i].t < HUGE_VAL);
                if (found(hits[i])) CHECK_NEAR(hits[i].t, roots[i].t, 1e-4);
            }
            CHECK_LT(worst, near_surface);
            CHECK_LT(0.99 * 3000, sure);
            CHECK_LT(500, met);
        });
    }
}

TEST(brep_hits_lie_on_the_surface_and_nothing_before_them) {
    for (const auto& [what, surface] : zoo()) {
        const Brep brep = brep_of(surface);
        const auto rays = random_rays(2, 400);
        const Dense dense(surface);
        std::vector<double> nearest;
        for (const Ray& ray : rays) nearest.push_back(dense.nearest(ray, everything));
        test::for_each_isa([&] {
            const auto hits = trace(brep, rays);
            int met = 0, passed = 0;
            double above = 0, aside = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                passed += nearest[i] + 1e-5 < hits[i].t;
                if (!found(hits[i])) continue;
                ++met;
                const Miss miss = missed_by(brep, surface, rays[i], hits[i]);
                above = std::max(above, miss.above), aside = std::max(aside, miss.aside);
            }
            expect(passed == 0, what, ": passed ", passed);
            expect(above < near_surface, what, ": above by ", above);
            expect(aside < 1, what, ": aside by ", aside);
            expect(met > 20, what, ": met ", met);
        });
    }
}

TEST(brep_hits_do_not_depend_on_batches) {
    std::vector<Face> faces = can();
    faces.push_back({moved(unit_sphere(), {0.1, 0.2, 0.8}, 0.3), {}});
    faces.push_back({sheet(3, 3, clamped(3, 9), clamped(3, 8), 1), {circle(3, 2, 1.5)}});
    const Brep brep(faces);
    auto rays = random_rays(3, 1000);
    for (const Ray& ray : picture_rays(bob::normalized(Vec3{-1, -0.7f, -0.4f}), 60)) rays.push_back(ray);
    test::for_each_isa([&] {
        const auto hits = trace(brep, rays);
        for (std::size_t i = rays.size(); i-- > 0;) {
            const Hit alone = trace(brep, rays[i]);
            CHECK(alone.t == hits[i].t && alone.primitive == hits[i].primitive && alone.u == hits[i].u &&
                  alone.v == hits[i].v);
        }
    });
}

TEST(brep_leaks_no_rays) {
    struct Closed {
        const char* what;
        std::vector<Face> faces;
        Point (*inside)(Random&);
        double between[2];  // a hit's distance from the origin, but for rounding
    };
    const Closed all[] = {
        {"sphere",
         {{unit_sphere(), {}}},
         [](Random& random) { return 0.999 * point(random_direction(random)); },
         {1, 1}},
        {"torus",
         {{torus(), {}}},
         [](Random& random) {
             const double a = random(-4, 4), b = random(-4, 4), r = spine + 0.999 * thickness * std::cos(b);
             return Point{r * std::cos(a), r * std::sin(a), 0.999 * thickness * std::sin(b)};
         },
         {spine - thickness, spine + thickness}},
        {"can",
         can(),
         [](Random& random) {
             const double a = random(-4, 4), r = can_radius * std::sqrt(random()) * 0.9999;
             return Point{r * std::cos(a), r * std::sin(a), random(-0.5999f, 0.3999f)};
         },
         {0.4, 1}},
        {"cube", cube(0.6), [](Random& random) { return point(random_point(random, 0.5999f)); }, {0.6, 1.04}},
        {"ring",
         {{ring(), {}}},
         [](Random& random) {
             const double a = random(-4, 4);
             return Point{0.6 * std::cos(a), 0.6 * std::sin(a), random(-0.1f, 0.1f)};
         },
         {0.2, 1.5}},
        {"tiny sphere, far away",
         {{moved(unit_sphere(), {0.5, -0.6, 0.7}, 1e-4), {}}},
         [](Random& random) { return Point{0.5, -0.6, 0.7} + 0.99e-4 * point(random_direction(random)); },
         {1, 1.1}},
    };
    for (const auto& [what, faces, inside, between] : all) {
        const Brep brep(faces);
        Random random(4);
        std::vector<Ray> rays;
        for (int i = 0; i < 13000; ++i) rays.push_back(towards(inside(random), random_direction(random), 3));
        // Through edges of pieces and patches, corners and poles, on their way inside.
        for (int i = 0; i < 4000; ++i) {
            const Face& face = faces[static_cast<std::size_t>(i) % faces.size()];
            if (!face.loops.empty()) continue;
            const auto [low_u, high_u, low_v, high_v] = domain(face.surface);
            const float u = std::floor(i % 10 ? random(1, 8) : random(0, 9)) / 8;
            const float v = i % 2 ? random() : std::floor(random(0, 17)) / 16;
            const Point to = at(face.surface, low_u + (high_u - low_u) * u, low_v + (high_v - low_v) * v);
            rays.push_back(towards(to, bob::normalized(rounded(inside(random) - to)), 2.5));
        }
        test::for_each_isa([&] {
            const auto hits = trace(brep, rays);
            int leaks = 0;
            double worst = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (!found(hits[i])) {
                    ++leaks;
                    continue;
                }
                const double from_origin = length(along(rays[i], hits[i].t));
                worst = std::max({worst, between[0] - from_origin, from_origin - between[1]});
            }
            expect(leaks == 0, what, ": leaks ", leaks, " of ", rays.size());
            expect(worst < near_surface, what, ": off by ", worst);
        });
    }
}

TEST(brep_leaks_no_rays_near_poles) {
    const Brep ball = brep_of(unit_sphere());
    Random random(11);
    std::vector<Ray> rays;
    while (rays.size() < 3000) {
        const double near = rays.size() % 40 ? std::pow(10, random(-8, 0)) : 0, angle = random(-4, 4);
        const double z = rays.size() % 2 ? 1 : -1;
        const Point target{near * std::cos(angle), near * std::sin(angle), z * std::sqrt(1 - near * near)};
        const Vec3 direction = random_direction(random);
        if (dot(target, point(direction)) < -0.1) rays.push_back(towards(target, direction, 2));
    }
    test::for_each_isa([&] {
        int leaks = 0;
        for (const Hit& hit : trace(ball, rays)) leaks += !(hit.t < 2.00001f);
        expect(leaks == 0, "leaks ", leaks, " of ", rays.size());
    });
}

TEST(brep_rays_begin_anywhere_and_have_any_length) {
    const Brep ball = brep_of(unit_sphere());
    Random random(5);
    test::for_each_isa([&] {
        for (int i = 0; i < 2000; ++i) {
            const Vec3 direction = random_direction(random), origin = random_point(random, 0.57f);
            const Hit hit = trace(ball, {origin, direction});
            const double b = dot(point(origin), point(direction)), c = dot(point(origin), point(origin)) - 1;
            CHECK_NEAR(hit.t, -b + std::sqrt(b * b - c), 1e-5);
            // A ray sees nothing behind it and nothing at its origin, up to rounding.
            const Ray from_it{rounded(along({origin, direction}, hit.t + 1e-6)), direction};
            CHECK(!found(trace(ball, from_it)));
            const Ray back{rounded(along({origin, direction}, hit.t - 1e-5)), direction};
            if (hit.t > 1e-4f) CHECK_NEAR(trace(ball, back).t, 1e-5, 2e-6);
            for (const float scale : {1e-3f, 0.37f, 256.f, 1e5f}) {
                CHECK_NEAR(trace(ball, {origin, scale * direction}).t * scale, hit.t, 2e-6);
            }
        }
    });
}

TEST(brep_trims_leave_what_they_enclose) {
    struct Trimmed {
        const char* what;
        NurbsSurface surface;
        std::vector<bob::TrimLoop> loops;
        double u, v, radius;  // of the circle that rays are aimed at
        double (*inside)(double, double);  // positive inside, in parameters
    };
    const auto border = [](const NurbsSurface& s) {
        const auto [low_u, high_u, low_v, high_v] = domain(s);
        return bob::TrimLoop{{1,
                              {0, 0, 1, 2, 3, 4, 4},
                              {{low_u, low_v, 1}, {high_u, low_v, 1}, {high_u, high_v, 1}, {low_u, high_v, 1},
                               {low_u, low_v, 1}}}};
    };
    constexpr auto disc = [](double u, double v) { return 0.8 - std::hypot(u, v); };
    constexpr auto washer = [](double u, double v) {
        return std::min(0.8 - std::hypot(u, v), std::hypot(u - 0.1, v + 0.2) - 0.25);
    };
    constexpr auto window = [](double u, double v) { return std::hypot(u - 0.5, v - 1.3) - 0.25; };
    const NurbsSurface pipe = revolved(1, {0, 0, 1, 1}, {{0.6, -0.7, 1}, {0.8, 0.7, 1}});
    const NurbsSurface wave = sheet(3, 3, {-1, -1, -1, -1, 0, 0.7, 2, 2, 2, 2}, {0, 0, 0, 0, 0.6, 2, 2, 2, 2}, 9);
    const Trimmed all[] = {
        {"disc", square(0.1), {circle(0, 0, 0.8)}, 0, 0, 0.8, disc},
        {"washer", square(0.1), {circle(0, 0, 0.8), circle(0.1, -0.2, 0.25)}, 0.1, -0.2, 0.25, washer},
        {"hole in a pipe", pipe, {border(pipe), circle(0.5, 1.3, 0.25)}, 0.5, 1.3, 0.25, window},
        {"hole in a wave", wave, {border(wave), circle(0.5, 1.3, 0.25)}, 0.5, 1.3, 0.25, window},
    };
    for (const auto& [what, surface, loops, u, v, radius, inside] : all) {
        const Brep trimmed(std::vector<Face>{{surface, loops}});
        const Dense dense(surface);
        Random random(6);
        std::vector<Ray> rays;
        while (rays.size() < 1000) {
            // Close to the curve, on either side of it.
            const double angle = random(-4, 4), side = random() < 0.5f ? -1 : 1;
            const double r = radius + side * std::pow(10, random(-5, -1));
            const Point target = at(surface, u + r * std::cos(angle), v + r * std::sin(angle));
            rays.push_back(towards(target, random_direction(random), 2));
        }
        for (const Ray& ray : random_rays(7, 300)) rays.push_back(ray);
        const auto keeps = [within = inside](double u, double v) { return within(u, v) > 3e-6; };
        std::vector<double> nearest;
        for (const Ray& ray : rays) nearest.push_back(dense.nearest(ray, keeps));
        test::for_each_isa([&] {
            const auto hits = trace(trimmed, rays);
            int passed = 0, met = 0;
            double outside = 0, above = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                passed += nearest[i] + 1e-5 < hits[i].t;
                if (!found(hits[i])) continue;
                ++met;
                const bob::Place place = trimmed.place(hits[i]);
                outside = std::max(outside, -inside(place.u, place.v));
                above = std::max(above, missed_by(trimmed, surface, rays[i], hits[i]).above);
            }
            expect(passed == 0, what, ": passed ", passed);
            expect(outside < 3e-6, what, ": outside by ", outside);
            expect(above < near_surface, what, ": above by ", above);
            expect(met > 300, what, ": met ", met);
        });
    }
}

TEST(brep_pictures_of_trims_are_what_their_regions_say) {
    const NurbsSurface plane = square(0.1);
    std::vector<bob::TrimLoop> holes{circle(0, 0, 0.95)};
    Random random(12);
    for (int i = 0; i < 12; ++i) holes.push_back(circle(random(-0.6f, 0.6f), random(-0.6f, 0.6f), random(0.01f, 0.2f)));
    const std::vector<bob::TrimLoop> corner{circle(1.1, 1.2, 0.6)};  // a small part of the plane
    for (const auto& loops : {holes, corner}) {
        const bob::TrimRegion region(loops, domain(plane));
        const Brep brep(std::vector<Face>{{plane, loops}});
        std::vector<Ray> rays;
        for (const Ray& ray : picture_rays({0.01f, 0, -1}, 250)) rays.push_back(ray);
        test::for_each_isa([&] {
            const auto hits = trace(brep, rays);
            int wrong = 0, met = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const auto x = along(rays[i], (0.1 - rays[i].origin.z) / rays[i].direction.z);
                const bool inside = std::fabs(x[0]) < 1 && std::fabs(x[1]) < 1 && region.contains(x[0], x[1]);
                met += inside;
                const bob::Domain near{x[0] - 1e-6, x[0] + 1e-6, x[1] - 1e-6, x[1] + 1e-6};
                wrong += inside != found(hits[i]) && region.coverage(near) != bob::TrimRegion::Coverage::some;
            }
            expect(wrong == 0, "wrong ", wrong, " of ", met);
            expect(met > 1000, "met ", met);
        });
    }
}

TEST(brep_normals_are_those_of_the_formulas) {
    const Brep ball = brep_of(unit_sphere()), ring_of_circles = brep_of(torus()), tin(can());
    Random random(8);
    test::for_each_isa([&] {
        const auto check = [&](const char* what, const Brep& brep, const Ray& ray, auto formula,
                               double tolerance = 1e-4) {
            const Hit hit = trace(brep, ray);
            if (!found(hit)) return expect(false, what, ": missed");
            const Point n = point(normal(brep, ray, hit));
            expect(std::fabs(length(n) - 1) < 1e-6, what, ": length ", length(n));
            expect(dot(n, point(ray.direction)) <= 0, what, ": turned away");
            const Point expected = formula(along(ray, hit.t));
            const double off = std::min(length(n - expected), length(n + expected));
            expect(off < tolerance, what, ": off by ", off, " at ", hit.u, " ", hit.v);
        };
        const auto of_sphere = [](const Point& p) { return 1 / length(p) * p; };
        const auto of_torus = [](const Point& p) {
            const double r = std::hypot(p[0], p[1]);
            const Point n{p[0] - spine * p[0] / r, p[1] - spine * p[1] / r, p[2]};
            return 1 / length(n) * n;
        };
        for (int i = 0; i < 1000; ++i) {
            const Vec3 direction = random_direction(random);
            check("sphere", ball, towards(point(random_point(random, 0.5f)), direction, i % 2 ? 3 : 0), of_sphere);
            const double angle = random(-4, 4);
            const Point in_torus{spine * std::cos(angle), spine * std::sin(angle), 0.1};
            check("torus", ring_of_circles, towards(in_torus, direction, 2), of_torus);
            if (i % 4) continue;
            // At the poles, and ever closer to them, where rounding takes its share.
            const double near = i % 40 ? std::pow(10, random(-8, 0)) : 0;
            const double z = i % 8 ? 1 : -1;
            const Point pole{near * std::cos(angle), near * std::sin(angle), z * std::sqrt(1 - near * near)};
            Vec3 down = random_direction(random);
            if ((down.z > 0) == (z > 0)) down = -down;
            const double tolerance = 1e-4 + (near > 0 ? 1e-7 / near : 0);
            if (std::fabs(down.z) > 0.1f) check("pole", ball, towards(pole, down, 2), of_sphere, tolerance);
        }
        for (const float z : {-3.f, 3.f}) {
            const Ray down{{0.1f, 0.2f, z}, {0.01f, 0.02f, -z}};
            const Vec3 n = normal(tin, down, trace(tin, down));
            CHECK_NEAR(n.z, z / 3, 1e-6f);
        }
    });
}

TEST(brep_without_area_is_harmless) {
    const Point a{-0.5, 0.1, 0.2}, b{0.7, 0.4, -0.3};
    const std::vector<double> knots_u = clamped(3, 6), knots_v = clamped(2, 4);
    const auto on_line = [&](int i) { return a + i / 5.0 * (b - a); };
    const Named none[] = {
        {"line", surface(3, 2, knots_u, knots_v, [&](int i, int) { return on_line(i); }, not_rational)},
        {"point", surface(3, 2, knots_u, knots_v, [&](int, int) { return a; }, not_rational)},
        {"sliver", surface(
                       3, 2, knots_u, knots_v,
                       [&](int i, int j) { return on_line(i) + Point{0, 0, 1e-7 * j}; }, not_rational)},
    };
    for (const auto& [what, surface] : none) {
        // A wall behind is seen as if there were nothing else.
        const Brep wall = brep_of(square(-0.9)), both(std::vector<Face>{{surface, {}}, {square(-0.9), {}}});
        Random random(9);
        std::vector<Ray> rays;
        for (int i = 0; i < 500; ++i) {
            const Point target = i % 2 ? a + double{random()} * (b - a) : point(random_point(random, 0.8f));
            Vec3 direction = random_direction(random);
            direction.z = -std::fabs(direction.z) - 0.1f;
            rays.push_back(towards(target, direction, 2));
        }
        test::for_each_isa([&] {
            const auto expected = trace(wall, rays), hits = trace(both, rays);
            int differ = 0, off = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (found(hits[i]) && both.place(hits[i]).part == 0) {
                    const bob::Place place = both.place(hits[i]);
                    off += length(at(surface, place.u, place.v) - along(rays[i], hits[i].t)) > 2e-6;
                } else {
                    differ += hits[i].t != expected[i].t;
                }
            }
            expect(differ == 0, what, ": differ ", differ);
            expect(off == 0, what, ": off ", off);
        });
        CHECK_NEAR(both.maximum([](Vec3 p) { return double{p.y}; }, 1e-3), 1, 2e-3);
    }
}

TEST(brep_of_coinciding_faces_is_met_like_one) {
    const NurbsSurface wave = sheet(3, 3, clamped(3, 9), clamped(3, 8), 1);
    const Brep one = brep_of(wave), three(std::vector<Face>{{wave, {}}, {wave, {}}, {wave, {}}});
    const auto rays = random_rays(10, 1000);
    test::for_each_isa([&] {
        const auto once = trace(one, rays), thrice = trace(three, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            CHECK_EQ(found(once[i]), found(thrice[i]));
            if (found(once[i])) CHECK_NEAR(once[i].t, thrice[i].t, 1e-6f);
        }
    });
}

TEST(brep_maxima_are_close_from_above) {
    const auto height = [](Vec3 p) { return double{p.z}; };
    const auto from = [](Vec3 c) { return [c](Vec3 p) { return double{length(p - c)}; }; };
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const auto check = [&](const char* what, const Brep& brep, const std::function<double(Vec3)>& f, double most) {
            const double found = brep.maximum(f, tolerance);
            const bool close = found > most - 1e-6 && found < most + tolerance + 1e-6;
            expect(close, what, ": ", found, " of ", most, " at ", tolerance);
        };
        check("sphere", brep_of(unit_sphere()), height, 1);
        check("sphere from aside", brep_of(unit_sphere()), from({3, 0, 4}), 6);
        check("torus", brep_of(torus()), height, thickness);
        check("torus from below", brep_of(torus()), from({0, 0, -2}), std::hypot(spine, 2) + thickness);
        check("can", Brep(can()), height, can_high);
        check("can from its axis", Brep(can()), from({0, 0, -1}), std::hypot(can_radius, 1.4));
        const Brep disc(std::vector<Face>{{square(0.1), {circle(0.1, 0, 0.6)}}});
        check("disc", disc, [](Vec3 p) { return double{p.x}; }, 0.7);
        check("disc from its middle", disc, from({0.1f, 0, 0.1f}), 0.6);
        const Brep nothing(std::vector<Face>{{square(0.1), {circle(5, 0, 0.6)}}});
        CHECK_EQ(nothing.maximum(height, tolerance), -HUGE_VAL);
        CHECK(!found(trace(nothing, {{0, 0, 3}, {0, 0, -1}})));
    }
    for (const auto& [what, surface] : zoo()) {
        const auto [low_u, high_u, low_v, high_v] = domain(surface);
        const Brep brep = brep_of(surface);
        std::vector<Vec3> samples;
        constexpr int steps = 150;
        for (int i = 0; i <= steps; ++i) {
            for (int j = 0; j <= steps; ++j) {
                const double u = low_u + (high_u - low_u) * i / steps, v = low_v + (high_v - low_v) * j / steps;
                samples.push_back(rounded(at(surface, u, v)));
            }
        }
        const std::function<double(Vec3)> functions[] = {height, from({0.2f, -0.1f, 0.3f}),
                                                         [](Vec3 p) { return double{p.x - p.y}; }};
        for (const auto& f : functions) {
            double most = -HUGE_VAL;
            for (const Vec3 sample : samples) most = std::max(most, f(sample));
            const double found = brep.maximum(f, 1e-3);
            expect(found > most - 1e-6 && found < most + 4e-3, what, ": ", found, " of ", most);
        }
    }
}
