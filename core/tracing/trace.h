/// From pixels to samples: one orthographic ray each.
#pragma once

#include <functional>
#include <span>

#include "picture/camera.h"
#include "picture/gbuffer.h"
#include "tracing/scene.h"

namespace bob {

/// Traces the pixels' centres; the scene lies within the unit sphere. Which thread traces a pixel does not matter to its
/// sample. `keep_going` is asked now and then on the calling thread; returns false if it said no.
bool trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Samples& samples, const std::function<bool()>& keep_going = nullptr);

}  // namespace bob
