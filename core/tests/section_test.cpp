#include "tracing/section.h"

#include <array>
#include <cmath>
#include <numbers>

#include "check.h"
#include "meshes.h"
#include "formula/expression.h"
#include "shapes/implicit/implicit.h"
#include "shapes/mesh/shells.h"
#include "shapes/tube/tube.h"
#include "tracing/scene.h"

using bob::Vec3;

namespace {

std::shared_ptr<bob::Implicit> ball(double radius) {
    bob::Graph g;
    const bob::Value f = sqrt(square(g.x()) + square(g.y()) + square(g.z())) - radius;
    return std::make_shared<bob::Implicit>(g.expression(f), bob::Bounds{{-1, -1, -1}, {1, 1, 1}});
}

bob::Scene scene_of(std::vector<std::shared_ptr<const bob::Shape>> shapes) {
    std::vector<bob::Instance> instances;
    for (auto& shape : shapes) {
        const bob::Bounds box = shape->bounds({});
        Vec3 low, high;
        for (int axis = 0; axis < 3; ++axis) low[axis] = static_cast<float>(box.low[axis]), high[axis] = static_cast<float>(box.high[axis]);
        instances.push_back({std::move(shape), {}, low, high, {}, static_cast<std::uint32_t>(instances.size())});
    }
    return bob::Scene(std::move(instances));
}

/// Rays towards points of the plane x = 0 in a square grid, from x = 2.
std::vector<bob::Ray> towards_plane(int side) {
    std::vector<bob::Ray> rays;
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) {
            const auto at = [side](int k) { return 1.9f * ((static_cast<float>(k) + 0.513f) / static_cast<float>(side) - 0.5f); };
            const Vec3 point{0, at(i), at(j)}, origin{2, 0.3f, 0.4f};
            rays.push_back({origin, point - origin});
        }
    }
    return rays;
}

constexpr bob::SectionPlane keep_below_x{{1, 0, 0}, 0};

std::vector<bob::SceneHit> cast(const bob::Scene& scene, const std::vector<bob::Ray>& rays) {
    std::vector<bob::SceneHit> hits(rays.size());
    scene.closest_hits(rays, hits);
    return hits;
}

/// Whether each ray that meets the plane where inside(y, z) has a cap there, and no other has.
template <class Inside>
void check_caps(const bob::Scene& scene, Inside inside) {
    const std::vector<bob::Ray> rays = towards_plane(64);
    const std::vector<bob::SceneHit> hits = cast(scene, rays);
    std::vector<Vec3> normals(rays.size());
    scene.normals(rays, hits, normals);
    int wrong = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Vec3 p = rays[i].origin + rays[i].direction;
        const bool on_cap = hits[i].instance != bob::no_instance && bob::is_cap(hits[i].in_shape.primitive);
        wrong += on_cap != inside(p.y, p.z);
        if (!on_cap) continue;
        CHECK_NEAR(hits[i].t, 1.f, 1e-6f);
        CHECK_NEAR(normals[i].x, 1.f, 1e-6f);
    }
    CHECK_EQ(wrong, 0);
}

/// Whether a point lies in a regular polygon with a corner on the first axis.
bool in_polygon(float y, float z, double radius, int corners) {
    const double step = 2 * std::numbers::pi / corners, angle = std::atan2(z, y), from_middle = angle - (std::floor(angle / step) + 0.5) * step;
    return std::hypot(y, z) < radius * std::cos(step / 2) / std::cos(from_middle);
}

}  // namespace

TEST(a_section_caps_solids_of_every_kind) {
    const auto in_disc = [](float radius) { return [radius](float y, float z) { return y * y + z * z < radius * radius; }; };
    const test::TriangleMesh mesh = test::sphere(4, 0.8f);
    bob::NurbsCurve<4> curve{1, {0, 0, 1, 1}, {{-0.5, 0, 0, 0.4, 1}, {0.5, 0, 0, 0.4, 1}}};
    test::for_each_isa([&] {
        check_caps(scene_of({ball(0.8)}).sectioned({&keep_below_x, 1}), in_disc(0.8f));
        check_caps(scene_of({std::make_shared<bob::Tube>(curve)}).sectioned({&keep_below_x, 1}), in_disc(0.4f));
        check_caps(scene_of({test::prepared(mesh.vertices, mesh.triangles)}).sectioned({&keep_below_x, 1}),
                   [](float y, float z) { return in_polygon(y, z, 0.8, 64); });
    });
}

TEST(a_cap_has_the_hole_of_a_hollow_solid) {
    const test::TriangleMesh outer = test::sphere(3, 0.9f);
    for (const bool is_turned : {false, true}) {  // the inner shell as files have it, or with the other side out
        test::TriangleMesh hollow = outer;
        const auto first = static_cast<std::uint32_t>(outer.vertices.size());
        for (const Vec3 v : outer.vertices) hollow.vertices.push_back(0.5f * v);
        for (const auto& [a, b, c] : outer.triangles) {
            is_turned ? hollow.triangles.push_back({first + a, first + b, first + c}) : hollow.triangles.push_back({first + a, first + c, first + b});
        }
        CHECK_EQ(bob::find_shells(hollow.vertices, hollow.triangles).count, 2u);
        check_caps(scene_of({test::prepared(hollow.vertices, hollow.triangles)}).sectioned({&keep_below_x, 1}), [](float y, float z) {
            return in_polygon(y, z, 0.9, 32) && !in_polygon(y, z, 0.45, 32);
        });
    }
}

