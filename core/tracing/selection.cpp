#include "tracing/selection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/vec3d.h"
#include "shapes/mesh/mesh.h"
#include "shapes/mesh/normals.h"
#include "shapes/mesh/owned_arrays.h"

namespace bob {
namespace {

using Range = std::pair<std::uint32_t, std::uint32_t>;

/// The ranges of each instance.
std::vector<std::vector<Range>> by_instance(const Scene& scene, std::span<const Primitives> primitives) {
    std::vector<std::vector<Range>> ranges(scene.size());
    for (const auto& [instance, begin, end] : primitives) {
        if (instance < scene.size() && begin < end) ranges[instance].emplace_back(begin, end);
    }
    return ranges;
}

/// A shape without its colours. Holes stay.
class Plain : public Shape {
public:
    explicit Plain(std::shared_ptr<const Shape> shape) : Shape(shape->sphere()), shape_(std::move(shape)) {}

    [[nodiscard]] Bounds bounds(const AffineMap& map) const override { return shape_->bounds(map); }
    [[nodiscard]] double radius(const AffineMap& map, const double center[3]) const override { return shape_->radius(map, center); }
    [[nodiscard]] double overshoot() const override { return shape_->overshoot(); }
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override { shape_->closest_hits(rays, hits); }
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override { shape_->normals(rays, hits, normals); }
    void face_normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override {
        shape_->face_normals(rays, hits, normals);
    }
    [[nodiscard]] float hit_error() const override { return shape_->hit_error(); }
    [[nodiscard]] bool prepare_inside() const override { return shape_->prepare_inside(); }
    void starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const override {
        shape_->starts_inside(rays, hits, inside);
    }
    [[nodiscard]] Place place(const Hit& hit) const override { return shape_->place(hit); }
    [[nodiscard]] std::uint32_t face(const Hit& hit) const override { return shape_->face(hit); }
    [[nodiscard]] const Shape& surface() const override { return *shape_; }
    [[nodiscard]] std::size_t bytes() const override { return shape_->bytes(); }

private:
    std::shared_ptr<const Shape> shape_;
};

/// Some triangles of a mesh, in the coordinates of the whole.
class CutMesh : public Mesh {
public:
    CutMesh(const Arrays& arrays, const Sphere& sphere, std::vector<std::uint32_t> numbers) : Mesh(arrays, sphere), numbers_(std::move(numbers)) {}

    [[nodiscard]] Place place(const Hit& hit) const override { return {numbers_[hit.primitive], hit.u, hit.v}; }

private:
    std::vector<std::uint32_t> numbers_;  // of the triangles in the whole
};

/// Corners become vertices with the normals of the whole: shading smooths over neighbours that are cut off.
std::shared_ptr<const Mesh> cut(const Mesh& mesh, std::span<const CornerNormals> normals, std::vector<std::uint32_t> numbers) {
    const Mesh::Arrays& whole = mesh.arrays();
    auto own = std::make_shared<OwnedArrays>();
    for (const std::uint32_t number : numbers) {
        const auto first = static_cast<std::uint32_t>(own->vertices.size());
        own->triangles.push_back({first, first + 1, first + 2});
        own->normals.insert(own->normals.end(), normals[number].begin(), normals[number].end());
        if (!whole.face_colors.empty()) own->face_colors.push_back(whole.face_colors[number]);
        for (const std::uint32_t vertex : whole.triangles[number]) {
            own->vertices.push_back(whole.vertices[vertex]);
            if (!whole.colors.empty()) own->colors.push_back(whole.colors[vertex]);
            if (!whole.uv.empty()) own->uv.push_back(whole.uv[vertex]);
            if (!whole.alphas.empty()) own->alphas.push_back(whole.alphas[vertex]);
        }
    }
    own->texture = whole.texture, own->alpha_cutoff = whole.alpha_cutoff;
    auto made = std::make_shared<CutMesh>(OwnedArrays::of(own), mesh.sphere(), std::move(numbers));
    made->prepare();
    return made;
}

/// The map from a shape's own units to the coordinates of the scene.
AffineMap to_scene(const Instance& instance) { return inverse(instance.to_shape) * to_unit_sphere(instance.shape->sphere()); }

/// Rays along each side of a box.
constexpr std::size_t looked = 256;

/// Finer lattices around the nearest hit, each a quarter as wide as the last. With none, an octahedron is .8 % too small and a ball 1e-5;
/// with 8, both are within 2e-7.
constexpr int refinements = 8;
constexpr std::size_t refined = 16;

struct Sighting {
    float t = std::numeric_limits<float>::infinity();
    Vec3 origin;
};

/// The nearest hit of parallel rays from `count` places along an axis, in the middles of equal parts of a length from `low` on.
Sighting nearest_of(const Scene& scene, Ray ray, int axis, float low, float length, std::size_t count) {
    std::vector<Ray> rays(count);
    std::vector<SceneHit> hits(count);
    for (std::size_t i = 0; i < count; ++i) {
        ray.origin[axis] = low + length * ((static_cast<float>(i) + 0.5f) / static_cast<float>(count));
        rays[i] = ray;
    }
    scene.closest_hits(rays, hits);
    Sighting found;
    for (std::size_t i = 0; i < count; ++i) {
        if (hits[i].t < found.t) found = {hits[i].t, rays[i].origin};
    }
    return found;
}

/// The nearest hit of rays from a rectangle of `count` times `count` places, across two axes.
Sighting nearest_of(const Scene& scene, const Ray& ray, const std::array<int, 2>& axes, const Vec3& low, const Vec3& size, std::size_t count) {
    std::vector<Sighting> rows(count);
    parallel_for(count, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Ray row = ray;
            row.origin[axes[0]] = low[axes[0]] + size[axes[0]] * ((static_cast<float>(i) + 0.5f) / static_cast<float>(count));
            rows[i] = nearest_of(scene, row, axes[1], low[axes[1]], size[axes[1]], count);
        }
    });
    return *std::min_element(rows.begin(), rows.end(), [](const Sighting& a, const Sighting& b) { return a.t < b.t; });
}

