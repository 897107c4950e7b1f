/// Triangles as rays meet them.
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

/// 320 bytes, five whole lines of a cache. (Packets of four make the tree larger: bunny and armadillo are a tenth slower, none is
/// faster.)
struct alignas(64) TrianglePacket {
    static constexpr int size = 8;

    float vertex[3][3][size];  // [corner][axis][lane]
    std::uint32_t triangle[size];
};

struct TriangleBvh {
    std::vector<BvhNode> nodes;
    std::vector<TrianglePacket> packets;
    float packet_size = 0;  // across, of those that most rays meet

    [[nodiscard]] std::size_t bytes() const {
        return nodes.size() * sizeof(BvhNode) + packets.size() * sizeof(TrianglePacket);
    }
};

[[nodiscard]] TriangleBvh build_triangle_bvh(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Whether memory can be fetched before it is needed. WebAssembly can't say so.
#if defined(__wasm__)
constexpr bool fetches_ahead = false;
#else
constexpr bool fetches_ahead = true;
#endif

/// Whether the rays of a call come to the unit sphere, or begin in it, so far apart that few meet a packet that one shortly before
/// them has met, in a tree too large for caches.
[[nodiscard]] bool lie_apart(const TriangleBvh& bvh, std::span<const Ray> rays);

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
    /// second corner. Rays that lie apart, of `lie_apart`, wait less for memory, and others take longer if this is said of them;
    /// hits are the same.
    ///
    /// Watertight (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013) for origins within a
    /// few sizes of the mesh: a ray never passes between two triangles that share an edge or a corner.
    void (*closest_hits)(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                         bool apart, Hit* hits);
    /// The same, but for intersections that lie in holes.
    void (*closest_hits_around)(const Holes& holes, const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays,
                                std::size_t count, bool apart, Hit* hits);
};

BOB_DECLARE_KERNELS(TriangleKernels, triangle_kernels)

}  // namespace bob
