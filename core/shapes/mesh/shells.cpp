#include "shapes/mesh/shells.h"

#include <algorithm>
#include <numeric>

#include "base/interruption.h"
#include "shapes/mesh/normals.h"

namespace bob {
namespace {

/// Sets of triangles, each with its direction relative to its parent.
class Sets {
public:
    explicit Sets(std::size_t count) : parent_(count), reversed_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

    struct Root {
        std::uint32_t index;
        bool is_reversed;
    };
    Root find(std::uint32_t i) {
        std::uint32_t root = i;
        std::uint8_t whole = 0;
        for (; parent_[root] != root; root = parent_[root]) whole ^= reversed_[root];
        const std::uint8_t result = whole;
        while (parent_[i] != root) {  // all of the path now points to the root
            const std::uint32_t next = parent_[i];
            const std::uint8_t own = reversed_[i];
            parent_[i] = root, reversed_[i] = whole;
            whole ^= own, i = next;
        }
        return {root, result != 0};
    }

    void join(std::uint32_t a, std::uint32_t b, bool is_reversed) {
        const Root to = find(a), from = find(b);
        if (to.index == from.index) return;
        parent_[from.index] = to.index, reversed_[from.index] = to.is_reversed ^ from.is_reversed ^ is_reversed;
    }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<std::uint8_t> reversed_;
};

}  // namespace

Shells find_shells(std::span<const Vec3> points, std::span<const Triangle> triangles) {
    const std::vector<std::uint32_t> first = merge_positions(points);
    struct Edge {
        std::uint64_t ends;
        std::uint32_t triangle;
        bool is_forward;

        bool operator<(const Edge& other) const { return ends != other.ends ? ends < other.ends : triangle < other.triangle; }
    };
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = first[triangles[t][i]], b = first[triangles[t][(i + 1) % 3]];
            if (a != b) edges.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), t, a < b});
        }
    }
    Interruption::check();
    std::sort(edges.begin(), edges.end());
    Sets sets(triangles.size());
    for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
        for (end = begin + 1; end < edges.size() && edges[end].ends == edges[begin].ends;) ++end;
        const Edge &a = edges[begin], &b = edges[end - 1];
        if (end - begin == 2 && a.triangle != b.triangle) sets.join(a.triangle, b.triangle, a.is_forward == b.is_forward);
    }
    Interruption::check();
    Shells shells;
    shells.of.resize(triangles.size()), shells.reversed.resize(triangles.size());
    constexpr std::uint32_t none = 0xffffffff;
    std::vector<std::uint32_t> number(triangles.size(), none);  // of the shell with that root
    std::vector<std::uint8_t> first_is_reversed;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const auto [root, is_reversed] = sets.find(t);
        if (number[root] == none) number[root] = shells.count++, first_is_reversed.push_back(is_reversed);
        shells.of[t] = number[root], shells.reversed[t] = is_reversed != (first_is_reversed[number[root]] != 0);
    }
    return shells;
}

}  // namespace bob
