/// Triangles as rays meet them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bvh.h"
#include "isa.h"
#include "shapes/shape.h"
#include "vec.h"

namespace bob {

using Triangle = std::array<std::uint32_t, 3>;

/// 320 bytes. (Packets of four make the tree larger: bunny and armadillo are a tenth slower, none is faster.)
struct alignas(32) TrianglePacket {
    static constexpr int size = 8;

    float vertex[3][3][size];  // [corner][axis][lane]
    std::uint32_t triangle[size];
};

struct TriangleBvh {
    std::vector<BvhNode> nodes;
    std::vector<TrianglePacket> packets;

    [[nodiscard]] std::size_t bytes() const {
        return nodes.size() * sizeof(BvhNode) + packets.size() * sizeof(TrianglePacket);
    }
};

[[nodiscard]] TriangleBvh build_triangle_bvh(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Where triangles have holes, which rays pass through.
class Holes {
public:
    virtual ~Holes() = default;
    /// Whether there is one at a place of a triangle, given by the barycentric weights of its first and second corner.
    [[nodiscard]] virtual bool at(std::uint32_t triangle, float u, float v) const = 0;

protected:
    Holes() = default;
    Holes(const Holes&) = default;
};

struct TriangleKernels {
    /// The nearest intersection with t > 0 of each ray; u and v are the barycentric weights of the triangle's first and
    /// second corner.
    ///
    /// Watertight (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013) for origins within a
    /// few sizes of the mesh: a ray never passes between two triangles that share an edge or a corner.
    void (*closest_hits)(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                         Hit* hits);
    /// The same, but for intersections that lie in holes.
    void (*closest_hits_around)(const Holes& holes, const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays,
                                std::size_t count, Hit* hits);
};

BOB_DECLARE_KERNELS(TriangleKernels, triangle_kernels)

}  // namespace bob
