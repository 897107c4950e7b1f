#include "shapes/mesh/texture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/color.h"
#include "check.h"

namespace {

bob::Texture texture(std::span<const std::uint8_t> texels, int height, int width, bob::Wrap across = bob::Wrap::repeat,
                     bob::Wrap down = bob::Wrap::repeat, std::span<const std::uint8_t> alpha = {}) {
    using Bytes = std::vector<std::uint8_t>;
    const auto own = std::make_shared<std::pair<Bytes, Bytes>>(Bytes(texels.begin(), texels.end()), Bytes(alpha.begin(), alpha.end()));
    return bob::Texture(std::make_shared<bob::Picture>(own->first, height, width, own->second, own), across, down);
}

/// Gray texels of the given sRGB values.
bob::Texture texture(int height, int width, const std::vector<int>& values, bob::Wrap wrap = bob::Wrap::repeat) {
    std::vector<std::uint8_t> texels;
    for (const int value : values) texels.insert(texels.end(), 3, static_cast<std::uint8_t>(value));
    return texture(texels, height, width, wrap, wrap);
}

float linear(int value) { return bob::from_srgb(static_cast<float>(value) / 255); }

}  // namespace

TEST(textures_are_bilinear_between_texels) {
    const bob::Texture t = texture(2, 2, {0, 100, 200, 255});
    CHECK_NEAR(t(0.25f, 0.25f, 0).x, 0.f, 1e-6f);
    CHECK_NEAR(t(0.75f, 0.25f, 1).y, linear(100), 1e-6f);
    CHECK_NEAR(t(0.25f, 0.75f, 0).z, linear(200), 1e-6f);
    CHECK_NEAR(t(0.5f, 0.25f, 0).x, linear(100) / 2, 1e-6f);
    CHECK_NEAR(t(0.5f, 0.5f, 0).x, (linear(100) + linear(200) + 1) / 4, 1e-6f);
}

TEST(bytes_of_srgb_are_the_curves_rounded) {
    const bob::SrgbBytes byte;
    const auto rounded = [](float x) { return static_cast<int>(bob::to_srgb(x) * 255 + 0.5f); };
    constexpr int steps = 1 << 20;
    int wrong = 0;
    for (int i = 0; i <= steps; ++i) wrong += byte(static_cast<float>(i) / steps) != rounded(static_cast<float>(i) / steps);
    for (int i = 0; i < 256; ++i) {  // around where one ends and the next begins
        float x = std::nextafter(linear(i) + (linear(i + 1) - linear(i)) * 0.45f, 0.f);
        for (const float end = std::min(1.f, linear(i) + (linear(i + 1) - linear(i)) * 0.55f); x < end; x = std::nextafter(x, 2.f)) {
            wrong += byte(x) != rounded(x);
        }
    }
    CHECK_EQ(wrong, 0);
}

TEST(textures_wrap_as_they_say) {
    const std::vector<int> values{10, 60, 160, 250};
    const auto at = [&](bob::Wrap wrap, float u) { return texture(1, 4, values, wrap)(u, 0.5f, 0).x; };
    for (const float turns : {-3.f, -1.f, 1.f, 7.f}) {
        CHECK_NEAR(at(bob::Wrap::repeat, 0.375f + turns), linear(60), 1e-5f);
        CHECK_NEAR(at(bob::Wrap::clamp, 0.375f + turns), linear(turns < 0 ? 10 : 250), 1e-6f);
        CHECK_NEAR(at(bob::Wrap::mirror, 0.375f + turns), linear(160), 1e-5f);  // an odd number of turns is reflected
        CHECK_NEAR(at(bob::Wrap::mirror, 0.375f + 2 * turns), linear(60), 1e-5f);
    }
    CHECK_NEAR(at(bob::Wrap::repeat, 0), (linear(10) + linear(250)) / 2, 1e-6f);
    CHECK_NEAR(at(bob::Wrap::clamp, 0), linear(10), 1e-6f);
    CHECK_EQ(at(bob::Wrap::repeat, std::nanf("")) >= 0, true);
}

TEST(footprints_choose_levels) {
    std::vector<int> columns;
    for (int i = 0; i < 16 * 16; ++i) columns.push_back(i % 2 ? 255 : 0);  // lines of one texel
    const bob::Texture t = texture(16, 16, columns);
    const float u = 0.5f / 16;  // on a dark one
    CHECK_NEAR(t(u, 0.5f, 1).x, 0.f, 1e-6f);
    CHECK_NEAR(t(u, 0.5f, 2).x, 0.5f, 0.01f);   // level 1: means of a dark and a bright one, in linear light
    CHECK_NEAR(t(u, 0.5f, 64).x, 0.5f, 0.01f);  // beyond the last level
    const float between = t(u, 0.5f, std::sqrt(2.f)).x;  // half way
    CHECK_NEAR(between, 0.25f, 0.01f);
}

