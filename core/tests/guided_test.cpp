#include "completion/guided.h"

#include <cmath>
#include <vector>

#include "check.h"
#include "completion/guided_surfaces.h"

namespace {

const bob::Layout traced{bob::channels::mask, bob::channels::color, bob::channels::variance};
const bob::Layout known{bob::channels::mask, bob::channels::depth, bob::channels::normal, bob::channels::albedo};

/// A picture with a share of traced pixels, and its guides: two surfaces side by side, one twenty times as bright.
struct Picture {
    int height, width;
    std::vector<float> planes, guides;

    Picture(int height, int width, float share, float variance = 0) : height(height), width(width) {
        planes.resize(5 * size()), guides.resize(7 * size());
        test::Random random(3);
        for (std::size_t i = 0; i < size(); ++i) {
            const bool left = is_left(i);
            guides[i] = 1, guides[size() + i] = left ? 0.25f : 0.75f;
            guides[2 * size() + i] = left ? -0.5f : 0.5f;
            for (std::size_t k = 4; k < 7; ++k) guides[k * size() + i] = random(0.5f, 0.6f);
            if (random() >= share) continue;
            planes[i] = 1, planes[4 * size() + i] = variance;
            for (std::size_t k = 0; k < 3; ++k) planes[(1 + k) * size() + i] = light(i) * guides[(4 + k) * size() + i];
        }
    }

    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }
    [[nodiscard]] bool is_left(std::size_t i) const { return 2 * (i % static_cast<std::size_t>(width)) < static_cast<std::size_t>(width); }
    [[nodiscard]] float light(std::size_t i) const { return is_left(i) ? 2.f : 0.1f; }

    [[nodiscard]] std::vector<float> completed() const {
        std::vector<float> output(3 * size(), -1);
        bob::complete_guided(traced, planes.data(), known, guides.data(), bob::channels::color, height, width, false, output.data());
        return output;
    }
};

}  // namespace

TEST(light_does_not_pass_from_one_surface_to_another) {
    const Picture picture(40, 60, 0.2f);
    const std::vector<float> color = picture.completed();
    for (std::size_t i = 0; i < color.size(); ++i) {
        const float wanted = picture.light(i % picture.size()) * picture.guides[4 * picture.size() + i];
        CHECK_NEAR(color[i], wanted, 0.05f);  // a fortieth of the brighter one
    }
}

TEST(exact_pixels_keep_their_values_and_noisy_ones_are_averaged) {
    for (const auto& [height, width] : {std::pair{1, 1}, {1, 7}, {6, 1}, {9, 17}, {33, 50}}) {
        const Picture exact(height, width, 0.3f), noisy(height, width, 0.3f, 1e4f);
        const std::vector<float> color = exact.completed(), averaged = noisy.completed();
        for (std::size_t i = 0; i < color.size(); ++i) {
            if (exact.planes[i % exact.size()] > 0) CHECK_EQ(color[i], exact.planes[exact.size() + i]);
            CHECK(std::isfinite(color[i]) && std::isfinite(averaged[i]) && averaged[i] >= 0);
        }
    }
}

TEST(nothing_is_made_of_nothing) {
    const std::vector<float> color = Picture(8, 12, 0).completed();
    for (const float value : color) CHECK_EQ(value, 0.f);
}

TEST(light_between_fitted_places_follows_position_and_normal) {
    // A wavy surface beside a darker one. Noisy samples are fitted at a few places, far apart.
    Picture picture(64, 96, 0.2f, 0.1f);
    const std::size_t pixels = picture.size();
    const auto tilt = [&](std::size_t i) { return picture.is_left(i) ? 0.3f * std::sin(0.2f * static_cast<float>(i % 96)) - 0.4f : 0.5f; };
    const auto light = [&](std::size_t i) {
        return picture.is_left(i) ? 1 + 0.01f * static_cast<float>(i / 96) + tilt(i) : 0.1f;
    };
    for (std::size_t i = 0; i < pixels; ++i) {
        picture.guides[2 * pixels + i] = tilt(i);
        for (std::size_t k = 0; k < 3; ++k) picture.planes[(1 + k) * pixels + i] = picture.planes[i] * light(i) * picture.guides[(4 + k) * pixels + i];
    }
    const std::vector<float> color = picture.completed();
    double sum = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        const float difference = std::abs(color[i] / picture.guides[4 * pixels + i] - light(i));
        CHECK_LT(difference, 0.06f);
        sum += difference;
    }
    CHECK_LT(sum / static_cast<double>(pixels), 0.01);
}

