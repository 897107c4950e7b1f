/// How far shapes of each kind reach in their places, against looking everywhere, and the scene that is made of these.
#include "tracing/arrangement.h"

#include <stdexcept>

#include "base/counts.h"
#include "check.h"
#include "interrupted.h"
#include "meshes.h"
#include "shapes/brep/brep.h"
#include "shapes/implicit/implicit.h"
#include "shapes/tube/tube.h"

namespace {

using Point = bob::Mesh::Point;

const bob::AffineMap place{{{0.9, 0.2, 0, 3}, {-0.1, 1.1, 0.3, -2}, {0, 0.1, 0.7, 0.5}}};

Point moved(const bob::AffineMap& map, const Point& p) {
    Point result;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& row = map.row[i];
        result[i] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
    }
    return result;
}

double distance(const Point& p, const double* center) { return std::hypot(p[0] - center[0], p[1] - center[1], p[2] - center[2]); }

/// A shape reaches exactly to the points that lie on it, or up to `slack` farther.
void check_extents(const bob::Shape& shape, const std::vector<Point>& points, double slack) {
    const double center[3] = {2, -2, 0.4};
    const bob::Bounds found = shape.bounds(place);
    double farthest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (const Point& p : points) {
            const double x = moved(place, p)[axis];
            low = std::min(low, x), high = std::max(high, x);
        }
        CHECK_LT(found.low[axis], low + 3e-6);
        CHECK_LT(high - 3e-6, found.high[axis]);
        CHECK_NEAR(found.low[axis], low, slack);
        CHECK_NEAR(found.high[axis], high, slack);
    }
    for (const Point& p : points) farthest = std::max(farthest, distance(moved(place, p), center));
    CHECK_LT(farthest - 3e-6, shape.radius(place, center));
    CHECK_NEAR(shape.radius(place, center), farthest, slack);
}

struct Arrays {
    std::vector<Point> vertices;
    std::vector<bob::Triangle> triangles;
};

Arrays soup(int count, double size, double shift) {
    const auto mesh = test::soup(count, 0.3f, 4);
    Arrays arrays{{}, mesh.triangles};
    for (const bob::Vec3 v : mesh.vertices) arrays.vertices.push_back({size * v.x + shift, size * v.y - shift, size * v.z});
    return arrays;
}

std::shared_ptr<bob::Mesh> mesh_of(const Arrays& arrays) {
    return std::make_shared<bob::Mesh>(bob::Mesh::Arrays{arrays.vertices, arrays.triangles, {}, nullptr});
}

/// A quarter of a cylinder of radius 2 about the z axis, from z = -1 to 3, with weights.
bob::Brep quarter() {
    const double w = 5 * std::sqrt(0.5);
    bob::NurbsSurface surface{2, 1, {0, 0, 0, 1, 1, 1}, {0, 0, 1, 1}, {}};
    for (const auto& [x, y, weight] : {std::array{2., 0., 5.}, {2., 2., w}, {0., 2., 5.}}) {
        for (const double z : {-1., 3.}) surface.control_points.push_back({x, y, z, weight});
    }
    return bob::Brep::of_weighted_points({{surface, {}}}, 0);
}

