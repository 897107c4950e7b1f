/// Interpolation between traced pixels that agree.
#pragma once

#include <span>

#include "completion/rows.h"
#include "picture/channels.h"

namespace bob {

/// Blends a network's output with the mean of agreeing traced pixels.
///
/// In a square of the lattice (`lattice_tile`), the mean of two opposite corners that agree is closer than a network's
/// output. That holds in the smooth parts of adaptively sampled pictures, and along their edges. In large squares all
/// corners have to agree. From the coarsest square to the finest, an untraced corner is itself a mean. The weight of a
/// mean falls with the contrast of its corners and is 0 beyond `most_contrast`. If the traced pixels do not lie in the
/// lattice, few pixels change. The components of a colour share their weights.
///
/// planes: (known.width(), height, width) of a G-buffer, beginning with the mask; output: (completed.width(), height,
/// width). Throws std::invalid_argument if the G-buffer lacks a completed channel.
void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width);

/// Interpolates a band only; other rows that it writes are incomplete.
void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band);

/// Interpolates one channel with values in units of `unit`. `weights`, (height, width) or null, receives the weight of
/// the mean, 0..1, and 0 where traced.
void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                         int height, int width);

/// Interpolates colours along a guide that is black outside `lit`, columns of each two rows, where nothing is
/// interpolated. Traced pixels are restored.
void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, std::span<const Stretch> lit,
                         float* output, int height, int width);

}  // namespace bob
