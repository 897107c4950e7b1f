/// Bounding volume hierarchy over boxes: eight to a node. Its leaves are runs of packets, each of eight primitives of any
/// kind, which are tested together.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.h"

namespace bob {

/// Where a child's subtree lies: a node, or a run of packets.
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

/// 224 bytes. An absent child has a box that no finite ray enters (low = +inf, high = -inf); others that enter it find
/// the first packet, which does no harm.
struct alignas(32) BvhNode {
    float bounds[2][3][8];  // [low, high][axis][child]
    ChildRef child[8];
};

/// The primitives that are tested together. An absent one repeats the packet's first.
using Packet = std::array<std::uint32_t, 8>;

struct Bvh {
    /// No path is longer than this, and a node leaves at most seven children behind.
    static constexpr int max_depth = 88;

    std::vector<BvhNode> nodes;  // the first is the root
    std::vector<Packet> packets;
};

/// Builds by the surface area heuristic; `node_cost` is the cost of visiting a node, in tests of a packet. The result is
/// a function of the boxes alone, not of the number of threads. Boxes are finite and at least one; each is made larger by
/// more than rounding can move a hit across its face.
[[nodiscard]] Bvh build_bvh(std::span<const Box> boxes, float node_cost);

}  // namespace bob