enum class Look : std::uint8_t { own, hidden, highlighted };

}  // namespace

Box box_by_rays(const Scene& scene, const Box& around) {
    const Vec3 low = around.low, size = around.high - around.low;
    Box found = around;
    for (int axis = 0; axis < 3; ++axis) {
        const std::array<int, 2> across{(axis + 1) % 3, (axis + 2) % 3};
        for (const bool is_upper : {false, true}) {
            Ray ray{};
            ray.direction[axis] = is_upper ? -1.f : 1.f;
            const float start = (is_upper ? around.high : around.low)[axis] - 0.5f * ray.direction[axis];
            ray.origin[axis] = start;
            Sighting nearest = nearest_of(scene, ray, across, low, size, looked);
            if (!(nearest.t < std::numeric_limits<float>::infinity())) continue;
            Vec3 window = (2.f / looked) * size;
            for (int i = 0; i < refinements; ++i, window = 0.25f * window) {
                const Sighting closer = nearest_of(scene, ray, across, nearest.origin - 0.5f * window, window, refined);
                if (closer.t < nearest.t) nearest = closer;
            }
            (is_upper ? found.high : found.low)[axis] = start + ray.direction[axis] * nearest.t;
        }
    }
    return found;
}

Scene selected(const Scene& scene, std::span<const Primitives> hidden, std::span<const Primitives> highlighted, const Vec3& color) {
    const auto hidden_of = by_instance(scene, hidden), highlighted_of = by_instance(scene, highlighted);
    std::vector<Instance> instances;
    const auto add = [&](Instance instance, Look look) {
        if (look == Look::hidden) return;
        if (look == Look::highlighted) {
            for (int axis = 0; axis < 3; ++axis) instance.material.color[axis] = static_cast<double>(color[axis]);
            if (instance.shape->is_colored()) instance.shape = std::make_shared<Plain>(instance.shape);
        }
        instances.push_back(std::move(instance));
    };
    for (std::uint32_t k = 0; k < scene.size(); ++k) {
        const Instance& instance = scene[k];
        if (hidden_of[k].empty() && highlighted_of[k].empty()) {
            instances.push_back(instance);
            continue;
        }
        const auto* const mesh = dynamic_cast<const Mesh*>(instance.shape.get());
        const std::size_t count = mesh ? mesh->arrays().triangles.size() : 1;
        std::vector<Look> looks(count, Look::own);
        const auto mark = [&](std::span<const Range> ranges, Look look) {
            for (const auto& [begin, end] : ranges) {
                const std::size_t first = mesh ? std::min<std::size_t>(begin, count) : 0, last = mesh ? std::min<std::size_t>(end, count) : 1;
                std::fill(looks.begin() + static_cast<std::ptrdiff_t>(first), looks.begin() + static_cast<std::ptrdiff_t>(last), look);
            }
        };
        mark(highlighted_of[k], Look::highlighted), mark(hidden_of[k], Look::hidden);
        if (std::all_of(looks.begin(), looks.end(), [&](Look look) { return look == looks[0]; })) {
            add(instance, looks[0]);
            continue;
        }
        const std::vector<CornerNormals> normals = mesh->corner_normals();
        for (const Look look : {Look::own, Look::highlighted}) {
            std::vector<std::uint32_t> numbers;
            for (std::uint32_t i = 0; i < count; ++i) {
                if (looks[i] == look) numbers.push_back(i);
            }
            if (numbers.empty()) continue;
            Instance part = instance;
            part.shape = cut(*mesh, normals, std::move(numbers));
            const Bounds bounds = part.shape->bounds(to_scene(part));
            for (int axis = 0; axis < 3; ++axis) {
                part.low[axis] = static_cast<float>(bounds.low[axis]), part.high[axis] = static_cast<float>(bounds.high[axis]);
            }
            add(std::move(part), look);
        }
    }
    return Scene(std::move(instances));
}