template <class F>
std::string message_of(F f) {
    try {
        f();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

bob::Arrangement alone(std::shared_ptr<const bob::Shape> shape, const bob::AffineMap& transform = {}) {
    return bob::Arrangement({{std::move(shape), transform, {}}});
}

}  // namespace

TEST(meshes_reach_as_far_as_the_vertices_that_triangles_have) {
    for (const double size : {1e-150, 1., 1e150}) {
        Arrays arrays = soup(20, size, 7 * size);
        std::vector<Point> used = arrays.vertices;
        arrays.vertices.push_back({1e300, 0, 0});
        const auto mesh = mesh_of(arrays);
        const bob::AffineMap to_one{{{1 / size, 0, 0, 0}, {0, 1 / size, 0, 0}, {0, 0, 1 / size, 0}}};
        for (Point& p : used) p = moved(to_one, p);
        const Arrays scaled{used, arrays.triangles};
        const auto again = mesh_of(scaled);
        check_extents(*again, used, 1e-12);
        const double center[3] = {size, 2 * size, 3 * size};
        double farthest = 0;
        for (const Point& p : used) farthest = std::max(farthest, distance(p, std::array{1., 2., 3.}.data()));
        CHECK_NEAR(mesh->radius({}, center) / size, farthest, 1e-12);
        CHECK_NEAR(mesh->sphere().radius / size, again->sphere().radius, 1e-12);
    }
}

TEST(breps_reach_as_far_as_their_faces) {
    std::vector<Point> points;
    for (int i = 0; i <= 2000; ++i) {
        const double angle = i * std::acos(0.) / 2000;
        for (const double z : {-1., 3.}) points.push_back({2 * std::cos(angle), 2 * std::sin(angle), z});
    }
    check_extents(quarter(), points, 1e-2);
}

TEST(tubes_reach_as_far_as_their_balls) {
    const bob::NurbsCurve<4> curve{1, {0, 0, 1, 2, 2}, {{0, 0, 0, 0.5, 3}, {10, 1, 0, 1, 3}, {10, 8, 2, 0.1, 3}}};
    const bob::Tube tube = bob::Tube::of_weighted_points(curve);
    const bob::Bounds found = tube.bounds({});
    const double low[3] = {-0.5, -0.5, -1}, high[3] = {11, 8.1, 2.1};
    for (int axis = 0; axis < 3; ++axis) {
        CHECK_NEAR(found.low[axis], low[axis], 0.02);
        CHECK_NEAR(found.high[axis], high[axis], 0.02);
    }
    const double origin[3] = {};
    CHECK_NEAR(tube.radius({}, origin), std::sqrt(168.) + 0.1, 0.02);
}

TEST(implicit_surfaces_reach_as_far_as_they_are) {
    bob::Graph g;
    const auto f = g.expression(hypot(hypot(g.x() - 40, g.y()), g.z()) - 3);
    const bob::Implicit ball(f, *bob::find_bounds(f));
    const bob::Bounds found = ball.bounds({{{2, 0, 0, 0}, {0, 1, 0, 5}, {0, 0, 1, 0}}});
    CHECK_NEAR(found.low[0], 74., 0.02);
    CHECK_NEAR(found.high[0], 86., 0.02);
    CHECK_NEAR(found.high[1], 8., 0.02);
    const double center[3] = {40, 0, 4};
    CHECK_NEAR(ball.radius({}, center), 7., 0.02);
}

TEST(the_sphere_is_about_the_centre_of_the_box_and_reaches_to_the_farthest_point) {
    const Arrays arrays = soup(20, 1, 0);
    const auto mesh = mesh_of(arrays);
    bob::AffineMap far;
    far.row[0][3] = 100;
    const bob::Arrangement two({{mesh, {}, {}}, {mesh, far, {}}});
    const bob::Bounds &a = two.bounds(0), &b = two.bounds(1);
    double farthest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        CHECK_EQ(two.sphere().center[axis], std::min(a.low[axis], b.low[axis]) / 2 + std::max(a.high[axis], b.high[axis]) / 2);
    }
    for (const bob::AffineMap& map : {bob::AffineMap{}, far}) {
        for (const Point& p : arrays.vertices) farthest = std::max(farthest, distance(moved(map, p), two.sphere().center));
    }
    CHECK_NEAR(two.sphere().radius, farthest, 1e-12);
}

TEST(a_shape_alone_meets_rays_in_its_own_coordinates) {
    for (const double size : {1e-9, 1., 1e9}) {
        const Arrays arrays = soup(20, size, 1e6 * size);
        CHECK(alone(mesh_of(arrays)).scene()[0].to_shape == bob::AffineMap{});
    }
    const auto brep = std::make_shared<const bob::Brep>(quarter());
    CHECK(!(alone(brep).scene()[0].to_shape == bob::AffineMap{}));  // its control points reach farther than it
}

TEST(scenes_are_in_the_order_of_digests_and_know_the_numbers) {
    const Arrays arrays = soup(20, 1, 0);
    const auto mesh = mesh_of(arrays);
    const bob::Arrangement three({{mesh, {}, {}}, {mesh, place, {}}, {mesh, {}, {}}});
    bob::Digest digests[3] = {};
    digests[0][0] = 3, digests[1][0] = 1, digests[2][0] = 2;
    const bob::Scene ordered = three.scene(digests), plain = three.scene();
    for (std::uint32_t i = 0; i < 3; ++i) {
        CHECK_EQ(plain[i].number, i);
        CHECK_EQ(ordered[i].number, (std::array{1u, 2u, 0u}[i]));
        for (int axis = 0; axis < 3; ++axis) {
            const auto& [center, radius] = three.sphere();
            const double low = (three.bounds(ordered[i].number).low[axis] - center[axis]) / radius;
            CHECK_NEAR(static_cast<double>(ordered[i].low[axis]), low, 2e-5);
        }
    }
}

