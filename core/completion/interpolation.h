/// Where traced pixels agree, what lies between them is their mean.
#pragma once

#include "completion/rows.h"
#include "picture/channels.h"

namespace bob {

/// Improves what a network made of the pixels that were not traced, where they lie in squares of the lattice
/// (`lattice_tile`) whose corners agree: there the mean of the corners is closer than a network comes, as in the smooth parts
/// of a picture whose order goes where pixels differ. From the coarsest square to the finest, a corner that was not traced
/// is the mean of its own corners; the more any of them differ, the less the mean counts, and beyond `most_contrast` not
/// at all. Where the traced pixels do not lie in the lattice, hardly a pixel changes.
///
/// planes: (known.width(), height, width) of a G-buffer, beginning with the mask; output: (completed.width(), height, width).
/// Throws std::invalid_argument if the G-buffer lacks a completed channel.
void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width);

/// The same of a band alone; what it writes to other rows is not finished.
void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band);

/// The same of a channel of one component; `weights`, (height, width), says how far the mean counts, 0..1, and 0 where
/// traced.
void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float* output, float* weights,
                         int height, int width);

}  // namespace bob
