/// Channels that are completed along with another one.
#pragma once

#include "picture/channels.h"

namespace bob {

/// Completes a channel by its ratio to a guide, such as colour to gray: where light and shade are, the guide says; what lies
/// between traced pixels has their ratio, by pull-push over sums that the guide weights, so that what is dark or empty
/// has no say. Where the guide is clearly brighter than the traced pixels around, the rest is white: it may be another surface, or a highlight.
///
/// planes: (known.width(), height, width) of a G-buffer, 0 where not traced; known_guide, (height, width), at least 0, and 0
/// where not traced; guide: the same completed. Writes the channel's components, (components, height, width), but for
/// traced pixels, which only are near their values. Throws std::invalid_argument if the G-buffer lacks the channel.
///
/// Kraus, "The pull-push algorithm revisited" (2009).
void complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                       int height, int width, float* output);

}  // namespace bob
