/// Light: its sequences, its directions, and reflection by surfaces.
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "base/color.h"
#include "check.h"
#include "light/dielectric.h"
#include "light/environment.h"
#include "light/facets.h"
#include "light/lights.h"
#include "light/reflection.h"
#include "light/sobol.h"

using namespace bob;

TEST(sobol_begins_as_published) {
    // Joe and Kuo's table, new-joe-kuo-6.21201: the first points after 0, in eighths.
    const std::uint32_t expected[8][4] = {{0, 0, 0, 0}, {4, 4, 4, 4}, {2, 6, 6, 6}, {6, 2, 2, 2}, {1, 5, 3, 1}, {5, 1, 7, 5}, {3, 3, 5, 7}, {7, 7, 1, 3}};
    for (std::uint32_t i = 0; i < 8; ++i) {
        for (std::size_t d = 0; d < 4; ++d) CHECK_EQ(reversed_bits(Sobol::point(i)[d]) >> 29, expected[i][d]);
    }
}

namespace {

/// Checks that the first two numbers of 2^exponent samples are stratified: they are of a (0, 2)-sequence, which Owen's scrambling keeps, so
/// each elementary box has one.
void check_stratified(int exponent, const std::vector<std::array<float, Sobol::dimensions>>& samples) {
    CHECK_EQ(samples.size(), std::size_t{1} << exponent);
    for (int across = 0; across <= exponent; ++across) {
        std::vector<int> boxes(samples.size());
        for (const auto& [x, y, z, w] : samples) {
            const auto column = static_cast<std::size_t>(x * static_cast<float>(1 << across));
            const auto row = static_cast<std::size_t>(y * static_cast<float>(1 << (exponent - across)));
            ++boxes[row << across | column];
        }
        for (const int count : boxes) CHECK_EQ(count, 1);
    }
}

}  // namespace

TEST(samples_of_a_visit_are_stratified) {
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        for (const std::uint32_t first : {0u, 16u, 48u}) {
            std::vector<std::array<float, Sobol::dimensions>> samples;
            for (std::uint32_t k = 0; k < 16; ++k) samples.push_back(PixelSequence(seed, seed + 1, 2 * seed, first + k, 16)(seed % 3));
            check_stratified(4, samples);
        }
    }
}

TEST(samples_of_a_square_of_pixels_are_stratified) {
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        std::vector<std::array<float, Sobol::dimensions>> samples;
        for (std::uint32_t place = 0; place < 16; ++place) {
            for (std::uint32_t k = 0; k < 8; ++k) samples.push_back(PixelSequence(seed, 8 + place / 4, 4 * seed + place % 4, k, 8)(seed % 3));
        }
        check_stratified(7, samples);
    }
}

TEST(samples_of_all_visits_of_a_pixel_are_stratified) {
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        std::vector<std::array<float, Sobol::dimensions>> samples;
        for (std::uint32_t k = 0; k < 256; ++k) samples.push_back(PixelSequence(seed, 5, seed, k, 16)(seed % 3));
        check_stratified(8, samples);
        samples.clear();  // of 13 each, 3 of every 16 at the next visit
        for (std::uint32_t k = 0; k < 64; ++k) samples.push_back(PixelSequence(seed, 5, seed, k, 13)(seed % 3));
        check_stratified(6, samples);
    }
}

TEST(sequences_are_the_same_on_every_machine) {
    // Whole numbers alone make them.
    std::uint32_t hash = 0;
    for (std::uint32_t k = 0; k < 100; ++k) {
        for (const float x : PixelSequence(1, 2, 3, k, 16)(k % 5)) hash = hashed(hash, static_cast<std::uint32_t>(x * 0x1p24f));
    }
    CHECK_EQ(hash, 618936284u);
}

TEST(directions_have_their_densities) {
    constexpr int side = 64;
    double cosine = 0, cap = 0;
    for (int i = 0; i < side * side; ++i) {
        const float u = (static_cast<float>(i / side) + 0.5f) / side, v = (static_cast<float>(i % side) + 0.5f) / side;
        cosine += static_cast<double>(cosine_weighted(u, v).z) / (side * side);
        const Vec3 in = in_cap(0.25f, u, v);
        CHECK(in.z >= 0.7499f);
        cap += static_cast<double>(in.z) / (side * side);
    }
    CHECK(std::fabs(cosine - 2. / 3) < 1e-3);  // the mean of z under cos / pi
    CHECK(std::fabs(cap - 0.875) < 1e-3);
}

