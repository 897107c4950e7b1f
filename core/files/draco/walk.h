/// Orders of Draco's values: walks over triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "files/draco/connectivity.h"

namespace bob::files::draco {

/// The order of an attribute's values.
struct Sequence {
    const Corners* corners = nullptr;    // null if values follow the points' order
    std::vector<std::int32_t> first;     // a corner of each value
    std::vector<std::int32_t> value_of;  // by the corners' vertices
    std::size_t count = 0;

    [[nodiscard]] std::size_t at_corner(std::int32_t c) const { return static_cast<std::size_t>(value_of[static_cast<std::size_t>(corners->vertex_of(c))]); }
};

/// Vertices as a walk over all triangles meets them.
///
/// is_by_degree: the walk prefers vertices that more triangles predict.
[[nodiscard]] Sequence walk(const Corners& corners, bool is_by_degree);

}  // namespace bob::files::draco
