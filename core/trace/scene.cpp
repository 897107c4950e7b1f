#include "trace/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "parallel.h"

namespace bob {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// More than rounding can move a hit across the face of its instance's box: origins and boxes are about 1 in size.
constexpr float box_margin = 1e-5f;

/// The rays that one shape is asked for. Each thread keeps one from call to call.
struct Batch {
    std::vector<std::size_t> index;  // among all rays
    std::vector<float> start;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<Vec3> normals;

    static Batch& of_this_thread(std::size_t most_rays) {
        thread_local Batch batch;
        if (batch.index.size() < most_rays) {
            batch.index.resize(most_rays), batch.start.resize(most_rays), batch.rays.resize(most_rays);
            batch.hits.resize(most_rays), batch.normals.resize(most_rays);
        }
        return batch;
    }
};

/// The t at which a ray enters the instance's box, 0 from within; infinite where it misses.
float enter_box(const Instance& instance, const Ray& ray) {
    float enter = 0, leave = infinity;
    for (int axis = 0; axis < 3; ++axis) {
        constexpr float tiny = 1e-18f;  // instead of 0, whose reciprocal times 0 is NaN
        const float d = ray.direction[axis];
        const float reciprocal = 1 / (std::fabs(d) > tiny ? d : tiny);
        const float a = (instance.low[axis] - ray.origin[axis]) * reciprocal;
        const float b = (instance.high[axis] - ray.origin[axis]) * reciprocal;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave ? enter : infinity;
}

/// The t to start a ray at that enters the instance's box at `enter`: a box' size before it, since shapes want origins
/// that are not many of their sizes away.
float start_before(const Instance& instance, const Ray& ray, float enter) {
    return std::max(0.f, enter - length(instance.high - instance.low) / length(ray.direction));
}

/// The ray in the shape's coordinates from t = start on. Its direction keeps the map's scale, so that t counts alike.
Ray in_shape(const AffineMap& to_shape, const Ray& ray, float start) {
    return {to_shape.point(ray.origin, start, ray.direction), to_shape.direction(ray.direction)};
}

/// Whether rays stay finite under a map. Where they don't, the shape is too small to be seen.
bool fits_float(const AffineMap& map) {
    bool fits = true;
    for (const auto& row : map.row) {
        for (const double x : row) fits = fits && std::fabs(x) < 1e30;
    }
    return fits;
}

bool stands_as_it_is(const Instance& instance) { return instance.to_shape == AffineMap{}; }

}  // namespace

Scene::Scene(std::vector<Instance> instances) : instances_(std::move(instances)) {
    constexpr Vec3 margin{box_margin, box_margin, box_margin};
    constexpr Vec3 nowhere{infinity, infinity, infinity};
    for (Instance& instance : instances_) {
        const bool fits = fits_float(instance.to_shape);
        instance.low = fits ? instance.low - margin : nowhere;
        instance.high = fits ? instance.high + margin : -nowhere;
    }
}

void Scene::closest_hits(std::span<const Ray> rays, std::span<SceneHit> hits) const {
    Batch& batch = Batch::of_this_thread(rays.size());
    if (instances_.size() == 1 && stands_as_it_is(instances_[0])) {  // most scenes; the long way costs them a tenth
        instances_[0].shape->closest_hits(rays, {batch.hits.data(), rays.size()});
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = batch.hits[i];
            hits[i] = {hit.t, hit.primitive == no_primitive ? no_instance : 0, 0, hit};
        }
        return;
    }
    std::fill(hits.begin(), hits.end(), SceneHit{});
    for (std::uint32_t k = 0; k < instances_.size(); ++k) {
        const Instance& instance = instances_[k];
        const bool moved = !stands_as_it_is(instance);
        std::size_t count = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const float enter = enter_box(instance, rays[i]);
            if (!(enter < hits[i].t)) continue;
            const float start = moved ? start_before(instance, rays[i], enter) : 0;
            batch.index[count] = i;
            batch.start[count] = start;
            batch.rays[count++] = moved ? in_shape(instance.to_shape, rays[i], start) : rays[i];
        }
        instance.shape->closest_hits({batch.rays.data(), count}, {batch.hits.data(), count});
        for (std::size_t j = 0; j < count; ++j) {
            SceneHit& hit = hits[batch.index[j]];
            const float t = batch.start[j] + batch.hits[j].t;
            if (t < hit.t) hit = {t, k, batch.start[j], batch.hits[j]};
        }
    }
}

void Scene::normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const {
    Batch& batch = Batch::of_this_thread(rays.size());
    std::fill(normals.begin(), normals.end(), Vec3{});
    for (std::uint32_t k = 0; k < instances_.size(); ++k) {
        const Instance& instance = instances_[k];
        const bool moved = !stands_as_it_is(instance);
        std::size_t count = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (hits[i].instance != k) continue;
            batch.index[count] = i;
            batch.hits[count] = hits[i].in_shape;
            batch.rays[count++] = moved ? in_shape(instance.to_shape, rays[i], hits[i].start) : rays[i];
        }
        instance.shape->normals({batch.rays.data(), count}, {batch.hits.data(), count}, {batch.normals.data(), count});
        for (std::size_t j = 0; j < count; ++j) {
            const Vec3 normal = batch.normals[j];
            normals[batch.index[j]] = moved ? instance.to_shape.normal_back(normal) : normal;
        }
    }
}

std::size_t Scene::bytes() const {
    std::set<const Shape*> shapes;
    std::size_t sum = 0;
    for (const Instance& instance : instances_) {
        if (shapes.insert(instance.shape.get()).second) sum += instance.shape->bytes();
    }
    return sum;
}

std::size_t batch_size(std::size_t count) {
    constexpr std::size_t batches_per_thread = 4;
    return std::clamp<std::size_t>(count / (batches_per_thread * static_cast<std::size_t>(thread_count())), 512, 8192);
}

}  // namespace bob
