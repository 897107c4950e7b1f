/// The pieces of a tube for ray intersection.
#pragma once

#include <cstddef>

#include "base/bvh.h"
#include "base/isa.h"
#include "shapes/shape.h"

namespace bob {

/// A cubic Bezier curve in space and radius.
struct alignas(32) TubePiece {
    double ball[4][4];  // [control point][x, y, z, radius]
};

struct TubeKernels {
    /// The first t > 0 where each ray crosses the boundary of the union of all balls. The value u is the parameter 0..1
    /// of the ball on its piece. The leaves' packets are nodes too: their children are the boxes and numbers of pieces.
    void (*closest_hits)(const BvhNode* nodes, const BvhNode* packets, const TubePiece* pieces, const Ray* rays,
                         std::size_t count, Hit* hits);
};

BOB_DECLARE_KERNELS(TubeKernels, tube_kernels)

}  // namespace bob
