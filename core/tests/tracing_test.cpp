#include "tracing/trace.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "check.h"
#include "meshes.h"
#include "picture/gbuffer.h"
#include "sampling/squares.h"
#include "shapes/mesh/mesh.h"
#include "tracing/material.h"
#include "tracing/picture_tracing.h"

namespace {

constexpr bob::Vec3 white{1, 1, 1};

struct Picture {
    std::vector<float> gray, depth, normal;
    std::vector<char> hit;
};

/// The scene of one mesh in the unit sphere, in white.
bob::Scene scene_of(std::span<const bob::Vec3> vertices, std::span<const bob::Triangle> triangles,
                    std::span<const bob::Vec3> normals = {}) {
    return bob::Scene({{test::prepared(vertices, triangles, normals), {}, {-1, -1, -1}, {1, 1, 1}, {}}});
}

Picture render(const bob::Scene& scene, const bob::Camera& camera, int height, int width) {
    std::vector<bob::Pixel> pixels;
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) pixels.push_back({row, column});
    }
    const std::size_t n = pixels.size();
    Picture picture{std::vector<float>(n), std::vector<float>(n), std::vector<float>(2 * n), std::vector<char>(n)};
    std::vector<float> samples(5 * n);
    bob::trace(scene, camera, height, width, pixels, bob::gbuffer_layout(), samples.data());
    for (std::size_t i = 0; i < n; ++i) {
        const float* const sample = &samples[5 * i];
        picture.hit[i] = sample[0] != 0, picture.gray[i] = sample[1], picture.depth[i] = sample[2];
        picture.normal[2 * i] = sample[3], picture.normal[2 * i + 1] = sample[4];
    }
    return picture;
}

}  // namespace

TEST(sphere_matches_the_analytic_one) {
    const auto sphere = test::sphere(6, 1);
    const bob::Scene scene = scene_of(sphere.vertices, sphere.triangles);
    constexpr int height = 90, width = 121;
    for (const bob::Camera& camera : {bob::Camera{}, bob::Camera{200, -70, 33, 1}, bob::Camera{0, 90, 0, 0.7f},
                                    bob::Camera{30, 20, 10, 1.5f, 0.25f, -0.5f}}) {
        const auto picture = render(scene, camera, height, width);
        for (int row = 0; row < height; ++row) {
            for (int column = 0; column < width; ++column) {
                const std::size_t i = static_cast<std::size_t>(row * width + column);
                const float x = (column + 0.5f - width / 2.f) * 2 / height / camera.zoom + camera.pan_x;
                const float y = (height / 2.f - row - 0.5f) * 2 / height / camera.zoom + camera.pan_y;
                const float r2 = x * x + y * y;
                if (r2 > 0.998f && r2 < 1.002f) continue;  // within the facets of the silhouette
                CHECK_EQ(picture.hit[i] != 0, r2 < 1);
                if (!picture.hit[i]) {
                    CHECK_EQ(picture.gray[i] + picture.depth[i], 0.f);
                    continue;
                }
                const float z = std::sqrt(1 - r2);
                CHECK_NEAR(picture.normal[2 * i], x, 0.01f);
                CHECK_NEAR(picture.normal[2 * i + 1], y, 0.01f);
                // The facets lie 3e-4 inside the sphere at most, more along a grazing ray.
                CHECK_NEAR(picture.depth[i], (1 + z) / 2, 5e-4f / z);
                CHECK_NEAR(picture.gray[i], bob::shaded({x, y, z}, white, {}).gray, 0.01f);
            }
        }
    }
}

