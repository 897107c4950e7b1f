/// From pixels to samples: one ray each.
#pragma once

#include <cstddef>
#include <span>

#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "tracing/material.h"
#include "tracing/scene.h"

namespace bob {

/// Traces the centres of the pixels, which lie in the image, in any order: it traces neighbours together whatever theirs is.
/// The scene lies within the unit sphere. `samples` is (n, layout.width()): the layout begins with the mask, in whose place
/// stands whether the ray hit. A pixel's sample does not depend on the thread that traces it, nor on the other pixels. Throws
/// std::invalid_argument if the tracer has no such channel.
void trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Layout& layout, float* samples);

/// Traces pixels into planes, (layout.width(), height, width): each thread scatters its own rays, while they are in its cache.
void trace_into(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
                const Layout& layout, float* planes);

/// Shades rows of a picture anew, for a camera, of which another one has seen the surfaces: writes gray, of the normal and the instance,
/// wherever the planes, (layout.width(), height, width), hold a hit, and 0 elsewhere. A layout with color has albedo as well, which
/// is shaded then; without it, shapes are taken to have no colours of their own.
class Shading {
public:
    Shading(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout, float* planes);

    void operator()(int row) const;

private:
    /// From a place in the planes on, all of one material.
    void shade(const Material& material, int row, int column, int count) const;
    void shade_alike(const Material& material, int row, int column, int count) const;

    const Scene& scene_;
    Projection projection_;
    Eye eye_;
    std::size_t width_, pixels_;
    const float *depth_, *normal_x_, *normal_y_, *instance_;
    const float* albedo_;    // or null
    float *gray_, *color_;   // the latter or null
};

}  // namespace bob
