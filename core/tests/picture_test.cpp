#include "check.h"
#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

TEST(layouts_know_their_channels_places) {
    const bob::Layout& layout = bob::gbuffer_layout();
    CHECK_EQ(layout.width(), 5);
    CHECK(layout.names() == "mask,gray,depth,normal");
    CHECK_EQ(layout.place(bob::channels::mask), 0);
    CHECK_EQ(layout.place(bob::channels::normal), 3);
    const bob::Layout two("normal,gray");
    CHECK_EQ(two.width(), 3);
    CHECK_EQ(two.place(bob::channels::gray), 2);
    CHECK_EQ(two.place(bob::channels::depth), -1);
    CHECK(bob::Layout(layout.names()) == layout);
    for (const char* wrong : {"", "gray,", "gray, depth", "grey"}) {
        bool refused = false;
        try {
            const bob::Layout none{std::string_view(wrong)};
        } catch (const std::invalid_argument&) {
            refused = true;
        }
        CHECK(refused);
    }
}

TEST(scattered_samples_lie_at_their_pixels) {
    const bob::Layout layout{bob::channels::mask, bob::channels::normal};
    std::vector<float> planes(3 * 6);
    const std::vector<bob::Pixel> pixels{{1, 2}, {0, 1}, {1, 2}};
    const std::vector<float> samples{1, 0.5f, -0.5f, 9, /* a miss */ 0, 0.25f, 0.25f, 9, /* the first again */ 1, 0.75f, 0, 9};
    CHECK_EQ(bob::scatter(layout, pixels, samples.data(), 4, planes.data(), 2, 3), std::size_t{2});
    CHECK_EQ(bob::scatter(layout, pixels, samples.data(), 4, planes.data(), 2, 3), std::size_t{0});
    CHECK(planes == std::vector<float>({0, 1, 0, 0, 0, 1, /* x */ 0, 0, 0, 0, 0, 0.75f, /* y */ 0, 0, 0, 0, 0, 0}));
}

TEST(what_shines_where_a_ray_missed_is_kept) {
    const bob::Layout layout{bob::channels::mask, bob::channels::gray, bob::channels::depth, bob::channels::variance};
    std::vector<float> planes(4 * 2);
    const std::vector<bob::Pixel> pixels{{0, 1}, {0, 0}};
    const std::vector<float> samples{/* a miss */ 0, 0.25f, 0.5f, 2, /* a hit */ 1, 0.75f, 0.5f, 3};
    CHECK_EQ(bob::scatter(layout, pixels, samples.data(), 4, planes.data(), 1, 2), std::size_t{2});
    CHECK(planes == std::vector<float>({1, 1, 0.75f, 0.25f, 0.5f, 0, 3, 2}));
}

TEST(channels_are_selected_from_planes_without_copies_where_they_come_first) {
    const bob::Layout& layout = bob::gbuffer_layout();
    std::vector<float> planes{0, 1, 10, 11, 20, 21, 30, 31, 40, 41}, storage;
    CHECK(bob::select(layout, planes.data(), layout, 2, storage) == planes.data());
    CHECK(bob::select(layout, planes.data(), bob::Layout("mask,gray"), 2, storage) == planes.data());
    CHECK(storage.empty());
    static_cast<void>(bob::select(layout, planes.data(), bob::Layout("normal,gray"), 2, storage));
    CHECK(storage == std::vector<float>({30, 31, 40, 41, 10, 11}));
    bool refused = false;
    try {
        static_cast<void>(bob::select(bob::Layout("mask,gray"), planes.data(), layout, 2, storage));
    } catch (const std::invalid_argument& error) {
        refused = std::string(error.what()) == "expected a G-buffer with the channel depth, got one with mask,gray";
    }
    CHECK(refused);
}

namespace {

bob::Camera in_perspective(float fov, bob::Camera camera = {}) {
    camera.fov_degrees = fov;
    return camera;
}

bob::Camera standing(float fov, std::array<double, 3> position, std::array<double, 3> target, std::array<double, 3> up = {0, 0, 1}) {
    bob::Camera camera = in_perspective(fov);
    camera.standpoint = {position, target, up};
    return camera;
}

}  // namespace