TEST(camera_axes_are_as_agreed) {
    // A small triangle on each axis, seen from where it is nearest.
    const auto nearest_seen = [](bob::Camera camera, bob::Vec3 at) {
        const std::vector<bob::Vec3> v{at + bob::Vec3{0.1f, 0, 0}, at + bob::Vec3{0, 0.1f, 0}, at + bob::Vec3{0, 0, 0.1f},
                                       -at};
        const std::vector<bob::Triangle> t{{0, 1, 2}};
        const auto picture = render(scene_of(v, t), camera, 64, 64);
        std::size_t row = 0, column = 0, count = 0;
        for (std::size_t i = 0; i < picture.hit.size(); ++i) {
            if (picture.hit[i]) row += i / 64, column += i % 64, ++count;
        }
        return std::pair{count ? row / count : 999, count ? column / count : 999};
    };
    // From +x, looking along -x: +y is to the right, +z up.
    CHECK_LT(40u, nearest_seen({0, 0, 0, 1}, {0, 0.5f, 0}).second);
    CHECK_LT(nearest_seen({0, 0, 0, 1}, {0, 0, 0.5f}).first, 24u);
    // A quarter turn anticlockwise seen from +z: from +y, +x is to the left.
    CHECK_LT(nearest_seen({90, 0, 0, 1}, {0.5f, 0, 0}).second, 24u);
    // From straight above at azimuth 0: -x is up.
    CHECK_LT(nearest_seen({0, 90, 0, 1}, {-0.5f, 0, 0}).first, 24u);
    // The camera rolled anticlockwise by a quarter: up becomes right.
    CHECK_LT(40u, nearest_seen({0, 0, 90, 1}, {0, 0, 0.5f}).second);
}

TEST(pictures_do_not_depend_on_threads) {
    const auto soup = test::soup(3000, 0.1f, 2);
    const bob::Scene scene = scene_of(soup.vertices, soup.triangles);
    const int threads = bob::thread_count();
    bob::set_thread_count(1);
    const auto one = render(scene, {}, 100, 70);
    bob::set_thread_count(5);
    const auto five = render(scene, {}, 100, 70);
    bob::set_thread_count(threads);
    CHECK(one.gray == five.gray && one.depth == five.depth && one.normal == five.normal && one.hit == five.hit);
}

TEST(both_sides_of_a_face_are_shaded_alike) {
    const std::vector<bob::Vec3> v{{0, -0.7f, -0.7f}, {0, 0.7f, -0.7f}, {0, 0, 0.9f}};
    const std::vector<bob::Triangle> front{{0, 1, 2}}, back{{0, 2, 1}};
    const auto a = render(scene_of(v, front), {0, 0, 0, 1}, 40, 40);
    const auto b = render(scene_of(v, back), {0, 0, 0, 1}, 40, 40);
    CHECK(a.gray == b.gray);
    CHECK_NEAR(a.gray[20 * 40 + 20], bob::shaded({0, 0, 1}, white, {}).gray, 1e-6f);
}

TEST(smooth_normals_that_lean_away_are_seen_edge_on) {
    // A face that turns its side to the camera, and a normal for it from beyond the horizon.
    const std::vector<bob::Vec3> v{{0.3f, -0.1f, -0.7f}, {-0.3f, 0.1f, -0.7f}, {0, 0, 0.7f}};
    const std::vector<bob::Vec3> leaning(3, {-0.3f, 0.95f, 0});
    const auto picture = render(scene_of(v, std::vector<bob::Triangle>{{0, 1, 2}}, leaning), {0, 0, 0, 1}, 64, 64);
    int seen = 0;
    for (std::size_t i = 0; i < picture.hit.size(); ++i) {
        if (!picture.hit[i]) continue;
        ++seen;
        CHECK_NEAR(std::fabs(picture.normal[2 * i]), 1.f, 1e-6f);
        CHECK_NEAR(picture.normal[2 * i + 1], 0.f, 1e-6f);
    }
    CHECK_LT(20, seen);
}

