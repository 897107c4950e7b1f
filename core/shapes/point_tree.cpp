#include "shapes/point_tree.h"

#include <utility>

#include "base/interruption.h"

namespace bob {

PointTree::PointTree(std::vector<Point> points) : points_(std::move(points)) {
    nodes_.reserve(points_.size() / (leaf_size / 4) + 1);
    build(0, points_.size());
    nodes_.shrink_to_fit();
}

void PointTree::build(std::size_t begin, std::size_t end) {
    if (end - begin > 4096) Interruption::check();
    const std::size_t index = nodes_.size();
    Node node{points_[begin], points_[begin], static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end), 0};
    for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            node.low[axis] = std::min(node.low[axis], points_[i][axis]);
            node.high[axis] = std::max(node.high[axis], points_[i][axis]);
        }
    }
    nodes_.push_back(node);
    if (end - begin <= leaf_size) return;
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
        if (node.high[axis] / 2 - node.low[axis] / 2 > node.high[longest] / 2 - node.low[longest] / 2) longest = axis;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](const Point& a, const Point& b) { return a[longest] < b[longest]; });
    build(begin, middle);
    nodes_[index].second = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
}

double PointTree::highest(const double row[4]) const {
    const auto bound = [&](std::uint32_t index) {
        const Node& node = nodes_[index];
        Point corner;
        for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] = row[axis] > 0 ? node.high[axis] : node.low[axis];
        return value(row, corner);
    };
    std::array<std::uint32_t, max_depth> stack;
    std::size_t open = 0;
    stack[open++] = 0;
    double most = -HUGE_VAL;
    while (open > 0) {
        const std::uint32_t index = stack[--open];
        if (bound(index) <= most) continue;
        const Node& node = nodes_[index];
        if (node.second) {
            const bool swap = bound(index + 1) > bound(node.second);  // the higher is visited first
            stack[open++] = swap ? node.second : index + 1;
            stack[open++] = swap ? index + 1 : node.second;
            continue;
        }
        for (std::size_t i = node.begin; i < node.end; ++i) most = std::max(most, value(row, points_[i]));
    }
    return most;
}

Bounds PointTree::bounds(const AffineMap& map) const {
    Bounds result;
    for (int axis = 0; axis < 3; ++axis) {
        const auto& row = map.row[axis];
        const double back[4] = {-row[0], -row[1], -row[2], -row[3]};
        result.low[axis] = -highest(back);
        result.high[axis] = highest(row);
    }
    return result;
}

}  // namespace bob