TEST(points_on_a_pixels_ray_are_seen_at_that_pixel) {
    const bob::Camera cameras[] = {
        {}, {200, -70, 33, 1}, {0, 90, 0, 0.7f}, {30, 20, 10, 1.5f, 0.25f, -0.5f},
        in_perspective(35), in_perspective(60, {200, -70, 33, 1}), in_perspective(120, {0, 90, 0, 0.7f}),
        in_perspective(0.1f), in_perspective(20, {30, 20, 10, 1.5f, 0.25f, -0.5f}),
        standing(50, {3, 1, 2}, {0, 0.2, 0}), standing(90, {0.1, 0.2, -0.1}, {0.9, -0.1, 0.3}), standing(1, {90, 30, 40}, {0, 0, 0}),
        standing(70, {0, 0, 0.5}, {0, 0, -0.5}, {1, 1, 0}),
    };
    for (const bob::Camera& camera : cameras) {
        const bob::Projection projection(camera, 48, 61);
        const bool perspective = camera.fov_degrees > 0;
        const bool inside = camera.standpoint && std::hypot(camera.standpoint->position[0], camera.standpoint->position[1], camera.standpoint->position[2]) < 1;
        int rays = 0;
        for (int row = 0; row < 48; ++row) {
            for (int column = 0; column < 61; ++column) {
                bob::Ray ray;
                if (!projection.ray({row, column}, ray)) continue;
                ++rays;
                CHECK_NEAR(length(ray.direction), 1.f, 1e-6f);
                if (!inside) CHECK_LT(0.9999f, length(ray.origin));  // outside the unit sphere
                for (const float t : {0.1f, 0.4f}) {
                    const bob::Vec3 point = ray.origin + t * ray.direction;
                    const auto [seen_row, seen_column, depth] = projection.seen(point);
                    CHECK_NEAR(seen_row, static_cast<float>(row), 2e-3f);
                    CHECK_NEAR(seen_column, static_cast<float>(column), 2e-3f);
                    if (!perspective) CHECK_NEAR(depth, std::clamp(0.5f - 0.5f * dot(point, ray.direction), 0.f, 1.f), 1e-6f);
                    if (depth > 0 && depth < 1) CHECK_LT(length(projection.point(seen_row, seen_column, depth) - point), 2e-6f);
                }
                const float r = static_cast<float>(row), c = static_cast<float>(column);
                CHECK_LT(length(projection.on_screen(-ray.direction, r, c) - bob::Vec3{0, 0, 1}), 1e-6f);
                const bob::Vec3 direction = bob::normalized({0.3f, -0.5f, 0.8f}), there = projection.on_screen(direction, r, c);
                CHECK_NEAR(length(there), 1.f, 1e-6f);
                CHECK_NEAR(dot(there, {0, 0, 1}), -dot(direction, ray.direction), 1e-6f);
                CHECK_LT(length(projection.in_scene(there, r, c) - direction), 1e-6f);
            }
        }
        CHECK_LT(0, rays);
    }
}

TEST(an_orbiting_camera_in_perspective_stands_where_the_unit_sphere_fits) {
    // Half of 60 degrees has a sine of 1/2: the camera is 2 radii away, and the sphere's horizon at (1/2, sqrt(3)/2).
    const auto camera = in_perspective(60, {0, 0, 0, 1});
    const bob::Projection projection(camera, 100, 140);
    const auto check = [&](bob::Vec3 point, float row, float column, float depth) {
        const auto seen = projection.seen(point);
        CHECK_NEAR(seen.row, row, 1e-4f);
        CHECK_NEAR(seen.column, column, 1e-4f);
        CHECK_NEAR(seen.depth, depth, 1e-6f);
    };
    const float root = std::sqrt(0.75f);
    check({1, 0, 0}, 49.5f, 69.5f, 1);
    check({0, 0, 0}, 49.5f, 69.5f, 0.5f);
    check({-1, 0, 0}, 49.5f, 69.5f, 0);
    check({0.5f, 0, root}, -0.5f, 69.5f, 1 - (std::sqrt(3.f) - 1) / 2);
    check({0.5f, root, 0}, 49.5f, 119.5f, 1 - (std::sqrt(3.f) - 1) / 2);
    CHECK(std::isnan(projection.seen({2.5f, 0, 0}).row) && std::isnan(projection.seen({2, 0.5f, 0}).column));
    // In an upright picture it is the width that the sphere fills; the fov is the height's.
    const bob::Projection upright(camera, 100, 50);
    CHECK_NEAR(upright.seen({0, 0.5f, 0.5f}).column - 24.5f, 49.5f - upright.seen({0, 0.5f, 0.5f}).row, 1e-4f);
    bob::Ray ray;
    CHECK(upright.ray({49, 0}, ray) && upright.ray({49, 49}, ray));
    const double half = std::atan(std::tan(3.14159265358979 / 6) / 2);
    CHECK_NEAR(upright.seen({static_cast<float>(std::sin(half)), static_cast<float>(std::cos(half)), 0}).column, 49.5f, 1e-4f);
}

TEST(nothing_behind_a_camera_is_on_its_rays) {
    const bob::Projection away(standing(60, {2, 0, 0}, {3, 0, 0}), 20, 20);
    bob::Ray ray;
    for (int i = 0; i < 400; ++i) CHECK(!away.ray({i / 20, i % 20}, ray));
    const bob::Projection inside(standing(60, {0.5, 0, 0}, {1, 0, 0}), 20, 20);
    for (int i = 0; i < 400; ++i) {
        CHECK(inside.ray({i / 20, i % 20}, ray));
        CHECK(ray.origin.x == 0.5f && ray.origin.y == 0 && ray.origin.z == 0);
    }
}
