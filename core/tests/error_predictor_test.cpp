#include "completion/error_predictor.h"

#include <cmath>
#include <stdexcept>

#include "check.h"
#include "meshes.h"

namespace {

namespace features = bob::error_features;

/// A G-buffer, and its completion by a network.
struct Picture {
    int height, width;
    std::vector<float> planes = std::vector<float>(5 * size()), gray = std::vector<float>(size());

    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }
    [[nodiscard]] std::size_t at(int row, int column) const { return static_cast<std::size_t>(row * width + column); }

    void trace(int row, int column, std::array<float, 4> values) {
        planes[at(row, column)] = 1;
        for (std::size_t channel = 0; channel < 4; ++channel) planes[(channel + 1) * size() + at(row, column)] = values[channel];
    }
    [[nodiscard]] std::vector<float> features() const {
        std::vector<float> result(size() * features::count, -1);
        bob::ErrorPredictor::features(bob::gbuffer_layout(), planes.data(), gray.data(), height, width, result.data());
        return result;
    }
};

Picture noise(int height, int width, float density) {
    test::Random random(static_cast<std::uint64_t>(width));
    Picture picture{height, width};
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            picture.gray[picture.at(row, column)] = random(-0.2f, 1.2f);
            if (random(0, 1) < density) picture.trace(row, column, {random(0, 1), random(-0.5f, 1), random(-1, 1), random(-1, 1)});
        }
    }
    return picture;
}

struct Layers {
    std::vector<float> hidden_weight, hidden_bias, output_weight, output_bias{-2};
    explicit Layers(int hidden) {
        test::Random random(7);
        for (int i = 0; i < hidden * features::count; ++i) hidden_weight.push_back(random(-0.3f, 0.3f));
        for (int i = 0; i < hidden; ++i) hidden_bias.push_back(random(-1, 1)), output_weight.push_back(random(-0.5f, 0.5f));
    }
    [[nodiscard]] bob::Weights weights() const {
        const int hidden = static_cast<int>(hidden_bias.size());
        return {bob::gbuffer_layout(),
                {bob::channels::gray},
                {{"hidden.weight", {{hidden, features::count}, hidden_weight}},
                 {"hidden.bias", {{hidden}, hidden_bias}},
                 {"output.weight", {{1, hidden}, output_weight}},
                 {"output.bias", {{1}, output_bias}}}};
    }
};

}  // namespace

TEST(features_are_of_the_nearest_pixel_in_each_quadrant) {
    Picture picture{9, 9};
    picture.gray.assign(picture.size(), 0.25f);
    picture.gray[picture.at(4, 3)] = 0.5f;               // wrong by 0.3
    picture.trace(4, 3, {0.2f, 0.5f, 0.1f, -0.2f});      // to the left: in both quadrants of that side
    picture.trace(2, 6, {0.6f, 0.7f, 0.3f, 0.4f});       // above, to the right
    picture.trace(8, 8, {0, 0, 0, 0});                   // below, to the right: missed
    picture.trace(0, 0, {1, 1, 1, 1});                   // behind another
    const std::vector<float> found = picture.features();
    const auto feature = [&](int k) { return found[static_cast<std::size_t>(k) * picture.size() + picture.at(4, 4)]; };
    const double near = 1 + 1, right = 1. / 8, far = 1. / 32, total = near + right + far;
    CHECK_NEAR(feature(features::nearest), 0, 1e-6);
    CHECK_NEAR(feature(features::second), 0, 1e-6);
    CHECK_NEAR(feature(features::third), std::log2(8) / 2, 1e-6);
    CHECK_NEAR(feature(features::farthest), std::log2(32) / 2, 1e-6);
    CHECK_NEAR(feature(features::gray_range), 0.6, 1e-6);
    CHECK(feature(features::hit_range) == 1 && feature(features::any_hit) == 1);
    CHECK_NEAR(feature(features::normal_range), 0.3 + 0.6, 1e-6);
    CHECK_NEAR(feature(features::depth_range), 0.2, 1e-6);
    CHECK_NEAR(feature(features::residual), (near * 0.3 + right * 0.35 + far * 0.25) / total, 1e-6);
    CHECK_NEAR(feature(features::greatest_change), 0.35, 1e-6);
    CHECK_NEAR(feature(features::mean_change), (near * 0.05 + right * 0.35 + far * 0.25) / total, 1e-6);
    CHECK_NEAR(feature(features::gray), 0.25, 1e-6);
    CHECK(feature(features::agreement) == 0);
    for (int k = 0; k < features::count; ++k) CHECK(found[static_cast<std::size_t>(k) * picture.size() + picture.at(4, 3)] == 0);
}

TEST(nothing_known_is_far_away) {
    const Picture picture{3, 2};
    const std::vector<float> found = picture.features();
    for (int k = 0; k < features::count; ++k) CHECK_NEAR(found[static_cast<std::size_t>(k) * picture.size()], k < 4 ? 6 : 0, 1e-6);
}

TEST(predicted_errors_are_those_of_the_layers) {
    for (const auto& [height, width] : {std::pair{1, 1}, {3, 64}, {5, 65}, {40, 130}}) {
        for (const float density : {0.f, 0.1f, 0.6f, 2.f}) {
            const Picture picture = noise(height, width, density);
            const Layers layers(5);
            std::vector<float> error(picture.size(), -1);
            bob::ErrorPredictor(layers.weights())(bob::gbuffer_layout(), picture.planes.data(), picture.gray.data(), height, width,
                                                  error.data());
            const std::vector<float> found = picture.features();
            for (std::size_t i = 0; i < picture.size(); ++i) {
                double logarithm = layers.output_bias[0];
                for (std::size_t j = 0; j < 5; ++j) {
                    double hidden = layers.hidden_bias[j];
                    for (std::size_t k = 0; k < features::count; ++k) {
                        hidden += double{layers.hidden_weight[j * features::count + k]} * found[k * picture.size() + i];
                    }
                    logarithm += layers.output_weight[j] * std::max(0., hidden);
                }
                CHECK_NEAR(error[i], picture.planes[i] > 0 ? 0 : std::exp(std::min(0., logarithm)), 1e-5);
            }
        }
    }
}

TEST(weights_of_another_predictor_are_refused) {
    const auto refused = [](const bob::Weights& weights) {
        try {
            const bob::ErrorPredictor predictor(weights);
        } catch (const std::invalid_argument&) {
            return true;
        }
        return false;
    };
    const Layers layers(3);
    CHECK(!refused(layers.weights()));
    for (const char* name : {"hidden.weight", "hidden.bias", "output.weight", "output.bias"}) {
        bob::Weights weights = layers.weights();
        weights.tensors.find(name)->second.shape.push_back(1);
        CHECK(refused(weights));
        weights.tensors.erase(weights.tensors.find(name));
        CHECK(refused(weights));
    }
}
