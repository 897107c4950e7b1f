/// Bounding volume hierarchy over boxes: eight to a node. Leaves are runs of packets, each of eight primitives of any
/// kind, tested together.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.h"

namespace bob {

/// A reference to a child's subtree: a node, or a run of packets.
struct ChildRef {
    static constexpr std::uint32_t leaf_bit = 0x80000000;
    static constexpr int max_packets = 8;

    std::uint32_t bits;

    static ChildRef node(std::size_t index) { return {static_cast<std::uint32_t>(index)}; }
    static ChildRef leaf(std::size_t first_packet, std::size_t packets) {
        return {leaf_bit | static_cast<std::uint32_t>(first_packet) << 3 | static_cast<std::uint32_t>(packets - 1)};
    }
    [[nodiscard]] bool is_leaf() const { return bits & leaf_bit; }
    [[nodiscard]] std::uint32_t node_index() const { return bits; }
    [[nodiscard]] std::uint32_t first_packet() const { return (bits & ~leaf_bit) >> 3; }
    [[nodiscard]] std::uint32_t packets() const { return (bits & 7) + 1; }
};

/// 224 bytes. An absent child has a box that no finite ray enters (low = +inf, high = -inf); other rays that enter it
/// find the first packet, which is harmless.
struct alignas(32) BvhNode {
    float bounds[2][3][8];  // [low, high][axis][child]
    ChildRef child[8];
};

/// Eight primitives tested together. Absent ones repeat the packet's first.
using Packet = std::array<std::uint32_t, 8>;

struct Bvh {
    /// Maximum length of a path; each node leaves at most seven children on the stack.
    static constexpr int max_depth = 88;

    std::vector<BvhNode> nodes;  // the first is the root
    std::vector<Packet> packets;
};

/// Builds by the surface area heuristic; `node_cost` is the cost of visiting a node, in tests of a packet. The result
/// depends on the boxes alone, not on the number of threads. Boxes are finite, at least one; each is padded by more
/// than rounding can move a hit across its face.
[[nodiscard]] Bvh build_bvh(std::span<const Box> boxes, float node_cost);

}  // namespace bob
