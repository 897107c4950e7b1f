#include "light/environment.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/color.h"
#include "light/directions.h"

namespace bob {

Environment::Environment(std::span<const Vec3> texels, int height, int width) : height_(height), width_(width) {
    if (texels.size() > max_texels) throw std::invalid_argument("environment: expected at most 8192 x 4096 pixels; make a smaller picture of it");
    texels_.assign(texels.begin(), texels.end());
    const auto across = static_cast<std::size_t>(width), down = static_cast<std::size_t>(height);
    std::vector<float> beside(texels_.size());
    for (std::size_t i = 0; i < texels_.size(); ++i) {
        const std::size_t column = i % across, row = i - column;
        beside[i] = luminance(texels_[row + (column + across - 1) % across]) + luminance(texels_[i]) + luminance(texels_[row + (column + 1) % across]);
    }
    weights_.resize(texels_.size()), columns_.resize(texels_.size()), rows_.resize(down);
    double above = 0;
    for (std::size_t row = 0; row < down; ++row) {
        const double ring = std::sin((static_cast<double>(row) + 0.5) * static_cast<double>(pi) / height);
        const std::size_t before = row ? row - 1 : 0, after = std::min(row + 1, down - 1);
        double left = 0;
        for (std::size_t column = 0; column < across; ++column) {
            const float sum = beside[before * across + column] + beside[row * across + column] + beside[after * across + column];
            weights_[row * across + column] = static_cast<float>(ring) * sum / 9;
            left += static_cast<double>(weights_[row * across + column]);
            columns_[row * across + column] = static_cast<float>(left);
        }
        above += left;
        rows_[row] = static_cast<float>(above);
    }
}

Environment::Place Environment::place(Vec3 toward) const {
    const float down = std::acos(std::clamp(toward.z, -1.f, 1.f)) / pi;
    const float turn = 0.5f - std::atan2(-toward.y, -toward.x) / (2 * pi);  // clockwise from above, 1/2 along -x
    return {down * static_cast<float>(height_), turn * static_cast<float>(width_)};
}

Vec3 Environment::radiance(Vec3 toward) const {
    const auto [row, column] = place(toward);
    const float top = std::floor(row - 0.5f), left = std::floor(column - 0.5f), down = row - 0.5f - top, right = column - 0.5f - left;
    const int first = std::clamp(static_cast<int>(top), 0, height_ - 1), second = std::min(static_cast<int>(top) + 1, height_ - 1);
    const int before = (static_cast<int>(left) + width_) % width_, after = (before + 1) % width_;
    const auto blend = [&](int r) { return (1 - right) * texel(r, before) + right * texel(r, after); };
    return (1 - down) * blend(first) + down * blend(second);
}

Environment::Drawn Environment::draw(float u, float v) const {
    const float all = rows_.back();
    if (!(all > 0)) return {{0, 0, 1}, 0};
    const auto find = [](std::span<const float> sums, float wanted, float& inside) {
        const auto at = std::upper_bound(sums.begin(), sums.end(), wanted);
        const auto i = static_cast<std::size_t>(std::min<std::ptrdiff_t>(at - sums.begin(), std::ssize(sums) - 1));
        const float from = i ? sums[i - 1] : 0;
        inside = sums[i] > from ? std::clamp((wanted - from) / (sums[i] - from), 0.f, 1.f) : 0.5f;
        return i;
    };
    float below, right;
    const std::size_t row = find(rows_, u * all, below), across = static_cast<std::size_t>(width_);
    const std::span<const float> sums{&columns_[row * across], across};
    const std::size_t column = find(sums, v * sums.back(), right);
    const float polar = (static_cast<float>(row) + below) * pi / static_cast<float>(height_);
    const float turn = (static_cast<float>(column) + right) / static_cast<float>(width_), angle = (0.5f - turn) * 2 * pi, ring = std::sin(polar);
    const Vec3 toward{-ring * std::cos(angle), -ring * std::sin(angle), std::cos(polar)};
    return {toward, density(toward)};
}

float Environment::density(Vec3 toward) const {
    const float all = rows_.back();
    if (!(all > 0)) return 0;
    const auto [row, column] = place(toward);
    const int r = std::clamp(static_cast<int>(row), 0, height_ - 1), c = std::clamp(static_cast<int>(column), 0, width_ - 1);
    const float here = std::sqrt(std::max(0.f, 1 - toward.z * toward.z));
    if (!(here > 0)) return 0;
    const float texels = static_cast<float>(height_) * static_cast<float>(width_);
    return weights_[static_cast<std::size_t>(r) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(c)] / all * texels / (2 * pi * pi * here);
}

}  // namespace bob
