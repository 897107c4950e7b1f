#include "tracing/scene.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_set>
#include <utility>

#include "base/parallel.h"
#include "base/thread_memory.h"
#include "shapes/mesh/texture.h"
#include "tracing/place_key.h"

namespace bob {
namespace {

// More than rounding can move a hit past the face of its instance's box. Origins and boxes are about 1 in size.
constexpr float box_margin = 1e-5f;

// A round has enough rays to make this number of entrances, or slightly more. Memory stays bounded where thousands of
// boxes overlap. Four times the number is no faster.
constexpr std::size_t entrances_at_once = 1 << 16;

/// The rays that enter an instance's box.
struct Group {
    std::uint32_t instance;
    float nearest;             // their minimum t
    std::size_t begin, count;  // range in the entrances
};

/// The memory for a batch of rays. Each thread keeps one between calls.
struct Batch {
    std::vector<Entrance> entrances, grouped;
    std::vector<Group> groups;
    std::vector<std::size_t> slots;  // per instance; all 0 except while grouping

    // The rays to test against one shape, later the rays that hit it.
    std::vector<float> start;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<Vec3> vectors;

    static Batch& of_this_thread(std::size_t most_rays, std::size_t instances, std::size_t most_entrances) {
        Batch& batch = thread_memory<Batch>();
        if (batch.rays.size() < most_rays) {
            batch.start.resize(most_rays), batch.rays.resize(most_rays);
            batch.hits.resize(most_rays), batch.vectors.resize(most_rays);
        }
        if (batch.slots.size() < instances) batch.slots.resize(instances);
        if (batch.entrances.size() < most_entrances) {
            batch.entrances.resize(most_entrances), batch.grouped.resize(most_entrances);
        }
        return batch;
    }

    /// Groups the first `count` entrances by instance, nearest groups first, and keeps the order of rays in each group.
    /// Instances that no ray enters cost nothing. `is_one`: all belong to one instance.
    void group(std::size_t count, bool is_one) {
        groups.clear();
        if (is_one && count) {
            grouped.swap(entrances);
            groups.push_back({grouped[0].box, 0, 0, count});
            return;
        }
        groups.reserve(std::min(count, slots.size()));
        for (std::size_t i = 0; i < count; ++i) {
            const Entrance& entrance = entrances[i];
            std::size_t& slot = slots[entrance.box];
            if (slot == 0) {
                groups.push_back({entrance.box, entrance.t, 0, 0});
                slot = groups.size();
            }
            Group& group = groups[slot - 1];
            group.nearest = std::min(group.nearest, entrance.t);
            ++group.count;
        }
        std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
            return a.nearest != b.nearest ? a.nearest < b.nearest : a.instance < b.instance;
        });
        std::size_t sum = 0;
        for (Group& group : groups) {
            slots[group.instance] = group.begin = sum;
            sum += group.count;
        }
        for (std::size_t i = 0; i < count; ++i) grouped[slots[entrances[i].box]++] = entrances[i];
        for (const Group& group : groups) slots[group.instance] = 0;
    }
};

/// Whether rays stay finite under a map; if not, the shape is too small to be visible.
bool fits_float(const AffineMap& map) {
    bool fits = true;
    for (const auto& row : map.row) {
        for (const double x : row) fits = fits && std::fabs(x) < 1e30;
    }
    return fits;
}

/// Whether a map makes a box, given by its squared diagonal, many times as long as the shape's sphere. For shapes
/// placed without much stretching this ratio is at most 6.
bool is_flattened(const AffineMap& map, float squared_diagonal) {
    constexpr double many = 32;
    double squares = 0;
    for (const auto& r : map.row) squares += r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    return squares * double{squared_diagonal} > many * many;
}

/// A t slightly before the ray enters the sphere that `map` takes to the unit sphere; at least 0.
float before_unit_sphere(const AffineMap& map, const Ray& ray) {
    double squared = 0, along = 0;
    for (const auto& r : map.row) {
        const double origin = r[0] * ray.origin.x + r[1] * ray.origin.y + r[2] * ray.origin.z + r[3];
        const double direction = r[0] * ray.direction.x + r[1] * ray.direction.y + r[2] * ray.direction.z;
        squared += direction * direction, along -= origin * direction;
    }
    const double nearest = along / squared;
    constexpr double rounding = 0x1p-23;
    return static_cast<float>(std::max(0., nearest - 2 / std::sqrt(squared) - rounding * nearest));
}

bool stands_as_it_is(const Instance& instance) { return instance.to_shape == AffineMap{}; }

