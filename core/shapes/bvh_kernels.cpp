#include "shapes/bvh.h"
#include "simd.h"

namespace bob::BOB_ISA {
namespace {

// A node's eight boxes, and a packet's eight triangles, fill one register, or two where registers hold four.
constexpr int width = lanes < 8 ? 4 : 8;
using Floats = Vector<width>;
using Ints = IntVector<width>;

/// What is computed once for a ray: the slabs' reciprocals and the shear that turns the ray into the axis k[2].
///
/// Nothing here branches: between rays of any direction, neither signs nor the longest axis can be predicted, and with
/// branches a seventh to a fifth of all time goes on mending wrong guesses. Setting up some rays ahead of their
/// traversal loses up to 7 %: processors overlap one ray's setup with the end of the one before anyhow.
struct Traversal {
    Floats inverse[3], shift[3];  // t of a slab = inverse * plane - shift
    int near_side[3];             // 0 where the ray meets the lower plane first
    int k[3];
    Floats origin[3];
    Floats shear_x, shear_y, scale_z;

    explicit Traversal(const Ray& ray) {
        using Float4 = Vector<4>;
        using Int4 = IntVector<4>;
        const Float4 o{ray.origin.x, ray.origin.y, ray.origin.z};
        const Float4 d{ray.direction.x, ray.direction.y, ray.direction.z};
        const Int4 sign = (Int4)d & INT32_MIN;
        const Float4 size = (Float4)((Int4)d ^ sign);
        // A bound instead of 1/0 = inf, which would make NaN of every slab: right still, but nothing is culled.
        const Float4 safe = (Float4)((Int4)max(size, broadcast<Float4>(1e-18f)) | sign);
        const Float4 reciprocal = 1.f / safe;
        const Float4 slab_shift = o * reciprocal;
        for (int axis = 0; axis < 3; ++axis) {
            inverse[axis] = broadcast<Floats>(reciprocal[axis]);
            shift[axis] = broadcast<Floats>(slab_shift[axis]);
            near_side[axis] = static_cast<int>(bits(sign) >> axis & 1);
            origin[axis] = broadcast<Floats>(o[axis]);
        }
        // The longest axis, by the outcomes of the comparisons x > y, x > z, y > z.
        constexpr signed char longest[8] = {2, 2, 2, 0, 1, 2, 1, 0};
        constexpr signed char next[5] = {0, 1, 2, 0, 1};
        k[2] = longest[(size[0] > size[1]) + 2 * (size[0] > size[2]) + 4 * (size[1] > size[2])];
        k[0] = next[k[2] + 1];
        k[1] = next[k[2] + 2];
        shear_x = broadcast<Floats>(d[k[0]] * reciprocal[k[2]]);
        shear_y = broadcast<Floats>(d[k[1]] * reciprocal[k[2]]);
        scale_z = broadcast<Floats>(reciprocal[k[2]]);
    }
};

/// Writes the distance at which the ray enters each child's box; a bit is set for each box entered before t_max.
inline unsigned enter_boxes(const BvhNode& node, const Traversal& ray, float t_max, float* t_enter) {
    unsigned entered = 0;
    for (int i = 0; i < 8; i += width) {
        Floats enter = broadcast<Floats>(0.f);
        Floats leave = broadcast<Floats>(t_max);
        for (int axis = 0; axis < 3; ++axis) {
            const int near = ray.near_side[axis];
            const Floats a = load<Floats>(&node.bounds[near][axis][i]);
            const Floats b = load<Floats>(&node.bounds[1 - near][axis][i]);
            enter = max(fma(a, ray.inverse[axis], -ray.shift[axis]), enter);
            leave = min(fma(b, ray.inverse[axis], -ray.shift[axis]), leave);
        }
        store(t_enter + i, enter);
        entered |= bits(enter <= leave) << i;
    }
    return entered;
}

/// Intersects eight triangles and keeps the nearest hit.
///
/// In the plane across the ray, an edge function is a difference of two products. Each product is rounded on its own
/// (no fma), so that the difference has the right sign or is zero, and a neighbour's is its exact negation; zero
/// counts as inside. So no ray slips between neighbours, and the paper's retry in double precision is not needed.
/// A NaN fails every comparison below: no hit.
inline void intersect(const TrianglePacket& packet, const Traversal& ray, Hit& hit) {
    for (int i = 0; i < 8; i += width) {
        Floats x[3], y[3], z[3];
        for (int corner = 0; corner < 3; ++corner) {
            const auto& vertex = packet.vertex[corner];
            z[corner] = load<Floats>(&vertex[ray.k[2]][i]) - ray.origin[ray.k[2]];
            x[corner] = load<Floats>(&vertex[ray.k[0]][i]) - ray.origin[ray.k[0]] - ray.shear_x * z[corner];
            y[corner] = load<Floats>(&vertex[ray.k[1]][i]) - ray.origin[ray.k[1]] - ray.shear_y * z[corner];
        }
        const Floats u = x[2] * y[1] - y[2] * x[1];
        const Floats v = x[0] * y[2] - y[0] * x[2];
        const Floats w = x[1] * y[0] - y[1] * x[0];
        const Floats zero{};
        const Floats lowest = min(min(u, v), w), highest = max(max(u, v), w);
        const Ints inside = (lowest >= zero) | (highest <= zero);
        if (!bits(inside)) continue;

        const Floats determinant = u + v + w;
        const Floats t = (u * z[0] + v * z[1] + w * z[2]) * ray.scale_z / determinant;
        unsigned found = bits(inside & (determinant != zero) & (t > zero) & (t < broadcast<Floats>(hit.t)));
        for (; found; found &= found - 1) {
            const int lane = __builtin_ctz(found);
            if (t[lane] < hit.t) {
                hit = {t[lane], u[lane] / determinant[lane], v[lane] / determinant[lane], packet.triangle[i + lane]};
            }
        }
    }
}

/// A child, and above it in the same number the distance at which the ray enters its box: floats that are not negative
/// sort as their bits do.
using Entry = std::uint64_t;

inline Entry entry(float t, ChildRef child) {
    std::uint32_t t_bits;
    std::memcpy(&t_bits, &t, sizeof t);
    return Entry{t_bits} << 32 | child.bits;
}

inline ChildRef child_of(Entry entry) { return {static_cast<std::uint32_t>(entry)}; }

/// The nearest of the children whose boxes were entered, of which there is at least one. The others go on the stack,
/// sorted so that the nearest of them comes off first.
///
/// One and two are most frequent, and which of two is nearer can't be predicted: whole numbers are swapped without a
/// branch. The same for three, in place of the loop, costs 3 %.
inline ChildRef take_nearest(const BvhNode& node, unsigned entered, const float* t, Entry*& top) {
    const auto next = [&] {
        const int i = __builtin_ctz(entered);
        entered &= entered - 1;
        return entry(t[i], node.child[i]);
    };
    if (!(entered & (entered - 1))) return node.child[__builtin_ctz(entered)];
    const Entry a = next(), b = next();
    Entry nearest = a < b ? a : b;
    Entry* const base = top;
    *top++ = a < b ? b : a;
    while (entered) {
        const Entry c = next();
        const Entry farther = nearest < c ? c : nearest;
        nearest = nearest < c ? nearest : c;
        Entry* slot = top++;
        for (; slot != base && slot[-1] < farther; --slot) *slot = slot[-1];
        *slot = farther;
    }
    return child_of(nearest);
}

Hit closest_hit(const BvhNode* nodes, const TrianglePacket* packets, const Ray& r) {
    const Traversal ray(r);
    Hit hit;
    // Depth is at most 88 (see bvh_build.cpp) and a node leaves at most seven children behind.
    Entry stack[640];
    Entry* top = stack;
    Entry farthest = entry(hit.t, {UINT32_MAX});  // of those that can hold a nearer hit
    ChildRef current = ChildRef::node(0);
    while (true) {
        if (current.is_leaf()) {
            const TrianglePacket* packet = packets + current.first_packet();
            for (const auto* end = packet + current.packets(); packet != end; ++packet) intersect(*packet, ray, hit);
            farthest = entry(hit.t, {UINT32_MAX});
        } else {
            const BvhNode& node = nodes[current.node_index()];
            alignas(32) float t[8];
            if (const unsigned entered = enter_boxes(node, ray, hit.t, t)) {
                current = take_nearest(node, entered, t, top);
                continue;
            }
        }
        do {
            if (top == stack) return hit;
            --top;
        } while (*top > farthest);
        current = child_of(*top);
    }
}

void closest_hits(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                  Hit* hits) {
    for (std::size_t i = 0; i < count; ++i) hits[i] = closest_hit(nodes, packets, rays[i]);
}

}  // namespace

const BvhKernels bvh_kernels = {closest_hits};

}  // namespace bob::BOB_ISA
