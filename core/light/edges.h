/// Edges between surfaces in a picture, and their smoothing by first hits within pixels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "picture/gbuffer.h"

namespace bob {

/// A first hit as numbers in the order of its planes. `behind` is 1 for surfaces seen in a smooth mirror or through glass; their depth is
/// measured along the unfolded path.
namespace first_hit {
enum : std::size_t { mask, depth, normal_x, normal_y, red, green, blue, ground, ground_depth, behind, count };
}

/// Pixels with a horizontal or vertical neighbour on another surface. `planes` is (first_hit::count, height, width).
[[nodiscard]] std::vector<Pixel> edges_between_surfaces(const float* planes, int height, int width);

/// Replaces pixels at edges by the means over their first hits.
///
/// Light changes little within a pixel, while surfaces end. Each first hit takes the light of the neighbour with the most similar
/// surface, times its own albedo; each hit of the ground takes the shadow of the nearest neighbour that shows ground.
///
/// `hits` is (pixels, per_pixel, first_hit::count). `guides` is (7, height, width): mask, depth, normal and albedo at pixels' centres;
/// `ground` (height, width) is 1 where they show the ground, or null. `color`, (3, height, width), and `alpha`, (height, width), hold
/// values at pixels' centres and receive means over pixels.
void smooth_edges(std::span<const Pixel> pixels, const float* hits, std::size_t per_pixel, const float* guides, const float* ground,
                  int height, int width, float* color, float* alpha);

}  // namespace bob
