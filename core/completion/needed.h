/// Parts of an image whose values matter: convolutions skip the others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "completion/planes.h"
#include "completion/rows.h"

namespace bob {

/// Blocks of 4 rows and 2 columns of an image, each needed or not.
class Needed {
public:
    static constexpr int block_rows = 4, block_columns = 2;

    /// An image with all its parts needed.
    Needed(int height, int width)
        : down_((height + block_rows - 1) / block_rows), across_((width + block_columns - 1) / block_columns),
          blocks_(static_cast<std::size_t>(down_) * static_cast<std::size_t>(across_), 1) {}

    [[nodiscard]] int down() const { return down_; }
    [[nodiscard]] int across() const { return across_; }
    /// A row of blocks, 1 where needed and else 0.
    [[nodiscard]] std::uint8_t* row(int y) { return blocks_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(across_); }
    [[nodiscard]] const std::uint8_t* row(int y) const { return const_cast<Needed*>(this)->row(y); }

    /// The first needed columns of the block that contains row `y`, in whole vectors from a multiple of them on, within
    /// `columns`. The image's column 0 is here called `-column`.
    [[nodiscard]] Stretch first(int y, Stretch columns, int column = 0) const {
        const std::uint8_t* const blocks = row(y / block_rows);
        const auto any = [&](int begin) {
            const int end = std::min((begin + max_lanes + column + block_columns - 1) / block_columns, across_);
            return std::find(blocks + (begin + column) / block_columns, blocks + end, 1) != blocks + end;
        };
        Stretch found{columns.begin / max_lanes * max_lanes, columns.end};
        while (found.begin < columns.end && !any(found.begin)) found.begin += max_lanes;
        found.end = found.begin;
        while (found.end < columns.end && any(found.end)) found.end += max_lanes;
        return {std::max(found.begin, columns.begin), std::min(found.end, columns.end)};
    }

    /// Everything that 3x3 convolutions of needed parts read, when they compute a row of blocks at once.
    [[nodiscard]] Needed with_neighbours() const {
        Needed result = *this;
        std::vector<std::uint8_t> column(static_cast<std::size_t>(across_) + 2);  // of three rows, with a border
        for (int y = 0; y < down_; ++y) {
            const std::uint8_t *const above = row(std::max(y - 1, 0)), *const here = row(y), *const below = row(std::min(y + 1, down_ - 1));
            std::uint8_t *const middle = column.data() + 1, *__restrict const to = result.row(y);
            for (int x = 0; x < across_; ++x) middle[x] = above[x] | here[x] | below[x];
            for (int x = 0; x < across_; ++x) to[x] = middle[x - 1] | middle[x] | middle[x + 1];
        }
        return result;
    }

    /// The same parts in half the resolution.
    [[nodiscard]] Needed halved() const {
        Needed result(half(down_) * block_rows, half(across_) * block_columns);
        for (int y = 0; y < result.down_; ++y) {
            const std::uint8_t *const upper = row(2 * y), *const lower = row(std::min(2 * y + 1, down_ - 1));
            for (int x = 0; x < result.across_; ++x) {
                const int left = 2 * x, right = std::min(2 * x + 1, across_ - 1);
                result.row(y)[x] = upper[left] | upper[right] | lower[left] | lower[right];
            }
        }
        return result;
    }

private:
    int down_, across_;
    std::vector<std::uint8_t> blocks_;
};

}  // namespace bob
