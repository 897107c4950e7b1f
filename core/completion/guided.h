/// Completion along guides: first hits of all pixels, light of a few.
#pragma once

#include "picture/channels.h"

namespace bob {

/// Completes gray or colour of a G-buffer along guides of all pixels.
///
/// Light is the channel divided by the albedo. At each pixel, weighted least squares fit a plane over position and normal to about 18
/// traced neighbours, or more if they are noisy. Weights fall with distance and with differences in normal, albedo and coverage, and with
/// the distance from the pixel's tangent plane in depth. Light does not leak across edges, and follows curvature within a surface.
///
/// An exact sample, of variance 0, keeps its value. A noisy one becomes a mean of its value and the fit, weighted by the scatter of its
/// neighbours beyond their noise. A sample more than twice as bright as its neighbours is darkened within its variance.
///
/// With `covered_only`, pixels without coverage are 0 and cost nothing.
///
/// planes: (known.width(), height, width) of a G-buffer, 0 where not traced, with `channel`, gray or color, and perhaps the
/// variance; guides: (guides.width(), height, width) with mask, depth, normal and albedo. Writes the channel's components,
/// (components, height, width), all at least 0; all 0 if no pixel is traced. Throws std::invalid_argument if a channel is missing.
///
/// noise: (height, width) or null. Receives the standard deviation that each pixel's own sample leaves in its largest component: where
/// neighbours differ by more than noise, the result keeps the sample.
///
/// Mean SSIM over bench/tracers.py's four perspective scenes, from 5 % of the pixels on a lattice: 0.982. With weighted means, as in
/// joint bilateral filters, 0.978; with planes over the position alone, or over the normal alone, 0.980.
///
/// After Moon et al., "Adaptive Rendering Based on Weighted Local Regression" (2014), of sparse pixels.
void complete_guided(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const Channel& channel,
                     int height, int width, bool covered_only, float* output, float* noise = nullptr);

/// Completes the alpha of a picture of light, (height, width): coverage by surfaces, plus the shadow on the ground, at most 1.
///
/// planes: of a G-buffer with shadow and variance; coverage: (height, width); ground: (2, height, width) with the ground's share of each
/// pixel and its depth; noise: as in `complete_guided`, of the shadow. keeps_samples: as in `complete_light`.
void complete_alpha(const Layout& known, const float* planes, const float* coverage, const float* ground, int height, int width, float* alpha,
                    float* noise = nullptr, bool keeps_samples = true);

/// Completes a picture of light, with `covered_only`: color, (3, height, width), and alpha, (height, width).
///
/// ground: as in `complete_alpha`, or null; noise: (height, width) or null, receives the standard deviation that noise leaves in the
/// displayed picture, in sRGB 0..1. Without `keeps_samples`, traced pixels show the fit too: of few, each would be a dot.
void complete_light(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const float* ground,
                    int height, int width, float* color, float* alpha, float* noise = nullptr, bool keeps_samples = true);

}  // namespace bob
