#include "tracing/scene.h"

#include <cstring>
#include <numeric>

#include "base/parallel.h"
#include "check.h"
#include "meshes.h"
#include "shapes/mesh/mesh.h"

using bob::Vec3;

namespace {

std::vector<bob::Ray> random_rays(int count, std::uint64_t seed) {
    test::Random random(seed);
    std::vector<bob::Ray> rays;
    for (int i = 0; i < count; ++i) {
        const Vec3 direction = random(0.3f, 3) * test::random_direction(random);
        const Vec3 target{random(-0.6f, 0.6f), random(-0.6f, 0.6f), random(-0.6f, 0.6f)};
        rays.push_back({target - 1.2f * bob::normalized(direction), direction});
    }
    return rays;
}

struct Found {
    std::vector<bob::SceneHit> hits;
    std::vector<Vec3> normals;
};

Found cast(const bob::Scene& scene, const std::vector<bob::Ray>& rays) {
    Found found{std::vector<bob::SceneHit>(rays.size()), std::vector<Vec3>(rays.size())};
    scene.closest_hits(rays, found.hits);
    scene.normals(rays, found.hits, found.normals);
    return found;
}

std::shared_ptr<bob::Mesh> mesh_of(const test::TriangleMesh& mesh) {
    return test::prepared(mesh.vertices, mesh.triangles);
}

/// x -> scale * turned(x) + shift, where the turn sends (x, y, z) to (-y, x, z); and the map back.
struct Placement {
    Vec3 scale, shift;

    [[nodiscard]] Vec3 operator()(Vec3 p) const {
        return {-scale.x * p.y + shift.x, scale.y * p.x + shift.y, scale.z * p.z + shift.z};
    }
    [[nodiscard]] bob::AffineMap inverse() const {
        const double a = 1.0 / scale.x, b = 1.0 / scale.y, c = 1.0 / scale.z;
        return {{{0, b, 0, -b * shift.y}, {-a, 0, 0, a * shift.x}, {0, 0, c, -c * shift.z}}};
    }
};

bob::Instance placed(std::shared_ptr<const bob::Shape> shape, const test::TriangleMesh& moved,
                     const Placement& placement) {
    Vec3 low = moved.vertices[0], high = low;
    for (const Vec3 v : moved.vertices) low = min(low, v), high = max(high, v);
    return {std::move(shape), placement.inverse(), low, high, {}};
}

test::TriangleMesh moved(test::TriangleMesh mesh, const Placement& placement) {
    for (Vec3& v : mesh.vertices) v = placement(v);
    return mesh;
}

/// A cube of side 2 whose near face is met, and how often it was asked.
class Cube : public bob::Shape {
public:
    [[nodiscard]] bob::Bounds bounds(const bob::AffineMap&) const override { return {}; }
    [[nodiscard]] double radius(const bob::AffineMap&, const double*) const override { return 0; }
    void closest_hits(std::span<const bob::Ray> rays, std::span<bob::Hit> hits) const override {
        ++calls;
        asked += rays.size();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            float enter = 0, leave = HUGE_VALF;
            for (int axis = 0; axis < 3; ++axis) {
                const float a = (-1 - rays[i].origin[axis]) / rays[i].direction[axis];
                const float b = (1 - rays[i].origin[axis]) / rays[i].direction[axis];
                enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
            }
            hits[i] = enter < leave && enter > 0 ? bob::Hit{enter, 0, 0, 0} : bob::Hit{};
        }
    }
    void normals(std::span<const bob::Ray> rays, std::span<const bob::Hit>, std::span<Vec3> normals) const override {
        ++calls;
        asked += rays.size();
        for (std::size_t i = 0; i < rays.size(); ++i) normals[i] = -bob::normalized(rays[i].direction);
    }
    [[nodiscard]] std::size_t bytes() const override { return 0; }

    mutable std::size_t calls = 0, asked = 0;
};

bob::Instance placed(std::shared_ptr<const Cube> cube, Vec3 center, float half_side) {
    bob::AffineMap to_cube;
    for (int axis = 0; axis < 3; ++axis) {
        to_cube.row[axis][axis] = 1.0 / half_side;
        to_cube.row[axis][3] = -center[axis] / static_cast<double>(half_side);
    }
    const Vec3 reach{half_side, half_side, half_side};
    return {std::move(cube), to_cube, center - reach, center + reach, {}};
}

