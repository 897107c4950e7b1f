/// Fits of light to the samples around each pixel.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "completion/guided_kernels.h"
#include "completion/guided_samples.h"
#include "completion/guided_surfaces.h"

namespace bob {

/// The fit at the pixels of a block of tiles.
struct GuidedBlock {
    static constexpr int width = 4 * guided_tiles::width, height = 4 * guided_tiles::height;
    static constexpr std::size_t size = width * height;
    std::array<float, size> light[3]{}, weight{}, detail{}, noise{};
};

/// Fits linear functions of position and normal at places, and blends them at the pixels between.
class GuidedFit {
public:
    GuidedFit(const GuidedSurfaces& surfaces, const GuidedSamples& traced, const GuidedReaches& reaches, int components, GuidedExtent extent)
        : surfaces_(surfaces), traced_(traced), reaches_(reaches), components_(components), extent_(extent) {}

    /// Fits the pixels of a block; those that are not completed keep any value.
    void block(int top, int left, GuidedBlock& fitted);

private:
    /// A rectangle of whole tiles; the picture may end in it.
    struct Area {
        int top, left, height, width;
    };

    [[nodiscard]] std::size_t in_block(int y, int x) const;
    [[nodiscard]] bool is_wanted(int y, int x) const;
    [[nodiscard]] bool is_any_wanted(const Area& area) const;

    void fit(Area area, GuidedBlock& fitted);
    void add(int y, int x);
    /// Fits places of a grid, and blends them at the pixels.
    void blend(const Area& area, float spacing, float reach, GuidedBlock& fitted);
    /// Fits the places, which are pixels, and removes them.
    void fit_pixels(const Area& area, float reach, GuidedBlock& fitted);
    /// Fits the places, with a larger reach where no sample is on the same surface.
    void fit_places(const Area& area, float reach);
    void fit_places(const Area& area, float reach, GuidedPlaces& places);
    /// Finds the samples within `reach` of an area; returns the step between them.
    int find_samples(const Area& area, float reach);

    const GuidedSurfaces& surfaces_;
    const GuidedSamples& traced_;
    const GuidedReaches& reaches_;
    int components_;
    GuidedExtent extent_;
    int block_top_ = 0, block_left_ = 0;
    std::vector<GuidedRange> ranges_;
    GuidedPlaces places_, wider_;
};

}  // namespace bob
