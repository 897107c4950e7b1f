/// From pixels to samples: one ray each.
#pragma once

#include <span>

#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "tracing/scene.h"

namespace bob {

/// Traces the centres of the pixels, which lie in the image, in any order: it traces neighbours together whatever theirs is.
/// The scene lies within the unit sphere. `samples` is (n, layout.width()): the layout begins with the mask, in whose place
/// stands whether the ray hit. A pixel's sample does not depend on the thread that traces it, nor on the other pixels. Throws
/// std::invalid_argument if the tracer has no such channel.
void trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Layout& layout, float* samples);

/// Shades anew, for a camera, what was found with another: writes gray, of the normal and the instance, wherever the planes,
/// (layout.width(), height, width), hold a hit. A layout with color has albedo as well, which is shaded then; without it,
/// shapes are taken to have no colours of their own.
void shade(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout, float* planes);

}  // namespace bob
