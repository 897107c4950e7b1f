#include "check.h"
#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"

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
    const std::vector<float> samples{1, 0.5f, -0.5f, /* a miss */ 0, 0.25f, 0.25f, /* the first again */ 1, 0.75f, 0};
    CHECK_EQ(bob::scatter(layout, pixels, samples.data(), planes.data(), 2, 3), std::size_t{2});
    CHECK_EQ(bob::scatter(layout, pixels, samples.data(), planes.data(), 2, 3), std::size_t{0});
    CHECK(planes == std::vector<float>({0, 1, 0, 0, 0, 1, /* x */ 0, 0, 0, 0, 0, 0.75f, /* y */ 0, 0, 0, 0, 0, 0}));
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

TEST(points_on_a_pixels_ray_are_seen_at_that_pixel) {
    for (const bob::Camera camera : {bob::Camera{}, bob::Camera{200, -70, 33, 1}, bob::Camera{0, 90, 0, 0.7f},
                                    bob::Camera{30, 20, 10, 1.5f, 0.25f, -0.5f}}) {
        const bob::Projection projection(camera, 48, 61);
        int rays = 0;
        for (int row = 0; row < 48; ++row) {
            for (int column = 0; column < 61; ++column) {
                bob::Ray ray;
                if (!projection.ray({row, column}, ray)) continue;
                ++rays;
                CHECK_NEAR(length(ray.direction), 1.f, 1e-6f);
                CHECK_LT(0.9999f, length(ray.origin));  // outside the unit sphere
                for (const float t : {0.f, 0.4f}) {
                    const bob::Vec3 point = ray.origin + t * ray.direction;
                    const auto [seen_row, seen_column, depth] = projection.seen(point);
                    CHECK_NEAR(seen_row, static_cast<float>(row), 1e-3f);
                    CHECK_NEAR(seen_column, static_cast<float>(column), 1e-3f);
                    CHECK_NEAR(depth, std::clamp(0.5f - 0.5f * dot(point, ray.direction), 0.f, 1.f), 1e-6f);
                }
                CHECK_NEAR(projection.on_screen(ray.direction).z, -1.f, 1e-6f);
            }
        }
        CHECK_LT(0, rays);
    }
}
