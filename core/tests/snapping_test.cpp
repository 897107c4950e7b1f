#include "tracing/snapping.h"

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "check.h"
#include "drawing/visible_edges.h"
#include "shapes/mesh/owned_arrays.h"
#include "tracing/arrangement.h"

using namespace bob;

namespace {

/// A cube about the origin, whose corners are on the unit sphere.
Scene cube() {
    auto own = std::make_shared<OwnedArrays>();
    const std::array<std::array<std::uint32_t, 4>, 6> quads{{{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
    for (int i = 0; i < 8; ++i) own->vertices.push_back({i & 4 ? 1. : -1., i & 2 ? 1. : -1., i & 1 ? 1. : -1.});
    for (const auto& [a, b, c, d] : quads) own->triangles.push_back({a, b, c}), own->triangles.push_back({a, c, d});
    const auto mesh = std::make_shared<Mesh>(OwnedArrays::of(own));
    const Arrangement arrangement({{mesh, {}, {}}});
    return arrangement.scene({});
}

constexpr int size = 200;

TEST(the_nearest_point_within_reach_is_snapped_to) {
    const Scene scene = cube();
    const Camera camera{30, 30};
    const Projection projection(camera, size, size);
    const double a = 1 / std::sqrt(3.);
    const auto at = [&](const Vec3d& p, float off) {
        const auto seen = projection.seen({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
        return snap(scene, camera, size, size, seen.row + off, seen.column + off, 6);
    };
    for (const Vec3d& corner : {Vec3d{a, a, a}, Vec3d{a, -a, a}, Vec3d{a, a, -a}}) {
        const auto found = at(corner, 3);
        CHECK(found && found->kind == SnapKind::corner && length(found->point - corner) < 1e-7);
    }
    const Vec3d middle{a, 0, a}, on_edge{a, 0.3 * a, a}, within{a, 0.4 * a, 0.4 * a}, hidden{-a, -a, -a};
    const auto of_middle = at(middle, 2), of_edge = at(on_edge, 0);
    CHECK(of_middle && of_middle->kind == SnapKind::middle && length(of_middle->point - middle) < 1e-7);
    CHECK(of_edge && of_edge->kind == SnapKind::edge && length(of_edge->point - on_edge) < 1e-3);
    CHECK(!at(within, 0));
    CHECK(!at(hidden, 0));
}

TEST(of_points_behind_each_other_the_nearest_to_the_camera_is_snapped_to) {
    const Scene scene = cube();
    const double a = 1 / std::sqrt(3.);
    for (const Camera& camera : {Camera{0, 90}, Camera{0, -90}, Camera{0, 0}, Camera{90, 0}, Camera{180, 0}, Camera{-90, 0}}) {
        const Projection projection(camera, size, size);
        const auto seen = [&](const Vec3d& p) {
            return projection.seen({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
        };
        for (int i = 0; i < 8; ++i) {
            const Vec3d corner{i & 4 ? a : -a, i & 2 ? a : -a, i & 1 ? a : -a};
            for (const float off : {-2.f, -0.3f, 0.f, 0.3f, 2.f}) {
                const auto place = seen(corner);
                const auto found = snap(scene, camera, size, size, place.row + off, place.column + off, 5);
                CHECK(found && found->kind == SnapKind::corner && seen(found->point).depth > 0.5f);
                const auto edge = snap(scene, camera, size, size, place.row, place.column / 2 + 0.25f * size + off, 5);
                CHECK(edge && edge->kind == SnapKind::edge && seen(edge->point).depth > 0.5f);
            }
        }
    }
}

TEST(coarse_edges_are_those_of_the_whole_picture) {
    const Scene scene = cube();
    for (const auto& [height, width] : {std::pair{150, 200}, {203, 151}}) {
        for (const float fov : {0.f, 50.f}) {
            Camera camera{30, 30};
            camera.fov_degrees = fov;
            std::vector<float> fine(static_cast<std::size_t>(height) * static_cast<std::size_t>(width)), coarse = fine;
            draw_visible_edges(scene, camera, height, width, 0, height, 2, fine);
            draw_coarse_edges(scene, camera, height, width, 5, 2, coarse);
            double apart = 0, all = 0;
            for (std::size_t i = 0; i < fine.size(); ++i) apart += std::abs(fine[i] - coarse[i]), all += fine[i];
            CHECK(all > 500);
            CHECK(apart < 0.3 * all);
        }
    }
}

}  // namespace
