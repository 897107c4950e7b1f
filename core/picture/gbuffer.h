/// The G-buffer: AOVs of the first visible surface at the traced pixels.
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

/// Sets `count` values of new planes to 0, from several threads: the first touch of fresh memory takes long.
void clear(float* planes, std::size_t count);

/// Writes samples, (n, C), to their pixels in `planes`, (C, height, width), both of one layout that begins with the
/// mask. Returns the number of pixels not traced before.
///
/// Samples may have further numbers, `sample_width` in all, which are ignored. A sample's first number is 1 for a hit.
/// If it is 0, only gray, colour and variance are used, which are 0 where nothing shines.
std::size_t scatter(const Layout& layout, std::span<const Pixel> pixels, const float* samples, std::size_t sample_width,
                    float* planes, std::size_t height, std::size_t width);

/// The planes of the channels in `wanted`, (wanted.width(), pixels). They are the planes themselves if these come first
/// and in order, else copies in `storage`. Throws std::invalid_argument if the layout lacks a channel.
[[nodiscard]] const float* select(const Layout& layout, const float* planes, const Layout& wanted, std::size_t pixels,
                                  std::vector<float>& storage);

}  // namespace bob
