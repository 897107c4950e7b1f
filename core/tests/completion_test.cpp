#include <algorithm>
#include <random>
#include <stdexcept>

#include "base/parallel.h"
#include "check.h"
#include "completion/conv3x3.h"
#include "completion/filling.h"
#include "completion/known.h"
#include "completion/paper.h"
#include "completion/pyramid.h"
#include "interrupted.h"
#include "meshes.h"

using bob::Planes;
using bob::Then;

namespace {

/// The convolution by its definition, in double precision, at one pixel.
double convolved(const Planes& input, const std::vector<float>& weight, const std::vector<float>& bias, int in,
                 int groups, int channel, int y, int x) {
    const int inputs = in / groups, outputs = static_cast<int>(bias.size()) / groups;
    double sum = bias[static_cast<std::size_t>(channel)];
    for (int i = 0; i < inputs; ++i) {
        for (int ky = 0; ky < 3; ++ky) {
            for (int kx = 0; kx < 3; ++kx) {
                const int py = y + ky - 1, px = x + kx - 1;
                if (py < 0 || py >= input.height() || px < 0 || px >= input.width()) continue;
                sum += double{weight[static_cast<std::size_t>(((channel * inputs + i) * 3 + ky) * 3 + kx)]} *
                       input.row(channel / outputs * inputs + i, py)[px];
            }
        }
    }
    return sum;
}

/// Channels of an image with a share of pixels other than 0.
void check_conv(int in, int out, int groups, int height, int width, Then then, int rows, float share) {
    test::Random random(static_cast<std::uint64_t>(in * 1000 + width));
    std::vector<float> weight(static_cast<std::size_t>(out * in / groups * 9)), bias(static_cast<std::size_t>(out));
    for (auto& w : weight) w = random(-0.3f, 0.3f);
    for (auto& b : bias) b = random(-0.3f, 0.3f);
    Planes input(in, height, width);
    for (int c = 0; c < in; ++c) {
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) input.row(c, y)[x] = random() < share ? random(-1, 1) : 0.f;
        }
    }
    const int scale = then == Then::relu_upsample || then == Then::shuffle ? 2 : 1;
    const int shrink = then == Then::relu_pool ? 2 : 1, merged = then == Then::shuffle ? 4 : 1;
    Planes output(out / merged + 1, height * scale / shrink, width * scale / shrink);
    bob::Conv3x3(weight, bias, in, groups, rows)(input, 0, output, 1, then, 0, height);

    const bool linear = then == Then::nothing || then == Then::shuffle;
    const auto relu = [&](double v) { return linear ? v : std::max(0., v); };
    const auto at = [&](int c, int y, int x) { return relu(convolved(input, weight, bias, in, groups, c, y, x)); };
    for (int c = 0; c < out / merged; ++c) {
        for (int y = 0; y < output.height(); ++y) {
            for (int x = 0; x < output.width(); ++x) {
                const double want = then == Then::relu_pool
                                        ? std::max(std::max(at(c, 2 * y, 2 * x), at(c, 2 * y, 2 * x + 1)),
                                                   std::max(at(c, 2 * y + 1, 2 * x), at(c, 2 * y + 1, 2 * x + 1)))
                                    : then == Then::shuffle ? at(4 * c + y % 2 * 2 + x % 2, y / 2, x / 2)
                                                            : at(c, y / scale, x / scale);
                CHECK_NEAR(output.row(c + 1, y)[x], want, 1e-5);
            }
            CHECK_EQ(output.row(c + 1, y)[-1], 0.f);
            CHECK_EQ(output.row(c + 1, y)[output.width()], 0.f);
        }
        for (int x = -1; x <= output.width(); ++x) {
            CHECK_EQ(output.row(c + 1, -1)[x], 0.f);
            CHECK_EQ(output.row(c + 1, output.height())[x], 0.f);
        }
    }
}

