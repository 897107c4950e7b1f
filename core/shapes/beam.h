/// Neighbouring rays that begin their way through a bounding volume hierarchy together. Included by *_kernels.cpp files alone.
#pragma once

#include <limits>
#include <span>

#include "shapes/bvh_traversal.h"

namespace bob::BOB_ISA {

/// Rays whose directions have the same signs, as far as they differ.
class Beam {
public:
    /// The node that rays begin at: one of the tree's, or one of up to eight subtrees that any of the rays may meet
    /// ("Multi-Level Ray Tracing Algorithm", Reshetov et al., 2005, find entry points likewise). Null where there are none.
    const BvhNode* entry(const BvhNode* nodes, std::span<const Ray> rays) {
        if (rays.size() < worth_it || !enclose(rays)) return nodes;
        int open = 0, count = 0;  // found_[open] on may be nodes that are to be opened
        add_entered(nodes[0], count);
        while (open < count) {
            const ChildRef child = found_[open].child;
            if (child.is_leaf()) {
                ++open;
                continue;
            }
            // In the node's place, if its children find a place.
            const Found node = found_[open];
            found_[open] = found_[--count];
            const int before = count;
            if (!add_entered(nodes[child.node_index()], count)) {
                count = before;
                found_[count++] = found_[open];
                found_[open++] = node;
            }
        }
        if (count == 0) return nullptr;
        constexpr float infinity = std::numeric_limits<float>::infinity();
        for (int i = 0; i < 8; ++i) {
            for (int side = 0; side < 2; ++side) {
                for (int axis = 0; axis < 3; ++axis) {
                    const float none = side ? -infinity : infinity;
                    root_.bounds[side][axis][i] = i < count ? found_[i].bounds[side][axis] : none;
                }
            }
            root_.child[i] = i < count ? found_[i].child : ChildRef::leaf(0, 1);
        }
        return &root_;
    }

private:
    static constexpr std::size_t worth_it = 4;

    struct Found {
        float bounds[2][3];
        ChildRef child;
    };

    bool enclose(std::span<const Ray> rays) {
        Vector<4> least[2], most[2];  // of reciprocal directions, and shifts
        unsigned signs = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const RayThroughBoxes::Slabs slabs(rays[i]);
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

    /// Which of a node's boxes a ray of the beam may enter: all that any enters, as rounding is monotonic.
    [[nodiscard]] unsigned entered(const BvhNode& node) const {
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
            result |= bits(enter <= leave) << i;
        }
        return result;
    }

    /// False where there is no place for all of them.
    bool add_entered(const BvhNode& node, int& count) {
        for (unsigned left = entered(node); left; left &= left - 1) {
            if (count == 8) return false;
            const int i = __builtin_ctz(left);
            Found& found = found_[count++];
            found.child = node.child[i];
            for (int side = 0; side < 2; ++side) {
                for (int axis = 0; axis < 3; ++axis) found.bounds[side][axis] = node.bounds[side][axis][i];
            }
        }
        return true;
    }

    Floats inverse_[2][3], shift_[2][3];  // the least and the largest
    int near_side_[3];
    Found found_[8];
    BvhNode root_;
};

}  // namespace bob::BOB_ISA
