#include "sampling/order.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "check.h"

TEST(uniform_order_is_a_permutation) {
    for (const std::uint32_t size : {1u, 2u, 3u, 5u, 16u, 97u, 640u * 48u, 65537u}) {
        for (const std::uint64_t seed : {0ull, 1ull, ~0ull}) {
            const bob::UniformOrder order(seed, size, 1);
            std::vector<bool> seen(size);
            for (std::uint32_t i = 0; i < size; ++i) {
                const std::uint32_t pixel = order(i);
                CHECK_LT(pixel, size);
                seen[pixel] = true;
            }
            CHECK_EQ(static_cast<std::uint32_t>(std::accumulate(seen.begin(), seen.end(), 0)), size);
        }
    }
}

TEST(orders_visit_every_pixel_once_and_start_anywhere) {
    for (const char* name : {"uniform", "lattice"}) {
        for (const auto& [height, width] : {std::pair{1u, 1u}, {5u, 7u}, {1u, 200u}, {64u, 64u}, {65u, 127u}, {130u, 600u}}) {
            const bob::Order order = bob::make_order(name, 3, height, width);
            std::vector<bob::Pixel> pixels(height * width);
            order(0, pixels);
            std::vector<bool> seen(pixels.size());
            for (std::uint32_t i = 0; i < pixels.size(); ++i) {
                CHECK(pixels[i].row >= 0 && pixels[i].row < static_cast<int>(height));
                CHECK(pixels[i].column >= 0 && pixels[i].column < static_cast<int>(width));
                seen[pixels[i].row * width + pixels[i].column] = true;
                bob::Pixel alone[1];
                order(i, alone);
                CHECK(alone->row == pixels[i].row && alone->column == pixels[i].column);
            }
            CHECK(std::find(seen.begin(), seen.end(), false) == seen.end());
        }
    }
}
