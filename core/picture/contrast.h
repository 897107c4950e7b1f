/// How much pixels differ to the eye, in 256 steps: what decides where rays go.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "picture/channels.h"

namespace bob {

/// What a pixel shows, or several pixels do: the range of their shades, and whether any of them missed or hit.
struct Look {
    static constexpr std::uint8_t missed = 1, hit = 2;
    static constexpr std::uint32_t most = 255;

    std::uint8_t low[3] = {255, 255, 255};  // gray, normal x, normal y, in 256 steps each
    std::uint8_t seen = 0;
    std::uint8_t high[3] = {};

    void add(const Look& other) {
        seen |= other.seen;
        for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], other.low[i]), high[i] = std::max(high[i], other.high[i]);
    }

    /// How much differs what was added, 0..most.
    [[nodiscard]] std::uint32_t contrast() const {
        if (seen == 0) return 0;
        if (seen == (missed | hit)) return most;  // silhouette
        const auto range = [&](int i) { return static_cast<std::uint32_t>(high[i] - low[i]); };
        return std::min(most, range(0) + (range(1) + range(2)) * 5 / 8);
    }
};

/// Reads what pixels show from planes, (C, pixels) of a layout.
class LookReader {
public:
    LookReader(const Layout& layout, const float* planes, std::size_t pixels)
        : gray_(plane(layout, planes, pixels, channels::gray, 0)), depth_(plane(layout, planes, pixels, channels::depth, 0)),
          x_(plane(layout, planes, pixels, channels::normal, 0)), y_(plane(layout, planes, pixels, channels::normal, 1)),
          red_(plane(layout, planes, pixels, channels::color, 0)), pixels_(pixels) {}

    /// Of a pixel that was traced.
    [[nodiscard]] Look operator()(std::size_t i) const {
        Look look;
        look.low[0] = look.high[0] = red_ ? step(shade(i), channels::gray) : gray_ ? step(gray_[i], channels::gray) : 0;
        look.low[1] = look.high[1] = x_ ? step(x_[i], channels::normal) : 0;
        look.low[2] = look.high[2] = y_ ? step(y_[i], channels::normal) : 0;
        look.seen = depth_ && !(depth_[i] > 0) ? Look::missed : Look::hit;
        return look;
    }

    /// Into the cache, ahead of its use.
    void prefetch(std::size_t i) const {
        for (const float* const values : {gray_, depth_, x_, y_, red_}) {
            if (values) __builtin_prefetch(values + i);
        }
        if (red_) __builtin_prefetch(red_ + pixels_ + i), __builtin_prefetch(red_ + 2 * pixels_ + i);
    }

private:
    static const float* plane(const Layout& layout, const float* planes, std::size_t pixels, const Channel& channel, int component) {
        const int at = layout.place(channel);
        return at < 0 ? nullptr : planes + static_cast<std::size_t>(at + component) * pixels;
    }

    /// One number of a colour: not the luminance, in which red and blue hardly count, and each primary has another.
    [[nodiscard]] float shade(std::size_t i) const {
        return 0.45f * red_[i] + 0.35f * red_[pixels_ + i] + 0.2f * red_[2 * pixels_ + i];
    }

    static std::uint8_t step(float value, const Channel& channel) {
        const float share = (value - channel.low) / (channel.high - channel.low);
        return share > 0 ? static_cast<std::uint8_t>(std::min(share, 1.f) * 255 + 0.5f) : 0;  // also of what is no number
    }

    const float *gray_, *depth_, *x_, *y_, *red_;
    std::size_t pixels_;
};

}  // namespace bob