/// Transforms the rays of entrances to the shape's coordinates, each from its start in the batch on. Directions keep
/// the map's scale, so that t is the same in both.
void take_rays(const Instance& instance, bool moved, std::span<const Entrance> entrances, std::span<const Ray> rays, Batch& batch) {
    if (!moved) {
        for (std::size_t j = 0; j < entrances.size(); ++j) batch.rays[j] = rays[entrances[j].ray];
        return;
    }
    const auto rays_through = best_box_kernels().rays_through;
    const std::size_t whole = rays_through ? entrances.size() - entrances.size() % BoxKernels::together : 0;
    if (whole) rays_through(instance.to_shape, rays.data(), entrances.data(), batch.start.data(), whole, batch.rays.data());
    for (std::size_t j = whole; j < entrances.size(); ++j) {
        const auto& [origin, direction] = rays[entrances[j].ray];
        batch.rays[j] = {instance.to_shape.point(origin, static_cast<double>(batch.start[j]), direction), instance.to_shape.direction(direction)};
    }
}

/// Intersects a group's rays with its instance, except rays with a hit nearer than the box. The order of groups affects
/// the work, not the results.
void ask(const Instance& instance, const Group& group, Batch& batch, std::span<const Ray> rays,
         std::span<SceneHit> hits) {
    const bool moved = !stands_as_it_is(instance);
    const Vec3 diagonal = instance.high - instance.low;
    const float size = dot(diagonal, diagonal);
    const bool flat = moved && is_flattened(instance.to_shape, size);
    Entrance* const entrances = &batch.grouped[group.begin];
    std::size_t count = 0;
    for (std::size_t j = 0; j < group.count; ++j) {
        const Entrance entrance = entrances[j];
        if (entrance.t > hits[entrance.ray].t) continue;
        // Starts one box size before the box: shapes want origins within a few of their sizes.
        const Vec3 direction = rays[entrance.ray].direction;
        const float squared = dot(direction, direction);
        const bool is_far = moved && entrance.t * entrance.t * squared > size;
        entrances[count] = entrance;
        batch.start[count++] = flat     ? before_unit_sphere(instance.to_shape, rays[entrance.ray])
                               : is_far ? std::max(0.f, entrance.t - std::sqrt(size / squared))
                                        : 0;
    }
    if (count == 0) return;
    take_rays(instance, moved, {entrances, count}, rays, batch);
    instance.shape->closest_hits({batch.rays.data(), count}, {batch.hits.data(), count});
    for (std::size_t j = 0; j < count; ++j) {
        if (batch.hits[j].primitive == no_primitive) continue;
        // No nearer than its box, despite rounding: otherwise a hit might depend on the order of groups.
        const float t = std::max(entrances[j].t, batch.start[j] + batch.hits[j].t);
        SceneHit& hit = hits[entrances[j].ray];
        if (t < hit.t || (t == hit.t && group.instance < hit.instance)) {
            hit = {t, group.instance, batch.start[j], batch.hits[j]};
        }
    }
}

/// Calls `use` for each instance with hits; the batch holds its rays, in the shape's coordinates, and their hits.
template <class Use>
void for_each_group(std::span<const Instance> instances, std::span<const Ray> rays, std::span<const SceneHit> hits, Use use) {
    Batch& batch = Batch::of_this_thread(rays.size(), instances.size(), rays.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::uint32_t k = hits[i].instance;
        if (k != no_instance) batch.entrances[count++] = {k, static_cast<std::uint32_t>(i), 0};
    }
    batch.group(count, instances.size() == 1);
    for (const Group& group : batch.groups) {
        const Instance& instance = instances[group.instance];
        const std::span<const Entrance> entrances(&batch.grouped[group.begin], group.count);
        for (std::size_t j = 0; j < group.count; ++j) {
            const SceneHit& hit = hits[entrances[j].ray];
            batch.hits[j] = hit.in_shape, batch.start[j] = hit.start;
        }
        take_rays(instance, !stands_as_it_is(instance), entrances, rays, batch);
        use(instance, entrances, batch);
    }
}

}  // namespace

Scene::Scene(std::vector<Instance> instances) : instances_(std::move(instances)) {
    constexpr Vec3 margin{box_margin, box_margin, box_margin};
    std::vector<Box> boxes;
    std::vector<std::uint32_t> visible;
    std::unordered_set<PlaceKey, PlaceKey::Hash> places;
    for (std::uint32_t k = 0; k < instances_.size(); ++k) {
        Instance& instance = instances_[k];
        has_colored_shapes_ = has_colored_shapes_ || instance.shape->is_colored();
        if (!fits_float(instance.to_shape)) continue;
        instance.low = instance.low - margin, instance.high = instance.high + margin;
        // Of equal shapes in the same place, only the first is ever visible.
        if (!places.insert({instance.shape.get(), instance.to_shape}).second) continue;
        boxes.push_back({instance.low, instance.high});
        visible.push_back(k);
    }
    if (boxes.empty()) return;
    tree_ = build_box_bvh(boxes);
    for (BoxPacket& packet : tree_.packets) {
        for (std::uint32_t& box : packet.box) box = visible[box];
    }
}

