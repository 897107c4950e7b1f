/// Axis-aligned boxes.
#pragma once

#include <limits>

#include "base/vec.h"

namespace bob {

/// Initially empty.
struct Box {
    static constexpr float infinity = std::numeric_limits<float>::infinity();

    Vec3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

    void extend(Vec3 p) { low = min(low, p), high = max(high, p); }
    void extend(const Box& box) { low = min(low, box.low), high = max(high, box.high); }

    /// Half the surface area, proportional to the probability of a ray intersection; 0 for an empty box.
    [[nodiscard]] float half_area() const {
        const Vec3 size = high - low;
        return size.x >= 0 ? size.x * size.y + size.y * size.z + size.z * size.x : 0;
    }
};

/// A box in double precision, in the units of its contents.
struct Bounds {
    double low[3], high[3];
};

}  // namespace bob
