/// Shared start of the BVH traversal for neighbouring rays. Only for *_kernels.cpp.
#pragma once

#include <limits>
#include <span>

#include "shapes/bvh_traversal.h"

namespace bob::BOB_ISA {

/// Rays with directions of equal signs, in all components that differ.
class Beam {
public:
    static constexpr std::size_t most_rays = 16;  // 8 are up to 4 % slower, and 32 are no faster

    /// Starts with a beam of rays and finds up to eight subtrees that it may intersect, near ones first. These are the
    /// entry points of "Multi-Level Ray Tracing Algorithm", Reshetov et al., 2005. False if rays are too few or too
    /// different: each then traverses the whole tree on its own.
    bool begin(const BvhNode* nodes, std::span<const Ray> rays) {
        if (rays.size() < worth_it || !enclose(rays)) return false;
        int open = 0, count = 0;  // found_[open] on: may be nodes to open
        add_entered(nodes[0], count);
        while (open < count) {
            const ChildRef child = found_[open].child;
            if (child.is_leaf()) {
                ++open;
                continue;
            }
            // Replaces the node by its children if there is room.
            const Found node = found_[open];
            found_[open] = found_[--count];
            const int before = count;
            if (!add_entered(nodes[child.node_index()], count)) {
                count = before;
                found_[count++] = found_[open];
                found_[open++] = node;
            }
        }
        is_empty_ = count == 0;
        if (is_empty_) return true;
        constexpr float infinity = std::numeric_limits<float>::infinity();
        Found* sorted[8];
        for (int i = 0; i < count; ++i) {
            int k = i;
            for (; k > 0 && sorted[k - 1]->t > found_[i].t; --k) sorted[k] = sorted[k - 1];
            sorted[k] = &found_[i];
        }
        for (int i = 0; i < 8; ++i) {
            for (int side = 0; side < 2; ++side) {
                for (int axis = 0; axis < 3; ++axis) {
                    const float none = side ? -infinity : infinity;
                    entries_.bounds[side][axis][i] = i < count ? sorted[i]->bounds[side][axis] : none;
                }
            }
            entries_.child[i] = i < count ? sorted[i]->child : ChildRef::leaf(0, 1);
        }
        return true;
    }

    /// No ray intersects any subtree.
    [[nodiscard]] bool is_empty() const { return is_empty_; }

    /// The subtrees, as children of a node.
    [[nodiscard]] const BvhNode& entries() const { return entries_; }

    /// The subtrees that a ray enters, and their t.
    [[nodiscard]] unsigned enter(std::size_t ray, float* t) const {
        return enter_boxes(entries_, RayThroughBoxes(slabs_[ray]), std::numeric_limits<float>::infinity(), t);
    }

private:
    static constexpr std::size_t worth_it = 4;

    struct Found {
        float bounds[2][3];
        ChildRef child;
        float t;  // lower bound for all rays
    };

    bool enclose(std::span<const Ray> rays) {
        Vector<4> least[2], most[2];  // of reciprocal directions, and shifts
        unsigned signs = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const RayThroughBoxes::Slabs& slabs = slabs_[i] = RayThroughBoxes::Slabs(rays[i]);
            const Vector<4> values[2] = {slabs.reciprocal, slabs.shift};
            for (int k = 0; k < 2; ++k) {
                least[k] = i ? min(least[k], values[k]) : values[k];
                most[k] = i ? max(most[k], values[k]) : values[k];
            }
            const unsigned own = bits(slabs.sign) & 7;
            if (i && own != signs) return false;
            signs = own;
        }
        for (int axis = 0; axis < 3; ++axis) {
            inverse_[0][axis] = broadcast<Floats>(least[0][axis]), inverse_[1][axis] = broadcast<Floats>(most[0][axis]);
            shift_[0][axis] = broadcast<Floats>(least[1][axis]), shift_[1][axis] = broadcast<Floats>(most[1][axis]);
            near_side_[axis] = static_cast<int>(signs >> axis & 1);
        }
        return true;
    }

    /// The boxes of a node that a ray of the beam may enter; conservative, as rounding is monotonic.
    [[nodiscard]] unsigned entered(const BvhNode& node, float* t) const {
        unsigned result = 0;
        for (int i = 0; i < 8; i += width) {
            Floats enter = broadcast<Floats>(0.f), leave = broadcast<Floats>(std::numeric_limits<float>::infinity());
            for (int axis = 0; axis < 3; ++axis) {
                const Floats a = load<Floats>(&node.bounds[near_side_[axis]][axis][i]);
                const Floats b = load<Floats>(&node.bounds[1 - near_side_[axis]][axis][i]);
                const Floats least = inverse_[0][axis], most = inverse_[1][axis];
                enter = max(min(fma(a, least, -shift_[1][axis]), fma(a, most, -shift_[1][axis])), enter);
                leave = min(max(fma(b, least, -shift_[0][axis]), fma(b, most, -shift_[0][axis])), leave);
            }
            store(t + i, enter);
            result |= bits(enter <= leave) << i;
        }
        return result;
    }

    /// False if there is no room for all.
    bool add_entered(const BvhNode& node, int& count) {
        alignas(32) float t[8];
        for (unsigned left = entered(node, t); left; left &= left - 1) {
            if (count == 8) return false;
            const int i = __builtin_ctz(left);
            Found& found = found_[count++];
            found.child = node.child[i], found.t = t[i];
            for (int side = 0; side < 2; ++side) {
                for (int axis = 0; axis < 3; ++axis) found.bounds[side][axis] = node.bounds[side][axis][i];
            }
        }
        return true;
    }

    Floats inverse_[2][3], shift_[2][3];  // minimum and maximum
    int near_side_[3];
    Found found_[8];
    bool is_empty_ = true;
    BvhNode entries_;
    RayThroughBoxes::Slabs slabs_[most_rays];
};

}  // namespace bob::BOB_ISA
