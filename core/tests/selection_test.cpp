#include "tracing/selection.h"

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "check.h"
#include "formula/expression.h"
#include "shapes/implicit/implicit.h"
#include "shapes/mesh/owned_arrays.h"
#include "tracing/arrangement.h"

using bob::Vec3;

namespace {

/// Boxes along x, three apart, as one mesh with colours: 12 triangles each.
std::shared_ptr<const bob::Mesh> boxes(int count) {
    auto own = std::make_shared<bob::OwnedArrays>();
    const std::array<std::array<std::uint32_t, 4>, 6> quads{{{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
    for (int k = 0; k < count; ++k) {
        const auto first = static_cast<std::uint32_t>(own->vertices.size());
        for (int i = 0; i < 8; ++i) own->vertices.push_back({3. * k + (i & 4 ? 1 : -1), i & 2 ? 1. : -1., i & 1 ? 1. : -1.});
        for (const auto& [a, b, c, d] : quads) {
            own->triangles.push_back({first + a, first + b, first + c}), own->triangles.push_back({first + a, first + c, first + d});
        }
    }
    own->face_colors.assign(own->triangles.size(), Vec3{0, 0, 1});
    return std::make_shared<bob::Mesh>(bob::OwnedArrays::of(own));
}

struct Seen {
    std::uint32_t triangle;
    Vec3 color;
};

/// The first hit straight down on the middle of box k, in the coordinates of the unit sphere.
Seen seen(const bob::Scene& scene, const bob::Sphere& sphere, int k) {
    const auto x = static_cast<float>((3. * k + 0.1 - sphere.center[0]) / sphere.radius);
    const std::array rays{bob::Ray{{x, 0.02f, 1}, {0, 0, -1}}};
    std::array<bob::SceneHit, 1> hits;
    std::array<Vec3, 1> normals, colors;
    const std::array widths{0.01f};
    scene.closest_hits(rays, hits);
    if (hits[0].instance == bob::no_instance) return {bob::no_primitive, {}};
    scene.normals_and_colors(rays, hits, widths, normals, colors);
    if (bob::is_cap(hits[0].in_shape.primitive)) return {hits[0].in_shape.primitive, colors[0]};
    const bob::Instance& instance = scene[hits[0].instance];
    const Vec3 material = instance.material.base_color();
    return {instance.shape->place(hits[0].in_shape).part, {material.x * colors[0].x, material.y * colors[0].y, material.z * colors[0].z}};
}

constexpr Vec3 orange{1, 0.3f, 0};

}  // namespace

TEST(parts_of_a_mesh_are_hidden_and_highlighted) {
    const bob::Arrangement arrangement({{boxes(3), {}, {}}});
    const bob::Scene whole = arrangement.scene();
    const std::array hidden{bob::Primitives{0, 0, 12}}, lit{bob::Primitives{0, 24, 36}};
    const bob::Scene scene = bob::selected(whole, hidden, lit, orange);
    CHECK(scene.size() == 2);
    CHECK(seen(scene, arrangement.sphere(), 0).triangle == bob::no_primitive);
    for (const int k : {1, 2}) {
        const Seen found = seen(scene, arrangement.sphere(), k), before = seen(whole, arrangement.sphere(), k);
        CHECK(found.triangle == before.triangle);
        const Vec3 color = k == 2 ? orange : before.color;
        CHECK(found.color.x == color.x && found.color.y == color.y && found.color.z == color.z);
    }
    const bob::Scene none = bob::selected(whole, std::array{bob::Primitives{0, 0, 36}}, {}, orange);
    CHECK(none.size() == 0);
    CHECK(seen(none, arrangement.sphere(), 1).triangle == bob::no_primitive);
}

TEST(cut_meshes_stay_solids_for_sections) {
    const bob::Arrangement arrangement({{boxes(2), {}, {}}});
    const std::array hidden{bob::Primitives{0, 0, 12}};
    const bob::Scene scene = bob::selected(arrangement.scene(), hidden, {}, orange).sectioned(std::array{bob::SectionPlane{{0, 0, 1}, 0}});
    CHECK(scene.open_instances().empty());
    CHECK(seen(scene, arrangement.sphere(), 0).triangle == bob::no_primitive);
    CHECK(bob::is_cap(seen(scene, arrangement.sphere(), 1).triangle));
}

TEST(primitives_are_measured_in_the_scenes_units) {
    bob::AffineMap twice;
    for (int axis = 0; axis < 3; ++axis) twice.row[axis][axis] = axis == 0 ? -2 : 2;  // mirrored
    const bob::Arrangement arrangement({{boxes(3), twice, {}}});
    const bob::Scene scene = arrangement.scene();
    const bob::Amount one = bob::amount(scene, std::array{bob::Primitives{0, 12, 24}}, arrangement.sphere());
    CHECK(std::fabs(*one.area - 96) < 1e-9 && std::fabs(*one.volume - 64) < 1e-9);
    CHECK(std::fabs(one.bounds.low[0] + 8) < 1e-12 && std::fabs(one.bounds.high[0] + 4) < 1e-12);
    const bob::Amount two = bob::amount(scene, std::array{bob::Primitives{0, 12, 24}, bob::Primitives{0, 30, 36}}, arrangement.sphere());
    CHECK(std::fabs(*two.area - 144) < 1e-9 && !two.volume);
}

TEST(other_shapes_have_the_size_that_rays_find) {
    bob::Graph g;
    const bob::Value f = sqrt(square(g.x()) + square(g.y()) + square(g.z())) - 0.7;
    auto ball = std::make_shared<bob::Implicit>(g.expression(f), bob::Bounds{{-1, -1, -1}, {1, 1, 1}});
    bob::AffineMap moved;
    moved.row[0][3] = 5;
    const bob::Arrangement arrangement({{ball, moved, {}}, {boxes(1), {}, {}}});
    const bob::Amount found = bob::amount(arrangement.scene(), std::array{bob::Primitives{0, 0, 1}}, arrangement.sphere());
    CHECK(!found.area && !found.volume);
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = axis == 0 ? 5 : 0;
        CHECK_NEAR(found.bounds.low[axis], middle - 0.7, 2e-5);
        CHECK_NEAR(found.bounds.high[axis], middle + 0.7, 2e-5);
    }
}

TEST(rays_find_the_corners_of_a_shape) {
    bob::Graph g;
    const bob::Value f = abs(g.x()) + abs(g.y()) + abs(g.z() - 0.1) - 0.7;
    auto octahedron = std::make_shared<bob::Implicit>(g.expression(f), bob::Bounds{{-1, -1, -1}, {1, 1, 1}});
    const bob::Arrangement arrangement({{octahedron, {}, {}}});
    const bob::Amount found = bob::amount(arrangement.scene(), std::array{bob::Primitives{0, 0, 1}}, arrangement.sphere());
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = axis == 2 ? 0.1 : 0;
        CHECK_NEAR(found.bounds.low[axis], middle - 0.7, 1e-5);
        CHECK_NEAR(found.bounds.high[axis], middle + 0.7, 1e-5);
    }
}
