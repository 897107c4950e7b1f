#include "tracing/scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
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
struct RayBatch {
    std::vector<Entrance> entrances, grouped;
    std::vector<Group> groups;
    std::vector<std::size_t> slots;  // per instance; all 0 except while grouping

    // The rays to test against one shape, later the rays that hit it.
    std::vector<float> start;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<Vec3> vectors;

    static RayBatch& of_this_thread(std::size_t most_rays, std::size_t instances, std::size_t most_entrances) {
        RayBatch& batch = thread_memory<RayBatch>();
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
void take_rays(const Instance& instance, bool moved, std::span<const Entrance> entrances, std::span<const Ray> rays, RayBatch& batch) {
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
/// the work, not the results. Afterwards the batch holds the rays that it intersected, and their number is returned.
std::size_t ask(const Instance& instance, const Group& group, RayBatch& batch, std::span<const Ray> rays,
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
    if (count == 0) return 0;
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
    return count;
}

/// The normals of caps, and zeros elsewhere.
void fill_normals(std::span<const SectionPlane> planes, std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) {
    std::fill(normals.begin(), normals.end(), Vec3{});
    if (planes.empty()) return;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (hits[i].instance == no_instance || !is_cap(hits[i].in_shape.primitive)) continue;
        const auto& n = planes[hits[i].in_shape.primitive - first_cap].normal;
        const Vec3 normal{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
        normals[i] = dot(normal, rays[i].direction) > 0 ? -normal : normal;
    }
}

/// Calls `use` for each instance with hits; the batch holds its rays, in the shape's coordinates, and their hits.
template <class Use>
void for_each_group(std::span<const Instance> instances, bool has_sections, std::span<const Ray> rays, std::span<const SceneHit> hits, Use use) {
    RayBatch& batch = RayBatch::of_this_thread(rays.size(), instances.size(), rays.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::uint32_t k = hits[i].instance;
        if (k != no_instance && !is_cap(hits[i].in_shape.primitive)) batch.entrances[count++] = {k, static_cast<std::uint32_t>(i), 0};
    }
    batch.group(count, instances.size() == 1);
    for (const Group& group : batch.groups) {
        const Instance& instance = instances[group.instance];
        const std::span<const Entrance> entrances(&batch.grouped[group.begin], group.count);
        for (std::size_t j = 0; j < group.count; ++j) {
            const SceneHit& hit = hits[entrances[j].ray];
            batch.hits[j] = hit.in_shape, batch.start[j] = hit.start;
        }
        take_rays(instance, has_sections || !stands_as_it_is(instance), entrances, rays, batch);
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
        lowest_ = std::min(lowest_, instance.low.z);
        if (!fits_float(instance.to_shape)) continue;
        instance.low = instance.low - margin, instance.high = instance.high + margin;
        // If equal shapes coincide, only the first is ever visible.
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
    if (!planes_.empty()) return hits_in_sections(rays, hits);
    if (instances_.size() == 1 && stands_as_it_is(instances_[0])) {  // most scenes; without this they take a tenth longer
        RayBatch& batch = RayBatch::of_this_thread(rays.size(), 0, 0);
        instances_[0].shape->closest_hits(rays, {batch.hits.data(), rays.size()});
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = batch.hits[i];
            hits[i] = {hit.t, hit.primitive == no_primitive ? no_instance : 0, 0, hit};
        }
        return;
    }
    std::fill(hits.begin(), hits.end(), SceneHit{});
    hits_before(rays, hits, nullptr);
}

/// The kept parts of rays that have one, and the caps at their ends.
struct Scene::Caps {
    std::vector<KeptPart> parts;
    std::vector<Ray> rays;                // from the start of the kept part on
    std::vector<std::uint32_t> numbers;   // of the rays in the call
    std::vector<SceneHit> hits;
    std::vector<std::uint32_t> instance;  // whose cap is visible, if any
    std::vector<std::uint32_t> rank;      // of that instance

    // Rays of one instance that start inside its box.
    std::vector<Ray> entering;
    std::vector<Hit> met;
    std::vector<std::uint32_t> of;
    std::vector<std::uint8_t> inside;

    /// A ray that starts inside a solid has its cap there, or, if it starts in the kept part, where it leaves this before
    /// the solid.
    void find(std::uint32_t rank_of, std::uint32_t number, const Shape& shape, std::span<const Entrance> entrances, std::span<const float> start,
              std::span<const Ray> asked, std::span<const Hit> found) {
        entering.clear(), met.clear(), of.clear();
        for (std::size_t j = 0; j < entrances.size(); ++j) {
            const std::uint32_t i = entrances[j].ray;
            const KeptPart& part = parts[i];
            if (entrances[j].t > 0 || found[j].primitive == no_primitive || rank_of >= rank[i]) continue;
            const bool is_beyond = part.start + double{start[j]} + double{found[j].t} > part.end;
            if (part.entered == no_primitive && !(is_beyond && part.left != no_primitive)) continue;
            entering.push_back(asked[j]), met.push_back(found[j]), of.push_back(i);
        }
        if (entering.empty()) return;
        inside.assign(entering.size(), 0);
        shape.starts_inside(entering, met, inside);
        for (std::size_t j = 0; j < of.size(); ++j) {
            if (inside[j]) instance[of[j]] = number, rank[of[j]] = rank_of;
        }
    }
};

void Scene::hits_before(std::span<const Ray> rays, std::span<SceneHit> hits, Caps* caps) const {
    if (tree_.nodes.empty()) return;
    RayBatch& batch = RayBatch::of_this_thread(rays.size(), instances_.size(), entrances_at_once + tree_.boxes);
    for (std::size_t i = 0; i < rays.size();) {
        std::size_t count;
        i = best_box_kernels().entrances(tree_, rays.data(), i, rays.size(), entrances_at_once, batch.entrances.data(),
                                         count);
        batch.group(count, instances_.size() == 1);
        for (const Group& group : batch.groups) {
            const std::size_t asked = ask(instances_[group.instance], group, batch, rays, hits);
            if (!caps || !asked || !is_solid_[group.instance]) continue;
            const std::span<const Entrance> entrances(&batch.grouped[group.begin], asked);
            caps->find(ranks_[group.instance], group.instance, *instances_[group.instance].shape, entrances, batch.start, batch.rays, batch.hits);
        }
    }
}

void Scene::hits_in_sections(std::span<const Ray> rays, std::span<SceneHit> hits) const {
    auto& caps = thread_memory<Caps>();
    caps.parts.clear(), caps.rays.clear(), caps.numbers.clear(), caps.hits.clear();
    const AffineMap identity;
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        const KeptPart part(planes_, rays[i]);
        hits[i] = {};
        if (part.is_empty()) continue;
        const float start = static_cast<float>(part.start);
        caps.parts.push_back(part), caps.numbers.push_back(i);
        caps.rays.push_back({identity.point(rays[i].origin, double{start}, rays[i].direction), rays[i].direction});
        caps.hits.push_back({static_cast<float>(part.end - part.start), no_instance, 0, {}});
    }
    caps.instance.assign(caps.rays.size(), no_instance), caps.rank.assign(caps.rays.size(), no_instance);
    hits_before(caps.rays, caps.hits, &caps);
    for (std::size_t j = 0; j < caps.rays.size(); ++j) {
        const KeptPart& part = caps.parts[j];
        SceneHit hit = caps.hits[j];
        const bool enters = part.entered != no_primitive, ends = hit.instance == no_instance;
        if (caps.instance[j] != no_instance && (enters || ends)) {
            const auto t = static_cast<float>(enters ? part.enter : part.leave);
            hits[caps.numbers[j]] = {t, caps.instance[j], 0, {t, 0, 0, first_cap + (enters ? part.entered : part.left)}};
        } else if (!ends) {
            const auto start = static_cast<float>(part.start);
            hit.t += start, hit.start += start;
            hits[caps.numbers[j]] = hit;
        }
    }
}

Scene Scene::sectioned(std::span<const SectionPlane> planes) const {
    Scene scene = *this;
    scene.planes_.assign(planes.begin(), planes.end());
    scene.ranks_.clear(), scene.is_solid_.clear();
    if (planes.empty()) return scene;
    std::map<const Shape*, bool> solid;
    for (const Instance& instance : instances_) {
        const auto [entry, added] = solid.try_emplace(instance.shape.get(), false);
        if (added) entry->second = instance.shape->prepare_inside();
        scene.is_solid_.push_back(entry->second);
    }
    std::vector<std::uint64_t> order;  // the volume's bits, whose order is that of numbers from 0 on, and the instance
    for (std::uint32_t k = 0; k < instances_.size(); ++k) {
        const Vec3 size = instances_[k].high - instances_[k].low;
        order.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(std::max(0.f, size.x * size.y * size.z))} << 32 | k);
    }
    std::sort(order.begin(), order.end());
    scene.ranks_.resize(order.size());
    for (std::uint32_t rank = 0; rank < order.size(); ++rank) scene.ranks_[static_cast<std::uint32_t>(order[rank])] = rank;
    return scene;
}

