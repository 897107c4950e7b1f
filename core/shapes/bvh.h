/// Bounding volume hierarchy over triangles: eight boxes to a node, eight triangles to a packet.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isa.h"
#include "shapes/shape.h"
#include "vec.h"

namespace bob {

using Triangle = std::array<std::uint32_t, 3>;

/// Where a child's subtree lies: a node, or a run of triangle packets.
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

/// 320 bytes. An absent triangle repeats the packet's first. (Packets of four make the tree larger: bunny and armadillo
/// are a tenth slower, none is faster.)
struct alignas(32) TrianglePacket {
    static constexpr int size = 8;

    float vertex[3][3][size];  // [corner][axis][lane]
    std::uint32_t triangle[size];
};

struct Bvh {
    std::vector<BvhNode> nodes;  // the first is the root
    std::vector<TrianglePacket> packets;

    [[nodiscard]] std::size_t bytes() const {
        return nodes.size() * sizeof(BvhNode) + packets.size() * sizeof(TrianglePacket);
    }
};

/// Builds by the surface area heuristic; the result is a function of the mesh alone, not of the number of threads.
[[nodiscard]] Bvh build_bvh(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

struct BvhKernels {
    /// The nearest intersection with t > 0 of each ray; u and v are the barycentric weights of the triangle's first and
    /// second corner.
    ///
    /// Watertight (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013) for origins within a
    /// few sizes of the mesh: a ray never passes between two triangles that share an edge or a corner.
    void (*closest_hits)(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                         Hit* hits);
};

BOB_DECLARE_KERNELS(BvhKernels, bvh_kernels)

}  // namespace bob