bob::Weights no_tensors() { return {bob::gbuffer_layout(), {bob::channels::gray}, {}}; }

bob::Weights paper_weights(std::vector<std::vector<float>>& storage, int groups) {
    struct Layer { const char* name; int in, out, groups; };
    bob::Weights weights = no_tensors();
    storage.reserve(12);
    test::Random random(3);
    for (const Layer& layer : {Layer{"encode1", 5, 20, 1}, {"encode2", 20, 80, groups}, {"encoded", 80, 20, groups},
                               {"decode1", 20, 5, 1}, {"decode2", 25, 5, 1}, {"output", 10, 1, 1}}) {
        const int inputs = layer.in / layer.groups;
        auto& weight = storage.emplace_back(static_cast<std::size_t>(layer.out * inputs * 9));
        for (auto& w : weight) w = random(-0.1f, 0.1f);
        weights.tensors[std::string(layer.name) + ".weight"] = {{layer.out, inputs, 3, 3}, weight};
        storage.emplace_back(static_cast<std::size_t>(layer.out), 0.1f);
        weights.tensors[std::string(layer.name) + ".bias"] = {{layer.out}, storage.back()};
    }
    return weights;
}

bob::Weights pyramid_weights(std::vector<std::vector<float>>& storage, int levels = 6) {
    bob::Weights weights = no_tensors();
    storage.reserve(24);
    test::Random random(4);
    const auto add = [&](const std::string& name, int in, int out) {
        auto& weight = storage.emplace_back(static_cast<std::size_t>(out * in * 9));
        for (auto& w : weight) w = random(-0.1f, 0.1f);
        weights.tensors[name + ".weight"] = {{out, in, 3, 3}, weight};
        weights.tensors[name + ".bias"] = {{out}, storage.emplace_back(static_cast<std::size_t>(out), 0.1f)};
    };
    for (int level = 1; level <= levels; ++level) {
        const int handed = level == levels ? 0 : 8, features = level == 1 ? 8 : 20;
        add("features" + std::to_string(level), (level == 1 ? 11 : 8) + handed, features);
        add("finer" + std::to_string(level), features, level == 1 ? 4 : 32);
    }
    return weights;
}

/// The sizes of tests/test_complete.py, and tall ones, with even and odd levels.
const std::pair<int, int> sizes[] = {{1, 1},    {2, 3},     {5, 7},     {1, 258},   {61, 47},  {64, 64},  {100, 70},
                                     {130, 257}, {17, 1000}, {1000, 17}, {700, 40}, {203, 21}, {1155, 3}};

/// The filling, of mask and gray; tests hand it the other channels too, which come after.
bob::Filling filling() { return bob::Filling({{bob::channels::mask, bob::channels::gray}, {bob::channels::gray}, {}}); }

}  // namespace

/// Widths: less than a vector, each number of vectors in a step, and a little over a tile. Heights end anywhere among the rows
/// of one step. With few pixels other than 0, the kernel skips most channels in most places. A sum of 180 products of up to .3
/// rounds by up to 180 x .3 x 2^-24 = 3e-6; Winograd's schemes at points near 1 round no worse (`winograd_near`). The limit is twice that.
TEST(convolutions_follow_their_definition) {
    test::for_each_isa([] {
        for (const float share : {1.f, 0.01f}) {
            for (const int width : {2, 6, 14, 32, 34, 70, 130, 162, 198}) {
                for (const int height : {2, 4, 6, 10}) {
                    check_conv(5, 20, 1, height, width, Then::relu_pool, 4, share);
                    check_conv(20, 40, 4, height, width, Then::relu_pool, 4, share);
                    check_conv(20, 48, 4, height, width, Then::relu_pool, 2, share);
                }
                check_conv(8, 20, 4, 5, width, Then::relu, 4, share);
                check_conv(7, 5, 1, 3, width, Then::relu_upsample, 4, share);
                check_conv(10, 1, 1, 7, width, Then::nothing, 4, share);
                check_conv(4, 3, 1, 5, width, Then::relu, 4, share);
                for (const int rows : {2, 4}) {
                    check_conv(17, 8, 1, 6, width, Then::relu, rows, share);
                    check_conv(6, 12, 1, 5, width, Then::shuffle, rows, share);
                    check_conv(3, 4, 1, 9, width, Then::nothing, rows, share);
                }
            }
            check_conv(3, 5, 1, 1, 1, Then::nothing, 4, share);
            check_conv(3, 4, 1, 1, 1, Then::nothing, 2, share);
        }
    });
}

