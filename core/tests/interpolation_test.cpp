#include "completion/interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "check.h"
#include "meshes.h"
#include "sampling/order.h"

namespace {

const bob::Layout gray{bob::channels::gray};

/// A G-buffer whose first lattice pixels are f(row, column).
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

namespace {

/// The definition, pixel by pixel over whole planes: each pixel's value and the spread of the values it was made from, from the
/// coarsest squares to the finest.
struct Defined {
    int height, width, components;
    std::vector<float> value, contrast, output, weights;

    Defined(const std::vector<float>& planes, std::vector<float> output, int height, int width, int components)
        : height(height), width(width), components(components), output(std::move(output)) {
        const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        value.assign(planes.begin() + static_cast<std::ptrdiff_t>(size), planes.end());
        contrast.resize(size), weights.resize(size);
        for (std::size_t i = 0; i < size; ++i) contrast[i] = planes[i] > 0 ? 0 : unknown;
        for (int step = 32; step > 0; step /= 2) {
            const int first = bob::lattice_first % step, odd = (bob::lattice_first - first) / step % 2;
            for (const bool middles : {true, false}) {
                for (int row = first; row < height; row += step) {
                    for (int column = first; column < width; column += step) {
                        const int down = ((row - first) / step + odd) % 2, right = ((column - first) / step + odd) % 2;
                        if (planes[at(row, column)] > 0 || (middles ? down + right != 2 : down + right != 1)) continue;
                        if (middles) {
                            make(row, column, step, {{{-step, -step}, {step, step}, {-step, step}, {step, -step}}});
                        } else {
                            make(row, column, step, {{{-step, 0}, {step, 0}, {0, -step}, {0, step}}});
                        }
                    }
                }
            }
        }
    }

private:
    static constexpr float unknown = std::numeric_limits<float>::infinity();

    [[nodiscard]] std::size_t at(int row, int column) const { return static_cast<std::size_t>(row * width + column); }

    void make(int row, int column, int step, const std::array<std::array<int, 2>, 4>& ways) {
        std::vector<std::size_t> corners;
        for (const auto& [down, right] : ways) {
            const int y = row + down, x = column + right;
            if (y >= 0 && y < height && x >= 0 && x < width) corners.push_back(at(y, x));
        }
        float differ = corners.empty() ? unknown : 0;
        for (const std::size_t i : corners) differ = std::max(differ, contrast[i]);
        if (!(differ < unknown)) return;
        const std::size_t here = at(row, column), plane = weights.size();
        std::vector<float> means(static_cast<std::size_t>(components));
        if (corners.size() == 4 && step <= 4) {
            float pairs[2], off = 0;
            std::vector<float> of[2] = {means, means};
            for (std::size_t k = 0; k < 2; ++k) pairs[k] = std::max(contrast[corners[2 * k]], contrast[corners[2 * k + 1]]);
            for (std::size_t c = 0; c < means.size(); ++c) {
                for (std::size_t k = 0; k < 2; ++k) {
                    const float a = value[c * plane + corners[2 * k]], b = value[c * plane + corners[2 * k + 1]];
                    of[k][c] = (a + b) / 2, pairs[k] = std::max(pairs[k], std::abs(a - b));
                }
                off = std::max(off, std::abs(of[0][c] - of[1][c]));
            }
            const std::size_t used = pairs[0] <= pairs[1] ? 0 : 1;
            means = of[used], differ = std::max(pairs[used], off - pairs[1 - used] / 2);
        } else {
            for (std::size_t c = 0; c < means.size(); ++c) {
                float sum = 0, low = unknown, high = -unknown;
                for (const std::size_t i : corners) {
                    const float v = value[c * plane + i];
                    sum += v, low = std::min(low, v), high = std::max(high, v);
                }
                means[c] = sum / static_cast<float>(corners.size()), differ = std::max(differ, high - low);
            }
        }
        const float weight = 1 - differ * (1 / 0.15f);
        if (!(weight > 0)) return;
        contrast[here] = differ, weights[here] = weight;
        for (std::size_t c = 0; c < means.size(); ++c) {
            value[c * plane + here] = means[c];
            output[c * plane + here] += (means[c] - output[c * plane + here]) * weight;
        }
    }
};

}  // namespace

TEST(pixels_are_interpolated_as_it_is_defined) {
    test::Random random(5);
    const int threads = bob::thread_count();
    for (const auto& [height, width] : {std::pair{1, 1}, {1, 90}, {90, 1}, {2, 3}, {22, 21}, {33, 64}, {64, 33}, {97, 131}, {200, 70}}) {
        for (const int components : {1, 3}) {
            for (const float share : {0.f, 0.02f, 0.3f}) {
                // The lattice of every 8th pixel and other pixels, with little noise and some large steps; half the picture is black.
                const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
                std::vector<float> planes(static_cast<std::size_t>(1 + components) * size);
                for (int row = 0; row < height; ++row) {
                    for (int column = 0; column < width; ++column) {
                        const auto i = static_cast<std::size_t>(row * width + column);
                        if (!(row % 8 == 5 && column % 8 == 5) && !(random() < share)) continue;
                        planes[i] = 1;
                        for (int c = 1; c <= components && row + column < 100; ++c) {
                            planes[static_cast<std::size_t>(c) * size + i] = (column > 50 ? 0.7f : 0.2f) + random(0, 0.04f);
                        }
                    }
                }
                std::vector<float> before(static_cast<std::size_t>(components) * size);
                for (float& v : before) v = random(0, 1);
                const bob::Channel& channel = components == 1 ? bob::channels::gray : bob::channels::color;
                const Defined defined(planes, before, height, width, components);
                for (const int count : {1, 3}) {
                    bob::set_thread_count(count);
                    std::vector<float> output = before, weights(size, -1);
                    bob::interpolate_lattice({bob::channels::mask, channel}, planes.data(), channel, 1, output.data(), weights.data(), height, width);
                    CHECK(output == defined.output);
                    CHECK(weights == defined.weights);
                    std::vector<float> without_weights = before;
                    bob::interpolate_lattice({bob::channels::mask, channel}, planes.data(), channel, 1, without_weights.data(), nullptr, height, width);
                    CHECK(without_weights == defined.output);
                }
            }
        }
    }
    bob::set_thread_count(threads);
}