bool same_bits(const bob::SceneHit& a, const bob::SceneHit& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Instances about `size` large, moved and not, some of them twice, and some too small to be seen.
std::vector<bob::Instance> assembly(int count, float size, std::uint64_t seed) {
    const test::TriangleMesh meshes[] = {test::sphere(1, 1), test::soup(30, 0.5f, 3)};
    const std::shared_ptr<const bob::Shape> shapes[] = {mesh_of(meshes[0]), mesh_of(meshes[1])};
    test::Random random(seed);
    std::vector<bob::Instance> instances;
    for (int i = 0; i < count; ++i) {
        const int kind = i % 2;
        const Placement placement{{random(0.3f, 1) * size, random(-1, -0.3f) * size, random(0.3f, 1) * size},
                                  {random(-0.5f, 0.5f), random(-0.5f, 0.5f), random(-0.5f, 0.5f)}};
        instances.push_back(placed(shapes[kind], moved(meshes[kind], placement), placement));
        if (i % 7 == 3) instances.back() = instances[static_cast<std::size_t>(i / 2)];
        if (i % 11 == 4) instances.back().to_shape.row[0][0] = HUGE_VAL;
        if (i % 50 == 6) instances.back() = {shapes[1], {}, {-1, -1, -1}, {1, 1, 1}, {}};
    }
    return instances;
}

/// Each instance alone: the least t, and of those the first instance.
std::vector<bob::SceneHit> brute_force(const std::vector<bob::Instance>& instances, const std::vector<bob::Ray>& rays) {
    std::vector<bob::SceneHit> nearest(rays.size());
    for (std::uint32_t k = 0; k < instances.size(); ++k) {
        const auto alone = cast(bob::Scene({instances[k]}), rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!(alone.hits[i].t < nearest[i].t)) continue;
            nearest[i] = alone.hits[i];
            nearest[i].instance = k;
        }
    }
    return nearest;
}

}  // namespace

TEST(one_shape_in_its_own_coordinates_is_traced_as_the_shape_itself) {
    const auto soup = test::soup(2000, 0.1f, 5);
    const auto mesh = mesh_of(soup);
    const bob::Scene scene({{mesh, {}, {-1, -1, -1}, {1, 1, 1}, {}}});
    const auto rays = random_rays(5000, 1);
    const auto found = cast(scene, rays);
    std::vector<bob::Hit> hits(rays.size());
    std::vector<Vec3> normals(rays.size());
    mesh->closest_hits(rays, hits);
    int hit = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        CHECK_EQ(found.hits[i].t, hits[i].t);
        CHECK_EQ(found.hits[i].in_shape.primitive, hits[i].primitive);
        CHECK_EQ(found.hits[i].instance, hits[i].primitive == bob::no_primitive ? bob::no_instance : 0);
        if (hits[i].primitive == bob::no_primitive) continue;
        ++hit;
        mesh->normals({&rays[i], 1}, {&hits[i], 1}, {&normals[i], 1});
        CHECK(found.normals[i].x == normals[i].x && found.normals[i].y == normals[i].y);
    }
    CHECK_LT(1000, hit);
}

