/// Triangles for ray intersection.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bvh.h"
#include "base/isa.h"
#include "base/vec.h"
#include "shapes/shape.h"

namespace bob {

using Triangle = std::array<std::uint32_t, 3>;

/// 320 bytes, five whole cache lines. (Packets of four enlarge the tree: bunny and armadillo are a tenth slower, no
/// mesh is faster.)
struct alignas(64) TrianglePacket {
    static constexpr int size = 8;

    float vertex[3][3][size];  // [corner][axis][lane]
    std::uint32_t triangle[size];
};

struct TriangleBvh {
    std::vector<BvhNode> nodes;
    std::vector<TrianglePacket> packets;
    float packet_size = 0;  // mean diameter of packets, weighted by how often rays reach them

    [[nodiscard]] std::size_t bytes() const {
        return nodes.size() * sizeof(BvhNode) + packets.size() * sizeof(TrianglePacket);
    }
};

[[nodiscard]] TriangleBvh build_triangle_bvh(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Whether memory can be prefetched; WebAssembly has no instruction for it.
#if defined(__wasm__)
constexpr bool fetches_ahead = false;
#else
constexpr bool fetches_ahead = true;
#endif

/// Whether few rays of a call find packets in the cache. Then their entry points into the unit sphere are far apart, and
/// the tree is larger than the caches.
[[nodiscard]] bool lie_apart(const TriangleBvh& bvh, std::span<const Ray> rays);

/// Holes in triangles, transparent to rays.
class Holes {
public:
    virtual ~Holes() = default;
    /// Whether there is a hole at a place, given by the barycentric weights of the triangle's first and second corner.
    [[nodiscard]] virtual bool at(std::uint32_t triangle, float u, float v) const = 0;

protected:
    Holes() = default;
    Holes(const Holes&) = default;
};

struct TriangleKernels {
    /// The nearest intersection with t > 0 of each ray. The values u and v are the barycentric weights of the triangle's
    /// first and second corner. `apart`, from `lie_apart`, affects speed only: it hides memory latency for scattered
    /// rays and slows others.
    ///
    /// Watertight (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013) for origins within a few
    /// sizes of the mesh: a ray never passes between two triangles that share an edge or a corner.
    void (*closest_hits)(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                         bool apart, Hit* hits);
    /// The same, ignoring intersections in holes.
    void (*closest_hits_around)(const Holes& holes, const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays,
                                std::size_t count, bool apart, Hit* hits);
};

BOB_DECLARE_KERNELS(TriangleKernels, triangle_kernels)

}  // namespace bob
