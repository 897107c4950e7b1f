/// The G-buffer: what is known of the first visible surface at the traced pixels.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/channels.h"

namespace bob {

struct Pixel {
    std::int32_t row, column;
};

/// Writes samples, (n, C), to their pixels in `planes`, (C, height, width), both of one layout that begins with the mask.
/// A sample's first number says whether its ray hit; where it is 0, the others do not matter. Returns how many of the
/// pixels were not traced before.
inline std::size_t scatter(const Layout& layout, std::span<const Pixel> pixels, const float* samples, float* planes,
                           std::size_t height, std::size_t width) {
    std::vector<float> missed;
    for (const Channel& channel : layout) missed.insert(missed.end(), static_cast<std::size_t>(channel.components), channel.missed);
    const std::size_t components = missed.size(), plane = height * width;
    std::size_t added = 0;
    for (const Pixel pixel : pixels) {
        float* p = planes + static_cast<std::size_t>(pixel.row) * width + static_cast<std::size_t>(pixel.column);
        const float* const found = samples[0] != 0 ? samples : missed.data();
        added += *p == 0;
        *p = 1;
        for (std::size_t c = 1; c < components; ++c) p[c * plane] = found[c];
        samples += components;
    }
    return added;
}

/// The planes of some channels, (wanted.width(), pixels), of those that a layout has: these themselves if they come first
/// and in this order, else copies in `storage`. Throws std::invalid_argument if the layout lacks one.
inline const float* select(const Layout& layout, const float* planes, const Layout& wanted, std::size_t pixels,
                           std::vector<float>& storage) {
    std::vector<int> places;
    for (const Channel& channel : wanted) {
        for (int component = 0; component < channel.components; ++component) places.push_back(layout.place_of(channel) + component);
    }
    bool in_place = true;
    for (std::size_t i = 0; i < places.size(); ++i) in_place = in_place && places[i] == static_cast<int>(i);
    if (in_place) return planes;
    storage.resize(places.size() * pixels);
    for (std::size_t i = 0; i < places.size(); ++i) {
        std::copy_n(planes + static_cast<std::size_t>(places[i]) * pixels, pixels, storage.data() + i * pixels);
    }
    return storage.data();
}

}  // namespace bob
