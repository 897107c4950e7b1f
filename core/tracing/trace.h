/// From pixels to samples: one ray per pixel.
#pragma once

#include <cstddef>
#include <span>

#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "tracing/material.h"
#include "tracing/scene.h"

namespace bob {

/// Traces the centres of pixels inside the image, given in any order; neighbours are traced together.
///
/// The scene lies within the unit sphere. `samples` is (n, layout.width()). The layout begins with the mask, here 1 for
/// a hit and 0 for a miss. A pixel's sample does not depend on the thread or on the other pixels. Throws
/// std::invalid_argument if the tracer lacks a channel.
void trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Layout& layout, float* samples);

/// Traces pixels into planes, (layout.width(), height, width): each thread scatters its samples while they are in its
/// cache.
void trace_into(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
                const Layout& layout, float* planes);

/// Traces the rows from `begin` to `end` of a picture into planes, (layout.width(), rows, width), whose first row is the picture's row `top`.
void trace_rows(const Scene& scene, const Camera& camera, int height, int width, int begin, int end, const Layout& layout, float* planes, int top,
                int rows);

/// Shades rows of a reprojected picture again, for the current camera.
///
/// Writes gray, from the normal and the instance, where the planes, (layout.width(), height, width), hold a hit, and 0
/// elsewhere. A layout with color also has albedo, which is shaded; otherwise shapes are treated as white.
class Shading {
public:
    Shading(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout, float* planes);

    void operator()(int row) const;

private:
    /// Shades `count` pixels of one material from (row, column) on.
    void shade(const Material& material, int row, int column, int count) const;
    void shade_alike(const Material& material, int row, int column, int count) const;

    const Scene& scene_;
    Projection projection_;
    Eye eye_;
    std::size_t width_, pixels_;
    const float *depth_, *normal_x_, *normal_y_, *instance_;
    const float* albedo_;    // or null
    float *gray_, *color_;   // color or null
};

}  // namespace bob
