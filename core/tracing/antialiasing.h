/// Antialiasing: pixels at edges, and the means of several rays in them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "picture/camera.h"
#include "picture/gbuffer.h"
#include "tracing/scene.h"

namespace bob {

/// Linear light of a picture, 0..1, row by row: every `step`-th number.
struct LightPlane {
    const float* values;
    std::size_t step = 1;
};

/// Pixels of the rows from `begin` to `end` that are far from the mean of their two neighbours in any of the four directions, in the
/// square root of light, which is close to sRGB, or because some are `covered`, above 0, and some are not.
///
/// Where shading is linear across neighbours, a pixel's centre shows its mean, and it needs no more rays. The borders of the picture, of
/// `height` rows, repeat their own pixels.
[[nodiscard]] std::vector<Pixel> pixels_at_edges(std::span<const LightPlane> light, const float* covered, int height, int width, int begin, int end);

/// Writes the means over side x side rays in each pixel, (pixels, 5): whether the rays differ enough to need more, linear RGB and coverage.
///
/// The subpixels of a pixel are the pixels of a picture enlarged by the same factor.
void trace_means(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels, int side, float* means);

}  // namespace bob
