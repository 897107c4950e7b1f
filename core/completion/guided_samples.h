/// The samples that light is fitted to, and how far each fit reaches.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "completion/guided_kernels.h"
#include "completion/guided_surfaces.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"

namespace bob {

/// The picture's tiles: reaches are known at their corners.
namespace guided_tiles {
constexpr int width = GuidedSurfaces::row_multiple, height = 8;
constexpr int across(int columns) { return (columns + width - 1) / width; }
constexpr int down(int rows) { return (rows + height - 1) / height; }
}  // namespace guided_tiles

/// The pixels that are completed: all, those with surfaces, or those of one plane without guides.
enum class GuidedExtent { all, surfaces, plane };

/// Traced samples in row order, of the pixels that are completed.
class GuidedSamples {
public:
    std::vector<GuidedSample> samples;
    bool is_noisy = false;

    /// planes: of a G-buffer with `channel`, and perhaps the variance. Throws std::invalid_argument if the channel is missing.
    GuidedSamples(const Layout& known, const float* planes, const Channel& channel, const GuidedSurfaces& surfaces, GuidedExtent extent);

    /// The samples of a row that are in columns of tiles from `begin` to before `end`.
    [[nodiscard]] std::span<const GuidedSample> in_tiles(int y, int begin, int end) const {
        return std::span(samples).subspan(static_cast<std::size_t>(first(y, begin)), static_cast<std::size_t>(first(y, end) - first(y, begin)));
    }

    /// The samples of a row that are in columns from `left` to before `right`.
    [[nodiscard]] GuidedRange within(int y, int left, int right) const;

private:
    [[nodiscard]] int first(int y, int across) const { return first_[static_cast<std::size_t>(y * stride_ + across)]; }

    int stride_;
    std::vector<int> first_;  // first sample of each row from each column of tiles on, and the row's end
};

/// Reach and offset of distances at the corners of tiles, linearly interpolated between them.
class GuidedReaches {
public:
    struct Reach {
        float reach, sharpness;
    };

    /// Also darkens noisy samples that are much brighter than their neighbours.
    GuidedReaches(const GuidedSurfaces& surfaces, GuidedSamples& traced);

    [[nodiscard]] Reach at(int y, int x) const;

    /// The largest reach and the smallest offset in a rectangle.
    [[nodiscard]] Reach extremes(int top, int left, int height, int width) const;

private:
    [[nodiscard]] std::size_t place(int down, int across) const {
        return static_cast<std::size_t>(down) * across_ + static_cast<std::size_t>(across);
    }

    std::size_t across_;
    std::vector<Reach> corners_;
};

}  // namespace bob
