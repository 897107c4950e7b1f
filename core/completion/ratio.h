/// Channels completed along a guide.
#pragma once

#include <optional>
#include <vector>

#include "completion/rows.h"
#include "picture/channels.h"

namespace bob {

/// Completes a colour channel by its ratio to a guide, such as colour to gray. Returns the lit columns of each two
/// rows; outside them the guide is black, and the channel with it.
///
/// The guide gives light and shade; the ratios of traced pixels are spread by pull-push over sums weighted by the
/// guide, so that dark or empty pixels have no influence. Where the guide is clearly brighter than the traced pixels
/// nearby, the excess is white: it may be another surface, or a highlight.
///
/// planes: (known.width(), height, width) of a G-buffer, beginning with the mask, 0 where not traced. known_guide:
/// (height, width), at least 0, and 0 where not traced. guide: the guide, completed. Writes the channel's components,
/// (3, height, width), within the channel's range; traced pixels are computed from the ratios too. For values of any
/// range, `unit` is the size of a 1, and there is no upper limit. Throws std::invalid_argument if the G-buffer lacks
/// the channel, or it has other than three components.
///
/// Kraus, "The pull-push algorithm revisited" (2009).
std::vector<Stretch> complete_by_ratio(const Layout& known, const float* planes, const Channel& channel, const float* known_guide,
                                       const float* guide, std::optional<float> unit, int height, int width, float* output);

/// The same, then interpolated where traced pixels of the lattice agree (completion/interpolation.h); traced pixels
/// keep their values.
void complete_along(const Layout& known, const float* planes, const Channel& channel, const float* known_guide, const float* guide,
                    std::optional<float> unit, int height, int width, float* output);

}  // namespace bob
