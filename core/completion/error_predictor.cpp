#include "completion/error_predictor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "completion/interpolation.h"

namespace bob {
namespace {

/// Clamp for distances, in pixels.
constexpr int far_away = 64;

/// Clamps for logarithms: every picture stays within float32.
constexpr float lowest = -14, highest = 0;

/// A traced pixel.
struct Known {
    std::int32_t row, column;
    float gray, depth, normal_x, normal_y;
    float residual;  // error of the network's own output at this pixel
    bool hit;
};

const std::vector<float>& logarithms_of_squares() {
    static const std::vector<float> table = [] {
        std::vector<float> values(far_away * far_away + 1);
        for (std::size_t square = 1; square < values.size(); ++square) {
            values[square] = 0.5f * static_cast<float>(std::log2(static_cast<double>(square)));
        }
        return values;
    }();
    return table;
}

/// The traced pixels of a G-buffer, and the nearest of them for every pixel.
class Surroundings {
public:
    Surroundings(const Layout& layout, const float* planes, const float* gray, int height, int width)
        : height_(height), width_(width) {
        const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        const auto plane = [&](const Channel& channel) { return planes + static_cast<std::size_t>(layout.place_of(channel)) * pixels; };
        const float *mask = plane(channels::mask), *traced_gray = plane(channels::gray), *depth = plane(channels::depth),
                    *normal = plane(channels::normal);
        for (auto& of_quadrant : nearest_) of_quadrant.assign(pixels, none);
        for (std::size_t i = 0; i < pixels; ++i) {
            if (!(mask[i] > 0)) continue;
            nearest_[0][i] = nearest_[1][i] = nearest_[2][i] = nearest_[3][i] = static_cast<std::int32_t>(known_.size());
            const auto row = static_cast<std::int32_t>(i / static_cast<std::size_t>(width));
            known_.push_back({row, static_cast<std::int32_t>(i) - row * width, traced_gray[i], depth[i], normal[i],
                              normal[i + pixels], std::abs(clamped(gray[i]) - traced_gray[i]), depth[i] > 0});
        }
        completed_.assign(gray, gray + pixels), agreement_.resize(pixels);
        interpolate_lattice(layout, planes, channels::gray, 1, completed_.data(), agreement_.data(), height, width);
        parallel_for(4, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t quadrant = begin; quadrant < end; ++quadrant) search(static_cast<int>(quadrant));
        });
    }

    [[nodiscard]] bool is_known(int row, int column) const {
        const std::int32_t i = nearest_[0][index(row, column)];
        return i >= 0 && known_[static_cast<std::size_t>(i)].row == row && known_[static_cast<std::size_t>(i)].column == column;
    }

    /// The features of an untraced pixel, `stride` floats apart.
    void describe(int row, int column, float* features, std::size_t stride) const {
        const std::size_t at = index(row, column);
        const float completed = clamped(completed_[at]);
        std::array<std::int32_t, 4> squares;
        Range gray, hit, normal_x, normal_y, depth;
        float weight = 0, residual = 0, change = 0, greatest_change = 0;
        for (std::size_t quadrant = 0; quadrant < 4; ++quadrant) {
            const std::int32_t found = nearest_[quadrant][at];
            squares[quadrant] = far_away * far_away;
            if (found < 0) continue;
            const Known& known = known_[static_cast<std::size_t>(found)];
            const std::int64_t square = square_to(known, row, column);
            squares[quadrant] = static_cast<std::int32_t>(std::min<std::int64_t>(square, squares[quadrant]));
            gray.add(known.gray), hit.add(known.hit), normal_x.add(known.normal_x), normal_y.add(known.normal_y);
            if (known.hit) depth.add(known.depth);
            const float w = 1 / static_cast<float>(square), d = std::abs(known.gray - completed);
            weight += w, residual += w * known.residual, change += w * d, greatest_change = std::max(greatest_change, d);
        }
        std::ranges::sort(squares);
        const auto set = [&](int feature, float value) { features[static_cast<std::size_t>(feature) * stride] = value; };
        for (int i = 0; i < 4; ++i) {
            set(error_features::nearest + i, logarithms_[static_cast<std::size_t>(squares[static_cast<std::size_t>(i)])]);
        }
        set(error_features::gray_range, gray.size());
        set(error_features::hit_range, hit.size());
        set(error_features::normal_range, normal_x.size() + normal_y.size());
        set(error_features::depth_range, depth.size());
        set(error_features::any_hit, depth.high >= depth.low ? 1.f : 0.f);
        set(error_features::residual, weight > 0 ? residual / weight : 0);
        set(error_features::greatest_change, greatest_change);
        set(error_features::mean_change, weight > 0 ? change / weight : 0);
        set(error_features::gray, completed);
        set(error_features::agreement, agreement_[at]);
    }

private:
    static constexpr std::int32_t none = -1;