TEST(what_can_t_be_placed_is_refused) {
    const Arrays point{{{1, 2, 3}}, {{0, 0, 0}}}, huge = soup(3, 1e308, 0), tiny = soup(3, 1e-310, 0);
    CHECK(message_of([] { bob::Arrangement none({}); }) == "shapes: expected at least one shape, got none");
    CHECK(message_of([] { bob::Arrangement many(std::vector<bob::Placed>(bob::max_instances + 1)); }) == "shapes: expected at most 100,000, got 100,001");
    CHECK(message_of([&] { alone(mesh_of(point)); }) ==
          "shapes: expected an extent above zero, got all vertices in one point");
    bob::AffineMap larger;
    for (int i = 0; i < 3; ++i) larger.row[i][i] = 1e10;
    CHECK(message_of([&] { alone(mesh_of(huge), larger); }).starts_with("shapes: expected a radius that float64 holds"));
    CHECK(message_of([&] { alone(mesh_of(tiny)); }).starts_with("shapes: expected a radius that float64 holds"));
}

TEST(shapes_are_measured_once_in_a_place) {
    class Counted : public bob::Shape {
    public:
        [[nodiscard]] bob::Bounds bounds(const bob::AffineMap&) const override { return ++boxes, bob::Bounds{{}, {1, 1, 1}}; }
        [[nodiscard]] double radius(const bob::AffineMap&, const double*) const override { return ++radii, 1; }
        void closest_hits(std::span<const bob::Ray>, std::span<bob::Hit>) const override {}
        void normals(std::span<const bob::Ray>, std::span<const bob::Hit>, std::span<bob::Vec3>) const override {}
        [[nodiscard]] std::size_t bytes() const override { return 0; }

        mutable int boxes = 0, radii = 0;
    };
    const auto shape = std::make_shared<const Counted>();
    const bob::Arrangement many({{shape, {}, {}}, {shape, place, {}}, {shape, {}, {}}, {shape, place, {}}});
    CHECK_EQ(many.scene().size(), 4u);
    CHECK_EQ(shape->boxes, 2);
    CHECK_EQ(shape->radii, 2);
}

TEST(shapes_reach_as_far_as_before_once_they_are_prepared_for_many_places) {
    const Arrays arrays = soup(200, 1, 0);
    bob::Graph g;
    const auto f = g.expression(max(hypot(hypot(g.x() - 4, g.y()), g.z()) - 3, abs(g.z()) - 1));
    const auto bounds = *bob::find_bounds(f);
    const bob::Implicit surface(f, bounds), prepared_surface(f, bounds);
    const auto mesh = mesh_of(arrays), prepared_mesh = mesh_of(arrays);
    prepared_surface.prepare_places();
    prepared_mesh->prepare_places();
    for (int i = 0; i < 100; ++i) {
        bob::AffineMap map = place;
        map.row[0][0] = 0.1 * i - 3, map.row[1][0] = 0.07 * i, map.row[2][1] = i % 5, map.row[2][3] = 1e3 * (i % 3);
        const double center[3] = {0.3 * i, 2, 100. * (i % 7)};
        const auto same = [&](const bob::Shape& a, const bob::Shape& b) {
            const bob::Bounds in = a.bounds(map), again = b.bounds(map);
            for (int axis = 0; axis < 3; ++axis) {
                CHECK_EQ(in.low[axis], again.low[axis]);
                CHECK_EQ(in.high[axis], again.high[axis]);
            }
            CHECK_EQ(a.radius(map, center), b.radius(map, center));
        };
        same(*mesh, *prepared_mesh);
        same(surface, prepared_surface);
    }
}

TEST(the_first_of_a_shape_in_one_place_is_seen) {
    const Arrays arrays = soup(20, 1, 0);
    const auto mesh = mesh_of(arrays);
    std::vector<bob::Placed> placed(1000, {mesh, {}, {}});
    placed.push_back({mesh, place, {}});
    const bob::Scene scene = bob::Arrangement(std::move(placed)).scene();
    std::vector<bob::Ray> rays;
    for (int i = 0; i < 100; ++i) rays.push_back({{-2, 0.01f * static_cast<float>(i) - 0.5f, 0}, {1, 0, 0.1f}});
    std::vector<bob::SceneHit> hits(rays.size());
    scene.closest_hits(rays, hits);
    int seen = 0;
    for (const bob::SceneHit& hit : hits) {
        seen += hit.instance == 0;
        CHECK(hit.instance == 0 || hit.instance == 1000 || hit.instance == bob::no_instance);
    }
    CHECK(seen > 0);
}

TEST(measuring_and_preparing_can_be_stopped) {
    const Arrays arrays = soup(20, 1, 0);
    const auto mesh = mesh_of(arrays);
    const bob::Arrangement one = alone(mesh);
    CHECK(stops_after(0, [&] { bob::Arrangement({{mesh, {}, {}}, {mesh, place, {}}}); }));
    CHECK(stops_after(0, [&] { (void)one.scene(); }));
    CHECK_EQ(mesh->bytes(), 0u);
}
