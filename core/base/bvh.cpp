/// Top-down construction: binary splits by the surface area heuristic over binned centroids (Wald, "On fast
/// Construction of SAH-based Bounding Volume Hierarchies", 2007). Then nodes are collapsed to eight children by opening
/// the largest ones.
#include "base/bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/float4.h"
#include "base/interruption.h"
#include "base/parallel.h"

namespace bob {
namespace {

constexpr int bins = 16;
constexpr std::size_t packet_size = std::tuple_size_v<Packet>;
constexpr std::size_t max_leaf = packet_size * ChildRef::max_packets;

// From this depth on, ranges are halved, so that no boxes, however odd, make the tree deeper than max_depth.
constexpr int max_sah_depth = Bvh::max_depth - 28;

// Ranges up to this size are built by one thread. The split depends on size, not on the number of threads, so that
// every number of threads builds the same tree.
constexpr std::size_t task_size = 4096;

constexpr float infinity = Box::infinity;

/// A box in registers, initially empty. The fourth lanes are unused.
struct WideBox {
    Float4 low{infinity, infinity, infinity, infinity}, high = -low;

    void extend(Float4 p) { low = min(low, p), high = max(high, p); }
    void extend(const WideBox& box) { low = min(low, box.low), high = max(high, box.high); }
    [[nodiscard]] Box narrow() const { return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}}; }
    [[nodiscard]] float half_area() const { return narrow().half_area(); }
};

WideBox widened(const Box& box) {
    return {Float4{box.low.x, box.low.y, box.low.z, 0}, Float4{box.high.x, box.high.y, box.high.z, 0}};
}

/// 32 bytes, so that a box is two loads: the index, low and high, and a zero.
class alignas(32) Primitive {
public:
    Primitive() = default;
    Primitive(std::uint32_t index, Vec3 low, Vec3 high)
        : values_{std::bit_cast<float>(index), low.x, low.y, low.z, high.x, high.y, high.z, 0} {}

    [[nodiscard]] std::uint32_t index() const { return std::bit_cast<std::uint32_t>(values_[0]); }
    [[nodiscard]] WideBox box() const { return {load4(values_ + 1), load4(values_ + 4)}; }
    /// Twice the centre.
    [[nodiscard]] float centroid(int axis) const { return values_[1 + axis] + values_[4 + axis]; }

private:
    float values_[8];
};

/// The bounds of a range of primitives; centroids are twice the centres.
struct Extent {
    WideBox box, centroids;

    void extend(const Primitive& p) {
        const WideBox b = p.box();
        box.extend(b);
        centroids.extend(b.low + b.high);
    }
};

/// A node of the binary tree: a range of primitives and, unless it is a leaf, two consecutive children.
struct BinaryNode {
    Box box, centroids;
    std::uint32_t begin, end;
    std::uint32_t left = 0;  // 0, the root's index, for a leaf
    int depth = 0;

    BinaryNode(const Extent& extent, std::uint32_t begin, std::uint32_t end, int depth)
        : box(extent.box.narrow()), centroids(extent.centroids.narrow()), begin(begin), end(end), depth(depth) {}

    [[nodiscard]] bool is_leaf() const { return left == 0; }
};

/// A split of a range of primitives, by the bins of one axis.
struct Cut {
    int axis;
    float low, scale, plane;

    [[nodiscard]] bool below(const Primitive& p) const { return scale * (p.centroid(axis) - low) < plane; }
};

/// Bins per unit of a range's centroids, 0 for an axis along which bins cannot separate them.
Float4 scales(const WideBox& centroids) {
    const Float4 size = centroids.high - centroids.low;
    Float4 scale{};
    for (int axis = 0; axis < 3; ++axis) {
        const float s = size[axis] > 0 ? bins * (1 - 1e-6f) / size[axis] : 0;
        scale[axis] = std::isfinite(s) ? s : 0;  // extents may be denormal
    }
    return scale;
}

/// The primitives of a range, binned by their centroids along each axis.
struct Bins {
    WideBox box[3][bins];
    std::uint32_t count[3][bins] = {};

    Bins(const Primitive* first, const Primitive* last, Float4 low, Float4 scale) {
        using Int4 [[gnu::vector_size(16)]] = std::int32_t;
        for (const Primitive* p = first; p != last; ++p) {
            const WideBox b = p->box();
            const Int4 at = __builtin_convertvector(scale * (b.low + b.high - low), Int4);
            for (int axis = 0; axis < 3; ++axis) {
                box[axis][at[axis]].extend(b);
                ++count[axis][at[axis]];
            }
        }
    }
};