    struct Range {
        float low = 2, high = -2;  // outside all values
        void add(float value) { low = std::min(low, value), high = std::max(high, value); }
        [[nodiscard]] float size() const { return std::max(0.f, high - low); }
    };

    static float clamped(float gray) { return gray > 0 ? std::min(gray, 1.f) : 0.f; }

    static std::int64_t square_to(const Known& known, int row, int column) {
        const std::int64_t down = known.row - row, right = known.column - column;
        return down * down + right * right;
    }

    [[nodiscard]] std::size_t index(int row, int column) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    }

    /// Propagates the nearest traced pixels across the picture, away from the quadrant's corner. They are the nearest
    /// by steps along rows and columns, and nearly always the nearest by distance.
    void search(int quadrant) {
        auto& nearest = nearest_[static_cast<std::size_t>(quadrant)];
        const int down = quadrant & 1 ? -1 : 1, right = quadrant & 2 ? -1 : 1;
        for (int y = 0; y < height_; ++y) {
            const int row = down > 0 ? y : height_ - 1 - y;
            for (int x = 0; x < width_; ++x) {
                const int column = right > 0 ? x : width_ - 1 - x;
                std::int32_t& here = nearest[index(row, column)];
                if (here != none) continue;
                const std::int32_t before = x > 0 ? nearest[index(row, column - right)] : none;
                const std::int32_t above = y > 0 ? nearest[index(row - down, column)] : none;
                if (before == none || above == none) {
                    here = std::max(before, above);
                    continue;
                }
                const auto square = [&](std::int32_t i) { return square_to(known_[static_cast<std::size_t>(i)], row, column); };
                here = square(before) <= square(above) ? before : above;
            }
        }
    }

    int height_, width_;
    std::vector<Known> known_;
    std::vector<float> completed_, agreement_;  // gray after interpolation, and the weight of the interpolation
    std::array<std::vector<std::int32_t>, 4> nearest_;  // of each pixel, by quadrant
    const std::vector<float>& logarithms_ = logarithms_of_squares();
};

}  // namespace

ErrorPredictor::ErrorPredictor(const Weights& weights) {
    const auto bias = weights.tensors.find("hidden.bias");
    const int hidden = bias == weights.tensors.end() ? 0 : static_cast<int>(bias->second.values.size());
    const auto copy = [&](const char* name, const std::vector<int>& shape) {
        const std::span<const float> values = tensor(weights, name, shape);
        return std::vector<float>(values.begin(), values.end());
    };
    hidden_bias_ = copy("hidden.bias", {hidden});
    hidden_weights_ = copy("hidden.weight", {hidden, error_features::count});
    output_weights_ = copy("output.weight", {1, hidden});
    output_bias_ = tensor(weights, "output.bias", {1})[0];
}

void ErrorPredictor::operator()(const Layout& layout, const float* planes, const float* gray, int height, int width,
                                float* error) const {
    const Surroundings surroundings(layout, planes, gray, height, width);
    const auto& kernels = best_error_predictor_kernels();
    const ErrorLayers layers{hidden_weights_.data(), hidden_bias_.data(), output_weights_.data(), output_bias_,
                             static_cast<int>(hidden_bias_.size())};
    for_rows(0, height, width, [&](int row) {
        constexpr int piece = 64;  // pixels
        float features[error_features::count * piece] = {}, logarithms[piece];
        for (int begin = 0; begin < width; begin += piece) {
            const int end = std::min(begin + piece, width);
            for (int column = begin; column < end; ++column) {
                if (!surroundings.is_known(row, column)) surroundings.describe(row, column, features + (column - begin), piece);
            }
            kernels.predict(layers, features, piece, piece, logarithms);
            for (int column = begin; column < end; ++column) {
                const float logarithm = std::clamp(logarithms[column - begin], lowest, highest);
                error[static_cast<std::ptrdiff_t>(row) * width + column] =
                    surroundings.is_known(row, column) ? 0 : std::exp(logarithm);
            }
        }
    });
}

void ErrorPredictor::features(const Layout& layout, const float* planes, const float* gray, int height, int width,
                              float* features) {
    const Surroundings surroundings(layout, planes, gray, height, width);
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    std::fill_n(features, error_features::count * pixels, 0.f);
    for_rows(0, height, width, [&](int row) {
        for (int column = 0; column < width; ++column) {
            if (surroundings.is_known(row, column)) continue;
            surroundings.describe(row, column, features + static_cast<std::ptrdiff_t>(row) * width + column, pixels);
        }
    });
}

}  // namespace bob