Amount amount(const Scene& scene, std::span<const Primitives> primitives, const Sphere& sphere) {
    const AffineMap from_scene = from_unit_sphere(sphere);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Amount result{{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}}, 0., std::nullopt};
    std::vector<Vec3d> corners;  // three of each triangle
    std::vector<Vec3> places;    // the same in the unit sphere, to find equal ones
    const auto widen = [&](const double* low, const double* high) {
        for (int axis = 0; axis < 3; ++axis) {
            result.bounds.low[axis] = std::min(result.bounds.low[axis], low[axis]);
            result.bounds.high[axis] = std::max(result.bounds.high[axis], high[axis]);
        }
    };
    for (const auto& [number, begin, end] : primitives) {
        if (number >= scene.size()) continue;
        const Instance& instance = scene[number];
        const auto* const mesh = dynamic_cast<const Mesh*>(instance.shape.get());
        if (!mesh) {
            const Box box = box_by_rays(Scene({instance}), {instance.low, instance.high});
            double low[3], high[3];
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = sphere.center[axis] + sphere.radius * static_cast<double>(box.low[axis]);
                high[axis] = sphere.center[axis] + sphere.radius * static_cast<double>(box.high[axis]);
            }
            widen(low, high);
            result.area.reset();
            continue;
        }
        const AffineMap in_scene = to_scene(instance), map = from_scene * in_scene;
        const double (&r)[3][4] = map.row;
        const bool is_mirrored = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) - r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                                     r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]) < 0;
        const Mesh::Arrays& arrays = mesh->arrays();
        const std::size_t last = std::min<std::size_t>(end, arrays.triangles.size());
        for (std::size_t i = begin; i < last; ++i) {
            Triangle triangle = arrays.triangles[i];
            if (is_mirrored) std::swap(triangle[1], triangle[2]);
            for (const std::uint32_t vertex : triangle) {
                const auto& [x, y, z] = arrays.vertices[vertex];
                Vec3d point;
                Vec3 place;
                for (int axis = 0; axis < 3; ++axis) {
                    const auto at = static_cast<std::size_t>(axis);
                    point[at] = r[axis][0] * x + r[axis][1] * y + r[axis][2] * z + r[axis][3];
                    const auto& s = in_scene.row[axis];
                    place[axis] = static_cast<float>(s[0] * x + s[1] * y + s[2] * z + s[3]);
                }
                widen(point.data(), point.data());
                corners.push_back(point), places.push_back(place);
            }
        }
    }
    if (!result.area || corners.empty()) return result;
    const std::vector<std::uint32_t> same = merge_positions(places);
    std::vector<std::uint64_t> forth, back;  // edges, by their ends
    double volume = 0;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
        const Vec3d a = corners[i] - corners[0], b = corners[i + 1] - corners[0], c = corners[i + 2] - corners[0];
        *result.area += length(cross(b - a, c - a)) / 2, volume += dot(a, cross(b, c)) / 6;
        const std::array<std::uint64_t, 3> corner{same[i], same[i + 1], same[i + 2]};
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t from = corner[k], to = corner[(k + 1) % 3];
            forth.push_back(from << 32 | to), back.push_back(to << 32 | from);
        }
    }
    std::sort(forth.begin(), forth.end()), std::sort(back.begin(), back.end());
    if (forth == back) result.volume = std::fabs(volume);
    return result;
}

}  // namespace bob