TEST(blinn_phong_worked_values) {
    // Facing the camera: n.l = 1 / sqrt(0.09 + 0.16 + 1), n.h = sqrt((1 + n.l) / 2).
    const double n_l = 1 / std::sqrt(1.25), n_h = std::sqrt((1 + n_l) / 2);
    CHECK_NEAR(bob::shaded({0, 0, 1}, white, {}).gray, 0.1 + 0.7 * n_l + 0.2 * std::pow(n_h, 32), 1e-5);
    CHECK_NEAR(bob::shaded(bob::normalized(bob::light_direction), white, {}).gray, 0.8 + 0.2 * std::pow(n_h, 32), 1e-5);
    CHECK_NEAR(bob::shaded(bob::normalized({0.3f, -0.4f, -1}), white, {}).gray, 0.1, 1e-6);
}

TEST(highlights_lie_between_light_and_eye) {
    // A face that an eye sees at 45 degrees from the right: the light, and half of the way from it to the eye.
    const bob::Vec3 l = bob::normalized(bob::light_direction), eye = bob::normalized({1, 0, 1});
    const bob::Vec3 h = bob::normalized(l + eye), n = bob::normalized({0.1f, 0.2f, 1});
    bob::Camera camera{0, 0, 0, 1};
    camera.fov_degrees = 90;
    const bob::Projection projection(camera, 2, 2);  // a place one pixel left of the centre is 45 degrees off
    const float row = 0.5f, column = -0.5f;
    const bob::Vec3 direction = projection.turned(l, row, column);
    const bob::Light light{direction, bob::normalized(direction + bob::Vec3{0, 0, 1})};
    CHECK_NEAR(bob::shaded(projection.turned(n, row, column), white, {}, light).gray,
               0.1 + 0.7 * dot(n, l) + 0.2 * std::pow(dot(n, h), 32), 1e-6);
    CHECK_NEAR(projection.turned(eye, row, column).z, 1.f, 1e-6f);
}

TEST(materials_shade_as_their_formula_says) {
    const bob::Vec3 n = bob::normalized({0.2f, 0.5f, 0.9f});
    const bob::Vec3 l = bob::normalized(bob::light_direction), h = bob::normalized(l + bob::Vec3{0, 0, 1});
    const bob::Material material{{0.5f, 0.25f, 1}, 0.05f, 0.6f, 0.3f, 5};
    const double luminance = 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722;
    CHECK_NEAR(bob::shaded(n, material.base_color(), material).gray,
               luminance * (0.05 + 0.6 * dot(n, l)) + 0.3 * std::pow(dot(n, h), 5), 1e-6);
    CHECK_EQ(bob::luminance(white), 1.f);
    CHECK_EQ(bob::shaded(n, white, {{1, 1, 1}, 1, 1, 1, 0}).gray, 1.f);
}

TEST(microfacets_are_as_their_formulas_say) {
    const double pi = 3.14159265358979;
    const bob::Light& light = bob::Light::of_the_camera();
    for (const auto& [metallic, roughness] : {std::pair{0., 0.3}, {1., 0.5}, {0.4, 0.9}}) {
        for (const bob::Vec3 direction : {bob::Vec3{0, 0, 1}, {0.2f, 0.5f, 0.9f}, {-0.7f, 0.1f, 0.3f}}) {
            const bob::Vec3 n = bob::normalized(direction), color{0.8f, 0.3f, 0.05f};
            bob::Material material;
            material.metallic = metallic, material.roughness = roughness;
            const bob::Vec3 found = bob::physical(n, color, material, light);
            const auto product = [](bob::Vec3 a, bob::Vec3 b) {
                return static_cast<double>(a.x) * b.x + static_cast<double>(a.y) * b.y + static_cast<double>(a.z) * b.z;
            };
            const double nl = product(n, light.direction), nv = n.z, vh = light.half.z;
            const double nh = product(n, light.half) / std::sqrt(product(n, n) * product(light.half, light.half));
            const double a2 = std::pow(roughness, 4), d = a2 / (pi * std::pow(nh * nh * (a2 - 1) + 1, 2));
            const auto masking = [&](double x) { return 2 * x / (x + std::sqrt(a2 + (1 - a2) * x * x)); };
            const double v = masking(nl) * masking(nv) / (4 * nl * nv);
            const double r0 = 1 - roughness, r1 = 0.0425 - 0.0275 * roughness, r2 = 1.04 - 0.572 * roughness;
            const double falloff = std::min(r0 * r0, std::exp2(-9.28 * nv)) * r0 + r1;
            for (int k = 0; k < 3; ++k) {
                const double f0 = 0.04 * (1 - metallic) + metallic * color[k], body = (1 - metallic) * color[k];
                const double f = f0 + (1 - f0) * std::pow(1 - vh, 5);
                const double around = f0 * (-1.04 * falloff + r2) + std::max(0., 1.04 * falloff + 0.022 * roughness - 0.04);
                const double wanted = ((1 - f) * body / pi + f * d * v) * nl * pi * 0.6 + 0.3 * ((1 - around) * body + around);
                CHECK_NEAR(found[k], wanted, 1e-5 * std::max(1., wanted));
            }
        }
    }
}

