#include "reprojection/history.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "base/isa.h"
#include "base/parallel.h"
#include "check.h"
#include "sampling/refresh.h"

namespace {

constexpr std::uint32_t height = 90, width = 120;
constexpr std::size_t pixels = std::size_t{height} * width;
const bob::Layout& layout() { return bob::gbuffer_layout(); }

struct Surface {
    float t;
    bob::Vec3 normal;
    float gray;
};
/// The first hit of a ray, in closed form.
using World = std::function<std::optional<Surface>(const bob::Ray&)>;

std::optional<Surface> ball(const bob::Ray& ray, bob::Vec3 center, float radius, float gray) {
    const bob::Vec3 from = ray.origin - center;
    const float b = dot(from, ray.direction), square = b * b - dot(from, from) + radius * radius;
    if (square < 0) return std::nullopt;
    const float t = -b - std::sqrt(square);
    const bob::Vec3 point = from + t * ray.direction;
    return Surface{t, (1 / radius) * point, gray};
}

/// A small light ball before a large dark one.
std::optional<Surface> two_balls(const bob::Ray& ray) {
    const auto front = ball(ray, {0.6f, 0, 0}, 0.2f, 0.9f), back = ball(ray, {-0.3f, 0, 0}, 0.5f, 0.2f);
    if (front && back) return front->t < back->t ? front : back;
    return front ? front : back;
}

void trace(const World& world, const bob::Camera& camera, std::span<const bob::Pixel> which, std::vector<float>& planes) {
    const bob::Projection projection(camera, height, width);
    for (const bob::Pixel pixel : which) {
        const std::size_t i = static_cast<std::size_t>(pixel.row) * width + static_cast<std::size_t>(pixel.column);
        for (std::size_t c = 0; c < 5; ++c) planes[c * pixels + i] = c == 0;
        bob::Ray ray;
        if (!projection.ray(pixel, ray)) continue;
        const auto found = world(ray);
        if (!found) continue;
        const auto row = static_cast<float>(pixel.row), column = static_cast<float>(pixel.column);
        const bob::Vec3 normal = projection.on_screen(found->normal, row, column);
        planes[pixels + i] = found->gray, planes[2 * pixels + i] = projection.depth(ray.origin + found->t * ray.direction);
        planes[3 * pixels + i] = normal.x, planes[4 * pixels + i] = normal.y;
    }
}

std::vector<bob::Pixel> every(int step) {
    std::vector<bob::Pixel> result;
    for (int row = 0; row < static_cast<int>(height); row += step) {
        for (int column = 0; column < static_cast<int>(width); column += step) result.push_back({row, column});
    }
    return result;
}

std::vector<float> traced(const World& world, const bob::Camera& camera, int step = 1) {
    std::vector<float> planes(5 * pixels);
    trace(world, camera, every(step), planes);
    return planes;
}

struct Expected {
    std::vector<float> planes = std::vector<float>(5 * pixels), off_center = std::vector<float>(pixels);
    std::size_t surfaces = 0;

    Expected(bob::History& history, const bob::Camera& camera) { surfaces = history.expect(camera, planes.data(), off_center.data()); }
};

bob::Camera camera_at(float azimuth, float fov = 0) { return {.azimuth_degrees = azimuth, .elevation_degrees = 10, .fov_degrees = fov}; }

}  // namespace

TEST(a_camera_that_stands_still_expects_what_it_has_seen) {
    for (const float fov : {0.f, 60.f}) {
        bob::History history(layout(), height, width);
        const auto planes = traced(two_balls, camera_at(10, fov));
        history.add(camera_at(10, fov), planes.data());
        const Expected expected(history, camera_at(10, fov));
        std::size_t surfaces = 0;
        for (std::size_t i = 0; i < pixels; ++i) {
            surfaces += planes[2 * pixels + i] > 0;
            CHECK_EQ(expected.planes[i], 1);
            for (std::size_t c = 1; c < 5; ++c) CHECK_NEAR(expected.planes[c * pixels + i], planes[c * pixels + i], 2e-5f);
            if (planes[2 * pixels + i] > 0) CHECK_LT(expected.off_center[i], 2e-2f);
        }
        CHECK_EQ(expected.surfaces, surfaces);
    }
}

TEST(surfaces_are_expected_where_a_camera_that_moved_sees_them) {
    for (const float fov : {0.f, 60.f}) {
        for (const float step : {2.f, 6.f}) {
            bob::History history(layout(), height, width);
            history.add(camera_at(10, fov), traced(two_balls, camera_at(10, fov)).data());
            const Expected expected(history, camera_at(10 + step, fov));
            const auto truth = traced(two_balls, camera_at(10 + step, fov));
            std::size_t right = 0, wrong = 0, missing = 0;
            for (std::size_t i = 0; i < pixels; ++i) {
                if (expected.planes[i] == 0) {
                    ++missing;
                    continue;
                }
                const bool is_same = std::fabs(expected.planes[pixels + i] - truth[pixels + i]) < 1e-6f &&
                                     std::fabs(expected.planes[2 * pixels + i] - truth[2 * pixels + i]) < 0.06f;
                ++(is_same ? right : wrong);
            }
            CHECK_LT(pixels * 85 / 100, right);
            CHECK_LT(wrong, pixels / 100);
            CHECK_LT(missing, pixels * 15 / 100);
        }
    }
}

