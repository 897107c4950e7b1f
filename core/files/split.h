/// A part becomes several.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// The triangles of each group 0..count-1, in their order, and the vertices that they use: linear time in the part's size. groups: (T,);
/// triangles of other groups are left out.
[[nodiscard]] std::vector<Part> split(const Part& whole, std::span<const std::int32_t> groups, std::size_t count);

/// Rows (n, width) by their numbers; NaN where there is no such row.
[[nodiscard]] Numbers<double> picked(std::span<const double> rows, std::size_t width, std::span<const std::int32_t> numbers);

}  // namespace bob::files
