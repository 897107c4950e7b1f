#include "shapes/mesh/texture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/color.h"
#include "base/parallel.h"

namespace bob {
namespace {

/// The linear value of each of the 256 bytes.
const std::array<float, 256>& linear() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values;
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = from_srgb(static_cast<float>(i) / 255);
        return values;
    }();
    return table;
}

/// A colour and its weight.
struct Weighted {
    Vec3 color;
    float weight;
};

/// A colour in one vector, available in every instruction set.
using Together [[gnu::vector_size(16)]] = float;
Together together(Vec3 color) { return Together{color.x, color.y, color.z, 0}; }

/// floor(x) for x in the range of int. Without a rounding instruction, the library's function takes as long as a texel.
int whole(float x) {
    const int truncated = static_cast<int>(x);
    return truncated - (static_cast<float>(truncated) > x);
}

/// Wraps a texel's index, at most two pictures outside, to 0..count - 1. Divisions would take longer than the rest.
int wrapped(int i, int count, Wrap wrap) {
    if (wrap == Wrap::clamp) return std::clamp(i, 0, count - 1);
    const int period = wrap == Wrap::mirror ? 2 * count : count;
    if (i < 0) i += period;
    while (i >= period) i -= period;
    return i < count ? i : period - 1 - i;
}

/// Wraps a place into the picture or the next one; clamped places are at most one picture outside.
float near_picture(float place, Wrap wrap) {
    if (!(std::fabs(place) < 0x1p30f)) return 0;  // float32 has no fractions there either
    if (wrap == Wrap::clamp) return std::clamp(place, -1.f, 2.f);
    return place - 2 * static_cast<float>(whole(place / 2));
}

}  // namespace

Picture::Picture(std::span<const std::uint8_t> texels, int height, int width, std::span<const std::uint8_t> alpha,
                 std::shared_ptr<const void> owner)
    : owner_(std::move(owner)), least_alpha_(alpha.empty() ? 1 : static_cast<float>(*std::min_element(alpha.begin(), alpha.end())) / 255) {
    const SrgbBytes& srgb_byte = srgb_bytes();
    const std::array<float, 256>& light = linear();
    std::size_t smaller = 0;
    for (int rows = height, columns = width; rows > 1 || columns > 1;) {
        rows = (rows + 1) / 2, columns = (columns + 1) / 2;
        smaller += static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
    }
    smaller_.resize((alpha.empty() ? 3 : 4) * smaller);
    auto room = [next = smaller_.data()](std::size_t size) mutable { return std::span(std::exchange(next, next + size), size); };
    levels_.push_back({height, width, texels, alpha});
    while (levels_.back().height > 1 || levels_.back().width > 1) {
        const Level from = levels_.back();
        const int rows = (from.height + 1) / 2, columns = (from.width + 1) / 2;
        const std::size_t size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
        const std::span<std::uint8_t> means = room(3 * size), alphas = room(from.alpha.empty() ? 0 : size);
        levels_.push_back({rows, columns, means, alphas});
        for_rows(0, rows, columns, [&](int row) {
            for (int column = 0; column < columns; ++column) {
                const auto at = static_cast<std::size_t>(row * columns + column);
                if (from.alpha.empty() && 2 * row + 1 < from.height && 2 * column + 1 < from.width) {  // as below, for most texels
                    const std::uint8_t* const upper = &from.texels[3 * static_cast<std::size_t>(2 * row * from.width + 2 * column)];
                    const std::uint8_t* const lower = upper + 3 * from.width;
                    for (std::size_t k = 0; k < 3; ++k) {
                        means[3 * at + k] = srgb_byte((light[upper[k]] + light[upper[k + 3]] + light[lower[k]] + light[lower[k + 3]]) / 4);
                    }
                    continue;
                }
                std::size_t covered[4], count = 0;
                for (int y = 2 * row; y < std::min(2 * row + 2, from.height); ++y) {
                    for (int x = 2 * column; x < std::min(2 * column + 2, from.width); ++x) {
                        covered[count++] = static_cast<std::size_t>(y * from.width + x);
                    }
                }
                float weights[4], total = 0;
                for (std::size_t i = 0; i < count; ++i) total += weights[i] = from.opacity(covered[i]);
                if (!alphas.empty()) alphas[at] = static_cast<std::uint8_t>(total / static_cast<float>(count) * 255 + 0.5f);
                if (total == 0) total = static_cast<float>(count), std::fill_n(weights, count, 1.f);
                for (std::size_t k = 0; k < 3; ++k) {
                    float sum = 0;
                    for (std::size_t i = 0; i < count; ++i) sum += weights[i] * light[from.texels[3 * covered[i] + k]];
                    means[3 * at + k] = srgb_byte(sum / total);
                }
            }
        });
    }
}

