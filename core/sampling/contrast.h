/// Perceived contrast of pixels, in 256 steps: the basis of adaptive sampling.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "picture/channels.h"

namespace bob {

/// The appearance of one or more pixels: the range of their shades, and whether any of them missed or hit.
class ShadeRange {
public:
    static constexpr std::uint32_t max = 255;

    ShadeRange() = default;
    /// Gray, normal x and normal y, in 256 steps.
    ShadeRange(const std::array<std::uint8_t, 3>& low, const std::array<std::uint8_t, 3>& high, bool missed, bool hit)
        : bytes_{below(low[0]), below(low[1]), below(low[2]), flag(missed), high[0], high[1], high[2], flag(hit)} {}

    void add(const ShadeRange& other) { bytes_ = bytes_ > other.bytes_ ? bytes_ : other.bytes_; }

    /// Whether no pixel was added.
    [[nodiscard]] bool is_empty() const { return std::bit_cast<std::uint64_t>(bytes_) == 0; }

    /// Contrast of the pixels added so far, 0..max.
    [[nodiscard]] std::uint32_t contrast() const {
        const auto all = std::bit_cast<std::uint64_t>(bytes_);
        const auto lower = static_cast<std::uint32_t>(all), upper = static_cast<std::uint32_t>(all >> 32);
        // Two sums of bytes in each: gray and normal y, normal x and flags.
        constexpr std::uint32_t every_other = 0x00ff00ff;
        const std::uint32_t even = (lower & every_other) + (upper & every_other), odd = (lower >> 8 & every_other) + (upper >> 8 & every_other);
        const std::uint32_t flags = odd >> 16;
        if (flags == 0) return 0;
        if (flags == 2 * max) return max;  // silhouette
        const auto range = [](std::uint32_t sum) { return static_cast<std::uint16_t>(sum - max); };
        return contrast_of(range(even & 0xffff), range(odd & 0xffff), range(even >> 16));
    }
    /// Contrast of the ranges of gray and of the normals. Narrow integers let loops over pixels vectorize well.
    ///
    /// Weight 5/8 of normals, SSIM of 14 and 24 models, means over 1 to 25 % of the pixels: with 0, adaptive loses .0035
    /// and priority .0014; with 2/8, adaptive loses .0005; with 1, adaptive gains .0002 and priority loses .0003.
    static constexpr std::uint8_t contrast_of(std::uint16_t gray, std::uint16_t x, std::uint16_t y) {
        const auto normals = static_cast<std::uint16_t>((x + y) * 5);
        const auto sum = static_cast<std::uint16_t>(gray + normals / 8);
        return static_cast<std::uint8_t>(sum < max ? sum : max);
    }

private:
    static std::uint8_t below(std::uint8_t low) { return static_cast<std::uint8_t>(max - low); }
    static std::uint8_t flag(bool is) { return is ? max : 0; }

    /// 255 minus the lowest shades, 255 if any missed, the highest shades, 255 if any hit. The union of two ranges is
    /// the larger of each byte.
    using Bytes [[gnu::vector_size(8)]] = std::uint8_t;
    Bytes bytes_{};
};

/// Reads the shades of pixels from planes, (C, pixels) of a layout.
class ShadeReader {
public:
    ShadeReader(const Layout& layout, const float* planes, std::size_t pixels)
        : gray_(plane(layout, planes, pixels, channels::gray, 0)), depth_(plane(layout, planes, pixels, channels::depth, 0)),
          x_(plane(layout, planes, pixels, channels::normal, 0)), y_(plane(layout, planes, pixels, channels::normal, 1)),
          red_(plane(layout, planes, pixels, channels::color, 0)), pixels_(pixels) {}

    /// The shades of a traced pixel.
    [[nodiscard]] ShadeRange operator()(std::size_t i) const {
        const auto shown = [i](const float* plane, const Channel& channel) {
            return static_cast<std::uint8_t>(plane ? step(plane[i], channel) : 0);
        };
        const std::array<std::uint8_t, 3> shades = {
            red_ ? static_cast<std::uint8_t>(step(shade(red_[i], red_[pixels_ + i], red_[2 * pixels_ + i]), channels::gray)) : shown(gray_, channels::gray),
            shown(x_, channels::normal), shown(y_, channels::normal)};
        const bool missed = depth_ && !(depth_[i] > 0);
        return {shades, shades, missed, !missed};
    }

    /// Writes the shades of all pixels, plane by plane. A pixel whose mask is 0 gets an empty range. `missed` and `hit`
    /// are 255 or 0.
    void read_all(const float* mask, std::uint8_t* const low[3], std::uint8_t* const high[3], std::uint8_t* missed, std::uint8_t* hit) const {
        const auto read = [=, size = pixels_](std::size_t k, const Channel& channel, auto value) {
            std::uint8_t *__restrict const lowest = low[k], *__restrict const highest = high[k];
            const Channel range = channel;
            for (std::size_t i = 0; i < size; ++i) {
                const int shown = step(value(i), range), known = mask[i] != 0 ? 255 : 0;
                lowest[i] = static_cast<std::uint8_t>(shown | (255 - known));
                highest[i] = static_cast<std::uint8_t>(shown & known);
            }
        };
        const auto read_plane = [&](std::size_t k, const Channel& channel, const float* plane) {
            if (plane) read(k, channel, [plane](std::size_t i) { return plane[i]; });
            else read(k, channel, [](std::size_t) { return 0.f; });
        };
        if (red_) {
            const float *const red = red_, *const green = red + pixels_, *const blue = green + pixels_;
            read(0, channels::gray, [=](std::size_t i) { return shade(red[i], green[i], blue[i]); });
        } else {
            read_plane(0, channels::gray, gray_);
        }
        read_plane(1, channels::normal, x_);
        read_plane(2, channels::normal, y_);
        const float* const depth = depth_ ? depth_ : mask;  // without a depth channel, each traced pixel is a hit
        std::uint8_t *__restrict const empty = missed, *__restrict const solid = hit;
        for (std::size_t i = 0, size = pixels_; i < size; ++i) {
            const int known = mask[i] != 0 ? 255 : 0, is_hit = depth[i] > 0 ? 255 : 0;
            empty[i] = static_cast<std::uint8_t>(known & ~is_hit);
            solid[i] = static_cast<std::uint8_t>(known & is_hit);
        }
    }

    /// Prefetches a pixel into the cache.
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

    /// Gray value of a colour. Not the luminance: that has little of red and blue, and here each primary needs its own
    /// value.
    static float shade(float red, float green, float blue) { return 0.45f * red + 0.35f * green + 0.2f * blue; }

    static int step(float value, const Channel& channel) {
        const float share = (value - channel.low) / (channel.high - channel.low);
        const float above = share > 0 ? share : 0;  // also if NaN
        return static_cast<int>((above < 1 ? above : 1) * 255 + 0.5f);
    }

    const float *gray_, *depth_, *x_, *y_, *red_;
    std::size_t pixels_;
};

}  // namespace bob