TEST(nothing_reflects_more_of_the_surroundings_than_comes) {
    const bob::Vec3 away = bob::normalized({0.8f, -0.7f, 0.3f});  // from the headlight
    CHECK_EQ(dot(away, bob::Light::of_the_camera().direction) < 0, true);
    for (const double metallic : {0., 0.5, 1.}) {
        for (const double roughness : {0., 0.1, 0.5, 1.}) {
            for (const float z : {0.f, 0.1f, 0.3f}) {
                bob::Material material;
                material.metallic = metallic, material.roughness = roughness;
                const float most = bob::physical(bob::normalized({away.x, away.y, z}), white, material, bob::Light::of_the_camera()).x;
                CHECK_EQ(most <= 0.3f + 1e-6f && most > 0.1f, true);
            }
        }
    }
}

TEST(colors_of_meshes_are_between_those_of_their_corners) {
    const std::vector<bob::Mesh::Point> points{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    const std::vector<bob::Triangle> triangles{{0, 1, 2}};
    const std::vector<bob::Vec3> colors{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, face{{1, 0.5f, 0.25f}};
    const std::vector<bob::Mesh::Uv> uv{{0, 0}, {1, 0}, {0, 1}};
    const std::vector<std::uint8_t> texels{255, 255, 255, 0, 0, 0};
    bob::Mesh::Arrays arrays{points, triangles, {}, nullptr};
    arrays.colors = colors, arrays.face_colors = face;
    const bob::Mesh mesh(arrays);
    mesh.prepare();
    const std::vector<bob::Ray> rays(1);
    const std::vector<bob::Hit> hits{{1, 0.5f, 0.3f, 0}};
    const std::vector<float> widths{0.01f};
    std::vector<bob::Vec3> found(1);
    mesh.colors(rays, hits, widths, found);
    CHECK_NEAR(found[0].x, 0.5f, 1e-6f);
    CHECK_NEAR(found[0].y, 0.3f * 0.5f, 1e-6f);
    CHECK_NEAR(found[0].z, 0.2f * 0.25f, 1e-6f);

    bob::Mesh::Arrays pictured{points, triangles, {}, nullptr};
    pictured.uv = uv, pictured.texture = std::make_shared<bob::Texture>(std::make_shared<bob::Picture>(texels, 1, 2));
    const bob::Mesh textured(pictured);
    textured.prepare();
    const std::vector<bob::Ray> down{{{0, 0, 1}, {0, 0, -1}}};
    textured.colors(down, hits, widths, found);  // at u = 0.3: 0.05 texels right of the white one's centre
    CHECK_NEAR(found[0].x, 0.9f, 1e-5f);
    // The triangle's 2 texels lie on an area of 4 of a sphere's radius squared: this area is 2 texels wide.
    const float radius = static_cast<float>(textured.sphere().radius);
    const std::vector<float> wide{2 * std::sqrt(2.f) / radius};
    textured.colors(down, hits, wide, found);
    CHECK_NEAR(found[0].x, 0.5f, 0.01f);
}

TEST(samples_do_not_depend_on_the_order_of_pixels) {
    const auto sphere = test::sphere(4, 0.8f);
    const bob::Scene scene = scene_of(sphere.vertices, sphere.triangles);
    constexpr int height = 45, width = 70;
    const Picture rows = render(scene, {}, height, width);
    test::Random random(3);
    for (const std::size_t count : {1, 40, 700, height * width}) {  // tiles of 64, 32, 8 pixels
        std::vector<bob::Pixel> pixels;
        for (int i = 0; i < height * width; ++i) pixels.push_back({i / width, i % width});
        for (std::size_t i = pixels.size(); i-- > 1;) {
            std::swap(pixels[i], pixels[std::min(i, static_cast<std::size_t>(random() * static_cast<float>(i + 1)))]);
        }
        pixels.resize(count);
        std::vector<float> samples(5 * count, -1);
        bob::trace(scene, {}, height, width, pixels, bob::gbuffer_layout(), samples.data());
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<std::size_t>(pixels[i].row * width + pixels[i].column);
            CHECK_EQ(samples[5 * i] != 0, rows.hit[at] != 0);
            CHECK_EQ(samples[5 * i + 1], rows.gray[at]);
            CHECK_EQ(samples[5 * i + 2], rows.depth[at]);
            CHECK_EQ(samples[5 * i + 3], rows.normal[2 * at]);
        }
    }
}

TEST(a_picture_is_traced_as_its_rounds_are_one_by_one) {
    const auto sphere = test::sphere(6, 1);
    const bob::Scene scene = scene_of(sphere.vertices, sphere.triangles);
    constexpr int height = 90, width = 121;
    constexpr std::size_t pixels = height * width;
    const bob::Layout& layout = bob::gbuffer_layout();
    for (const std::size_t wanted : {pixels / 9, pixels / 10 * 9}) {
        std::vector<float> expected(5 * pixels);
        bob::SquaresOrder order(height, width, nullptr, bob::SquaresOrder::First::priority);
        for (std::size_t done = 0; done < wanted;) {
            auto round = order.next(layout, expected.data());
            round = round.first(std::min(round.size(), wanted - done));
            std::vector<float> samples(5 * round.size());
            bob::trace(scene, {}, height, width, round, layout, samples.data());
            bob::scatter(layout, round, samples.data(), 5, expected.data(), height, width);
            done += round.size();
        }
        for (const int threads : {1, 3}) {
            const int before = bob::thread_count();
            bob::set_thread_count(threads);
            for (const std::size_t step : {wanted, std::size_t{97}}) {
                bob::PictureTracing picture(scene, {}, height, width, layout, "priority", 3);
                std::vector<float> planes(5 * pixels);
                while (picture.done() < wanted) picture.trace(std::min(picture.done() + step, wanted), planes.data());
                CHECK_EQ(picture.done(), wanted);
                CHECK(planes == expected);
            }
            bob::set_thread_count(before);
        }
    }
}

TEST(a_picture_of_tiles_has_all_pixels) {
    const auto sphere = test::sphere(5, 1);
    const bob::Scene scene = scene_of(sphere.vertices, sphere.triangles);
    for (const auto& [height, width] : {std::pair{1, 1}, {13, 30}, {64, 40}}) {
        const auto pixels = static_cast<std::size_t>(height * width);
        const auto all = render(scene, {}, height, width);
        bob::PictureTracing picture(scene, {}, height, width, bob::gbuffer_layout(), "tiles", 0);
        std::vector<float> planes(5 * pixels);
        for (std::size_t count = 1; picture.done() < pixels; count = picture.done() + 1) picture.trace(count, planes.data());
        CHECK_EQ(std::count(planes.begin(), planes.begin() + static_cast<std::ptrdiff_t>(pixels), 1.f), static_cast<std::ptrdiff_t>(pixels));
        CHECK(std::equal(all.gray.begin(), all.gray.end(), planes.begin() + static_cast<std::ptrdiff_t>(pixels)));
    }
}
