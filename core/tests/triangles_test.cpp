#include "shapes/mesh/triangles.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "check.h"
#include "meshes.h"

using bob::Hit;
using bob::Ray;
using bob::Vec3;

namespace {

Hit trace(const bob::TriangleBvh& bvh, const Ray& ray) {
    Hit hit;
    bob::best_triangle_kernels().closest_hits(bvh.nodes.data(), bvh.packets.data(), &ray, 1, false, &hit);
    return hit;
}

bool same_bits(const Hit& a, const Hit& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Möller and Trumbore in double precision, over all triangles: another method, as the oracle.
double brute_force(const test::TriangleMesh& mesh, const Ray& ray) {
    struct D3 { double x, y, z; };
    const auto wide = [](Vec3 v) { return D3{v.x, v.y, v.z}; };
    const auto sub = [](D3 a, D3 b) { return D3{a.x - b.x, a.y - b.y, a.z - b.z}; };
    const auto crossed = [](D3 a, D3 b) { return D3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; };
    const auto dotted = [](D3 a, D3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
    double nearest = HUGE_VAL;
    for (const auto& t : mesh.triangles) {
        const D3 a = wide(mesh.vertices[t[0]]), d = wide(ray.direction);
        const D3 ab = sub(wide(mesh.vertices[t[1]]), a), ac = sub(wide(mesh.vertices[t[2]]), a);
        const D3 p = crossed(d, ac), s = sub(wide(ray.origin), a), q = crossed(s, ab);
        const double det = dotted(ab, p);
        const double u = dotted(s, p) / det, v = dotted(d, q) / det, distance = dotted(ac, q) / det;
        if (det != 0 && u >= 0 && v >= 0 && u + v <= 1 && distance > 0) nearest = std::min(nearest, distance);
    }
    return nearest;
}

Ray random_ray(test::Random& random) {
    const Vec3 direction = test::random_direction(random);
    return {Vec3{random(-0.6f, 0.6f), random(-0.6f, 0.6f), random(-0.6f, 0.6f)} - 1.5f * direction, direction};
}

}  // namespace

TEST(bvh_equals_brute_force) {
    for (const float size : {0.02f, 0.3f}) {
        for (const int count : {1, 2, 4, 5, 33, 1000}) {
            const auto mesh = test::soup(count, size, 7);
            const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
            test::for_each_isa([&] {
                test::Random random(11);
                int disagreements = 0;
                for (int i = 0; i < 2000; ++i) {
                    const Ray ray = random_ray(random);
                    const double want = brute_force(mesh, ray);
                    const Hit hit = trace(bvh, ray);
                    const bool found = hit.primitive != bob::no_primitive;
                    if (found != (want < HUGE_VAL) || (found && std::fabs(hit.t - want) > 1e-4)) ++disagreements;
                }
                // Rays within rounding of an edge may go either way: these seeds have at most two of them.
                CHECK_LT(disagreements, 3);
            });
        }
    }
}

TEST(barycentric_weights_give_the_point) {
    const auto mesh = test::soup(300, 0.3f, 3);
    const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
    test::Random random(5);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Ray ray = random_ray(random);
        const Hit hit = trace(bvh, ray);
        if (hit.primitive == bob::no_primitive) continue;
        ++hits;
        const auto& t = mesh.triangles[hit.primitive];
        const Vec3 point = hit.u * mesh.vertices[t[0]] + hit.v * mesh.vertices[t[1]] +
                           (1 - hit.u - hit.v) * mesh.vertices[t[2]];
        CHECK_LT(length(point - (ray.origin + hit.t * ray.direction)), 1e-4f);
    }
    CHECK_LT(500, hits);
}

TEST(rays_never_leak_through_shared_edges_and_corners) {
    for (const int levels : {0, 1, 3, 5}) {
        auto mesh = test::sphere(levels, 0.7f);
        test::Random random(static_cast<std::uint64_t>(levels));
        // Moved and dented, so that coordinates are not round and triangles differ.
        for (auto& v : mesh.vertices) v = random(0.8f, 1) * v + Vec3{0.1f, -0.07f, 0.05f};
        const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
        test::for_each_isa([&] {
            int leaks = 0;
            for (int i = 0; i < 20000; ++i) {
                const auto& t = mesh.triangles[static_cast<std::size_t>(random(0, 0.9999f) * mesh.triangles.size())];
                const float along = i % 3 == 0 ? 0.f : random();  // a corner, or a point on an edge
                const Vec3 target = (1 - along) * mesh.vertices[t[0]] + along * mesh.vertices[t[1]];
                const Vec3 inside{0.1f, -0.07f, 0.05f};
                // From outside towards the inside, and from inside out: either way something must be in front.
                const Vec3 inward = inside - target;
                if (trace(bvh, {target - 0.5f * inward, inward}).primitive == bob::no_primitive) ++leaks;
                if (trace(bvh, {inside, target - inside}).primitive == bob::no_primitive) ++leaks;
                // Along an axis, where slabs and shears are degenerate.
                const int axis = i % 3;
                Vec3 direction{};
                direction[axis] = inward[axis] > 0 ? 1.f : -1.f;
                Vec3 origin = inside;
                origin[axis] -= 1.2f * direction[axis];
                if (trace(bvh, {origin, direction}).primitive == bob::no_primitive) ++leaks;
            }
            CHECK_EQ(leaks, 0);
        });
    }
}

TEST(slivers_of_closed_meshes_are_hit_where_they_are) {
    // Two cones over one rim, whose points come in close pairs: every other triangle is thinner than the rounding of floats.
    for (const float thickness : {1e-5f, 1e-6f, 1e-7f, 1e-8f}) {
        test::Random random(7);
        const Vec3 z = test::random_direction(random), x = normalized(cross(z, {1, 0, 0})), y = cross(z, x);
        test::TriangleMesh mesh;
        constexpr std::uint32_t pairs = 100, rim = 2 * pairs;
        for (std::uint32_t i = 0; i < pairs; ++i) {
            const float angle = 6.2831853f * (static_cast<float>(i) + random(0, 0.9f)) / pairs;
            const Vec3 point = std::cos(angle) * x + std::sin(angle) * y, along = std::cos(angle) * y - std::sin(angle) * x;
            mesh.vertices.insert(mesh.vertices.end(), {point, point + random(0, thickness) * along});
        }
        mesh.vertices.insert(mesh.vertices.end(), {0.7f * z + 0.1f * x, -0.8f * z});
        for (std::uint32_t i = 0; i < rim; ++i) {
            const std::uint32_t next = (i + 1) % rim;
            mesh.triangles.push_back({i, next, rim});
            mesh.triangles.push_back({next, i, rim + 1});
        }
        const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
        test::for_each_isa([&] {
            int leaks = 0;
            float farthest = 0, apart = 0;
            for (int i = 0; i < 20000; ++i) {
                const auto& t = mesh.triangles[static_cast<std::size_t>(random(0, 0.9999f) * static_cast<float>(mesh.triangles.size()))];
                const float u = random(), v = random(0, 1 - u) * static_cast<float>(i % 2);  // on an edge, or within
                const auto at = [&](float first, float second) {
                    return first * mesh.vertices[t[0]] + second * mesh.vertices[t[2]] + (1 - first - second) * mesh.vertices[t[1]];
                };
                const Vec3 inside = random(0, 0.05f) * test::random_direction(random), way = at(v, u) - inside;
                const Hit hit = trace(bvh, {inside, way});
                if (hit.primitive == bob::no_primitive) {
                    ++leaks;
                    continue;
                }
                farthest = std::max(farthest, std::fabs(hit.t - 1) * length(way));
                const auto& [a, b, c] = mesh.triangles[hit.primitive];
                const Vec3 point = hit.u * mesh.vertices[a] + hit.v * mesh.vertices[b] + (1 - hit.u - hit.v) * mesh.vertices[c];
                apart = std::max(apart, length(point - inside - hit.t * way));
            }
            CHECK_EQ(leaks, 0);
            CHECK_LT(farthest, 1e-5f);
            CHECK_LT(apart, 1e-5f);
        });
    }
}

TEST(axis_aligned_rays_hit_an_axis_aligned_grid_exactly_on_its_lines) {
    // Two triangles a cell; rays run through lines, corners and diagonals of the grid.
    test::TriangleMesh mesh;
    constexpr std::uint32_t n = 16;
    for (std::uint32_t y = 0; y <= n; ++y) {
        for (std::uint32_t x = 0; x <= n; ++x) {
            mesh.vertices.push_back({static_cast<float>(x) / n - 0.5f, static_cast<float>(y) / n - 0.5f, 0});
        }
    }
    for (std::uint32_t y = 0; y < n; ++y) {
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t a = y * (n + 1) + x;
            mesh.triangles.push_back({a, a + 1, a + n + 2});
            mesh.triangles.push_back({a, a + n + 2, a + n + 1});
        }
    }
    const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
    test::for_each_isa([&] {
        int missed = 0;
        for (int y = 0; y <= 64; ++y) {
            for (int x = 0; x <= 64; ++x) {
                const Ray ray{{static_cast<float>(x) / 64 - 0.5f, static_cast<float>(y) / 64 - 0.5f, 1}, {0, 0, -1}};
                const Hit hit = trace(bvh, ray);
                if (hit.primitive == bob::no_primitive || hit.t != 1) ++missed;
            }
        }
        CHECK_EQ(missed, 0);
    });
}