TEST(surfaces_are_alike_by_all_that_guides_say) {
    // A plane that is tilted to the right, of one color; then each guide of the last pixel is changed.
    constexpr int height = 3, width = 20;
    constexpr std::size_t pixels = height * width, last = pixels - 1;
    std::vector<float> guides(7 * pixels, 0.5f);
    for (std::size_t i = 0; i < pixels; ++i) guides[i] = 1, guides[pixels + i] = 0.4f + 0.01f * static_cast<float>(i % width);
    const auto likeness = [&] { return bob::GuidedSurfaces(known, guides.data(), height, width).likeness({0, 3}, {height - 1, width - 1}); };
    CHECK_NEAR(likeness(), 1, 1e-5f);
    const float steps[] = {-1, -0.3f, -0.5f, -0.5f, -0.3f, -0.3f, -0.3f};
    for (std::size_t k = 0; k < 7; ++k) {
        const float before = guides[k * pixels + last];
        guides[k * pixels + last] += steps[k];
        CHECK_LT(likeness(), 0.3f);
        CHECK_LT(0, likeness());
        guides[k * pixels + last] = before;
    }
}

/// A picture of shadows on the ground.
struct Shadows {
    int height, width;
    std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    std::vector<float> planes = std::vector<float>(3 * pixels), coverage = std::vector<float>(pixels), ground = std::vector<float>(2 * pixels),
                       alpha = std::vector<float>(pixels);

    void trace(std::size_t i, float shadow, float variance) { planes[i] = 1, planes[pixels + i] = shadow, planes[2 * pixels + i] = variance; }
    /// As far right as the pixel.
    [[nodiscard]] float ramp(std::size_t i) const { return static_cast<float>(i % static_cast<std::size_t>(width)) / static_cast<float>(width); }
    void complete() {
        const bob::Layout layout{bob::channels::mask, bob::channels::shadow, bob::channels::variance};
        bob::complete_alpha(layout, planes.data(), coverage.data(), ground.data(), height, width, alpha.data());
    }
};

TEST(shadows_are_completed_from_samples_of_the_ground) {
    // A surface covers the left half; a shadow of half the light lies on the ground beside it, out to the horizon.
    Shadows picture{30, 48};
    test::Random random(5);
    for (std::size_t i = 0; i < picture.pixels; ++i) {
        const bool covered = i % 48 < 24;
        picture.coverage[i] = covered, picture.ground[i] = !covered;
        picture.ground[picture.pixels + i] = 1 - 30 / static_cast<float>(i / 48 + 1);
        if (random() < 0.15f) picture.trace(i, covered ? 0.f : 0.5f, 1e-3f);
    }
    picture.complete();
    for (std::size_t i = 0; i < picture.pixels; ++i) CHECK_NEAR(picture.alpha[i], picture.coverage[i] > 0 ? 1.f : 0.5f, 1e-6f);
}

TEST(shadows_between_fitted_places_are_interpolated) {
    // The ground ends within tiles, whose fit is interpolated between places, some of them beyond it.
    for (const std::size_t rows : {50, 51, 53}) {
        Shadows picture{60, 60};
        test::Random random(5);
        for (std::size_t i = 0; i < rows * 60; ++i) {
            picture.ground[i] = 1;
            if (random() < 0.006f) picture.trace(i, picture.ramp(i), 1e-2f);
        }
        picture.complete();
        for (std::size_t i = 0; i < picture.pixels; ++i) {
            if (i % 60 > 10 && i % 60 < 50) CHECK_NEAR(picture.alpha[i], picture.ground[i] * picture.ramp(i), 0.04f);
        }
    }
}

TEST(slopes_do_not_keep_noise) {
    // The samples lie on a ramp, except for one, whose variance explains its deviation.
    Shadows picture{48, 48};
    test::Random random(5);
    std::size_t middle = picture.pixels;
    for (std::size_t i = 0; i < picture.pixels; ++i) {
        picture.ground[i] = 1;
        if (random() >= 0.1f) continue;
        picture.trace(i, picture.ramp(i), 1e-3f);
        if (i > picture.pixels / 2 && i % 48 > 20 && i % 48 < 28) middle = std::min(middle, i);
    }
    picture.planes[picture.pixels + middle] += 0.1f;
    picture.complete();
    CHECK_NEAR(picture.alpha[middle], picture.ramp(middle), 0.02f);
}