TEST(placed_shapes_are_seen_where_moved_vertices_are) {
    const auto ball = test::sphere(4, 1);
    const auto shape = mesh_of(ball);
    // Stretched, mirrored, and a thousandth of the scene.
    for (const Placement placement : {Placement{{0.5f, 0.2f, 0.3f}, {0.1f, -0.2f, 0.3f}},
                                      Placement{{-0.4f, 0.4f, 0.4f}, {0, 0.3f, 0}},
                                      Placement{{0.7f, 0.7f, 0.7f}, {}}, Placement{{1e-3f, 1e-3f, 2e-3f}, {0.5f, 0, 0}}}) {
        const auto there = moved(ball, placement);
        const bob::Scene by_map({placed(shape, there, placement)});
        const auto mesh = mesh_of(there);
        auto rays = random_rays(4000, 2);
        for (auto& ray : rays) {  // at the shape, however small
            const Vec3 target = placement(0.6f * (ray.origin + 1.2f * bob::normalized(ray.direction)));
            ray.origin = target - 1.5f * bob::normalized(ray.direction);
        }
        const auto found = cast(by_map, rays);
        const float size = std::fabs(placement.scale.z);
        int hit = 0, differ = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            bob::Hit want;
            mesh->closest_hits({&rays[i], 1}, {&want, 1});
            const bool same = (found.hits[i].instance == 0) == (want.primitive != bob::no_primitive);
            differ += !same;
            if (!same || found.hits[i].instance != 0) continue;
            ++hit;
            const Vec3 direction = rays[i].direction;
            Vec3 normal;
            mesh->normals({&rays[i], 1}, {&want, 1}, {&normal, 1});
            CHECK_LT(dot(found.normals[i], direction), 1e-3f);
            // Nearly edge-on, rounding moves a hit along the surface.
            if (dot(normal, direction) > -0.1f * length(direction)) continue;
            CHECK_NEAR(found.hits[i].t * length(direction), want.t * length(direction), 1e-5f);
            CHECK_NEAR(length(found.normals[i]), 1.f, 1e-6f);
            // Stretching and smoothing don't commute, but the facets are small. The smallest sphere's vertices are also
            // rounded to 6e-8 of the scene.
            CHECK_NEAR(length(found.normals[i] - normal), 0.f, 0.02f + 1e-5f / size);
        }
        CHECK_LT(1500, hit);
        CHECK_LT(differ, 10);
    }
}

TEST(flattened_shapes_are_seen_where_doubles_see_them) {
    // The front and the back of a ball are closer together than floats tell apart in the scene's coordinates.
    const auto ball = test::sphere(3, 1);
    const auto shape = mesh_of(ball);
    for (const double flat : {1e-4, 1e-5, 1e-6, 1e-7}) {
        bob::AffineMap to_shape;  // turned about x, so that its box is not flat
        to_shape.row[1][1] = 0.8, to_shape.row[1][2] = 0.6;
        to_shape.row[2][1] = -0.6 / flat, to_shape.row[2][2] = 0.8 / flat;
        const bob::Scene scene({bob::Instance{shape, to_shape, {-1, -0.8f, -0.6f}, {1, 0.8f, 0.6f}, {}}});
        auto rays = random_rays(4000, 5);
        const auto found = cast(scene, rays);
        int hit = 0, differ = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto& [o, d] = rays[i];
            const Vec3 direction = to_shape.direction(d);
            // The convex ball's own: from two sizes before the point of the ray nearest to its centre on.
            double squared = 0, along = 0;
            for (const auto& r : to_shape.row) {
                const double origin = r[0] * o.x + r[1] * o.y + r[2] * o.z, way = r[0] * d.x + r[1] * d.y + r[2] * d.z;
                squared += way * way, along -= origin * way;
            }
            const double start = std::max(0., along / squared - 2 / std::sqrt(squared));
            const bob::Ray near{to_shape.point(o, start, d), direction};
            bob::Hit want;
            shape->closest_hits({&near, 1}, {&want, 1});
            const bool is_hit = want.primitive != bob::no_primitive;
            hit += is_hit;
            if (found.hits[i].in_shape.primitive != want.primitive) {
                ++differ;
            } else if (is_hit) {
                CHECK_NEAR(found.hits[i].t * length(d), static_cast<float>(start + double{want.t}) * length(d), 1e-6f);
            }
        }
        CHECK_LT(1000, hit);
        CHECK_LT(differ, 5);  // along edges rounding decides
    }
}

