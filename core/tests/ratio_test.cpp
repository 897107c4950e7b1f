#include "completion/ratio.h"

#include <cstdlib>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "check.h"

namespace {

const bob::Layout layout{bob::channels::mask, bob::channels::gray, bob::channels::color};

/// A picture with a share of traced pixels: gray, and colours as ratios to it at each pixel.
struct Picture {
    int height, width;
    std::vector<float> planes, guide;

    template <class Ratio>
    Picture(int height, int width, float share, Ratio ratio, std::uint64_t seed = 1) : height(height), width(width) {
        const std::size_t pixels = size();
        planes.resize(5 * pixels), guide.resize(pixels);
        test::Random random(seed);
        for (std::size_t i = 0; i < pixels; ++i) {
            guide[i] = random(0.1f, 0.9f);
            if (random() >= share) continue;
            planes[i] = 1, planes[pixels + i] = guide[i];
            for (std::size_t k = 0; k < 3; ++k) planes[(2 + k) * pixels + i] = guide[i] * ratio(static_cast<int>(i) % width, k);
        }
    }

    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }

    [[nodiscard]] std::vector<float> completed(std::optional<float> unit = {}) const {
        std::vector<float> output(3 * size());
        bob::complete_by_ratio(layout, planes.data(), bob::channels::color, planes.data() + size(), guide.data(), unit,
                               height, width, output.data());
        return output;
    }
    [[nodiscard]] std::vector<float> completed_along() const {
        std::vector<float> output(3 * size(), -1);
        bob::complete_along(layout, planes.data(), bob::channels::color, planes.data() + size(), guide.data(), {}, height, width, output.data());
        return output;
    }
};

}  // namespace

TEST(what_is_gray_stays_gray) {
    for (const auto& [height, width] : {std::pair{1, 1}, {1, 7}, {6, 1}, {33, 50}, {64, 64}}) {
        const Picture picture(height, width, 0.1f, [](int, std::size_t) { return 1.f; });
        const std::vector<float> color = picture.completed();
        for (std::size_t i = 0; i < color.size(); ++i) CHECK_NEAR(color[i], picture.guide[i % picture.size()], 1e-5f);
    }
}

TEST(ratios_are_those_of_the_traced_pixels_around) {
    // Red on the left, blue on the right.
    const auto ratio = [](int column, std::size_t k) { return (column < 64) == (k == 0) && k != 1 ? 0.8f : 0.1f; };
    Picture picture(64, 128, 0.2f, ratio);
    const std::size_t pixels = picture.size();
    for (std::size_t i = 0; i < pixels; ++i) {
        if (picture.planes[i] == 0) continue;
        picture.planes[pixels + i] = 0.5f;
        for (std::size_t k = 0; k < 3; ++k) picture.planes[(2 + k) * pixels + i] = 0.5f * ratio(static_cast<int>(i) % 128, k);
    }
    for (const float shade : {0.f, 0.25f, 0.5f, 0.75f}) {
        picture.guide.assign(pixels, shade);
        const std::vector<float> color = picture.completed();
        const float colored = std::min(shade, 0.625f), more = shade - colored;  // pixels clearly brighter than their neighbours are white
        for (std::size_t i = 0; i < pixels; ++i) {
            const int column = static_cast<int>(i) % 128;
            if (column > 32 && column < 96) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const float completed = color[k * pixels + i];
                CHECK_NEAR(completed, ratio(column, k) * colored + more, 0.01f);
            }
        }
    }
}

