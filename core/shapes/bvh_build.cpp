/// Top-down: binary splits by the surface area heuristic over binned centroids (Wald, "On fast Construction of SAH-based
/// Bounding Volume Hierarchies", 2007), collapsed to eight children a node by opening the largest ones.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "parallel.h"
#include "shapes/bvh.h"

namespace bob {
namespace {

constexpr int bins = 16;
constexpr std::size_t packet_size = std::tuple_size_v<Packet>;
constexpr std::size_t max_leaf = packet_size * ChildRef::max_packets;

// From this depth on ranges are halved, so that no boxes, however odd, make the tree deeper than max_depth.
constexpr int max_sah_depth = Bvh::max_depth - 28;

// Ranges up to this size are built whole by one thread. The split is by size, not by the number of threads, so that
// the tree is the same for any number of them.
constexpr std::size_t task_size = 4096;

constexpr float infinity = Box::infinity;

/// Half of a box' surface area; 0 for an empty one.
float half_area(const Box& box) {
    const Vec3 s = box.high - box.low;
    return s.x >= 0 ? s.x * s.y + s.y * s.z + s.z * s.x : 0;
}

struct Primitive {
    Box box;
    std::uint32_t index;

    /// Twice the centre.
    [[nodiscard]] float centroid(int axis) const { return box.low[axis] + box.high[axis]; }
};

/// A node of the binary tree: an inner node has two children, a leaf a range of primitives.
struct BinaryNode {
    Box box;
    std::size_t begin = 0, end = 0;
    int depth = 0;
    std::int64_t left = -1, right = -1;

    [[nodiscard]] bool is_leaf() const { return left < 0; }
};

struct Bin {
    Box box;
    std::size_t count = 0;
};

/// Which of an axis' bins a centroid falls into.
struct Binning {
    int axis;
    float low, scale;

    Binning(int axis, const Box& centroids) : axis(axis), low(centroids.low[axis]) {
        const float size = centroids.high[axis] - low;
        scale = size > 0 ? bins * (1 - 1e-6f) / size : 0;
        if (!std::isfinite(scale)) scale = 0;  // a size of denormal numbers
    }
    [[nodiscard]] int operator()(const Primitive& p) const {
        return static_cast<int>(scale * (p.centroid(axis) - low));
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
        // More than the rounding of box and primitive tests can move a hit across a box' face: for boxes and origins
        // within some units, errors stay below 2^-21 units.
        const float pad = extent * 0x1p-19f;
        parallel_for(boxes.size(), 16384, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 margin{pad, pad, pad};
                primitives_[i] = {{boxes[i].low - margin, boxes[i].high + margin}, static_cast<std::uint32_t>(i)};
            }
        });
    }