TEST(the_nearest_of_many_instances_is_seen) {
    // Balls of all sizes that share one shape, against each ball alone.
    const auto ball = test::sphere(3, 1);
    const auto shape = mesh_of(ball);
    test::Random random(9);
    std::vector<bob::Instance> instances;
    for (int i = 0; i < 40; ++i) {
        const float size = random(0.02f, 0.2f);
        const Placement placement{{size, size, size}, {random(-0.5f, 0.5f), random(-0.5f, 0.5f), random(-0.5f, 0.5f)}};
        instances.push_back(placed(shape, moved(ball, placement), placement));
    }
    const auto rays = random_rays(3000, 4);
    const auto found = cast(bob::Scene(instances), rays);
    std::vector<float> nearest(rays.size(), HUGE_VALF);
    for (std::uint32_t k = 0; k < instances.size(); ++k) {
        const auto alone = cast(bob::Scene({instances[k]}), rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            nearest[i] = std::min(nearest[i], alone.hits[i].t);
            if (found.hits[i].instance == k) CHECK_EQ(found.hits[i].t, alone.hits[i].t);
        }
    }
    for (std::size_t i = 0; i < rays.size(); ++i) CHECK_EQ(found.hits[i].t, nearest[i]);
    CHECK_EQ(bob::Scene(instances).bytes(), shape->bytes());
}

TEST(a_ray_s_hit_depends_on_that_ray_alone) {
    const auto soup = test::soup(500, 0.2f, 6);
    const Placement placement{{0.5f, 0.6f, 0.7f}, {0.1f, 0, 0}};
    const auto there = moved(soup, placement);
    const bob::Scene scene({placed(mesh_of(soup), there, placement), {mesh_of(soup), {}, {-1, -1, -1}, {1, 1, 1}, {}}});
    const auto rays = random_rays(500, 7);
    const auto together = cast(scene, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto alone = cast(scene, {rays[i]});
        CHECK_EQ(alone.hits[0].t, together.hits[i].t);
        CHECK_EQ(alone.hits[0].instance, together.hits[i].instance);
        CHECK(alone.normals[0].x == together.normals[i].x && alone.normals[0].z == together.normals[i].z);
    }
}

TEST(where_instances_coincide_the_first_is_seen) {
    const auto ball = test::sphere(3, 0.8f);
    const auto shape = mesh_of(ball);
    const bob::Instance instance{shape, {}, {-1, -1, -1}, {1, 1, 1}, {}};
    bob::Instance asked_sooner = instance;  // rays enter its box before the other's
    asked_sooner.low = {-1.1f, -1.1f, -1.1f}, asked_sooner.high = {1.1f, 1.1f, 1.1f};
    for (const auto& second : {instance, asked_sooner}) {
        const bob::Scene scene({instance, second});
        for (const auto& ray : random_rays(500, 8)) {
            const auto hit = cast(scene, {ray}).hits[0];
            CHECK(hit.instance == 0 || hit.instance == bob::no_instance);
        }
    }
}

TEST(scenes_of_any_size_equal_brute_force_to_the_bit) {
    for (const int count : {1, 2, 8, 9, 60, 400}) {
        for (const float size : {0.05f, 0.6f}) {  // apart, and through each other: 400 of these take several rounds
            const auto instances = assembly(count, size, static_cast<std::uint64_t>(count));
            const bob::Scene scene(instances);
            const auto rays = random_rays(400, 12);
            test::for_each_isa([&] {
                const auto want = brute_force(instances, rays);
                const auto found = cast(scene, rays);
                int hits = 0, differ = 0;
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    hits += want[i].instance != bob::no_instance;
                    differ += !same_bits(found.hits[i], want[i]);
                }
                CHECK_EQ(differ, 0);
                CHECK_LT(size < 0.1f ? count / 8 : 40, hits);
                // Cut into batches of any size.
                std::vector<bob::SceneHit> in_batches(rays.size());
                std::vector<Vec3> normals(rays.size());
                for (std::size_t begin = 0, step = 1; begin < rays.size(); begin += step, step = step * 2 % 37) {
                    const std::size_t n = std::min(step, rays.size() - begin);
                    scene.closest_hits({&rays[begin], n}, {&in_batches[begin], n});
                    scene.normals({&rays[begin], n}, {&in_batches[begin], n}, {&normals[begin], n});
                }
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    differ += !same_bits(in_batches[i], want[i]) || normals[i].x != found.normals[i].x ||
                              normals[i].y != found.normals[i].y || normals[i].z != found.normals[i].z;
                }
                CHECK_EQ(differ, 0);
            });
        }
    }
}

