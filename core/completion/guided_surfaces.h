/// First surfaces of all pixels, and the similarity of two of them.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/color.h"
#include "completion/guided_kernels.h"
#include "completion/planes.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"

namespace bob {

/// The tolerance of depth has a share of the picture's range, and a part proportional to the surface's slope.
constexpr GuidedLikeness guided_likeness{20, 20, 100, 5e-4f};

/// Guides, with rows padded to whole vectors by repeating their last pixel.
class GuidedSurfaces {
public:
    using Plane = Guides::Plane;
    using enum Guides::Plane;

    /// Row lengths are multiples of this.
    static constexpr int row_multiple = 16;

    /// guides: (layout.width(), height, width) with mask, depth, normal and albedo. Throws std::invalid_argument if one is missing.
    GuidedSurfaces(const Layout& layout, const float* guides, int height, int width);

    /// One white plane that covers these shares of the pixels, (height, width); it has no depth and normals.
    GuidedSurfaces(const float* covered, int height, int width);

    [[nodiscard]] float* row(int plane, int y) {
        return values_.get() + (static_cast<std::size_t>(plane) * static_cast<std::size_t>(height_) + static_cast<std::size_t>(y)) * stride_;
    }
    [[nodiscard]] const float* row(int plane, int y) const { return const_cast<GuidedSurfaces*>(this)->row(plane, y); }
    [[nodiscard]] std::size_t stride() const { return stride_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }

    /// Divisor of light for a channel's component.
    [[nodiscard]] float divisor(int components, int component, int y, int x) const {
        const auto albedo = [&](int k) { return row(red + k, y)[x]; };
        return std::max(min_albedo, components == 3 ? albedo(component) : luminance({albedo(0), albedo(1), albedo(2)}));
    }

    /// Similarity of two pixels' surfaces, from 1 for equal surfaces down to 0.
    [[nodiscard]] float likeness(Pixel own, Pixel other) const;

    /// Bytes in use.
    [[nodiscard]] std::size_t bytes() const { return sizeof(float) * count * stride_ * static_cast<std::size_t>(height_); }

private:
    GuidedSurfaces(int height, int width);

    int height_, width_;
    std::size_t stride_;
    AlignedFloats values_;
};

}  // namespace bob
