#include "completion/ratio.h"

#include <vector>

#include "check.h"
#include "parallel.h"

namespace {

const bob::Layout layout{bob::channels::mask, bob::channels::gray, bob::channels::color};

/// A picture of which a share is traced: gray, and colours by their ratios to it at each pixel.
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
        const float colored = std::min(shade, 0.625f), more = shade - colored;  // what is clearly brighter than around is white
        for (std::size_t i = 0; i < pixels; ++i) {
            const int column = static_cast<int>(i) % 128;
            if (column > 32 && column < 96) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const float completed = color[k * pixels + i];
                if (picture.planes[i] > 0) {
                    CHECK_EQ(completed, picture.planes[(2 + k) * pixels + i]);
                } else {
                    CHECK_NEAR(completed, ratio(column, k) * colored + more, 0.01f);
                }
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

TEST(nothing_traced_is_white) {
    const Picture picture(20, 30, 0, [](int, std::size_t) { return 0.f; });
    const std::vector<float> color = picture.completed();
    for (std::size_t i = 0; i < color.size(); ++i) CHECK_NEAR(color[i], picture.guide[i % picture.size()], 1e-6f);
}
