/// The G-buffer: what is known of the first visible surface at the traced pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/channels.h"

namespace bob {

struct Pixel {
    std::int32_t row, column;
};

/// Writes samples, (n, C), to their pixels in `planes`, (C, height, width), both of one layout that begins with the mask;
/// samples may have more numbers than that, `sample_width` in all, which are left out. A sample's first number says whether
/// its ray hit; where it is 0, only gray, colour and variance matter, which are 0 where nothing shines. Returns how many of
/// the pixels were not traced before.
std::size_t scatter(const Layout& layout, std::span<const Pixel> pixels, const float* samples, std::size_t sample_width,
                    float* planes, std::size_t height, std::size_t width);

/// The planes of some channels, (wanted.width(), pixels), of those that a layout has: these themselves if they come first
/// and in this order, else copies in `storage`. Throws std::invalid_argument if the layout lacks one.
[[nodiscard]] const float* select(const Layout& layout, const float* planes, const Layout& wanted, std::size_t pixels,
                                  std::vector<float>& storage);

}  // namespace bob