std::vector<std::uint32_t> Scene::open_instances() const {
    std::vector<std::uint32_t> open;
    for (std::uint32_t k = 0; k < is_solid_.size(); ++k) {
        if (!is_solid_[k]) open.push_back(k);
    }
    return open;
}

void Scene::color_caps(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<const float> widths, std::span<Vec3> colors) const {
    std::vector<PlaneAxes> axes;
    for (const SectionPlane& plane : planes_) axes.emplace_back(plane.normal);
    std::map<std::uint32_t, std::vector<std::uint32_t>> of_colored;  // instances
    for (std::uint32_t i = 0; i < hits.size(); ++i) {
        const auto& [t, instance, start, hit] = hits[i];
        if (instance != no_instance && is_cap(hit.primitive) && instances_[instance].shape->is_colored()) of_colored[instance].push_back(i);
    }
    std::vector<Vec3> points, of_shape;
    for (const auto& [instance, numbers] : of_colored) {
        points.clear(), of_shape.resize(numbers.size());
        for (const std::uint32_t i : numbers) points.push_back(instances_[instance].to_shape.point(rays[i].origin, double{hits[i].t}, rays[i].direction));
        instances_[instance].shape->colors_inside(points, of_shape);
        for (std::size_t j = 0; j < numbers.size(); ++j) colors[numbers[j]] = of_shape[j];
    }
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const auto& [t, instance, start, hit] = hits[i];
        if (instance == no_instance || !is_cap(hit.primitive)) continue;
        const std::size_t plane = hit.primitive - first_cap;
        const Vec3 direction = rays[i].direction;
        const auto& normal = planes_[plane].normal;
        const Vec3 facing{static_cast<float>(normal[0]), static_cast<float>(normal[1]), static_cast<float>(normal[2])};
        const float size = length(direction), slant = std::max(0.05f, std::fabs(dot(facing, direction)) / size);
        colors[i] = hatched(axes[plane], rays[i].origin + t * direction, widths[i] * size / slant, instance) * colors[i];
    }
}

