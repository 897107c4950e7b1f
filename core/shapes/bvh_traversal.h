/// BVH traversal for any kind of packets. Only for *_kernels.cpp.
#pragma once

#include <limits>

#include "base/bvh.h"
#include "base/simd.h"
#include "shapes/shape.h"

namespace bob::BOB_ISA {

// A node's eight boxes fill one register, or two of four lanes.
constexpr int width = lanes < 8 ? 4 : 8;
using Floats = Vector<width>;
using Ints = IntVector<width>;

/// Per-ray values for intersection with boxes.
///
/// Branch-free: for rays of any direction, neither signs nor the longest axis can be predicted, and mispredicted
/// branches cost a seventh to a fifth of all time. Setting up several rays ahead of their traversal loses up to 7 %:
/// processors already overlap one ray's setup with the end of the last.
struct RayThroughBoxes {
    using Float4 = Vector<4>;
    using Int4 = IntVector<4>;

    // Replaces zero direction components: 1/0 = inf would turn every slab into NaN, which is correct but culls nothing.
    static constexpr float least_size = 1e-18f;

    /// Per-axis values: the t of a plane is plane * reciprocal - shift.
    struct Slabs {
        Float4 origin, direction, size, reciprocal, shift;  // size: magnitudes of the direction's components
        Int4 sign;

        Slabs() = default;
        explicit Slabs(const Ray& ray)
            : origin{ray.origin.x, ray.origin.y, ray.origin.z}, direction{ray.direction.x, ray.direction.y, ray.direction.z} {
            sign = (Int4)direction & INT32_MIN;
            size = (Float4)((Int4)direction ^ sign);
            const Float4 safe = (Float4)((Int4)max(size, broadcast<Float4>(least_size)) | sign);
            reciprocal = 1.f / safe;
            shift = origin * reciprocal;
        }
    };

    Float4 origin, direction, size, reciprocal;
    Floats inverse[3], shift[3];
    int near_side[3];  // 0 if the ray reaches the lower plane first

    explicit RayThroughBoxes(const Ray& ray) : RayThroughBoxes(Slabs(ray)) {}
    explicit RayThroughBoxes(const Slabs& slabs)
        : origin(slabs.origin), direction(slabs.direction), size(slabs.size), reciprocal(slabs.reciprocal) {
        for (int axis = 0; axis < 3; ++axis) {
            inverse[axis] = broadcast<Floats>(reciprocal[axis]);
            shift[axis] = broadcast<Floats>(slabs.shift[axis]);
            near_side[axis] = static_cast<int>(bits(slabs.sign) >> axis & 1);
        }
    }
};

/// Writes the entry t of each child's box; returns a bit for each box entered before t_max.
inline unsigned enter_boxes(const BvhNode& node, const RayThroughBoxes& ray, float t_max, float* t_enter) {
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

/// A child and, in the upper bits, the ray's entry t into its box: nonnegative floats sort as their bits.
using Entry = std::uint64_t;

inline Entry entry(float t, ChildRef child) {
    std::uint32_t t_bits;
    std::memcpy(&t_bits, &t, sizeof t);
    return Entry{t_bits} << 32 | child.bits;
}

inline ChildRef child_of(Entry entry) { return {static_cast<std::uint32_t>(entry)}; }

/// Returns the nearest of the entered children, at least one. The others go on the stack, sorted so that the nearest is
/// popped first.
///
/// One and two children are most frequent, and the nearer of two cannot be predicted: integers are swapped without a
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

/// Traverses the leaves along a ray, near ones first.
class Traversal {
public:
    /// Leaves no leaf.
    void clear() { top_ = stack_; }

    /// Starts with the children of a node.
    void begin(const BvhNode& root, const RayThroughBoxes& ray) {
        clear();
        alignas(32) float t[8];
        const unsigned entered = enter_boxes(root, ray, std::numeric_limits<float>::infinity(), t);
        if (!entered) return;
        const ChildRef nearest = take_nearest(root, entered, t, top_);
        *top_++ = entry(0, nearest);
    }

    /// False if no remaining leaf can contain a hit before t_max, which must not grow.
    bool next_leaf(const BvhNode* nodes, const RayThroughBoxes& ray, float t_max, ChildRef& leaf) {
        const Entry farthest = entry(t_max, {UINT32_MAX});
        while (true) {
            do {
                if (top_ == stack_) return false;
                --top_;
            } while (*top_ > farthest);
            ChildRef current = child_of(*top_);
            while (true) {
                if (current.is_leaf()) {
                    leaf = current;
                    return true;
                }
                const BvhNode& node = nodes[current.node_index()];
                alignas(32) float t[8];
                const unsigned entered = enter_boxes(node, ray, t_max, t);
                if (!entered) break;
                current = take_nearest(node, entered, t, top_);
            }
        }
    }

private:
    Entry stack_[7 * Bvh::max_depth + 24];
    Entry* top_;
};

/// Calls intersect(packet) for the packets along the ray, near ones first, while a nearer hit is possible. It may reduce
/// hit.t.
template <class Intersect>
inline void traverse(const BvhNode* nodes, const RayThroughBoxes& ray, Hit& hit, Intersect&& intersect) {
    Traversal way;
    way.begin(nodes[0], ray);
    ChildRef leaf;
    while (way.next_leaf(nodes, ray, hit.t, leaf)) {
        const std::uint32_t first = leaf.first_packet(), end = first + leaf.packets();
        for (std::uint32_t packet = first; packet != end; ++packet) intersect(packet);
    }
}

}  // namespace bob::BOB_ISA
