#include "shapes/texture.h"

#include <algorithm>
#include <cmath>

#include "color.h"
#include "parallel.h"

namespace bob {
namespace {

/// Of each of the 256 values.
const std::array<float, 256>& linear() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values;
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = from_srgb(static_cast<float>(i) / 255);
        return values;
    }();
    return table;
}

/// A number of a texel, which may lie beyond the edges, wrapped into 0..count - 1.
int wrapped(int i, int count, Wrap wrap) {
    if (wrap == Wrap::clamp) return std::clamp(i, 0, count - 1);
    const int period = wrap == Wrap::mirror ? 2 * count : count;
    i = i % period;
    if (i < 0) i += period;
    return i < count ? i : period - 1 - i;
}

/// The same of a place, so that whole numbers hold its texels.
float near_picture(float place, Wrap wrap) {
    if (!std::isfinite(place)) return 0;
    if (wrap == Wrap::clamp) return std::clamp(place, -1.f, 2.f);
    return place - 2 * std::floor(place / 2);
}

}  // namespace

Texture::Texture(std::span<const std::uint8_t> texels, int height, int width, Wrap across, Wrap down,
                 std::span<const std::uint8_t> alpha)
    : across_(across), down_(down), alpha_(alpha.begin(), alpha.end()) {
    levels_.push_back({height, width, {texels.begin(), texels.end()}});
    while (levels_.back().height > 1 || levels_.back().width > 1) {
        const Level& from = levels_.back();
        Level to{(from.height + 1) / 2, (from.width + 1) / 2, {}};
        to.texels.resize(static_cast<std::size_t>(to.height) * static_cast<std::size_t>(to.width) * 3);
        for_rows(0, to.height, to.width, [&](int row) {
            for (int column = 0; column < to.width; ++column) {
                for (std::size_t k = 0; k < 3; ++k) {
                    float sum = 0;
                    int count = 0;
                    for (int y = 2 * row; y < std::min(2 * row + 2, from.height); ++y) {
                        for (int x = 2 * column; x < std::min(2 * column + 2, from.width); ++x, ++count) {
                            sum += linear()[from.texels[static_cast<std::size_t>(y * from.width + x) * 3 + k]];
                        }
                    }
                    const float mean = to_srgb(sum / static_cast<float>(count));
                    to.texels[static_cast<std::size_t>(row * to.width + column) * 3 + k] =
                        static_cast<std::uint8_t>(mean * 255 + 0.5f);
                }
            }
        });
        levels_.push_back(std::move(to));
    }
}

Vec3 Texture::operator()(float u, float v, float width) const {
    u = near_picture(u, across_), v = near_picture(v, down_);
    const float last = static_cast<float>(levels_.size() - 1);
    const float at = width > 1 ? std::min(std::log2(width), last) : 0;  // also of what is no number
    const auto lower = static_cast<std::size_t>(at);
    const float share = at - static_cast<float>(lower);
    const Vec3 fine = bilinear(levels_[lower], u, v);
    return share > 0 ? (1 - share) * fine + share * bilinear(levels_[lower + 1], u, v) : fine;
}

float Texture::alpha(float u, float v) const {
    if (alpha_.empty()) return 1;
    const auto [texel, dx, dy] = around(levels_[0], near_picture(u, across_), near_picture(v, down_));
    // Not a sum of shares, which would be 1 but for rounding: between equal texels is what they are.
    const auto between = [](float a, float b, float share) { return a + share * (b - a); };
    const auto row = [&](int j) {
        return between(static_cast<float>(alpha_[texel[j][0]]), static_cast<float>(alpha_[texel[j][1]]), dx);
    };
    return between(row(0), row(1), dy) / 255;
}

float Texture::least_alpha() const {
    return alpha_.empty() ? 1 : static_cast<float>(*std::min_element(alpha_.begin(), alpha_.end())) / 255;
}

Texture::Around Texture::around(const Level& level, float u, float v) const {
    const float x = u * static_cast<float>(level.width) - 0.5f, y = v * static_cast<float>(level.height) - 0.5f;
    const float left = std::floor(x), top = std::floor(y), dx = x - left, dy = y - top;
    const int columns[2] = {wrapped(static_cast<int>(left), level.width, across_),
                            wrapped(static_cast<int>(left) + 1, level.width, across_)};
    const int rows[2] = {wrapped(static_cast<int>(top), level.height, down_), wrapped(static_cast<int>(top) + 1, level.height, down_)};
    Around result{{}, dx, dy};
    for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) result.texel[j][i] = static_cast<std::size_t>(rows[j] * level.width + columns[i]);
    }
    return result;
}

Vec3 Texture::bilinear(const Level& level, float u, float v) const {
    const Around at = around(level, u, v);
    const float dx = at.dx, dy = at.dy;
    const auto texel = [&](int j, int i) {
        const std::uint8_t* const t = &level.texels[3 * at.texel[j][i]];
        return Vec3{linear()[t[0]], linear()[t[1]], linear()[t[2]]};
    };
    return (1 - dy) * ((1 - dx) * texel(0, 0) + dx * texel(0, 1)) + dy * ((1 - dx) * texel(1, 0) + dx * texel(1, 1));
}

std::size_t Texture::bytes() const {
    std::size_t sum = alpha_.size();
    for (const Level& level : levels_) sum += level.texels.size();
    return sum;
}

}  // namespace bob
