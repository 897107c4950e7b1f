/// The trimmed domain of a NURBS surface: what loops of curves in (u, v) leave of it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "nurbs/nurbs.h"

namespace bob {

/// Curves end to end. Where one does not begin at the end of the one before, or the last does not end where the first
/// begins, a straight line joins them.
using TrimLoop = std::vector<NurbsCurve<2>>;

/// A rectangle of the parameters.
struct Domain {
    double low_u, high_u, low_v, high_v;
};

class TrimRegion {
public:
    /// Inside is what an odd number of loops goes around, whichever way they turn. Without loops, everything is.
    explicit TrimRegion(std::span<const TrimLoop> loops);

    /// Whether a point is inside. The curves themselves count, not an approximation by lines.
    [[nodiscard]] bool contains(double u, double v) const;

    enum class Coverage { none, some, all };

    /// How much of a rectangle is inside; `some` where a curve may pass through it, and only rarely where none does.
    [[nodiscard]] Coverage coverage(const Domain& rectangle) const;

    [[nodiscard]] std::size_t bytes() const;
};

}  // namespace bob
