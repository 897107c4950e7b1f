/// Ray intersection with many boxes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/affine.h"
#include "base/box.h"
#include "base/bvh.h"
#include "base/isa.h"
#include "shapes/shape.h"

namespace bob {

/// 224 bytes. An absent box is one that no ray enters (low = +inf, high = -inf).
struct alignas(32) BoxPacket {
    float bounds[2][3][8];  // [low, high][axis][lane]
    std::uint32_t box[8];
};

struct BoxBvh {
    std::vector<BvhNode> nodes;  // the first is the root
    std::vector<BoxPacket> packets;
    std::size_t boxes = 0;  // their number
};

[[nodiscard]] BoxBvh build_box_bvh(std::span<const Box> boxes);

/// A ray enters a box at t, which is 0 if it starts inside.
struct Entrance {
    std::uint32_t box, ray;
    float t;
};

struct BoxKernels {
    /// Lists the boxes that the rays begin..end enter, in no particular order, until `enough` are listed. Returns the
    /// next ray. There is room for `enough` entrances plus the number of boxes. Each result depends on the ray and the
    /// box alone, to the bit in all instruction sets.
    std::size_t (*entrances)(const BoxBvh& boxes, const Ray* rays, std::size_t begin, std::size_t end,
                             std::size_t enough, Entrance* entrances, std::size_t& count);

    /// Transforms the rays of `count` entrances, a multiple of `together`, by a map. Each starts at its point t = start.
    /// The result equals AffineMap's to the bit. Null in instruction sets with too few doubles per register.
    static constexpr std::size_t together = 8;
    void (*rays_through)(const AffineMap& map, const Ray* rays, const Entrance* entrances, const float* start, std::size_t count,
                         Ray* mapped);
};

BOB_DECLARE_KERNELS(BoxKernels, box_kernels)

}  // namespace bob
