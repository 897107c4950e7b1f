#include "shapes/boxes.h"

#include <algorithm>
#include <limits>

#include "check.h"
#include "meshes.h"

using bob::Box;
using bob::Entrance;
using bob::Ray;
using bob::Vec3;

namespace {

std::vector<Box> random_boxes(int count, float size, std::uint64_t seed) {
    test::Random random(seed);
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) {
        const Vec3 low{random(-0.6f, 0.6f), random(-0.6f, 0.6f), random(-0.6f, 0.6f)};
        boxes.push_back({low, low + Vec3{random(0, size), random(0, size), random(0, size)}});
    }
    return boxes;
}

/// In the order of rays and then of boxes.
std::vector<Entrance> entrances(const bob::BoxBvh& bvh, const std::vector<Ray>& rays, std::size_t enough) {
    std::vector<Entrance> found;
    for (std::size_t i = 0; i < rays.size();) {
        std::vector<Entrance> some(enough + bvh.boxes);
        std::size_t count;
        i = bob::best_box_kernels().entrances(bvh, rays.data(), i, rays.size(), enough, some.data(), count);
        found.insert(found.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(count));
    }
    std::sort(found.begin(), found.end(), [](const Entrance& a, const Entrance& b) {
        return a.ray != b.ray ? a.ray < b.ray : a.box < b.box;
    });
    return found;
}

}  // namespace

TEST(boxes_entered_equal_brute_force_to_the_bit) {
    test::Random random(3);
    std::vector<Ray> rays;
    for (int i = 0; i < 300; ++i) {
        const Vec3 direction = random(0.2f, 5) * test::random_direction(random);
        const Vec3 target{random(-0.6f, 0.6f), random(-0.6f, 0.6f), random(-0.6f, 0.6f)};
        rays.push_back({target - random(0, 1.5f) * bob::normalized(direction), direction});
    }
    for (const int count : {1, 7, 8, 9, 32, 33, 300}) {
        const auto boxes = random_boxes(count, 0.4f, 5);
        const auto bvh = bob::build_box_bvh(boxes);
        std::vector<Entrance> want;
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            for (std::uint32_t k = 0; k < boxes.size(); ++k) {
                float enter = 0, leave = Box::infinity;
                for (int axis = 0; axis < 3; ++axis) {
                    const float reciprocal = 1 / rays[i].direction[axis];
                    const float a = (boxes[k].low[axis] - rays[i].origin[axis]) * reciprocal;
                    const float b = (boxes[k].high[axis] - rays[i].origin[axis]) * reciprocal;
                    enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
                }
                if (enter <= leave) want.push_back({k, i, enter});
            }
        }
        CHECK_LT(static_cast<std::size_t>(count), want.size());
        test::for_each_isa([&] {
            for (const std::size_t enough : {1, 100, 1'000'000}) {
                const auto found = entrances(bvh, rays, enough);
                CHECK_EQ(found.size(), want.size());
                int differ = 0;
                for (std::size_t i = 0; i < std::min(found.size(), want.size()); ++i) {
                    differ += found[i].box != want[i].box || found[i].ray != want[i].ray || found[i].t != want[i].t;
                }
                CHECK_EQ(differ, 0);
            }
        });
    }
}

TEST(rays_go_through_maps_as_points_do_to_the_bit) {
    test::Random random(7);
    bob::AffineMap map;
    for (auto& row : map.row) {
        for (double& x : row) x = random(-3, 3);
    }
    std::vector<Ray> rays;
    std::vector<Entrance> entrances;
    std::vector<float> start;
    for (std::uint32_t i = 0; i < 48; ++i) {
        rays.push_back({random(0, 2) * test::random_direction(random), random(0.2f, 5) * test::random_direction(random)});
        entrances.push_back({0, 47 - i, 0});
        start.push_back(i % 3 ? 0 : random(0, 100));
    }
    test::for_each_isa([&] {
        if (!bob::best_box_kernels().rays_through) return;
        for (const std::size_t count : {8, 48}) {
            std::vector<Ray> mapped(count);
            bob::best_box_kernels().rays_through(map, rays.data(), entrances.data(), start.data(), count, mapped.data());
            int differ = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const Ray& ray = rays[entrances[i].ray];
                const Vec3 origin = map.point(ray.origin, static_cast<double>(start[i]), ray.direction), direction = map.direction(ray.direction);
                for (int axis = 0; axis < 3; ++axis) {
                    differ += mapped[i].origin[axis] != origin[axis] || mapped[i].direction[axis] != direction[axis];
                }
            }
            CHECK_EQ(differ, 0);
        }
    });
}

TEST(rays_that_are_not_finite_list_no_more_than_there_are_boxes) {
    const float infinity = Box::infinity, nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<Ray> rays{{{nan, nan, nan}, {1, 0, 0}}, {{0, 0, 0}, {nan, nan, nan}},
                                {{infinity, 0, 0}, {1, 0, 0}}, {{1e38f, 1e38f, 1e38f}, {0, 0, 1e-30f}}};
    for (const int count : {3, 300}) {
        const auto bvh = bob::build_box_bvh(random_boxes(count, 0.4f, 6));
        test::for_each_isa([&] { CHECK(entrances(bvh, rays, 1).size() <= rays.size() * bvh.boxes); });
    }
}
