/// Traced pixels keep their values.
#pragma once

#include <cstddef>

#include "base/parallel.h"
#include "completion/interpolation_kernels.h"
#include "picture/channels.h"

namespace bob {

/// Restores the traced pixels of a G-buffer in completed channels.
///
/// planes: (known.width(), height, width), beginning with the mask; output: (completed.width(), height, width).
/// Untraced pixels are clamped to the channel's range, and NaN to its low end. Throws std::invalid_argument if the
/// G-buffer lacks a completed channel.
inline void keep_known(const Layout& known, const float* planes, const Layout& completed, float* output, std::size_t pixels) {
    for (const Channel& channel : completed) {
        const int place = known.place_of(channel);
        const float low = channel.low, high = channel.high;
        for (int component = 0; component < channel.components; ++component, output += pixels) {
            const float* const traced = planes + static_cast<std::size_t>(place + component) * pixels;
            parallel_for(pixels, 32768, [=](std::size_t begin, std::size_t end) {
                best_interpolation_kernels().keep(planes + begin, traced + begin, low, high, output + begin, end - begin);
            });
        }
    }
}

}  // namespace bob