TEST(nearer_pixels_have_more_of_a_say) {
    // One red pixel and one green, in a row of any length, wherever blocks begin.
    for (int red = 4; red < 12; ++red) {
        Picture picture(9, 40, 0, [](int, std::size_t) { return 0.f; });
        picture.guide.assign(picture.size(), 0.5f);
        const auto trace = [&](int column, std::size_t channel) {
            const std::size_t i = 4 * 40 + static_cast<std::size_t>(column);
            picture.planes[i] = 1, picture.planes[picture.size() + i] = 0.5f, picture.planes[(2 + channel) * picture.size() + i] = 0.5f;
        };
        const int green = red + 7;
        trace(red, 0), trace(green, 1);
        const std::vector<float> color = picture.completed();
        const auto share = [&](int column) { return color[4 * 40 + static_cast<std::size_t>(column)] / 0.5f; };  // of red
        for (int column = red; column < green; ++column) CHECK_LT(share(column + 1), share(column) + 1e-6f);
        CHECK_LT(0.95f, share(red + 1));
        CHECK_LT(share(green - 1), 0.05f);
        CHECK_LT(0.25f, share(red + 3));
        CHECK_LT(share(red + 4), 0.75f);
    }
}

TEST(ratios_do_not_depend_on_threads) {
    const Picture picture(200, 300, 0.05f, [](int column, std::size_t k) { return static_cast<float>(column % 7) / (7.f + static_cast<float>(k)); });
    const int threads = bob::thread_count();
    bob::set_thread_count(1);
    const std::vector<float> alone = picture.completed();
    bob::set_thread_count(3);
    CHECK_EQ(picture.completed() == alone, true);
    bob::set_thread_count(threads);
}

TEST(pictures_of_any_size_have_the_ratios_up_to_their_edges) {
    const float ratios[] = {1.4f, 1.f, 0.2f};
    for (const auto& [height, width] : {std::pair{5, 7}, {2, 64}, {9, 33}, {16, 17}, {31, 40}, {33, 50}, {18, 95}}) {
        Picture picture(height, width, 0.5f, [&](int, std::size_t k) { return ratios[k]; });
        picture.guide.assign(picture.size(), 0.4f);
        for (std::size_t i = 0; i < picture.size(); ++i) {
            if (picture.planes[i] == 0) continue;
            picture.planes[picture.size() + i] = 0.4f;
            for (std::size_t k = 0; k < 3; ++k) picture.planes[(2 + k) * picture.size() + i] = 0.4f * ratios[k];
        }
        const std::vector<float> color = picture.completed();
        for (std::size_t i = 0; i < color.size(); ++i) {
            CHECK_NEAR(color[i], ratios[i / picture.size()] * 0.4f, 0.03f);
        }
    }
}

TEST(values_of_any_range_are_completed_by_their_unit) {
    const float unit = 300;
    const Picture picture(40, 70, 0.1f, [](int column, std::size_t k) { return column < 30 ? 0.6f : 0.2f + 0.3f * static_cast<float>(k); });
    Picture large = picture;
    for (std::size_t i = picture.size(); i < large.planes.size(); ++i) large.planes[i] *= unit;
    for (float& value : large.guide) value *= unit;
    const std::vector<float> expected = picture.completed(), found = large.completed(unit);
    for (std::size_t i = 0; i < found.size(); ++i) CHECK_NEAR(found[i], unit * expected[i], 1e-5f * unit);
}

TEST(completed_colors_are_within_their_range) {
    Picture picture(12, 40, 0.1f, [](int, std::size_t) { return 1.f; });
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 0; i < picture.size(); ++i) picture.guide[i] = i % 3 == 0 ? 50.f : i % 3 == 1 ? -1.f : nan;
    const std::vector<float> color = picture.completed(), unbounded = picture.completed(1.f);
    for (std::size_t i = 0; i < color.size(); ++i) {
        const std::size_t pixel = i % picture.size();
        CHECK_EQ(color[i], pixel % 3 == 0 ? 1.f : 0.f);
        CHECK_NEAR(unbounded[i], pixel % 3 == 0 ? 50.f : 0.f, 1e-4f);
    }
}