float packets_of(std::size_t primitives) { return static_cast<float>((primitives + packet_size - 1) / packet_size); }

class Builder {
public:
    Builder(std::span<const Box> boxes, float node_cost) : node_cost_(node_cost), primitives_(boxes.size()) {
        float extent = 0;
        for (const Box& box : boxes) {
            for (const Vec3 v : {box.low, box.high}) {
                extent = std::max({extent, std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
            }
        }
        // More than rounding in box and primitive tests can move a hit across a box's face. For boxes and origins
        // within a few units, errors stay below 2^-21 units.
        const float pad = extent * 0x1p-19f;
        parallel_for(boxes.size(), 16384, [&](std::size_t begin, std::size_t end) {
            Interruption::check();
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 margin{pad, pad, pad};
                primitives_[i] = {static_cast<std::uint32_t>(i), boxes[i].low - margin, boxes[i].high + margin};
            }
        });
    }

    Bvh build() {
        const std::vector<BinaryNode> nodes = split_whole();
        return collapse(nodes);
    }

private:
    /// Splits large ranges level by level, then builds small ones as whole subtrees; both in parallel.
    std::vector<BinaryNode> split_whole() {
        Extent whole;
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            if (i % 32768 == 0) Interruption::check();
            whole.extend(primitives_[i]);
        }
        std::vector<BinaryNode> nodes{{whole, 0, static_cast<std::uint32_t>(primitives_.size()), 0}};
        std::vector<std::size_t> small;
        for (std::size_t level = 0; level < nodes.size();) {
            const std::size_t end = nodes.size();
            const auto is_small = [&](std::size_t i) { return nodes[i].end - nodes[i].begin <= task_size; };
            std::vector<std::optional<Children>> children(end - level);
            parallel_for(children.size(), 1, [&](std::size_t first, std::size_t last) {
                for (std::size_t i = first; i < last; ++i) {
                    if (!is_small(level + i)) children[i] = split(nodes[level + i]);
                }
            });
            for (std::size_t i = level; i < end; ++i) {
                if (is_small(i)) small.push_back(i);
                append(nodes, i, children[i - level]);
            }
            level = end;
        }
        std::vector<std::vector<BinaryNode>> subtrees(small.size());
        parallel_for(small.size(), 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t task = first; task < last; ++task) {
                auto& subtree = subtrees[task];
                subtree.push_back(nodes[small[task]]);
                for (std::size_t i = 0; i < subtree.size(); ++i) append(subtree, i, split(subtree[i]));
            }
        });
        for (std::size_t task = 0; task < small.size(); ++task) {
            // The subtree's root replaces the range; the nodes below it are appended.
            const auto offset = static_cast<std::uint32_t>(nodes.size() - 1);
            auto& subtree = subtrees[task];
            for (BinaryNode& node : subtree) {
                if (!node.is_leaf()) node.left += offset;
            }
            nodes[small[task]] = subtree.front();
            nodes.insert(nodes.end(), subtree.begin() + 1, subtree.end());
        }
        return nodes;
    }

    using Children = std::array<BinaryNode, 2>;

    /// Appends the children of nodes[i], if it has any.
    static void append(std::vector<BinaryNode>& nodes, std::size_t i, const std::optional<Children>& children) {
        if (!children) return;
        nodes[i].left = static_cast<std::uint32_t>(nodes.size());
        nodes.insert(nodes.end(), children->begin(), children->end());
    }

    /// Splits a node's primitives; empty if a leaf is cheaper.
    std::optional<Children> split(const BinaryNode& node) {
        const std::uint32_t count = node.end - node.begin;
        if (count <= packet_size) return std::nullopt;
        if (count > task_size / 4) Interruption::check();

        Primitive* const first = primitives_.data() + node.begin;
        Primitive* const last = primitives_.data() + node.end;
        Primitive* middle = first + count / 2;
        Extent below, above;
        std::optional<Cut> cut;
        if (node.depth < max_sah_depth) {
            float cost = infinity;
            cut = cheapest_cut(first, last, widened(node.centroids), cost);
            const float area = node.box.half_area();
            if (count <= max_leaf && packets_of(count) * area <= node_cost_ * area + cost) return std::nullopt;
        }
        if (cut) {
            middle = part(first, last, *cut, below, above);
        } else {  // too deep, or centroids that bins cannot separate
            if (count <= max_leaf) return std::nullopt;
            for (const Primitive* p = first; p != middle; ++p) below.extend(*p);
            for (const Primitive* p = middle; p != last; ++p) above.extend(*p);
        }
        const auto end_below = static_cast<std::uint32_t>(middle - primitives_.data());
        return Children{BinaryNode(below, node.begin, end_below, node.depth + 1),
                        BinaryNode(above, end_below, node.end, node.depth + 1)};
    }

    /// The cheapest plane between bins, if there is any. Its cost, from the areas of both sides, is in tests of a
    /// packet.
    static std::optional<Cut> cheapest_cut(const Primitive* first, const Primitive* last, const WideBox& centroids, float& cost) {
        const Float4 scale = scales(centroids);
        const Bins binned(first, last, centroids.low, scale);
        std::optional<Cut> best;
        for (int axis = 0; axis < 3; ++axis) {
            const auto& box = binned.box[axis];
            const auto& count = binned.count[axis];
            float cost_above[bins];  // for the bins at and above each plane
            WideBox sum;
            std::uint32_t inside = 0;
            for (int plane = bins - 1; plane > 0; --plane) {
                sum.extend(box[plane]);
                inside += count[plane];
                cost_above[plane] = inside ? sum.half_area() * packets_of(inside) : infinity;
            }
            sum = {}, inside = 0;
            for (int plane = 1; plane < bins; ++plane) {
                sum.extend(box[plane - 1]);
                inside += count[plane - 1];
                if (inside == 0) continue;
                const float both = sum.half_area() * packets_of(inside) + cost_above[plane];
                if (both < cost) cost = both, best = {axis, centroids.low[axis], scale[axis], static_cast<float>(plane)};
            }
        }
        return best;
    }

    /// Partitions a range by the side of the cut. Returns the start of the second side and the bounds of both.
    static Primitive* part(Primitive* first, Primitive* last, const Cut& cut, Extent& below, Extent& above) {
        while (true) {
            while (first != last && cut.below(*first)) below.extend(*first++);
            while (first != last && !cut.below(*(last - 1))) above.extend(*--last);
            if (first == last) return first;
            std::swap(*first, *(last - 1));
        }
    }

    Bvh collapse(const std::vector<BinaryNode>& binary) {
        Bvh bvh;
        // Pairs of a node to fill and its binary node.
        std::vector<std::pair<std::size_t, std::uint32_t>> open{{0, 0}};
        bvh.nodes.emplace_back();
        while (!open.empty()) {
            if (bvh.nodes.size() % 1024 == 0) Interruption::check();
            const auto [index, root] = open.back();
            open.pop_back();
            std::uint32_t children[8] = {root};
            int count = 1;
            while (count < 8) {
                int largest = -1;
                float largest_area = -1;
                for (int i = 0; i < count; ++i) {
                    const BinaryNode& child = binary[children[i]];
                    const float area = child.is_leaf() ? -1 : child.box.half_area();
                    if (area > largest_area) largest = i, largest_area = area;
                }
                if (largest < 0) break;
                const std::uint32_t left = binary[children[largest]].left;
                children[largest] = left;
                children[count++] = left + 1;
            }
            BvhNode node;
            for (int i = 0; i < 8; ++i) {
                const Box box = i < count ? binary[children[i]].box : Box{};
                for (int axis = 0; axis < 3; ++axis) {
                    node.bounds[0][axis][i] = box.low[axis];
                    node.bounds[1][axis][i] = box.high[axis];
                }
                if (i >= count) {
                    node.child[i] = ChildRef::leaf(0, 1);
                    continue;
                }
                const BinaryNode& child = binary[children[i]];
                if (child.is_leaf()) {
                    node.child[i] = emit_packets(bvh, child);
                } else {
                    node.child[i] = ChildRef::node(bvh.nodes.size());
                    open.emplace_back(bvh.nodes.size(), children[i]);
                    bvh.nodes.emplace_back();
                }
            }
            bvh.nodes[index] = node;
        }
        return bvh;
    }

    ChildRef emit_packets(Bvh& bvh, const BinaryNode& leaf) {
        const std::size_t first = bvh.packets.size();
        for (std::size_t begin = leaf.begin; begin < leaf.end; begin += packet_size) {
            Packet packet;
            for (std::size_t lane = 0; lane < packet_size; ++lane) {
                packet[lane] = primitives_[begin + lane < leaf.end ? begin + lane : begin].index();
            }
            bvh.packets.push_back(packet);
        }
        return ChildRef::leaf(first, bvh.packets.size() - first);
    }

    float node_cost_;
    std::vector<Primitive> primitives_;
};

}  // namespace

Bvh build_bvh(std::span<const Box> boxes, float node_cost) {
    if (boxes.empty()) throw std::invalid_argument("build_bvh: expected at least one box, got none");
    return Builder(boxes, node_cost).build();
}

}  // namespace bob
