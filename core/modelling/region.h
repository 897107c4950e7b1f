/// Regions of the plane as formulas of their signed distance.
#pragma once

#include <optional>
#include <vector>

#include "formula/expression.h"
#include "modelling/boundary.h"

namespace bob {

/// The signed distance in x and y from the inside of loops, negative inside; empty if there is no inside.
[[nodiscard]] std::optional<Value> region(Graph& graph, const std::vector<Loop>& loops, Winding winding);

}  // namespace bob
