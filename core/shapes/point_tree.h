/// A point set that bounds its extent under any map without visiting each point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/affine.h"
#include "base/box.h"

namespace bob {

class PointTree {
public:
    using Point = std::array<double, 3>;

    /// Needs at least one point; all must be finite.
    explicit PointTree(std::vector<Point> points);

    /// The lowest and highest coordinates of the points transformed by a map, exact to the bit. A sum of products
    /// rounded one after the other is monotonic in each coordinate, so that a box corner bounds its contents.
    [[nodiscard]] Bounds bounds(const AffineMap& map) const;

    /// The maximum of value(p) over the points transformed by a map. The function is nondecreasing in the distance from
    /// `center`, up to rounding.
    template <class Value>
    [[nodiscard]] double farthest(const AffineMap& map, const double center[3], Value value) const;

    [[nodiscard]] std::size_t bytes() const { return points_.size() * sizeof(Point) + nodes_.size() * sizeof(Node); }

private:
    static constexpr std::size_t leaf_size = 8;
    static constexpr std::size_t max_depth = 64;

    struct Node {
        Point low, high;
        std::uint32_t begin, end;  // range of its points
        std::uint32_t second;      // second child; the first follows the node; 0 for a leaf
    };

    void build(std::size_t begin, std::size_t end);
    [[nodiscard]] double highest(const double row[4]) const;

    static double value(const double row[4], const Point& p) { return row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]; }

    std::vector<Point> points_;
    std::vector<Node> nodes_;
};

template <class Value>
double PointTree::farthest(const AffineMap& map, const double center[3], Value value) const {
    // The maximum distance of a node's points from its centre along each axis, including rounding.
    const auto reach = [&](const Node& node) {
        Point result;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& row = map.row[i];
            double middle = row[3], half = 0, largest = std::fabs(row[3]) + std::fabs(center[i]);
            for (std::size_t j = 0; j < 3; ++j) {
                middle += row[j] * (node.low[j] / 2 + node.high[j] / 2);
                half += std::fabs(row[j]) * (node.high[j] / 2 - node.low[j] / 2);
                largest += std::fabs(row[j]) * std::max(std::fabs(node.low[j]), std::fabs(node.high[j]));
            }
            result[i] = std::fabs(middle - center[i]) + half + 1e-14 * largest;
        }
        return result;
    };
    const Point all = reach(nodes_[0]);
    int exponent = 0;  // in units of about the largest distance, so that squares stay in range
    std::frexp(std::max({all[0], all[1], all[2]}), &exponent);
    const double scale = std::ldexp(1, std::clamp(-exponent, -1000, 1000));
    const auto square = [scale](double x, double y, double z) {
        x *= scale, y *= scale, z *= scale;
        return x * x + y * y + z * z;
    };
    struct Open {
        std::uint32_t node;
        double bound;
    };
    std::array<Open, max_depth> stack;
    std::size_t open = 0;
    const auto bounded = [&](std::uint32_t node) {
        const Point at = reach(nodes_[node]);
        return Open{node, square(at[0], at[1], at[2])};
    };
    stack[open++] = bounded(0);
    double most = -HUGE_VAL, farthest = -1;
    while (open > 0) {
        const auto [index, bound] = stack[--open];
        if (bound < farthest) continue;
        const Node& node = nodes_[index];
        if (node.second) {
            const Open first = bounded(index + 1), second = bounded(node.second);
            const bool swap = first.bound > second.bound;  // the farther is visited first
            stack[open++] = swap ? second : first;
            stack[open++] = swap ? first : second;
            continue;
        }
        for (std::size_t i = node.begin; i < node.end; ++i) {
            Point p;
            for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = PointTree::value(map.row[axis], points_[i]);
            most = std::max(most, value(p));
            farthest = std::max(farthest, square(p[0] - center[0], p[1] - center[1], p[2] - center[2]));
        }
    }
    return most;
}

}  // namespace bob