/// A G-buffer of noise, the same for the same size.
std::vector<float> noise(int height, int width) {
    test::Random random(9);
    std::vector<float> gbuffer(static_cast<std::size_t>(5 * height * width));
    for (auto& v : gbuffer) v = random();
    return gbuffer;
}

template <class Network>
std::vector<float> completed(Network&& network, const std::vector<float>& gbuffer, int height, int width) {
    std::vector<float> gray(static_cast<std::size_t>(height * width));
    network(gbuffer.data(), height, width, gray.data());
    return gray;
}

/// The output of a network for noise.
template <class Network>
std::vector<float> completed(Network&& network, int height, int width) {
    return completed(network, noise(height, width), height, width);
}

TEST(networks_give_the_same_from_call_to_call_and_size_to_size) {
    std::vector<std::vector<float>> storage;
    const auto weights = paper_weights(storage, 4);
    const bob::Paper used(weights);
    // All sizes have one padded size: values that a call leaves in the padding must not appear in the next result.
    for (const auto& [height, width] : {std::pair{37, 51}, {38, 50}, {40, 52}, {37, 49}, {38, 50}}) {
        CHECK(completed(used, height, width) == completed(bob::Paper(weights), height, width));
    }
    CHECK_EQ(completed(used, 1, 1).size(), 1u);

    test::for_each_isa([] {
        std::vector<std::vector<float>> storage;
        const auto weights = pyramid_weights(storage);
        const bob::Pyramid used(weights);
        for (const auto& [height, width] : {std::pair{37, 51}, {64, 64}, {1, 1}, {33, 63}, {50, 130}, {100, 60}}) {
            CHECK(completed(used, height, width) == completed(bob::Pyramid(weights), height, width));
        }
        const bob::Filling filled = filling();
        for (const auto& [height, width] : sizes) {
            CHECK(completed(filled, height, width) == completed(filling(), height, width));
        }
    });
}

