/// Where a formula's inside ends.
#pragma once

#include <optional>

#include "base/box.h"
#include "formula/expression.h"

namespace bob {

/// A box around all points where f <= 0, a little larger than they need; nothing where f is positive everywhere. Throws
/// std::invalid_argument if intervals can't prove that it ends somewhere within 1e9 of the origin, and Stopped if it is
/// interrupted.
[[nodiscard]] std::optional<Bounds> find_bounds(const Expression& f);

}  // namespace bob
