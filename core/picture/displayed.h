/// Finished pictures as displays and files have them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/color.h"
#include "base/parallel.h"

namespace bob {

/// A plane of a picture in an array of any order.
struct StridedPlane {
    const float* first;
    std::ptrdiff_t down, right;

    [[nodiscard]] float operator()(int row, int column) const { return first[row * down + column * right]; }
};

/// Linear light as a byte of sRGB; values beyond 0..1 are clamped, and NaN is 0.
inline std::uint8_t displayed(float linear) {
    return srgb_bytes()(linear > 0 ? std::min(linear, 1.f) : 0.f);
}

/// Writes sRGB with straight alpha, (height, width, 4): of linear RGB times coverage, and coverage. What is not covered is 0.
inline void write_rgba(const StridedPlane (&color)[3], const StridedPlane& alpha, int height, int width, std::uint8_t* rgba) {
    for_rows(0, height, width, [&](int row) {
        std::uint8_t* pixel = rgba + 4 * static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
        for (int column = 0; column < width; ++column, pixel += 4) {
            const float coverage = alpha(row, column);
            pixel[3] = static_cast<std::uint8_t>(std::lrintf(coverage > 0 ? std::min(coverage, 1.f) * 255 : 0));
            for (int c = 0; c < 3; ++c) pixel[c] = pixel[3] == 0 ? 0 : displayed(color[c](row, column) / std::max(coverage, 1e-6f));
        }
    });
}

}  // namespace bob
