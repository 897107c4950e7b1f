/// Channels that are completed along with another one.
#pragma once

#include <optional>
#include <vector>

#include "completion/rows.h"
#include "picture/channels.h"

namespace bob {

/// Completes a channel of colours by its ratio to a guide, such as colour to gray: where light and shade are, the guide says; what lies
/// between traced pixels has their ratio, by pull-push over sums that the guide weights, so that what is dark or empty
/// has no say. Where the guide is clearly brighter than the traced pixels around, the rest is white: it may be another surface, or a highlight.
///
/// planes: (known.width(), height, width) of a G-buffer, beginning with the mask, 0 where not traced; known_guide, (height, width),
/// at least 0, and 0 where not traced; guide: the same completed. Writes the channel's components, (3, height, width), within the
/// channel's range; those of traced pixels, too, are what the ratios around make of the guide. Values of any range come with the `unit`
/// that counts as 1, and have no upper end. Returns the columns of each two rows beyond which the guide is black, and all of the channel
/// with it.
/// Throws std::invalid_argument if the G-buffer lacks the channel, or it has other than three components.
///
/// Kraus, "The pull-push algorithm revisited" (2009).
std::vector<Stretch> complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide,
                                       const float* guide, std::optional<float> unit, int height, int width, float* output);

/// The same, and interpolated where traced pixels of the lattice agree (completion/interpolation.h); traced pixels are as they were.
void complete_along(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                    std::optional<float> unit, int height, int width, float* output);

}  // namespace bob