void Scene::closest_hits(std::span<const Ray> rays, std::span<SceneHit> hits) const {
    if (instances_.size() == 1 && stands_as_it_is(instances_[0])) {  // most scenes; without this they take a tenth longer
        Batch& batch = Batch::of_this_thread(rays.size(), 0, 0);
        instances_[0].shape->closest_hits(rays, {batch.hits.data(), rays.size()});
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = batch.hits[i];
            hits[i] = {hit.t, hit.primitive == no_primitive ? no_instance : 0, 0, hit};
        }
        return;
    }
    std::fill(hits.begin(), hits.end(), SceneHit{});
    if (tree_.nodes.empty()) return;
    Batch& batch = Batch::of_this_thread(rays.size(), instances_.size(), entrances_at_once + tree_.boxes);
    for (std::size_t i = 0; i < rays.size();) {
        std::size_t count;
        i = best_box_kernels().entrances(tree_, rays.data(), i, rays.size(), entrances_at_once, batch.entrances.data(),
                                         count);
        batch.group(count, instances_.size() == 1);
        for (const Group& group : batch.groups) ask(instances_[group.instance], group, batch, rays, hits);
    }
}

void Scene::normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const {
    normals_and_colors(rays, hits, {}, normals, {});
}

void Scene::normals_and_colors(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<const float> widths,
                               std::span<Vec3> normals, std::span<Vec3> colors) const {
    std::fill(normals.begin(), normals.end(), Vec3{});
    std::fill(colors.begin(), colors.end(), Vec3{1, 1, 1});
    for_each_group(instances_, rays, hits, [&](const Instance& instance, std::span<const Entrance> hit_rays, Batch& batch) {
        const std::size_t count = hit_rays.size();
        const std::span<const Ray> met{batch.rays.data(), count};
        const std::span<const Hit> found{batch.hits.data(), count};
        const std::span<Vec3> vectors{batch.vectors.data(), count};
        instance.shape->normals(met, found, vectors);
        const bool moved = !stands_as_it_is(instance);
        for (std::size_t j = 0; j < count; ++j) {
            normals[hit_rays[j].ray] = moved ? instance.to_shape.normal_back(vectors[j]) : vectors[j];
        }
        if (colors.empty() || !instance.shape->is_colored()) return;
        for (std::size_t j = 0; j < count; ++j) batch.start[j] = widths[hit_rays[j].ray];
        instance.shape->colors(met, found, {batch.start.data(), count}, vectors);
        for (std::size_t j = 0; j < count; ++j) colors[hit_rays[j].ray] = vectors[j];
    });
}

void Scene::face_normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const {
    std::fill(normals.begin(), normals.end(), Vec3{});
    for_each_group(instances_, rays, hits, [&](const Instance& instance, std::span<const Entrance> hit_rays, Batch& batch) {
        const std::size_t count = hit_rays.size();
        const std::span<Vec3> vectors{batch.vectors.data(), count};
        instance.shape->face_normals({batch.rays.data(), count}, {batch.hits.data(), count}, vectors);
        const bool moved = !stands_as_it_is(instance);
        for (std::size_t j = 0; j < count; ++j) normals[hit_rays[j].ray] = moved ? instance.to_shape.normal_back(vectors[j]) : vectors[j];
    });
}

bool Scene::is_colored() const {
    return has_colored_shapes_ || std::ranges::any_of(instances_, [](const Instance& i) { return !i.material.is_white(); });
}

std::size_t Scene::bytes() const {
    std::set<const void*> counted;
    std::size_t sum = 0;
    for (const Instance& instance : instances_) {
        if (!counted.insert(instance.shape.get()).second) continue;
        sum += instance.shape->bytes();
        if (const Picture* const picture = instance.shape->picture(); picture && counted.insert(picture).second) sum += picture->bytes();
    }
    return sum;
}

std::size_t batch_size(std::size_t count) {
    const auto threads = static_cast<std::size_t>(thread_count());
    const std::size_t batches = threads == 1 ? 1 : 4 * threads;
    return std::clamp<std::size_t>(count / batches, 512, 8192);
}

}  // namespace bob