TEST(what_comes_from_behind_a_surface_leaves_no_ghost) {
    // The light ball moves across the dark one, and few points of the dark one are known. No dark point may shine
    // through, and nothing light may remain at the light ball's old place.
    bob::History history(layout(), height, width);
    auto planes = traced(two_balls, camera_at(-30), 3);
    history.add(camera_at(-30), planes.data());
    for (float azimuth = -28; azimuth <= 30; azimuth += 2) {
        const Expected expected(history, camera_at(azimuth));
        const auto truth = traced(two_balls, camera_at(azimuth));
        std::size_t ghosts = 0, known = 0;
        for (std::size_t i = 0; i < pixels; ++i) {
            if (expected.planes[2 * pixels + i] == 0) continue;
            ++known;
            // Not within a pixel of an edge.
            bool is_wrong = true;
            for (const std::ptrdiff_t by : {std::ptrdiff_t{0}, std::ptrdiff_t{1}, std::ptrdiff_t{-1}, std::ptrdiff_t{width}, -std::ptrdiff_t{width}}) {
                const auto j = static_cast<std::ptrdiff_t>(i) + by;
                if (j < 0 || j >= static_cast<std::ptrdiff_t>(pixels)) continue;
                is_wrong = is_wrong && std::fabs(expected.planes[pixels + i] - truth[pixels + static_cast<std::size_t>(j)]) > 0.1f;
            }
            ghosts += is_wrong;
        }
        CHECK_LT(pixels / 100, known);
        CHECK_LT(ghosts, 4 + known / 50);
        planes = traced(two_balls, camera_at(azimuth), 3);
        history.add(camera_at(azimuth), planes.data());
    }
}

TEST(emptiness_gives_way_to_what_moves_over_it) {
    // From the side the small ball is next to the large one; then it passes in front of it.
    bob::History history(layout(), height, width);
    history.add(camera_at(90), traced(two_balls, camera_at(90)).data());
    for (float azimuth = 86; azimuth >= 50; azimuth -= 4) {
        const Expected expected(history, camera_at(azimuth));
        const auto truth = traced(two_balls, camera_at(azimuth));
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < pixels; ++i) {
            wrong += expected.planes[i] != 0 && expected.planes[2 * pixels + i] == 0 && truth[2 * pixels + i] > 0;
        }
        CHECK_LT(wrong, pixels / 60);
        const auto few = traced(two_balls, camera_at(azimuth), 4);
        history.add(camera_at(azimuth), few.data());
    }
}

TEST(a_history_has_at_most_a_point_for_each_pixel) {
    bob::History history(layout(), height, width);
    std::size_t bytes = 0;
    for (int k = 0; k < 40; ++k) {
        const bob::Camera camera = camera_at(static_cast<float>(2 * k));
        history.add(camera, traced(two_balls, camera).data());
        const Expected expected(history, camera_at(static_cast<float>(2 * k + 2)));
        if (k == 20) bytes = history.bytes();
    }
    CHECK_LT(history.bytes(), bytes + bytes / 2);
    history.clear();
    const Expected expected(history, camera_at(0));
    CHECK_EQ(expected.surfaces, 0u);
}

TEST(edges_are_expected_to_be_as_likely_as_they_are) {
    // A light half of a wall next to a dark one, seen half a pixel away from the pixels' centres.
    const World wall = [](const bob::Ray& ray) {
        const float along = (0.1f - ray.origin.x) / ray.direction.x;
        const float side = ray.origin.y + along * ray.direction.y;
        return Surface{along, {1, 0, 0}, side > 0 ? 0.9f : 0.1f};
    };
    bob::Camera camera;
    camera.azimuth_degrees = camera.elevation_degrees = 0;
    bob::History history(layout(), height, width);
    history.add(camera, traced(wall, camera).data());
    camera.pan_x = 1.f / height;  // half a pixel
    const Expected expected(history, camera);
    const float* const row = expected.planes.data() + pixels + height / 2 * width;
    std::size_t between = 0, dark = 0, light = 0;
    for (std::size_t column = width / 2 - 20; column < width / 2 + 20; ++column) {
        dark += std::fabs(row[column] - 0.1f) < 1e-6f, light += std::fabs(row[column] - 0.9f) < 1e-6f;
        between += row[column] > 0.4f && row[column] < 0.6f;
    }
    CHECK_EQ(between, 1u);
    CHECK_EQ(dark + light, 39u);
}

