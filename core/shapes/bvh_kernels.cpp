#include "shapes/bvh.h"
#include "simd.h"

namespace bob::BOB_ISA {
namespace {

using Float4 = Vector<4>;
using Int4 = IntVector<4>;

// A node's eight boxes fill one register, or two where registers hold four.
constexpr int box_lanes = lanes < 8 ? 4 : 8;
using Boxes = Vector<box_lanes>;

/// What is computed once for a ray: the slabs' reciprocals and the shear that turns the ray into the axis k[2].
struct Traversal {
    Boxes inverse[3], shift[3];  // t of a slab = inverse * plane - shift
    int near_side[3];            // 0 where the ray meets the lower plane first
    int k[3];
    Float4 origin[3];
    Float4 shear_x, shear_y, scale_z;

    explicit Traversal(const Ray& ray) {
        const Float4 o{ray.origin.x, ray.origin.y, ray.origin.z};
        const Float4 d{ray.direction.x, ray.direction.y, ray.direction.z};
        // Nothing here branches: what a random ray does is not to be predicted.
        const Int4 sign = (Int4)d & std::int32_t(0x80000000);
        const Float4 size = (Float4)((Int4)d ^ sign);
        // A bound instead of 1/0 = inf, which would make NaN of every slab: right still, but nothing is culled.
        const Float4 safe = (Float4)((Int4)max(size, broadcast<Float4>(1e-18f)) | sign);
        const Float4 reciprocal = 1 / safe;
        const Float4 offset = o * reciprocal;
        const unsigned negative = bits(sign);
        for (int axis = 0; axis < 3; ++axis) {
            inverse[axis] = broadcast<Boxes>(reciprocal[axis]);
            shift[axis] = broadcast<Boxes>(offset[axis]);
            near_side[axis] = negative >> axis & 1;
            origin[axis] = broadcast<Float4>(o[axis]);
        }
        const unsigned larger = (size[0] > size[1]) + 2 * (size[0] > size[2]) + 4 * (size[1] > size[2]);
        k[2] = "\2\2\2\0\1\1\1\0"[larger];
        k[0] = "\1\2\0"[k[2]];
        k[1] = "\2\0\1"[k[2]];
        shear_x = broadcast<Float4>(d[k[0]] * reciprocal[k[2]]);
        shear_y = broadcast<Float4>(d[k[1]] * reciprocal[k[2]]);
        scale_z = broadcast<Float4>(reciprocal[k[2]]);
    }
};

/// Writes the distance at which the ray enters each child's box; a bit is set for each box entered before t_max.
inline unsigned enter_boxes(const BvhNode& node, const Traversal& ray, float t_max, float* t_enter) {
    unsigned entered = 0;
    for (int i = 0; i < 8; i += box_lanes) {
        Boxes enter = broadcast<Boxes>(0.f);
        Boxes leave = broadcast<Boxes>(t_max);
        for (int axis = 0; axis < 3; ++axis) {
            const int near = ray.near_side[axis];
            const Boxes a = load<Boxes>(&node.bounds[near][axis][i]);
            const Boxes b = load<Boxes>(&node.bounds[1 - near][axis][i]);
            enter = max(fma(a, ray.inverse[axis], -ray.shift[axis]), enter);
            leave = min(fma(b, ray.inverse[axis], -ray.shift[axis]), leave);
        }
        store(t_enter + i, enter);
        entered |= bits(enter <= leave) << i;
    }
    return entered;
}

/// Intersects four triangles and keeps the nearest hit.
///
/// In the plane across the ray, an edge function is a difference of two products. Each product is rounded on its own
/// (no fma), so that the difference has the right sign or is zero, and a neighbour's is its exact negation; zero
/// counts as inside. So no ray slips between neighbours, and the paper's retry in double precision is not needed.
/// A NaN fails every comparison below: no hit.
inline void intersect(const TrianglePacket& packet, const Traversal& ray, Hit& hit) {
    Float4 x[3], y[3], z[3];
    for (int corner = 0; corner < 3; ++corner) {
        const auto& vertex = packet.vertex[corner];
        z[corner] = load<Float4>(vertex[ray.k[2]]) - ray.origin[ray.k[2]];
        x[corner] = load<Float4>(vertex[ray.k[0]]) - ray.origin[ray.k[0]] - ray.shear_x * z[corner];
        y[corner] = load<Float4>(vertex[ray.k[1]]) - ray.origin[ray.k[1]] - ray.shear_y * z[corner];
    }
    const Float4 u = x[2] * y[1] - y[2] * x[1];
    const Float4 v = x[0] * y[2] - y[0] * x[2];
    const Float4 w = x[1] * y[0] - y[1] * x[0];
    const Float4 zero{};
    const Float4 lowest = min(min(u, v), w), highest = max(max(u, v), w);
    const Int4 inside = (lowest >= zero) | (highest <= zero);
    if (!bits(inside)) return;

    const Float4 determinant = u + v + w;
    const Float4 t = (u * z[0] + v * z[1] + w * z[2]) * ray.scale_z / determinant;
    unsigned found = bits(inside & (determinant != zero) & (t > zero) & (t < broadcast<Float4>(hit.t)));
    for (; found; found &= found - 1) {
        const int lane = __builtin_ctz(found);
        if (t[lane] < hit.t) {
            hit = {t[lane], u[lane] / determinant[lane], v[lane] / determinant[lane], packet.triangle[lane]};
        }
    }
}

struct Entry {
    ChildRef child;
    float t;  // where the ray enters the child's box
};

Hit closest_hit(const BvhNode* nodes, const TrianglePacket* packets, const Ray& r) {
    const Traversal ray(r);
    Hit hit;
    // Depth is at most 88 (see bvh_build.cpp) and a node leaves at most seven children behind.
    Entry stack[640];
    Entry* top = stack;
    ChildRef current = ChildRef::node(0);
    while (true) {
        if (current.is_leaf()) {
            const TrianglePacket* packet = packets + current.first_packet();
            for (const auto* end = packet + current.packets(); packet != end; ++packet) intersect(*packet, ray, hit);
        } else {
            const BvhNode& node = nodes[current.node_index()];
            alignas(32) float t[8];
            unsigned entered = enter_boxes(node, ray, hit.t, t);
            if (entered) {
                // The nearest child next; the others wait, sorted so that the nearest of them comes off first.
                Entry nearest{node.child[__builtin_ctz(entered)], t[__builtin_ctz(entered)]};
                entered &= entered - 1;
                Entry* const base = top;
                for (; entered; entered &= entered - 1) {
                    const int i = __builtin_ctz(entered);
                    Entry entry{node.child[i], t[i]};
                    if (entry.t < nearest.t) {
                        const Entry swap = nearest;
                        nearest = entry;
                        entry = swap;
                    }
                    Entry* slot = top++;
                    for (; slot != base && slot[-1].t < entry.t; --slot) *slot = slot[-1];
                    *slot = entry;
                }
                current = nearest.child;
                continue;
            }
        }
        do {
            if (top == stack) return hit;
            --top;
        } while (top->t > hit.t);
        current = top->child;
    }
}

void closest_hits(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                  Hit* hits) {
    for (std::size_t i = 0; i < count; ++i) hits[i] = closest_hit(nodes, packets, rays[i]);
}

}  // namespace

const BvhKernels bvh_kernels = {closest_hits};

}  // namespace bob::BOB_ISA