TEST(only_instances_on_a_ray_s_way_are_asked) {
    // 16 x 16 x 16 cubes with gaps between them; the ray runs along a row of 16 and meets the first of it.
    const auto cube = std::make_shared<const Cube>();
    std::vector<bob::Instance> instances;
    for (int i = 0; i < 16 * 16 * 16; ++i) {
        const auto along = [](int place) { return 0.1f * (static_cast<float>(place) - 7.5f); };
        instances.push_back(placed(cube, {along(i % 16), along(i / 16 % 16), along(i / 256)}, 0.02f));
    }
    const auto found = cast(bob::Scene(instances), {{{-1, 0.051f, 0.049f}, {1, 1e-4f, 1e-4f}}});
    CHECK_EQ(found.hits[0].instance, 8u * 256 + 8 * 16);
    CHECK_EQ(cube->calls, 2u);  // for the hit and its normal, and no instance behind it
    CHECK_EQ(cube->asked, 2u);
    cast(bob::Scene(instances), {{{-1, 0.1f, 0.1f}, {1, 1e-4f, 1e-4f}}});  // between the rows
    CHECK_EQ(cube->calls, 2u);
}

TEST(near_instances_are_asked_before_those_behind_them) {
    const auto cube = std::make_shared<const Cube>();
    std::vector<bob::Instance> instances;
    for (int i = 0; i < 100; ++i) instances.push_back(placed(cube, {0, 0, 0.009f * static_cast<float>(i)}, 0.1f));
    const auto found = cast(bob::Scene(instances), {{{0.01f, 0.01f, 1.2f}, {1e-4f, 1e-4f, -1}}});
    CHECK_EQ(found.hits[0].instance, 99u);
    CHECK_EQ(cube->asked, 2u);
}

TEST(a_scene_of_nothing_that_can_be_seen) {
    bob::Instance speck = placed(std::make_shared<const Cube>(), {}, 1);
    speck.to_shape.row[0][0] = HUGE_VAL;
    for (const auto& instances : {std::vector<bob::Instance>{}, std::vector<bob::Instance>{speck, speck}}) {
        for (const auto& hit : cast(bob::Scene(instances), random_rays(10, 3)).hits) {
            CHECK_EQ(hit.instance, bob::no_instance);
        }
    }
}

TEST(rays_from_within_and_past) {
    const auto ball = test::sphere(4, 1);
    const Placement placement{{0.5f, 0.5f, 0.5f}, {0.2f, 0, 0}};
    const bob::Scene scene({placed(mesh_of(ball), moved(ball, placement), placement)});
    const auto found = cast(scene, {{{0.2f, 0.01f, 0.02f}, {0, 0, 1}}, {{0.2f, 0.01f, 2}, {0, 0, 1}},
                                    {{0.2f, 0.6f, 2}, {0, 0, -1}}, {{0.69f, 0.49f, 2}, {0, 0, -1}}});
    CHECK_NEAR(found.hits[0].t, 0.48f, 5e-3f);
    for (std::size_t i = 1; i < found.hits.size(); ++i) {
        CHECK_EQ(found.hits[i].instance, bob::no_instance);
        CHECK_EQ(found.hits[i].t, HUGE_VALF);
        CHECK_EQ(dot(found.normals[i], found.normals[i]), 0.f);
    }
}

TEST(shapes_too_small_for_float_are_not_seen) {
    const auto ball = test::sphere(2, 1);
    bob::Instance speck = placed(mesh_of(ball), ball, {{1, 1, 1}, {}});
    for (const double size : {1e-60, 1e-320, 0.0}) {
        for (int axis = 0; axis < 3; ++axis) speck.to_shape.row[axis][axis] = 1 / size;
        for (const auto& hit : cast(bob::Scene({speck}), random_rays(500, 3)).hits) {
            CHECK_EQ(hit.instance, bob::no_instance);
        }
    }
}

TEST(batches_are_large_but_leave_work_for_every_thread) {
    const int threads = bob::thread_count();
    bob::set_thread_count(2);
    CHECK_EQ(bob::batch_size(1), 512u);
    CHECK_EQ(bob::batch_size(16000), 2000u);
    CHECK_EQ(bob::batch_size(10'000'000), 8192u);
    bob::set_thread_count(1);
    CHECK_EQ(bob::batch_size(6000), 6000u);  // for one, nothing is gained by several
    bob::set_thread_count(threads);
}