TEST(odd_pictures_have_levels_down_to_one_texel) {
    const bob::Texture t = texture(3, 5, std::vector<int>(15, 77));
    for (const float width : {0.f, 1.5f, 3.f, 100.f}) CHECK_NEAR(t(0.3f, 0.9f, width).x, linear(77), 2e-3f);
    CHECK_EQ(t.picture().bytes(), static_cast<std::size_t>(3 * (15 + 6 + 2 + 1)));
}

TEST(srgb_goes_both_ways) {
    for (int i = 0; i < 256; ++i) CHECK_NEAR(bob::to_srgb(linear(i)) * 255, static_cast<float>(i), 1e-3f);
    CHECK_NEAR(bob::from_srgb(0.5f), 0.21404114f, 1e-6f);
}

TEST(alphas_are_bilinear_and_wrap) {
    const std::vector<std::uint8_t> texels(4 * 3, 200), alpha{0, 102, 255, 51};
    const bob::Texture t = texture(texels, 1, 4, bob::Wrap::clamp, bob::Wrap::repeat, alpha), plain = texture(texels, 1, 4);
    CHECK_EQ(t.alpha(0.125f, 0.5f), 0.f);
    CHECK_NEAR(t.alpha(0.5f, 7.3f), (102 + 255) / 510.f, 1e-6f);
    CHECK_NEAR(t.alpha(9, 0.5f), 0.2f, 1e-6f);
    CHECK_NEAR(t.alpha(-9, 0.5f), 0.f, 1e-6f);
    CHECK_EQ(t.alpha(std::nanf(""), 0.5f), 0.f);
    CHECK_EQ(t.picture().least_alpha(), 0.f);
    CHECK_EQ(plain.alpha(0.3f, 0.3f), 1.f);
    CHECK_EQ(plain.picture().least_alpha(), 1.f);
    CHECK_EQ(t.picture().bytes() - plain.picture().bytes(), static_cast<std::size_t>(4 + 2 + 1));
}

TEST(what_is_transparent_lends_no_color) {
    // Green among white that is cut out, seen from near and from far.
    std::vector<std::uint8_t> texels, alpha;
    test::Random random(2);
    for (int i = 0; i < 16 * 16; ++i) {
        const bool is_green = random() < 0.4f;
        const std::uint8_t green[3] = {10, 130, 20}, white[3] = {255, 255, 255};
        texels.insert(texels.end(), is_green ? green : white, (is_green ? green : white) + 3);
        alpha.push_back(is_green ? 255 : 0);
    }
    const bob::Texture t = texture(texels, 16, 16, bob::Wrap::repeat, bob::Wrap::repeat, alpha);
    for (int i = 0; i < 1000; ++i) {
        const float u = random(-1, 2), v = random(-1, 2), width = random(0, 20);
        if (t.alpha(u, v) == 0) continue;
        CHECK_NEAR(t(u, v, width).x, linear(10), 1e-3f);
        CHECK_NEAR(t(u, v, width).y, linear(130), 4e-3f);
    }
    const bob::Texture none = texture(std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255}, 1, 2, bob::Wrap::clamp, bob::Wrap::clamp,
                                      std::vector<std::uint8_t>{0, 0});
    CHECK_NEAR(none(0.5f, 0.5f, 0).x, 0.5f, 1e-6f);  // of a texture that is transparent everywhere
    CHECK_NEAR(none(0.5f, 0.5f, 2).x, 0.5f, 3e-3f);
}

TEST(what_is_opaque_all_over_is_opaque_to_the_bit) {
    const std::vector<std::uint8_t> texels(5 * 3 * 3, 9), alpha(5 * 3, 255);
    const bob::Texture t = texture(texels, 5, 3, bob::Wrap::repeat, bob::Wrap::mirror, alpha);
    test::Random random(1);
    for (int i = 0; i < 1000; ++i) CHECK_EQ(t.alpha(random(-3, 3), random(-3, 3)), 1.f);
}

TEST(textures_share_a_picture_and_wrap_each_in_its_way) {
    const std::vector<std::uint8_t> texels{0, 0, 0, 255, 255, 255}, alpha{0, 255};
    const auto owner = std::make_shared<int>();
    const auto picture = std::make_shared<const bob::Picture>(texels, 1, 2, alpha, owner);
    CHECK_EQ(owner.use_count(), 2);
    const bob::Texture clamped(picture, bob::Wrap::clamp), repeated(picture);
    CHECK_EQ(&clamped.picture(), &repeated.picture());
    CHECK_EQ(clamped.alpha(1.2f, 0), 1.f);
    CHECK_NEAR(repeated.alpha(1.25f, 0), 0.f, 1e-6f);
}