TEST(triangles_of_any_order_of_corners_enclose_a_solid) {
    test::TriangleMesh mesh = test::sphere(3, 0.9f);
    test::Random random(5);
    for (auto& [a, b, c] : mesh.triangles) {
        if (random() < 0.5f) std::swap(b, c);
    }
    const bob::Scene scene = scene_of({test::prepared(mesh.vertices, mesh.triangles)}).sectioned({&keep_below_x, 1});
    CHECK(scene.open_instances().empty());
    const std::vector<bob::Ray> rays{{{2, 0, 0}, {-1, 0.1f, 0.1f}}};
    CHECK(bob::is_cap(cast(scene, rays)[0].in_shape.primitive));
}

TEST(solids_that_overlap_in_a_mesh_are_capped_as_one) {
    test::TriangleMesh mesh = test::sphere(3, 0.6f), other = mesh;
    for (Vec3& v : mesh.vertices) v.y -= 0.3f;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3 v : other.vertices) mesh.vertices.push_back(v + Vec3{0, 0.3f, 0});
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
    const bob::Scene scene = scene_of({test::prepared(mesh.vertices, mesh.triangles)}).sectioned({&keep_below_x, 1});
    CHECK(scene.open_instances().empty());
    for (const float y : {-0.8f, -0.4f, -0.25f, 0.f, 0.25f, 0.4f, 0.8f}) {
        const std::vector<bob::Ray> rays{{{2, y, 0.01f}, {-1, 0, 0}}};
        CHECK(bob::is_cap(cast(scene, rays)[0].in_shape.primitive));
    }
}

TEST(an_open_shape_shows_its_inside) {
    test::TriangleMesh mesh = test::sphere(3, 0.9f);
    std::erase_if(mesh.triangles, [&](const bob::Triangle& t) { return mesh.vertices[t[0]].z > 0.5f; });
    const bob::Scene scene = scene_of({test::prepared(mesh.vertices, mesh.triangles)}).sectioned({&keep_below_x, 1});
    CHECK_EQ(scene.open_instances().size(), 1u);
    const std::vector<bob::Ray> rays{{{2, 0, 0}, {-1, 0.1f, 0.1f}}};
    const bob::SceneHit hit = cast(scene, rays)[0];
    CHECK_EQ(hit.instance, 0u);
    CHECK(!bob::is_cap(hit.in_shape.primitive));
    CHECK_LT(2.f, hit.t);
}

TEST(of_nested_solids_the_cap_of_the_smallest_is_seen) {
    for (const bool is_first : {false, true}) {
        const auto inner = ball(0.4), outer = ball(0.9);
        const bob::Scene scene = scene_of(is_first ? std::vector<std::shared_ptr<const bob::Shape>>{inner, outer}
                                                   : std::vector<std::shared_ptr<const bob::Shape>>{outer, inner});
        const std::vector<bob::Ray> rays{{{2, 0, 0}, {-1, 0.01f, 0.1f}}, {{2, 0.6f, 0}, {-1, 0.01f, 0.01f}}};
        const auto hits = cast(scene.sectioned({&keep_below_x, 1}), rays);
        CHECK(bob::is_cap(hits[0].in_shape.primitive) && bob::is_cap(hits[1].in_shape.primitive));
        CHECK_EQ(hits[0].instance, is_first ? 0u : 1u);
        CHECK_EQ(hits[1].instance, is_first ? 1u : 0u);
    }
}

TEST(rays_from_inside_meet_caps_where_they_leave) {
    const bob::Scene scene = scene_of({ball(0.9)}).sectioned({&keep_below_x, 1});
    const std::vector<bob::Ray> rays{{{-0.3f, 0.1f, 0}, {1, 0, 0}}, {{-0.3f, 0.1f, 0}, {-1, 0, 0}}};
    const auto hits = cast(scene, rays);
    CHECK(bob::is_cap(hits[0].in_shape.primitive));
    CHECK_NEAR(hits[0].t, 0.3f, 1e-6f);
    CHECK(!bob::is_cap(hits[1].in_shape.primitive));
    CHECK_NEAR(hits[1].t, std::sqrt(0.8f) - 0.3f, 1e-5f);
    std::vector<Vec3> normals(2);
    scene.normals(rays, hits, normals);
    CHECK_NEAR(normals[0].x, -1.f, 1e-6f);
}

TEST(planes_keep_what_lies_behind_all_of_them) {
    const std::array<bob::SectionPlane, 2> planes{{{{1, 0, 0}, 0.2}, {{0, 0, 1}, 0.3}}};
    const bob::Scene scene = scene_of({ball(0.9)}).sectioned(planes);
    const std::vector<bob::Ray> rays{{{2, 0, 0.25f}, {-1, 0, 0}}, {{2, 0, 0.35f}, {-1, 0, 0}}, {{0.1f, 0, 2}, {0, 0, -1}}, {{0.25f, 0, 2}, {0, 0, -1}}};
    const auto hits = cast(scene, rays);
    CHECK_NEAR(hits[0].t, 1.8f, 1e-6f);
    CHECK_EQ(hits[0].in_shape.primitive, bob::first_cap);
    CHECK_EQ(hits[1].instance, bob::no_instance);
    CHECK_NEAR(hits[2].t, 1.7f, 1e-6f);
    CHECK_EQ(hits[2].in_shape.primitive, bob::first_cap + 1);
    CHECK_EQ(hits[3].instance, bob::no_instance);
    CHECK_EQ(cast(scene.sectioned({}), rays)[1].instance, 0u);
}