TEST(zeros_of_either_sign_are_the_same_direction) {
    const auto mesh = test::soup(1000, 0.3f, 9);
    const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
    test::for_each_isa([&] {
        test::Random random(2);
        int hits = 0;
        for (int i = 0; i < 2000; ++i) {
            const int axis = i % 3;
            Vec3 direction{}, negative{-0.f, -0.f, -0.f};
            direction[axis] = negative[axis] = i % 2 ? 1.f : -1.f;
            const Vec3 point{random(-0.6f, 0.6f), random(-0.6f, 0.6f), random(-0.6f, 0.6f)};
            const Hit hit = trace(bvh, {point - 2 * direction, direction});
            CHECK(same_bits(trace(bvh, {point - 2 * direction, negative}), hit));
            hits += std::isfinite(hit.t);
        }
        CHECK_LT(1000, hits);
    });
}

TEST(a_hit_depends_on_its_ray_alone) {
    const auto mesh = test::soup(3000, 0.1f, 4);
    const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
    test::Random random(8);
    std::vector<Ray> rays(1000);
    for (Ray& ray : rays) ray = random_ray(random);
    test::for_each_isa([&] {
        const auto closest_hits = bob::best_triangle_kernels().closest_hits;
        for (const bool apart : {false, true}) {
            for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{5}, rays.size()}) {
                std::vector<Hit> hits(count, Hit{1, 2, 3, 4});
                closest_hits(bvh.nodes.data(), bvh.packets.data(), rays.data(), count, apart, hits.data());
                for (std::size_t i = 0; i < count; ++i) CHECK(same_bits(hits[i], trace(bvh, rays[i])));
            }
        }
    });
}

