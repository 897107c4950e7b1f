#include "completion/interpolation.h"

#include <algorithm>
#include <cmath>

#include "check.h"
#include "meshes.h"
#include "picture/order.h"

namespace {

const bob::Layout gray{bob::channels::gray};

/// A G-buffer of which the first pixels of the lattice show f(row, column).
template <class F>
std::vector<float> traced(int height, int width, std::size_t count, F f) {
    const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    std::vector<float> planes(5 * size);
    std::vector<bob::Pixel> pixels(count);
    bob::make_order("lattice", 0, static_cast<std::uint32_t>(height), static_cast<std::uint32_t>(width))(0, pixels);
    for (const auto [row, column] : pixels) {
        const auto i = static_cast<std::size_t>(row * width + column);
        planes[i] = 1, planes[size + i] = f(row, column);
    }
    return planes;
}

void interpolate(const std::vector<float>& planes, std::vector<float>& image, int height, int width) {
    bob::interpolate_lattice(bob::gbuffer_layout(), planes.data(), gray, image.data(), height, width);
}

}  // namespace

TEST(equal_corners_are_believed) {
    for (const std::size_t count : {192 * 128 / 64, 192 * 128 / 32, 192 * 128 / 8, 192 * 128}) {
        const auto planes = traced(192, 128, count, [](int, int) { return 0.25f; });
        std::vector<float> image(192 * 128, 0.75f);
        interpolate(planes, image, 192, 128);
        std::vector<float> again(192 * 128, 0.75f), weights(image.size(), -1);
        bob::interpolate_lattice(bob::gbuffer_layout(), planes.data(), bob::channels::gray, 1, again.data(), weights.data(), 192, 128);
        CHECK(again == image);
        for (std::size_t i = 0; i < image.size(); ++i) {
            CHECK_EQ(image[i], planes[i] > 0 ? 0.75f : 0.25f);
            CHECK_EQ(weights[i], planes[i] > 0 ? 0 : 1);
        }
    }
}

/// A little noise: corners are believed to different degrees, at all distances.
TEST(bands_are_interpolated_as_the_whole_picture) {
    for (const auto& [height, width] : {std::pair{1, 1}, {70, 40}, {400, 50}, {531, 70}}) {
        for (const int share : {300, 40, 5}) {
            const auto noisy = [](int row, int column) { return 0.5f + 0.03f * std::sin(static_cast<float>(row * row + 7 * column)); };
            const auto planes = traced(height, width, static_cast<std::size_t>(height * width / share), noisy);
            std::vector<float> whole(static_cast<std::size_t>(height * width), 0.25f);
            interpolate(planes, whole, height, width);
            for (const int bands : {1, 2, 3, 7}) {
                std::vector<float> image(whole.size());
                for (int i = 0; i < bands; ++i) {
                    const bob::Band band{i * height / bands, (i + 1) * height / bands};
                    std::vector<float> part(whole.size(), 0.25f);
                    bob::interpolate_lattice(bob::gbuffer_layout(), planes.data(), gray, part.data(), height, width, band);
                    std::copy(part.begin() + band.begin * width, part.begin() + band.end * width, image.begin() + band.begin * width);
                }
                CHECK(image == whole);
            }
        }
    }
}

TEST(a_slope_is_continued_between_the_pixels) {
    const auto slope = [](int row, int column) { return 0.1f + 0.001f * static_cast<float>(row) + 0.002f * static_cast<float>(column); };
    const auto planes = traced(128, 128, 128 * 128 / 64, slope);
    std::vector<float> image(128 * 128, 1);
    interpolate(planes, image, 128, 128);
    // Corners 8 pixels away from each other differ by 0.024 in all: that much of 0.15 is left to the network.
    for (int row = 21; row < 100; ++row) {
        for (int column = 21; column < 100; ++column) {
            const auto i = static_cast<std::size_t>(row * 128 + column);
            if (planes[i] > 0) continue;
            const float weight = (1 - image[i]) / (1 - slope(row, column));
            CHECK(weight > 0.83f && weight < 1);
        }
    }
}

TEST(edges_are_followed) {
    // Of squares that a slanted edge cuts, the two corners along it agree.
    const auto edge = [](int row, int column) { return row + column < 127 ? 0.2f : 0.8f; };
    const auto planes = traced(128, 128, 128 * 128 / 4, edge);
    std::vector<float> image(128 * 128, 0.5f);
    interpolate(planes, image, 128, 128);
    int cut = 0;
    for (int row = 2; row < 126; row += 2) {
        for (int column = 2; column < 126; column += 2) {
            const auto i = static_cast<std::size_t>(row * 128 + column);
            cut += edge(row - 1, column - 1) != edge(row + 1, column + 1);
            CHECK_NEAR(image[i], edge(row, column), 1e-6);
        }
    }
    CHECK(cut > 50);
}

TEST(where_lines_go_is_left_to_the_network) {
    // In squares on the line, two corners say that it passes, and two that it does not.
    const auto line = [](int row, int column) { return row == column ? 0.8f : 0.2f; };
    const auto planes = traced(128, 128, 128 * 128 / 4, line);
    std::vector<float> image(128 * 128, 0.5f);
    interpolate(planes, image, 128, 128);
    for (int row = 2; row < 126; row += 2) {
        for (int column = 2; column < 126; column += 2) {
            CHECK_NEAR(image[static_cast<std::size_t>(row * 128 + column)], row == column ? 0.5f : 0.2f, 1e-6);
        }
    }
}

TEST(corners_that_differ_are_left_to_the_network) {
    const auto edge = [](int, int column) { return column < 60 ? 0.2f : 0.8f; };
    const auto planes = traced(128, 128, 128 * 128 / 16, edge);
    std::vector<float> image(128 * 128, 0.5f);
    interpolate(planes, image, 128, 128);
    int left = 0;
    for (int row = 8; row < 120; ++row) {
        for (int column = 8; column < 120; ++column) {
            const auto i = static_cast<std::size_t>(row * 128 + column);
            if (planes[i] > 0) continue;
            left += image[i] == 0.5f;
            if (image[i] != 0.5f || column < 55 || column > 64) CHECK_NEAR(image[i], edge(row, column), 1e-6);
        }
    }
    CHECK(left > 100);
}

TEST(pixels_beside_the_lattice_change_nothing) {
    std::vector<float> planes(5 * 64 * 64), image(64 * 64, 0.5f);
    for (int row = 0; row < 64; row += 4) planes[static_cast<std::size_t>(row * 64)] = 1;
    interpolate(planes, image, 64, 64);
    for (const float value : image) CHECK_EQ(value, 0.5f);
}

TEST(any_size_is_interpolated) {
    test::Random random(3);
    for (const auto& [height, width] : {std::pair{1, 1}, {1, 300}, {300, 1}, {5, 7}, {21, 22}, {23, 65}, {130, 67}}) {
        const auto count = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        const auto planes = traced(height, width, (count + 3) / 4, [&](int, int) { return random(0, 1); });
        std::vector<float> image(count, 0.5f);
        interpolate(planes, image, height, width);
        for (std::size_t i = 0; i < count; ++i) CHECK(planes[i] > 0 ? image[i] == 0.5f : image[i] >= 0 && image[i] <= 1);
    }
}
