#include "sampling/squares.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <utility>
#include <vector>

#include "base/sha256.h"
#include "check.h"
#include "sampling/order.h"

namespace {

/// Gray and whether something was hit, by row and column.
using Scene = std::function<float(int, int)>;

/// The rounds for a picture whose traced pixels alone are known.
std::vector<std::vector<bob::Pixel>> rounds_of(int height, int width, const Scene& scene, float untraced = 0,
                                               bob::SquaresOrder::First first = bob::SquaresOrder::First::contrast) {
    const auto n = static_cast<std::size_t>(height * width);
    std::vector<float> planes(5 * n, untraced);
    bob::SquaresOrder order(static_cast<std::uint32_t>(height), static_cast<std::uint32_t>(width), nullptr, first);
    std::vector<std::vector<bob::Pixel>> result;
    while (true) {
        const auto round = order.next(bob::gbuffer_layout(), planes.data());
        if (round.empty()) return result;
        result.emplace_back(round.begin(), round.end());
        for (const auto [row, column] : round) {
            const auto i = static_cast<std::size_t>(row * width + column);
            planes[i] = 1, planes[n + i] = scene(row, column), planes[2 * n + i] = planes[n + i] > 0 ? 0.5f : 0.f;
            planes[3 * n + i] = planes[4 * n + i] = 0;
        }
    }
}

float pattern(int row, int column) { return static_cast<float>((row * row + 3 * column) % 256) / 255; }

bool is_before(bob::Pixel a, bob::Pixel b) { return std::pair(a.row, a.column) < std::pair(b.row, b.column); }

}  // namespace

TEST(squares_visit_every_pixel_once) {
    for (const auto& [height, width] : {std::pair{1, 1}, {1, 50}, {5, 5}, {6, 9}, {64, 64}, {65, 130}, {37, 3}}) {
        for (const Scene& scene : {Scene(pattern), Scene([](int, int) { return 0.f; })}) {
            for (const auto first : {bob::SquaresOrder::First::contrast, bob::SquaresOrder::First::priority}) {
                std::vector<int> seen(static_cast<std::size_t>(height * width));
                for (const auto& round : rounds_of(height, width, scene, 0, first)) {
                    CHECK(std::ranges::is_sorted(round, is_before));
                    for (const auto [row, column] : round) ++seen[static_cast<std::size_t>(row * width + column)];
                }
                CHECK_EQ(std::ranges::count(seen, 1), static_cast<std::ptrdiff_t>(seen.size()));
            }
        }
    }
}

TEST(squares_begin_with_the_lattice_and_ask_seldom) {
    const auto rounds = rounds_of(128, 192, pattern);
    std::vector<bob::Pixel> lattice(128 * 192 / 64);
    bob::make_order("lattice", 7, 128, 192)(0, lattice);
    std::ranges::sort(lattice, is_before);
    CHECK(std::ranges::equal(rounds[0], lattice, [](bob::Pixel a, bob::Pixel b) { return a.row == b.row && a.column == b.column; }));
    CHECK_LT(rounds.size(), std::size_t{17});
    CHECK_EQ(rounds_of(128, 192, [](int, int) { return 0.5f; }).size(), std::size_t{4});  // nothing differs
}

TEST(squares_are_divided_along_edges_the_clearest_first) {
    // A silhouette and a step of gray, both slanted.
    const auto to_silhouette = [](int row, int column) { return 0.9f * static_cast<float>(column) + 0.4f * static_cast<float>(row) - 90; };
    const auto to_step = [](int row, int column) { return 0.9f * static_cast<float>(column) + 0.4f * static_cast<float>(row) - 200; };
    const auto rounds = rounds_of(256, 256, [&](int row, int column) {
        return to_silhouette(row, column) < 0 ? 0.f : to_step(row, column) < 0 ? 0.5f : 0.64f;
    });
    std::vector<int> round_of(256 * 256);
    for (std::size_t k = 0; k < rounds.size(); ++k) {
        for (const auto [row, column] : rounds[k]) round_of[static_cast<std::size_t>(row * 256 + column)] = static_cast<int>(k);
    }
    // Round 0 is the lattice. Three rounds divide squares that differ clearly, and three divide visible differences.
    int of_silhouette = 0, of_step = 0, elsewhere = 0, late = 0;
    for (int i = 0; i < 256 * 256; ++i) {
        const float silhouette = std::fabs(to_silhouette(i / 256, i % 256)), step = std::fabs(to_step(i / 256, i % 256));
        const int round = round_of[static_cast<std::size_t>(i)];
        if (silhouette < 0.9f) {
            ++of_silhouette;
            late += round > 3;
        } else if (step < 0.9f) {
            ++of_step;
            late += round > 6;
            CHECK(round == 0 || round > 3);
        } else if (std::min(silhouette, step) > 12) {
            ++elsewhere;
            CHECK(round == 0 || round > 6);
        }
    }
    CHECK_LT(50 * late, of_silhouette + of_step);  // squares that an edge barely touches, and squares at the border
    CHECK(of_silhouette > 200 && of_step > 200 && elsewhere > 40'000);
}

TEST(by_priority_large_squares_come_before_small_ones_that_differ_as_much) {
    // A gentle slope on the left, a step of gray on the right.
    const auto rounds = rounds_of(256, 256, [](int, int column) {
        return column < 128 ? 0.2f + 0.003f * static_cast<float>(column) : column < 192 ? 0.3f : 0.5f;
    }, 0, bob::SquaresOrder::First::priority);
    CHECK_EQ(rounds[0].size(), std::size_t{256});  // every 16th pixel and row
    const auto between_columns = [&](std::size_t begin, std::size_t end, int left, int right) {
        std::ptrdiff_t count = 0;
        for (std::size_t k = begin; k < end; ++k) {
            count += std::ranges::count_if(rounds[k], [&](bob::Pixel p) { return p.column >= left && p.column < right; });
        }
        return count;
    };
    // Squares of 16 divide at both, squares of 8 only at the step: over 8 pixels the slope differs by 6 of 255.
    CHECK_LT(250, between_columns(1, 2, 8, 120));
    CHECK_LT(20, between_columns(1, 2, 176, 208));
    CHECK_EQ(between_columns(2, 3, 8, 112), 0);
    CHECK_LT(40, between_columns(2, 3, 184, 200));
    CHECK_EQ(between_columns(3, 4, 8, 112), 0);  // then squares of 4, when 48 suffice
    CHECK_LT(40, between_columns(3, 4, 188, 196));
}

TEST(what_was_not_traced_is_not_read) {
    const auto rounds = rounds_of(100, 150, pattern), with_others = rounds_of(100, 150, pattern, 0.7f);
    CHECK_EQ(rounds.size(), with_others.size());
    for (std::size_t k = 0; k < rounds.size(); ++k) {
        CHECK(std::ranges::equal(rounds[k], with_others[k], [](bob::Pixel a, bob::Pixel b) { return a.row == b.row && a.column == b.column; }));
    }
}

TEST(squares_are_the_same_everywhere) {
    for (const auto& [first, expected] : {std::pair{bob::SquaresOrder::First::contrast, 13242}, {bob::SquaresOrder::First::priority, 41130}}) {
        bob::Sha256 digest;
        for (const auto& round : rounds_of(100, 150, pattern, 0, first)) {
            for (const auto [row, column] : round) {
                const std::byte bytes[] = {static_cast<std::byte>(row), static_cast<std::byte>(column)};
                digest.update(bytes);
            }
        }
        const auto bytes = digest.digest();
        CHECK_EQ(bytes[0] * 256 + bytes[1], expected);
    }
}
