#include "sampling/adaptive.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "base/sha256.h"
#include "check.h"

namespace {

/// A picture as a tracer would give it: gray and whether something was hit, by row and column.
std::vector<float> planes_of(int height, int width, const std::function<float(int, int)>& gray) {
    const auto n = static_cast<std::size_t>(height * width);
    std::vector<float> planes(5 * n);
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            const auto i = static_cast<std::size_t>(row * width + column);
            planes[n + i] = gray(row, column);
            planes[2 * n + i] = planes[n + i] > 0 ? 0.5f : 0.f;
        }
    }
    return planes;
}

std::vector<bob::Pixel> sequence(int height, int width, const std::vector<float>& planes, std::size_t count, int* rounds = nullptr,
                                 bob::AdaptiveOrder::Likeness likeness = {}) {
    bob::AdaptiveOrder order(7, static_cast<std::uint32_t>(height), static_cast<std::uint32_t>(width), std::move(likeness));
    std::vector<bob::Pixel> result;
    int calls = 0;
    while (result.size() < count) {
        const auto round = order.next(bob::gbuffer_layout(), planes.data());
        if (round.empty()) break;
        result.insert(result.end(), round.begin(), round.end());
        ++calls;
    }
    if (rounds) *rounds = calls;
    result.resize(std::min(result.size(), count));
    return result;
}

}  // namespace

TEST(adaptive_orders_visit_every_pixel_once) {
    for (const auto& [height, width] : {std::pair{1, 1}, {1, 50}, {64, 64}, {65, 130}, {37, 3}}) {
        const auto planes = planes_of(height, width, [](int row, int column) { return static_cast<float>((row * column) % 7) / 7; });
        const auto total = static_cast<std::size_t>(height * width);
        std::vector<int> seen(total);
        for (const auto [row, column] : sequence(height, width, planes, 2 * total)) {
            ++seen[static_cast<std::size_t>(row * width + column)];
        }
        CHECK_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(total));
    }
}

TEST(adaptive_orders_ask_seldom) {
    const auto planes = planes_of(256, 256, [](int row, int column) { return row > column ? 0.8f : 0.f; });
    int rounds = 0;
    (void)sequence(256, 256, planes, 256 * 256 / 20, &rounds);
    CHECK_LT(rounds, 9);
    (void)sequence(256, 256, planes, 256 * 256 / 4, &rounds);
    CHECK_LT(rounds, 17);
}

TEST(an_adaptive_order_follows_an_edge) {
    // A silhouette, a step of gray, both slanted.
    for (const float other : {0.f, 0.6f}) {
        const auto far = [](int row, int column) { return std::fabs(0.9f * static_cast<float>(column) + 0.4f * static_cast<float>(row) - 170); };
        const auto planes = planes_of(256, 256, [&](int row, int column) { return 0.9f * static_cast<float>(column) + 0.4f * static_cast<float>(row) < 170 ? 0.8f : other; });
        const auto pixels = sequence(256, 256, planes, 256 * 256 / 20);
        const auto near = std::count_if(pixels.begin(), pixels.end(), [&](bob::Pixel p) { return far(p.row, p.column) < 4; });
        CHECK_LT(5 * 256 * 256 / 20 * 8 / 256, near);  // five times a lattice's
        std::vector<bool> traced(256 * 256);
        for (const auto [row, column] : pixels) traced[static_cast<std::size_t>(row * 256 + column)] = true;
        int on_edge = 0, found = 0;
        for (int i = 0; i < 256 * 256; ++i) {
            on_edge += far(i / 256, i % 256) < 0.5f;
            found += far(i / 256, i % 256) < 0.5f && traced[static_cast<std::size_t>(i)];
        }
        CHECK_LT((other > 0 ? 0.45 : 0.95) * on_edge, found);
    }
}

TEST(an_adaptive_order_follows_a_wire_to_its_ends) {
    // One pixel wide, so it lies mostly between the pixels of any coarse lattice.
    const auto on_wire = [](int row, int column) { return row > 20 && row < 235 && column == 60 + row / 2; };
    const auto planes = planes_of(256, 256, [&](int row, int column) { return on_wire(row, column) ? 0.8f : 0.f; });
    int found = 0;
    for (const auto [row, column] : sequence(256, 256, planes, 256 * 256 / 5)) found += on_wire(row, column);
    CHECK_LT(200, found);  // of 214
}

TEST(where_nothing_is_an_adaptive_order_is_the_lattice) {
    const auto planes = planes_of(128, 192, [](int, int) { return 0.f; });
    const std::size_t quarter = 128 * 192 / 4;
    std::vector<bob::Pixel> lattice(quarter);
    bob::make_order("lattice", 7, 128, 192)(0, lattice);
    std::vector<bool> chosen(128 * 192);
    for (const auto [row, column] : sequence(128, 192, planes, quarter)) chosen[static_cast<std::size_t>(row * 192 + column)] = true;
    const auto missing = std::ranges::count_if(lattice, [&](bob::Pixel p) { return !chosen[static_cast<std::size_t>(p.row * 192 + p.column)]; });
    CHECK_LT(missing, 5);  // at the picture's corners, where all four corners of a pixel may lie outside
}

TEST(an_adaptive_order_is_the_same_everywhere) {
    const auto planes = planes_of(100, 150, [](int row, int column) { return static_cast<float>((row * row + 3 * column) % 256) / 255; });
    const auto pixels = sequence(100, 150, planes, 100 * 150);
    bob::Sha256 digest;
    for (const auto [row, column] : pixels) {
        const std::byte bytes[] = {static_cast<std::byte>(row), static_cast<std::byte>(column)};
        digest.update(bytes);
    }
    CHECK_EQ(digest.digest()[0] * 256 + digest.digest()[1], 37256);
}

TEST(what_is_like_no_corner_comes_first) {
    // All pixels show the same, and the surface is another one on thin bars, which most corners miss.
    const auto planes = planes_of(256, 256, [](int, int) { return 0.5f; });
    const auto is_bar = [](bob::Pixel pixel) { return pixel.column % 64 / 2 == 1; };
    const auto on_bars = [&](bob::AdaptiveOrder::Likeness likeness) {
        const auto pixels = sequence(256, 256, planes, 256 * 256 / 14, nullptr, std::move(likeness));
        return static_cast<double>(std::ranges::count_if(pixels, is_bar)) / static_cast<double>(pixels.size());
    };
    const double blind = on_bars({});
    const double knowing = on_bars([&](bob::Pixel own, bob::Pixel other) { return is_bar(own) == is_bar(other) ? 1.f : 0.f; });
    CHECK_LT(blind, 0.01);
    CHECK_LT(0.04, knowing);
    // A channel that is the same everywhere changes nothing.
    CHECK_EQ(on_bars([](bob::Pixel, bob::Pixel) { return 1.f; }), blind);
}