inline Texture::Around Texture::around(const Level& level, float u, float v) const {
    const float x = u * static_cast<float>(level.width) - 0.5f, y = v * static_cast<float>(level.height) - 0.5f;
    const int left = whole(x), top = whole(y);
    const float dx = x - static_cast<float>(left), dy = y - static_cast<float>(top);
    const int columns[2] = {wrapped(left, level.width, across_), wrapped(left + 1, level.width, across_)};
    const int rows[2] = {wrapped(top, level.height, down_), wrapped(top + 1, level.height, down_)};
    Around result{{}, dx, dy};
    for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) result.texel[j][i] = static_cast<std::size_t>(rows[j] * level.width + columns[i]);
    }
    return result;
}

inline Vec3 Texture::bilinear(const Level& level, const Around& at) {
    const float dx = at.dx, dy = at.dy;
    const float* const values = linear().data();
    const auto texel = [&](int j, int i) {
        const std::uint8_t* const t = &level.texels[3 * at.texel[j][i]];
        return Vec3{values[t[0]], values[t[1]], values[t[2]]};
    };
    if (!level.alpha.empty()) {
        const auto mixed = [](Weighted a, Weighted b) {
            if (b.weight == 0) return a;
            if (a.weight == 0) return b;
            const float sum = a.weight + b.weight;
            return Weighted{a.color + b.weight / sum * (b.color - a.color), sum};  // exact for equal colours
        };
        const auto row = [&](int j, float share) {
            return mixed({texel(j, 0), share * (1 - dx) * level.opacity(at.texel[j][0])},
                         {texel(j, 1), share * dx * level.opacity(at.texel[j][1])});
        };
        const Weighted mean = mixed(row(0, 1 - dy), row(1, dy));
        if (mean.weight > 0) return mean.color;
    }
    const auto row = [&](int j) { return (1 - dx) * together(texel(j, 0)) + dx * together(texel(j, 1)); };
    const Together mean = (1 - dy) * row(0) + dy * row(1);
    return {mean[0], mean[1], mean[2]};
}

Texture::Lookup Texture::look_up(float u, float v, float width) const {
    u = near_picture(u, across_), v = near_picture(v, down_);
    const float last = static_cast<float>(picture_->levels_.size() - 1);
    const float at = width > 1 ? std::min(std::log2(width), last) : 0;  // also if NaN
    const auto lower = static_cast<std::size_t>(at);
    const Level& level = picture_->levels_[lower];
    const Lookup lookup{lower, around(level, u, v), u, v, at - static_cast<float>(lower)};
    for (const auto& row : lookup.fine.texel) {
        __builtin_prefetch(&level.texels[3 * row[0]]);
        if (!level.alpha.empty()) __builtin_prefetch(&level.alpha[row[0]]);
    }
    return lookup;
}

Vec3 Texture::color(const Lookup& lookup) const {
    const Vec3 fine = bilinear(picture_->levels_[lookup.level], lookup.fine);
    if (!(lookup.share > 0)) return fine;
    const Level& coarse = picture_->levels_[lookup.level + 1];
    return (1 - lookup.share) * fine + lookup.share * bilinear(coarse, around(coarse, lookup.u, lookup.v));
}

Vec3 Texture::operator()(float u, float v, float width) const { return color(look_up(u, v, width)); }

float Texture::alpha(float u, float v) const {
    const Level& level = picture_->levels_[0];
    if (level.alpha.empty()) return 1;
    const auto [texel, dx, dy] = around(level, near_picture(u, across_), near_picture(v, down_));
    // Interpolates by differences, not by weights, whose sum may differ from 1: equal texels stay exact.
    const auto between = [](float a, float b, float share) { return a + share * (b - a); };
    const auto row = [&](int j) {
        return between(static_cast<float>(level.alpha[texel[j][0]]), static_cast<float>(level.alpha[texel[j][1]]), dx);
    };
    return between(row(0), row(1), dy) / 255;
}

std::size_t Picture::bytes() const {
    std::size_t sum = 0;
    for (const Level& level : levels_) sum += level.texels.size() + level.alpha.size();
    return sum;
}

}  // namespace bob
