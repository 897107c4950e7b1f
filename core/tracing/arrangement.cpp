#include "tracing/arrangement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/counts.h"
#include "base/interruption.h"
#include "base/parallel.h"
#include "tracing/place_key.h"

namespace bob {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Minimum number of places that repays a precomputation per shape.
constexpr std::size_t many_places = 8;

void check(double radius) {
    if (!(radius > 0)) throw std::invalid_argument("shapes: expected an extent above zero, got all vertices in one point");
    if (std::isfinite(radius) && radius > smallest_radius) return;
    // Without the library's formats, a WebAssembly module is 12 KB smaller.
    const std::string text = std::isfinite(radius) ? "about 1e" + std::to_string(static_cast<int>(std::floor(std::ilogb(radius) * 0.30103))) : "inf";
    throw std::invalid_argument("shapes: expected a radius that float64 holds with its reciprocal, got " + text);
}

/// Upper bound, from its box, of a placed shape's distance from a centre; infinite if out of range.
double farthest_possible(const Arrangement::Place& place, const double center[3]) {
    double distance[3], largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = place.bounds.low[axis], high = place.bounds.high[axis];
        distance[axis] = std::max(std::fabs(low - center[axis]), std::fabs(high - center[axis]));
        largest = std::max({largest, std::fabs(low), std::fabs(high), std::fabs(center[axis])});
    }
    const double slack = place.shape->overshoot() * place.shape->sphere().radius * singular_values(place.transform)[0];
    const double reach = std::hypot(distance[0], distance[1], distance[2]) * (1 + 1e-12) + slack + 1e-14 * largest;
    return reach < infinity ? reach : infinity;
}

/// Calls f(i) for each place, from several threads; with few places, each call has the threads to itself.
template <class F>
void for_places(std::size_t count, F f) {
    const auto some = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) f(i);
    };
    if (count >= many_places) {
        parallel_for(count, 16, some);
        return;
    }
    for (std::size_t i = 0; i < count; ++i) {
        Interruption::check();
        f(i);
    }
}

}  // namespace

Arrangement::Arrangement(std::vector<Placed> shapes) : shapes_(std::move(shapes)) {
    if (shapes_.empty()) throw std::invalid_argument("shapes: expected at least one shape, got none");
    check_instances("shapes", shapes_.size());
    std::unordered_map<PlaceKey, std::size_t, PlaceKey::Hash> known;
    std::map<const Shape*, std::size_t> counts;  // of places
    for (const auto& [shape, transform, material] : shapes_) {
        const auto [entry, added] = known.try_emplace({shape.get(), transform}, places_.size());
        if (added) places_.push_back({shape.get(), transform, {}});
        if (added) ++counts[shape.get()];
        place_.push_back(entry->second);
    }
    for (const auto& [shape, count] : counts) {
        if (count >= many_places) shape->prepare_places();
    }
    measure();
    check(sphere_.radius);
}

void Arrangement::measure() {
    for_places(places_.size(), [&](std::size_t i) { places_[i].bounds = places_[i].shape->bounds(places_[i].transform); });
    Bounds box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (const Place& place : places_) {
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], place.bounds.low[axis]);
            box.high[axis] = std::max(box.high[axis], place.bounds.high[axis]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) sphere_.center[axis] = box.low[axis] / 2 + box.high[axis] / 2;  // avoids overflow

    // The farthest boxes first, until the rest cannot reach as far.
    std::vector<double> reach(places_.size()), radius(places_.size());
    for_places(places_.size(), [&](std::size_t i) { reach[i] = farthest_possible(places_[i], sphere_.center); });
    std::vector<std::size_t> order(places_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return reach[a] > reach[b]; });
    sphere_.radius = 0;
    std::size_t count = 1;
    for (std::size_t begin = 0; begin < order.size() && reach[order[begin]] >= sphere_.radius; begin += count) {
        count = std::min<std::size_t>(begin < many_places ? 1 : 64, order.size() - begin);
        for_places(count, [&](std::size_t i) {
            const Place& place = places_[order[begin + i]];
            radius[begin + i] = place.shape->radius(place.transform, sphere_.center);
        });
        for (std::size_t i = begin; i < begin + count; ++i) sphere_.radius = std::max(sphere_.radius, radius[i]);
    }
}

Scene Arrangement::scene(std::span<const Digest> digests) const {
    std::vector<std::uint32_t> order = canonical_order(digests);
    if (digests.empty()) {
        order.resize(shapes_.size());
        std::iota(order.begin(), order.end(), 0u);
    }
    std::vector<Instance> instances;
    instances.reserve(order.size());
    for (const std::uint32_t i : order) {
        Interruption::check();
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

/// The map from the unit sphere to the coordinates of the shape.
AffineMap Arrangement::to_shape(const Place& place) const {
    const AffineMap from_here = to_unit_sphere(place.shape->sphere()) * inverse(place.transform);
    if (from_here == to_unit_sphere(sphere_)) return {};  // exactly; the product below is not
    return from_here * from_unit_sphere(sphere_);
}

}  // namespace bob
