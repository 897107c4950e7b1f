/// Pictures enlarged to another size.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.h"

namespace bob {

/// Writes planes (count, from_height, from_width), enlarged bilinearly, to `to`, (count, height, width). Both pictures cover the same area;
/// values beyond the outer centres are those of the border.
inline void enlarge(int count, const float* from, int from_height, int from_width, float* to, int height, int width) {
    /// The two pixels around another size's pixel, and the share of the second.
    struct Between {
        int first, second;
        float share;
    };
    const auto between = [](int i, int size, int from_size) {
        const float at = std::clamp((static_cast<float>(i) + 0.5f) * static_cast<float>(from_size) / static_cast<float>(size) - 0.5f, 0.f,
                                    static_cast<float>(from_size - 1));
        const int first = static_cast<int>(at);
        return Between{first, std::min(first + 1, from_size - 1), at - static_cast<float>(first)};
    };
    std::vector<Between> columns;
    for (int x = 0; x < width; ++x) columns.push_back(between(x, width, from_width));
    const auto size = [](int rows, int row_width) { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(row_width); };
    for_rows(0, count * height, width, [&](int row) {
        const auto [above, below, share] = between(row % height, height, from_height);
        const float* const plane = from + size(row / height * from_height, from_width);
        const float *const upper = plane + size(above, from_width), *const lower = plane + size(below, from_width);
        float* const line = to + size(row, width);
        for (int x = 0; x < width; ++x) {
            const auto [left, right, along] = columns[static_cast<std::size_t>(x)];
            const float top = upper[left] + along * (upper[right] - upper[left]), bottom = lower[left] + along * (lower[right] - lower[left]);
            line[x] = top + share * (bottom - top);
        }
    });
}

}  // namespace bob
