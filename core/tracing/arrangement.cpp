#include "tracing/arrangement.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace bob {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using Numbers = std::array<double, 12>;

void check(double radius) {
    if (!(radius > 0)) throw std::invalid_argument("shapes: expected an extent above zero, got all vertices in one point");
    if (std::isfinite(radius) && radius > smallest_radius) return;
    char text[32];
    std::snprintf(text, sizeof text, "%g", radius);
    throw std::invalid_argument(std::string("shapes: expected a radius that float64 holds with its reciprocal, got ") + text);
}

}  // namespace

Arrangement::Arrangement(std::vector<Placed> shapes, const std::function<bool()>& keep_going) : shapes_(std::move(shapes)) {
    if (shapes_.empty()) throw std::invalid_argument("shapes: expected at least one shape, got none");
    std::map<std::pair<const Shape*, Numbers>, std::size_t> known;
    for (const auto& [shape, transform, material] : shapes_) {
        const auto [entry, added] = known.try_emplace({shape.get(), std::bit_cast<Numbers>(transform)}, places_.size());
        if (added) places_.push_back({shape.get(), transform, {}});
        place_.push_back(entry->second);
    }
    const auto stopped = [&] { return keep_going && !keep_going(); };
    Bounds box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (auto& [shape, transform, bounds] : places_) {
        if (stopped()) return;
        bounds = shape->bounds(transform);
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], bounds.low[axis]);
            box.high[axis] = std::max(box.high[axis], bounds.high[axis]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) sphere_.center[axis] = box.low[axis] / 2 + box.high[axis] / 2;  // no overflow
    sphere_.radius = 0;
    for (const auto& [shape, transform, bounds] : places_) {
        if (stopped()) return;
        sphere_.radius = std::max(sphere_.radius, shape->radius(transform, sphere_.center));
    }
    check(sphere_.radius);
}

Scene Arrangement::scene(std::span<const Digest> digests, const std::function<bool()>& keep_going) const {
    std::vector<std::uint32_t> order = canonical_order(digests);
    if (digests.empty()) {
        order.resize(shapes_.size());
        std::iota(order.begin(), order.end(), 0u);
    }
    std::vector<Instance> instances;
    instances.reserve(order.size());
    for (const std::uint32_t i : order) {
        if (keep_going && !keep_going()) break;
        const Placed& placed = shapes_[i];
        const Place& place = places_[place_[i]];
        placed.shape->prepare();
        Vec3 low, high;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = static_cast<float>((place.bounds.low[axis] - sphere_.center[axis]) / sphere_.radius);
            high[axis] = static_cast<float>((place.bounds.high[axis] - sphere_.center[axis]) / sphere_.radius);
        }
        instances.push_back({placed.shape, to_shape(place), low, high, placed.material, i});
    }
    return Scene(std::move(instances));
}

/// From the unit sphere to the coordinates in which rays meet the shape.
AffineMap Arrangement::to_shape(const Place& place) const {
    const AffineMap from_here = to_unit_sphere(place.shape->sphere()) * inverse(place.transform);
    if (from_here == to_unit_sphere(sphere_)) return {};  // to the bit, which the product below is not
    return from_here * from_unit_sphere(sphere_);
}

}  // namespace bob