    Bvh build() {
        const std::vector<BinaryNode> nodes = split_whole();
        return collapse(nodes);
    }

private:
    /// Large ranges are split one after the other, then small ones side by side.
    std::vector<BinaryNode> split_whole() {
        std::vector<BinaryNode> nodes{{{}, 0, primitives_.size()}};
        std::vector<std::int64_t> tasks;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (nodes[i].end - nodes[i].begin <= task_size) {
                tasks.push_back(static_cast<std::int64_t>(i));
            } else {
                split(nodes, i);
            }
        }
        std::vector<std::vector<BinaryNode>> subtrees(tasks.size());
        parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t task = begin; task < end; ++task) {
                auto& subtree = subtrees[task];
                subtree.push_back(nodes[static_cast<std::size_t>(tasks[task])]);
                for (std::size_t i = 0; i < subtree.size(); ++i) split(subtree, i);
            }
        });
        for (std::size_t task = 0; task < tasks.size(); ++task) {
            // The subtree's root takes the place of the range; the nodes below it go to the end.
            const auto offset = static_cast<std::int64_t>(nodes.size()) - 1;
            auto& subtree = subtrees[task];
            for (BinaryNode& node : subtree) {
                if (!node.is_leaf()) node.left += offset, node.right += offset;
            }
            nodes[static_cast<std::size_t>(tasks[task])] = subtree.front();
            nodes.insert(nodes.end(), subtree.begin() + 1, subtree.end());
        }
        return nodes;
    }

    /// Gives nodes[i] its box and, unless a leaf is cheaper, two children at the end of `nodes`.
    void split(std::vector<BinaryNode>& nodes, std::size_t i) {
        BinaryNode node = nodes[i];
        const auto first = primitives_.begin() + static_cast<std::ptrdiff_t>(node.begin);
        const auto last = primitives_.begin() + static_cast<std::ptrdiff_t>(node.end);
        Box centroids;
        for (auto p = first; p != last; ++p) {
            node.box.extend(p->box);
            centroids.extend(Vec3{p->centroid(0), p->centroid(1), p->centroid(2)});
        }
        nodes[i] = node;
        const std::size_t count = node.end - node.begin;
        if (count <= packet_size) return;

        auto middle = first;
        if (node.depth < max_sah_depth) {
            if (!split_by_area(first, last, node.box, centroids, middle)) return;
        }
        if (middle == first || middle == last) {  // too deep, or centroids that bins can't part
            if (count <= max_leaf) return;
            middle = first + static_cast<std::ptrdiff_t>(count / 2);
        }
        const auto cut = static_cast<std::size_t>(middle - primitives_.begin());
        nodes[i].left = static_cast<std::int64_t>(nodes.size());
        nodes[i].right = nodes[i].left + 1;
        nodes.push_back({{}, node.begin, cut, node.depth + 1});
        nodes.push_back({{}, cut, node.end, node.depth + 1});
    }

    using Iterator = std::vector<Primitive>::iterator;

    /// Parts first..last at the cheapest plane between bins; false where a leaf is cheaper.
    bool split_by_area(Iterator first, Iterator last, const Box& box, const Box& centroids, Iterator& middle) const {
        const Binning binning[3] = {{0, centroids}, {1, centroids}, {2, centroids}};
        Bin bin[3][bins];
        for (auto p = first; p != last; ++p) {
            for (int axis = 0; axis < 3; ++axis) {
                Bin& b = bin[axis][binning[axis](*p)];
                b.box.extend(p->box);
                ++b.count;
            }
        }
        float best_cost = infinity;
        int best_axis = 0, best_plane = 0;
        for (int axis = 0; axis < 3; ++axis) {
            float cost_above[bins];  // of the bins at and above each plane
            Bin sum;
            for (int plane = bins - 1; plane > 0; --plane) {
                sum.box.extend(bin[axis][plane].box);
                sum.count += bin[axis][plane].count;
                cost_above[plane] = sum.count ? half_area(sum.box) * packets_of(sum.count) : infinity;
            }
            sum = {};
            for (int plane = 1; plane < bins; ++plane) {
                sum.box.extend(bin[axis][plane - 1].box);
                sum.count += bin[axis][plane - 1].count;
                if (sum.count == 0) continue;
                const float cost = half_area(sum.box) * packets_of(sum.count) + cost_above[plane];
                if (cost < best_cost) best_cost = cost, best_axis = axis, best_plane = plane;
            }
        }
        const auto count = static_cast<std::size_t>(last - first);
        const float area = half_area(box);
        if (count <= max_leaf && packets_of(count) * area <= node_cost_ * area + best_cost) return false;
        middle = first;
        if (best_cost < infinity) {
            const Binning& by = binning[best_axis];
            middle = std::partition(first, last, [&](const Primitive& p) { return by(p) < best_plane; });
        }
        return true;
    }

    Bvh collapse(const std::vector<BinaryNode>& binary) {
        Bvh bvh;
        // Pairs of a node to be filled and the binary node that it stands for.
        std::vector<std::pair<std::size_t, std::int64_t>> open{{0, 0}};
        bvh.nodes.emplace_back();
        while (!open.empty()) {
            const auto [index, root] = open.back();
            open.pop_back();
            std::int64_t children[8] = {root};
            int count = 1;
            while (count < 8) {
                int largest = -1;
                float largest_area = -1;
                for (int i = 0; i < count; ++i) {
                    const BinaryNode& child = binary[static_cast<std::size_t>(children[i])];
                    if (!child.is_leaf() && half_area(child.box) > largest_area) {
                        largest = i, largest_area = half_area(child.box);
                    }
                }
                if (largest < 0) break;
                const BinaryNode& opened = binary[static_cast<std::size_t>(children[largest])];
                children[largest] = opened.left;
                children[count++] = opened.right;
            }
            BvhNode node;
            for (int i = 0; i < 8; ++i) {
                const Box box = i < count ? binary[static_cast<std::size_t>(children[i])].box : Box{};
                for (int axis = 0; axis < 3; ++axis) {
                    node.bounds[0][axis][i] = box.low[axis];
                    node.bounds[1][axis][i] = box.high[axis];
                }
                if (i >= count) {
                    node.child[i] = ChildRef::leaf(0, 1);
                    continue;
                }
                const BinaryNode& child = binary[static_cast<std::size_t>(children[i])];
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
                packet[lane] = primitives_[begin + lane < leaf.end ? begin + lane : begin].index;
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