TEST(rays_lie_apart_where_they_meet_other_triangles) {
    test::Random random(8);
    const auto fine = test::sphere(7, 1), coarse = test::sphere(2, 1);
    const auto fine_bvh = bob::build_triangle_bvh(fine.vertices, fine.triangles);
    const auto coarse_bvh = bob::build_triangle_bvh(coarse.vertices, coarse.triangles);
    std::vector<Ray> scattered(100), neighbours(100), turning(100), reflected(100);
    for (std::size_t i = 0; i < 100; ++i) {
        const float step = static_cast<float>(i);
        scattered[i] = random_ray(random);
        neighbours[i] = {{1e-3f * step, 0, 2}, {0, 0, -3}};
        turning[i] = {{0, 0, 5}, {std::sin(0.01f * step - 0.5f), 0, -std::cos(0.01f * step - 0.5f)}};
        reflected[i] = {{1e-3f * step, 0, 0.5f}, test::random_direction(random)};
    }
    CHECK(bob::lie_apart(fine_bvh, scattered));
    CHECK(bob::lie_apart(fine_bvh, turning));
    CHECK(!bob::lie_apart(fine_bvh, neighbours));
    CHECK(!bob::lie_apart(fine_bvh, reflected));
    CHECK(!bob::lie_apart(coarse_bvh, scattered));
    CHECK(!bob::lie_apart(fine_bvh, {scattered.data(), 1}));
    CHECK(!bob::lie_apart(fine_bvh, {}));
}

TEST(rays_that_are_not_finite_hit_nothing) {
    for (const int count : {1, 9, 100, 1000}) {
        const auto mesh = test::soup(count, 0.3f, 6);
        const auto bvh = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
        constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
        test::for_each_isa([&] {
            for (const float odd : {nan, -nan, inf, -inf}) {
                for (int where = 1; where < 64; ++where) {  // any of the six numbers
                    Ray ray{{0.1f, 0.2f, 3}, {0.01f, -0.02f, -1}};
                    for (int axis = 0; axis < 3; ++axis) {
                        if (where >> axis & 1) ray.origin[axis] = odd;
                        if (where >> (axis + 3) & 1) ray.direction[axis] = odd;
                    }
                    CHECK(same_bits(trace(bvh, ray), Hit{}));
                }
            }
        });
    }
}

TEST(odd_meshes_are_built_and_traced) {
    // All centroids in one point, sizes over twenty orders of magnitude, and triangles without area.
    test::TriangleMesh same, growing, flat;
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const float size = std::ldexp(1.f, -static_cast<int>(i % 64));
        for (const Vec3 v : {Vec3{-1, -1, 0}, Vec3{1, -1, 0}, Vec3{0, 2, 0}}) {
            same.vertices.push_back(v);
            growing.vertices.push_back(size * v + Vec3{size, size, size});
            flat.vertices.push_back({v.x, 0, 0});
        }
        for (auto* mesh : {&same, &growing, &flat}) mesh->triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    test::for_each_isa([&] {
        const Ray down{{0.01f, 0.01f, 3}, {0, 0, -1}};
        const auto same_bvh = bob::build_triangle_bvh(same.vertices, same.triangles);
        CHECK_EQ(trace(same_bvh, down).t, 3.f);
        const auto growing_bvh = bob::build_triangle_bvh(growing.vertices, growing.triangles);
        CHECK_NEAR(trace(growing_bvh, {{1, 1, 3}, {0, 0, -1}}).t, 2.f, 1e-6f);
        const auto flat_bvh = bob::build_triangle_bvh(flat.vertices, flat.triangles);
        CHECK_EQ(trace(flat_bvh, {{0, 1, 0}, {0, -1, 0}}).primitive, bob::no_primitive);
        const float nan = std::nanf("");
        CHECK_EQ(trace(same_bvh, {{nan, 0, 3}, {0, 0, -1}}).primitive, bob::no_primitive);
    });
}