void Scene::normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const {
    normals_and_colors(rays, hits, {}, normals, {});
}

void Scene::normals_and_colors(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<const float> widths,
                               std::span<Vec3> normals, std::span<Vec3> colors) const {
    fill_normals(planes_, rays, hits, normals);
    std::fill(colors.begin(), colors.end(), Vec3{1, 1, 1});
    if (!planes_.empty() && !colors.empty()) color_caps(rays, hits, widths, colors);
    for_each_group(instances_, !planes_.empty(), rays, hits, [&](const Instance& instance, std::span<const Entrance> hit_rays, RayBatch& batch) {
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
    fill_normals(planes_, rays, hits, normals);
    for_each_group(instances_, !planes_.empty(), rays, hits, [&](const Instance& instance, std::span<const Entrance> hit_rays, RayBatch& batch) {
        const std::size_t count = hit_rays.size();
        const std::span<Vec3> vectors{batch.vectors.data(), count};
        instance.shape->face_normals({batch.rays.data(), count}, {batch.hits.data(), count}, vectors);
        const bool moved = !stands_as_it_is(instance);
        for (std::size_t j = 0; j < count; ++j) normals[hit_rays[j].ray] = moved ? instance.to_shape.normal_back(vectors[j]) : vectors[j];
    });
}

bool Scene::is_colored() const {
    return has_colored_shapes() || std::ranges::any_of(instances_, [](const Instance& i) { return !i.material.is_white(); });
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