TEST(only_colors_are_completed_by_ratio) {
    const Picture picture(2, 2, 1, [](int, std::size_t) { return 1.f; });
    std::vector<float> output(12);
    try {
        bob::complete_by_ratio(layout, picture.planes.data(), bob::channels::gray, picture.planes.data() + 4, picture.guide.data(), {}, 2,
                               2, output.data());
        CHECK(false);
    } catch (const std::invalid_argument& error) {
        CHECK(std::string_view(error.what()) == "gray: expected 3 components");
    }
}

TEST(nothing_traced_is_white) {
    const Picture picture(20, 30, 0, [](int, std::size_t) { return 0.f; });
    const std::vector<float> color = picture.completed();
    for (std::size_t i = 0; i < color.size(); ++i) CHECK_NEAR(color[i], picture.guide[i % picture.size()], 1e-6f);
}

TEST(traced_pixels_are_put_back_as_they_were) {
    // Out of range as well, and where the guide says black.
    for (const auto& [height, width] : {std::pair{1, 1}, {5, 7}, {33, 50}, {70, 161}, {64, 256}}) {
        Picture picture(height, width, 0.2f, [](int column, std::size_t k) { return static_cast<float>(column % 3) + static_cast<float>(k); });
        const std::size_t pixels = picture.size();
        for (std::size_t i = 0; i < pixels; ++i) {
            if (static_cast<int>(i) % width > width / 2) picture.guide[i] = picture.planes[pixels + i] = 0;
        }
        test::for_each_isa([&] {
            const std::vector<float> color = picture.completed_along();
            for (std::size_t i = 0; i < color.size(); ++i) {
                if (picture.planes[i % pixels] > 0) CHECK_EQ(color[i], picture.planes[2 * pixels + i]);
            }
        });
    }
}

TEST(what_is_black_beside_a_shape_changes_nothing_of_it) {
    for (const auto& [height, width] : {std::pair{37, 90}, {128, 333}, {200, 640}}) {
        // A slanted stripe; in the other picture both ends of each row are lit, too, so that nothing is left out. No pixel was traced there.
        Picture alone(height, width, 0.3f, [](int column, std::size_t k) { return static_cast<float>(column % 5) / (3 + static_cast<float>(k)); });
        const std::size_t pixels = alone.size();
        const auto is_shown = [&](std::size_t i) {
            const int row = static_cast<int>(i) / width, column = static_cast<int>(i) % width;
            return std::abs(column - width / 3 - row / 2) < width / 8 && row > height / 5 && row < 4 * height / 5;
        };
        for (std::size_t i = 0; i < pixels; ++i) {
            if (is_shown(i)) continue;
            alone.guide[i] = 0;
            const bool is_end = static_cast<int>(i) % width < 4 || static_cast<int>(i) % width >= width - 4;
            for (std::size_t plane = 0; plane < 5; ++plane) alone.planes[plane * pixels + i] = plane == 0 && !is_end && i % 7 == 0 ? 1.f : 0.f;
        }
        Picture among = alone;
        for (std::size_t row = 0; row < static_cast<std::size_t>(height); ++row) {
            const std::size_t line = static_cast<std::size_t>(width);
            among.guide[row * line] = among.guide[row * line + line - 1] = 0.5f;
        }
        test::for_each_isa([&] {
            for (const bool along : {false, true}) {
                (void)Picture(height, width, 0.5f, [](int, std::size_t) { return 0.7f; }).completed();  // leaves other values in memory
                const std::vector<float> some = along ? alone.completed_along() : alone.completed();
                const std::vector<float> all = along ? among.completed_along() : among.completed();
                std::size_t shown = 0;
                for (std::size_t i = 0; i < some.size(); ++i) {
                    const std::size_t column = i % static_cast<std::size_t>(width);
                    if (column > 0 && column + 1 < static_cast<std::size_t>(width)) CHECK_EQ(some[i], all[i]);
                    if (!is_shown(i % pixels)) CHECK_EQ(some[i], 0.f);
                    shown += some[i] > 0;
                }
                CHECK_LT(pixels / 4, shown);
            }
        });
    }
}