TEST(what_is_expected_is_the_same_in_any_instruction_set_and_in_any_number_of_threads) {
    const int threads = bob::thread_count();
    const bob::Isa best = bob::isa();
    for (const float fov : {0.f, 60.f}) {
        std::vector<float> first;
        for (const bob::Isa isa : {bob::Isa::baseline, bob::Isa::avx2, bob::Isa::avx512}) {
            if (!bob::set_isa(isa)) continue;
            for (const int count : {1, 3}) {
                bob::set_thread_count(count);
                bob::History history(layout(), height, width);
                history.add(camera_at(10, fov), traced(two_balls, camera_at(10, fov), 2).data());
                const Expected expected(history, camera_at(13, fov));
                if (first.empty()) first = expected.planes;
                CHECK_EQ(first == expected.planes, true);
            }
        }
    }
    bob::set_isa(best), bob::set_thread_count(threads);
}

TEST(after_a_jump_nothing_is_expected) {
    bob::History history(layout(), height, width);
    history.add(camera_at(0), traced(two_balls, camera_at(0)).data());
    const Expected expected(history, camera_at(130));
    CHECK_EQ(expected.surfaces, 0u);
    for (std::size_t i = 0; i < pixels; ++i) CHECK_EQ(expected.planes[i], 0);
}

TEST(what_was_seen_with_another_camera_is_forgotten_if_it_was_not_expected_with_this) {
    bob::History history(layout(), height, width);
    history.add(camera_at(0), traced(two_balls, camera_at(0)).data());
    history.add(camera_at(50), std::vector<float>(5 * pixels).data());
    CHECK_EQ(Expected(history, camera_at(50)).surfaces, 0u);
}

TEST(refreshing_ends_with_every_pixel_once) {
    for (const auto& [h, w] : {std::pair{1, 1}, {1, 50}, {37, 3}, {64, 130}}) {
        const auto n = static_cast<std::size_t>(h * w);
        std::vector<float> done(5 * n), picture(5 * n), off_center(n);
        test::Random random(5);
        for (std::size_t i = 0; i < n; ++i) {
            picture[i] = random() < 0.5f, picture[n + i] = picture[i] * random(), picture[2 * n + i] = picture[i] * 0.5f;
        }
        bob::RefreshOrder order(static_cast<std::uint32_t>(h), static_cast<std::uint32_t>(w));
        std::size_t total = 0;
        while (total < n) {
            const std::size_t wanted = n / 5 + 1, count = std::min(wanted <= n / 64 ? wanted : (wanted + 1) / 2, n - total);
            const auto round = order.next(layout(), done.data(), picture.data(), off_center.data(), wanted);
            CHECK_EQ(round.size(), count);
            if (round.size() != count) return;
            for (const auto [row, column] : round) {
                const std::size_t i = static_cast<std::size_t>(row * w + column);
                CHECK_EQ(done[i], 0);
                done[i] = picture[i] = 1, picture[n + i] = done[n + i] = random();
            }
            total += round.size();
        }
        CHECK_EQ(order.next(layout(), done.data(), picture.data(), off_center.data(), 10).size(), 0u);
    }
}

TEST(refreshing_goes_along_edges_and_where_nothing_is_expected) {
    auto picture = traced(two_balls, camera_at(10));
    const auto is_edge = [&](std::size_t row, std::size_t column) {
        if (row == 0 || column == 0 || row + 1 == height || column + 1 == width) return false;
        float low = 1, high = 0;
        for (std::size_t r = row - 1; r <= row + 1; ++r) {
            for (std::size_t c = column - 1; c <= column + 1; ++c) {
                low = std::min(low, picture[pixels + r * width + c]), high = std::max(high, picture[pixels + r * width + c]);
            }
        }
        return high > low + 0.1f;
    };
    std::vector<float> done(5 * pixels), off_center(pixels, 0.4f);
    bob::RefreshOrder order(height, width);
    std::size_t edges = 0;
    for (const auto [row, column] : order.next(layout(), done.data(), picture.data(), off_center.data(), 150)) {
        edges += is_edge(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
    }
    CHECK_LT(145u, edges);

    // A hole in the middle of the picture, half of it light.
    const auto in_hole = [](std::size_t row, std::size_t column) { return row >= 30 && row < 50 && column >= 50 && column < 80; };
    for (std::size_t row = 0; row < height; ++row) {
        for (std::size_t column = 0; column < width; ++column) {
            const std::size_t i = row * width + column;
            picture[i] = !in_hole(row, column), picture[pixels + i] = in_hole(row, column) ? 0 : 0.5f, picture[2 * pixels + i] = picture[pixels + i];
        }
    }
    std::size_t inside = 0;
    bob::RefreshOrder of_hole(height, width);
    for (const auto [row, column] : of_hole.next(layout(), done.data(), picture.data(), off_center.data(), 100)) {
        inside += in_hole(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
    }
    CHECK_LT(95u, inside);
}