TEST(bvh_does_not_depend_on_the_number_of_threads) {
    const auto mesh = test::soup(30000, 0.02f, 1);
    const int threads = bob::thread_count();
    bob::set_thread_count(1);
    const auto one = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
    bob::set_thread_count(4);
    const auto four = bob::build_triangle_bvh(mesh.vertices, mesh.triangles);
    bob::set_thread_count(threads);
    CHECK_EQ(one.nodes.size(), four.nodes.size());
    bool same = one.packets.size() == four.packets.size();
    for (std::size_t i = 0; same && i < one.packets.size(); ++i) {
        same = std::ranges::equal(one.packets[i].triangle, four.packets[i].triangle);
    }
    CHECK(same);
}

TEST(rays_go_on_where_alpha_is_below_the_cutoff) {
    // Each triangle occurs twice in the same place, with different alphas. Neither may hide surfaces behind it or next to it.
    auto mesh = test::soup(150, 0.5f, 21);
    mesh.vertices.insert(mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (std::uint32_t i = 0; i < 150; ++i) mesh.triangles.push_back({450 + 3 * i, 451 + 3 * i, 452 + 3 * i});
    test::Random random(3);
    std::vector<bob::Mesh::Point> points;
    for (const Vec3 v : mesh.vertices) points.push_back({v.x, v.y, v.z});
    std::vector<bob::Mesh::Uv> uv(points.size());
    for (auto& place : uv) place = {random(-1, 2), random(-1, 2)};
    std::vector<float> alphas(points.size());
    for (float& alpha : alphas) alpha = random(0.5f, 1);
    const std::vector<std::uint8_t> texels(8 * 8 * 3, 100);
    std::vector<std::uint8_t> alpha(8 * 8);
    for (auto& value : alpha) value = static_cast<std::uint8_t>(random(0, 255.9f));
    const auto picture = std::make_shared<bob::Picture>(texels, 8, 8, alpha);
    const auto texture = std::make_shared<bob::Texture>(picture, bob::Wrap::repeat, bob::Wrap::mirror);

    const auto made = [&](std::span<const bob::Triangle> triangles, float cutoff) {
        bob::Mesh::Arrays arrays{points, triangles, {}, nullptr};
        arrays.uv = uv, arrays.texture = texture, arrays.alphas = alphas, arrays.alpha_cutoff = cutoff;
        auto shape = std::make_unique<bob::Mesh>(arrays, bob::Sphere{});
        shape->prepare();
        return shape;
    };
    for (const float cutoff : {0.f, 0.4f, 1.f}) {
        const auto shape = made(mesh.triangles, cutoff);
        test::for_each_isa([&] {
            test::Random rays(5);
            std::vector<Ray> all;
            for (int i = 0; i < 500; ++i) all.push_back(random_ray(rays));
            std::vector<float> nearest(all.size(), HUGE_VALF);
            for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
                const auto alone = made({&mesh.triangles[i], 1}, 0);  // without holes
                std::vector<Hit> hits(all.size());
                alone->closest_hits(all, hits);
                for (std::size_t j = 0; j < all.size(); ++j) {
                    const auto [t, u, v, primitive] = hits[j];
                    if (primitive == bob::no_primitive) continue;
                    const auto& [a, b, c] = mesh.triangles[i];
                    const float w = 1 - u - v;
                    const float opacity = texture->alpha(u * uv[a][0] + v * uv[b][0] + w * uv[c][0],
                                                         u * uv[a][1] + v * uv[b][1] + w * uv[c][1]) *
                                          (alphas[c] + u * (alphas[a] - alphas[c]) + v * (alphas[b] - alphas[c]));
                    if (opacity >= cutoff) nearest[j] = std::min(nearest[j], t);
                }
            }
            std::vector<Hit> hits(all.size());
            shape->closest_hits(all, hits);
            int found = 0;
            for (std::size_t j = 0; j < all.size(); ++j) {
                CHECK_EQ(hits[j].t, nearest[j]);
                found += hits[j].primitive != bob::no_primitive;
            }
            if (cutoff < 1) CHECK_LT(100, found);
        });
    }
}