TEST(discs_cover_what_is_drawn_from_them) {
    test::Random random(7);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 direction = normalized({random(-1, 1), random(-1, 1), random(-1, 1)});
        const DiscLight disc{direction, random(1e-6f, 1), {1, 1, 1}};
        CHECK(disc.covers(Across(direction).from(in_cap(0.999f * disc.height, random(), random()))));
        CHECK(!disc.covers(Across(direction).from(in_cap(0.f, 0, 0) + Vec3{2 * std::sqrt(2 * disc.height) + 0.01f, 0, 0})));
    }
}

TEST(white_surfaces_reflect_all_of_a_white_world) {
    for (const double metallic : {0., 1.}) {
        for (const double roughness : {0., 0.1, 0.3, 0.6, 1.}) {
            Material material;
            material.metallic = metallic, material.roughness = roughness;
            for (const double coat : {0., 0.02, 0.1, 0.5}) {
                material.clearcoat = coat > 0 ? 0.7 : 0, material.clearcoat_roughness = coat;
                for (const float height : {0.15f, 0.5f, 1.f}) {
                    const Reflection reflection(material, {1, 1, 1}, {std::sqrt(1 - height * height), 0, height});
                    Vec3 sum;
                    constexpr std::uint32_t count = 4096;
                    for (std::uint32_t k = 0; k < count; ++k) {
                        const auto [choice, u, v, other] = PixelSequence(0, 0, 0, k, 16)(0);
                        const auto drawn = reflection.draw(choice, u, v);
                        if (drawn.toward.z > 0) sum = sum + drawn.weight;
                    }
                    CHECK(std::fabs(luminance(sum) / count - 1) < 0.02f);
                }
            }
        }
    }
}

TEST(drawn_directions_have_the_density_that_is_said) {
    for (const double coat : {0., 1.}) {
        Material material;
        material.metallic = 0.3, material.roughness = 0.5, material.clearcoat = coat, material.clearcoat_roughness = 0.4;
        const Reflection reflection(material, {0.8f, 0.5f, 0.3f}, normalized({0.6f, 0.1f, 0.7f}));
        // The mean of 1 / density is the solid angle of all possible directions: the hemisphere.
        double sum = 0, all = 0;
        constexpr std::uint32_t count = 1 << 16;
        for (std::uint32_t k = 0; k < count; ++k) {
            const auto [choice, u, v, other] = PixelSequence(3, 0, 0, k, 16)(0);
            const auto drawn = reflection.draw(choice, u, v);
            if (drawn.toward.z > 0) sum += 1 / static_cast<double>(drawn.density) / count;
            const Vec3 even = in_cap(1, u, v);
            all += static_cast<double>(reflection.density(even)) * 2 * static_cast<double>(pi) / count;
        }
        CHECK(std::fabs(sum / (2 * static_cast<double>(pi)) - 1) < 0.02);
        CHECK(all > 0.97);  // reflections below the horizon are lost
        CHECK(all < 1.005);
    }
}

TEST(environments_draw_by_their_brightness) {
    std::vector<Vec3> texels(16 * 32, Vec3{0.01f, 0.01f, 0.01f});
    texels[5 * 32 + 7] = {50, 40, 30};
    const Environment environment(texels, 16, 32);
    double sum = 0, light = 0;
    int bright = 0;
    constexpr std::uint32_t count = 1 << 14;
    for (std::uint32_t k = 0; k < count; ++k) {
        const auto [u, v, w, x] = PixelSequence(0, 0, 0, k, 16)(0);
        const auto [toward, density] = environment.draw(u, v);
        CHECK(std::fabs(length(toward) - 1) < 1e-5f);
        CHECK(density > 0);
        sum += 1 / static_cast<double>(density) / count;
        light += static_cast<double>(environment.radiance(toward).x) / static_cast<double>(density) / count;
        bright += environment.radiance(toward).x > 1;
    }
    CHECK(std::fabs(sum / (4 * static_cast<double>(pi)) - 1) < 0.02);  // the sphere
    const double solid = static_cast<double>(pi) / 16 * 2 * static_cast<double>(pi) / 32 * std::sin(5.5 * static_cast<double>(pi) / 16);
    CHECK(std::fabs(light / (0.01 * 4 * static_cast<double>(pi) + 49.99 * solid) - 1) < 0.02);
    CHECK(bright > static_cast<int>(count) / 3);
}

