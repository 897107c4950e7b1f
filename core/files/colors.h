/// Colours as files store them.
#pragma once

#include <cstddef>

#include "files/part.h"

namespace bob::files {

/// Linear light of an sRGB value, both 0..1, after IEC 61966-2-1.
[[nodiscard]] double linear(double srgb);

/// Turns components of sRGB into linear ones. `full` is all of a colour; 0 if it is to be guessed: 1 if all values are at most 1, else
/// 255 if they are at most that, else `most`.
void make_linear(Numbers<double>& values, double full, double most = 255);

}  // namespace bob::files
