/// Where traced pixels agree, what lies between them is interpolated.
#pragma once

#include <span>

#include "completion/rows.h"
#include "picture/channels.h"

namespace bob {

/// Improves what a network made of the pixels that were not traced, where they lie in squares of the lattice
/// (`lattice_tile`) of whose corners two opposite ones agree: there their mean is closer than a network comes, as in the smooth
/// parts of a picture whose order goes where pixels differ, and along its edges. Of large squares all corners have to agree. From the
/// coarsest square to the finest, a corner that was not traced is such a mean itself; the more its corners differ, the less it counts, and beyond `most_contrast` not at
/// all. Where the traced pixels do not lie in the lattice, hardly a pixel changes. The components of a colour agree or differ together.
///
/// planes: (known.width(), height, width) of a G-buffer, beginning with the mask; output: (completed.width(), height, width).
/// Throws std::invalid_argument if the G-buffer lacks a completed channel.
void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width);

/// The same of a band alone; what it writes to other rows is not finished.
void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band);

/// The same of one channel, of whose values `unit` counts as 1; `weights`, (height, width) or null, says how far the mean counts,
/// 0..1, and 0 where traced.
void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                         int height, int width);

/// The same of colours along a guide that is black beyond `lit`, columns of each two rows: there nothing is interpolated. Traced pixels
/// are put back.
void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, std::span<const Stretch> lit,
                         float* output, int height, int width);

}  // namespace bob