TEST(environments_may_be_black_and_not_too_large) {
    const Environment black(std::vector<Vec3>(8), 2, 4);
    CHECK_EQ(black.draw(0.5f, 0.5f).density, 0.f);
    CHECK_EQ(black.density({0, 0, 1}), 0.f);
    const Vec3 texel;
    bool is_refused = false;
    try {
        const Environment large(std::span(&texel, Environment::max_texels + 1), 1, 1);
    } catch (const std::invalid_argument&) {
        is_refused = true;
    }
    CHECK(is_refused);
}

// ---- Glass -----------------------------------------------------------------------------------------------

TEST(glass_reflects_as_fresnel_says) {
    // At 0 degrees ((n - 1) / (n + 1))^2: 4 % of glass, from either side.
    CHECK(std::fabs(Boundary(1, 1 / 1.5f).reflectance - 0.04f) < 1e-6f);
    CHECK(std::fabs(Boundary(1, 1.5f).reflectance - 0.04f) < 1e-6f);
    // At Brewster's angle, tan = n, light of one polarisation is not reflected: the mean is half of ((n^2 - 1) / (n^2 + 1))^2.
    const float n = 1.5f, brewster = std::atan(n), of_other = (n * n - 1) / (n * n + 1);
    CHECK(std::fabs(Boundary(std::cos(brewster), 1 / n).reflectance - 0.5f * of_other * of_other) < 1e-6f);
    // Beyond the critical angle, sin = 1 / n, all of it; before, not.
    const float critical = std::asin(1 / n);
    CHECK_EQ(Boundary(std::cos(critical + 1e-3f), n).reflectance, 1.f);
    CHECK(Boundary(std::cos(critical - 1e-3f), n).reflectance < 0.9f);
    CHECK_EQ(Boundary(0, 1 / n).reflectance, 1.f);                       // grazing
    CHECK(std::fabs(Boundary(0.7f, 1).reflectance) < 1e-12f);            // of nothing
    // The same for both directions of a ray.
    const Boundary in(0.6f, 1 / n);
    CHECK(std::fabs(in.reflectance - Boundary(in.beyond, n).reflectance) < 1e-6f);
}

TEST(a_sheet_of_glass_reflects_by_both_sides) {
    // R + T R T + T R^3 T + ... = R + T^2 R / (1 - R^2), with T = 1 - R.
    for (const float along : {1.f, 0.5f, 0.1f}) {
        const float once = Boundary(along, 1 / 1.5f).reflectance, series = once + (1 - once) * (1 - once) * once / (1 - once * once);
        const Boundary sheet = Boundary::sheet(along, 1.5f);
        CHECK(std::fabs(sheet.reflectance - series) < 1e-6f);
        CHECK_EQ(sheet.beyond, along);
    }
}

TEST(glass_refracts_as_snell_says) {
    for (const float eta : {1 / 1.5f, 1 / 2.42f, 1.1f}) {
        const Vec3 half{0, 0, 1}, eye = normalized({0.4f, 0.2f, 0.9f});
        const Boundary boundary(eye.z, eta);
        const Vec3 toward = refracted(eye, half, eta, boundary.beyond);
        CHECK(std::fabs(length(toward) - 1) < 1e-6f);
        CHECK(toward.z < 0);
        CHECK(std::fabs(std::hypot(toward.x, toward.y) - eta * std::hypot(eye.x, eye.y)) < 1e-6f);
    }
}

TEST(the_last_glass_that_was_entered_counts) {
    Media media;
    CHECK(media.is_empty());
    media.enter(3), media.enter(5);  // water that reaches into its glass
    CHECK_EQ(media.last(), 5u);
    media.leave(3);
    CHECK(!media.contains(3));
    CHECK_EQ(media.last(), 5u);
    media.leave(5);
    CHECK(media.is_empty());
    for (std::uint32_t k = 0; k < 2 * Media::max; ++k) media.enter(k);
    CHECK_EQ(media.last(), Media::max - 1);
}

TEST(light_falls_off_in_glass_by_beer) {
    Material glass;
    glass.attenuation[0] = 0.5, glass.attenuation[1] = 0, glass.attenuation_distance = 2;
    const Vec3 left = attenuation(glass, 0.25f, 24);  // six units
    CHECK(std::fabs(left.x - 0.125f) < 1e-6f);
    CHECK_EQ(left.y, 0.f);
    CHECK_EQ(left.z, 1.f);
    CHECK_EQ(attenuation(Material{}, 1, 1).x, 1.f);
}