TEST(large_pictures_are_completed_in_windows_of_rows) {
    test::for_each_isa([] {
        std::vector<std::vector<float>> of_paper, of_pyramid;
        const auto paper = paper_weights(of_paper, 4), pyramid = pyramid_weights(of_pyramid);
        for (const auto& [height, width] : sizes) {
            const auto paper_whole = completed(bob::Paper(paper), height, width);
            const auto pyramid_whole = completed(bob::Pyramid(pyramid), height, width);
            for (const std::size_t memory : {0u, 300'000u, 1'000'000u}) {  // the least rows at once, and some more
                CHECK(completed(bob::Paper(paper, memory), height, width) == paper_whole);
                CHECK(completed(bob::Pyramid(pyramid, memory), height, width) == pyramid_whole);
            }
        }
    });
}

/// Threads share the finest level in bands of rows; wide pictures are cut into tiles of columns too. At a seam, both sides
/// must compute everything that a pixel depends on.
TEST(threads_and_tiles_leave_no_seams) {
    const int threads = bob::thread_count();
    test::for_each_isa([&] {
        std::vector<std::vector<float>> of_six, of_two, of_paper;
        const bob::Pyramid six(pyramid_weights(of_six)), two(pyramid_weights(of_two, 2));
        const bob::Paper paper(paper_weights(of_paper, 4));
        const bob::Filling filled = filling();
        for (const auto& [height, width] : {std::pair{300, 33}, {131, 1101}, {66, 2090}}) {
            bob::set_thread_count(1);
            const auto of_pyramid = completed(six, height, width), of_paper = completed(paper, height, width);
            const auto of_filling = completed(filled, height, width);
            for (const int count : {2, 3, 8, 16}) {
                bob::set_thread_count(count);
                // Memory holds another picture's values. They must not replace missing ones.
                completed(six, std::vector<float>(static_cast<std::size_t>(5 * height * width), 0.5f), height, width);
                CHECK(completed(six, height, width) == of_pyramid);
                CHECK(completed(paper, height, width) == of_paper);
                CHECK(completed(filled, height, width) == of_filling);
            }
            bob::set_thread_count(threads);

            // A piece that is too narrow to be cut.
            const auto values = noise(height, width), whole = completed(two, values, height, width);
            // Two levels reach 29 pixels; both compute four rows at once, that is from every 16th pixel on.
            const int reach = 29, columns = std::min(width, 400);
            for (int left = 0; left + columns <= width; left += 16 * 9) {
                std::vector<float> piece;
                for (int row = 0; row < 5 * height; ++row) {
                    const auto from = values.begin() + row * width + left;
                    piece.insert(piece.end(), from, from + columns);
                }
                const auto gray = completed(two, piece, height, columns);
                for (int y = 0; y < height; ++y) {
                    for (int x = left == 0 ? 0 : reach; x < columns - (left + columns == width ? 0 : reach); ++x) {
                        CHECK_EQ(gray[static_cast<std::size_t>(y * columns + x)], whole[static_cast<std::size_t>(y * width + left + x)]);
                    }
                }
            }
        }
    });
}

/// Completing rows gives the rows of the whole picture, whatever an earlier picture left in memory.
TEST(bands_of_rows_are_those_of_the_whole_picture) {
    test::for_each_isa([] {
        std::vector<std::vector<float>> of_six, of_two, of_paper;
        const auto check = [](const auto& network) {
            for (const auto& [height, width] : {std::pair{1, 1}, {2, 3}, {37, 51}, {480, 65}, {701, 33}, {130, 1101}}) {
                const auto values = noise(height, width), whole = completed(network, values, height, width);
                const std::vector<float> other(values.size(), 0.5f);
                for (const int bands : {1, 2, 3, 7}) {
                    std::vector<float> gray(whole.size());
                    for (int i = 0; i < bands; ++i) {
                        const bob::Band band{i * height / bands, (i + 1) * height / bands};
                        std::vector<float> part(whole.size());
                        network(other.data(), height, width, part.data(), band);
                        network(values.data(), height, width, part.data(), band);
                        std::copy(part.begin() + band.begin * width, part.begin() + band.end * width, gray.begin() + band.begin * width);
                    }
                    CHECK(gray == whole);
                }
            }
        };
        const auto weights = pyramid_weights(of_six);
        check(bob::Pyramid(weights));
        check(bob::Pyramid(weights, 0));  // in windows of the least rows
        check(bob::Pyramid(pyramid_weights(of_two, 2), 300'000));
        check(bob::Paper(paper_weights(of_paper, 4)));
        check(filling());
    });
}

TEST(what_is_no_number_stays_within_reach) {
    const float nan = std::nanf(""), infinity = INFINITY;
    test::for_each_isa([&] {
        std::vector<std::vector<float>> of_paper, of_pyramid;
        const bob::Paper paper(paper_weights(of_paper, 4));
        const bob::Pyramid pyramid(pyramid_weights(of_pyramid));
        const bob::Filling filled = filling();
        const int height = 1100, width = 9;
        const auto values = noise(height, width);
        const auto check = [&](const auto& network, int reach, int place) {
            const auto expected = completed(network, values, height, width);
            for (const float strange : {nan, infinity, -infinity, 3e38f, 1e-42f}) {
                auto changed = values;
                for (int c = 0; c < 5; ++c) changed[static_cast<std::size_t>((c * height + place) * width + c)] = strange;
                const auto gray = completed(network, changed, height, width);
                CHECK_EQ(gray.size(), expected.size());
                for (std::size_t i = 0; i < gray.size(); ++i) {
                    if (std::abs(static_cast<int>(i) / width - place) > reach) CHECK_EQ(gray[i], expected[i]);
                }
            }
        };
        // Where rows computed at once begin and end, at the coarsest levels too.
        for (const int place : {511, 512, 601, 639, 640}) {
            check(paper, 28, place);
            check(pyramid, 345, place);
            check(filled, 192, place);
        }
    });
}

TEST(a_network_stops_when_it_is_told_to) {
    std::vector<std::vector<float>> storage;
    const bob::Pyramid network(pyramid_weights(storage), 0);
    const std::vector<float> gbuffer(5 * 400 * 8);
    std::vector<float> gray(400 * 8, -1);
    int asked = 0;
    {
        const bob::Interruption interruption([&] { return ++asked, true; });
        network(gbuffer.data(), 400, 8, gray.data());
    }
    CHECK(gray.back() != -1);
    std::fill(gray.begin(), gray.end(), -1.f);
    CHECK(stops_after(asked / 2, [&] { network(gbuffer.data(), 400, 8, gray.data()); }));
    CHECK(gray[0] != -1);
    CHECK_EQ(gray.back(), -1.f);
}

TEST(weights_that_do_not_fit_are_refused_by_name) {
    const auto refused = [](auto spoil, const char* name) {
        std::vector<std::vector<float>> storage;
        auto weights = paper_weights(storage, 4);
        spoil(weights);
        try {
            const bob::Paper network(weights);
        } catch (const std::invalid_argument& error) {
            return std::string(error.what()).find(name) != std::string::npos;
        }
        return false;
    };
    CHECK(refused([](auto& w) { w.tensors.erase("encoded.bias"); }, "encoded.bias"));
    CHECK(refused([](auto& w) { w.tensors["decode2.weight"].shape = {5, 24, 3, 3}; }, "decode2.weight"));
    CHECK(refused([](auto& w) { w.tensors["encode1.weight"].shape = {20, 5, 9}; }, "encode1.weight"));
    CHECK(refused([](auto& w) { w.tensors["output.bias"].shape = {2}; }, "output.bias"));
    CHECK(refused([](auto& w) { w.tensors["encode2.weight"].shape = {80, 0, 3, 3}; }, "encode2.weight"));
    const auto refused_by_filling = [](const bob::Weights& weights, const char* name) {
        try {
            const bob::Filling network(weights);
        } catch (const std::invalid_argument& error) {
            return std::string(error.what()).find(name) != std::string::npos;
        }
        return false;
    };
    const bob::Layout gray{bob::channels::gray}, both{bob::channels::mask, bob::channels::gray};
    CHECK(refused_by_filling({both, gray, {{"output.bias", {{0}, {}}}}}, "output.bias"));
    CHECK(refused_by_filling({bob::gbuffer_layout(), gray, {}}, "inputs"));
}

TEST(known_pixels_are_kept_and_the_others_clamped) {
    const std::vector<float> gbuffer{1, 0, 0, 0, /* gray */ 0.25f, 0, 0, 0};
    std::vector<float> gray{0.9f, 1.5f, -2, std::nanf("")};
    const bob::Layout known{bob::channels::mask, bob::channels::gray}, completed{bob::channels::gray};
    bob::keep_known(known, gbuffer.data(), completed, gray.data(), 4);
    CHECK_EQ(gray[0], 0.25f);
    CHECK_EQ(gray[1], 1.f);
    CHECK_EQ(gray[2], 0.f);
    CHECK_EQ(gray[3], 0.f);
}
