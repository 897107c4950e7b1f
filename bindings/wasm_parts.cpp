/// Sections and parts of scenes in the WebAssembly modules.
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "picture/camera.h"
#include "tracing/selection.h"
#include "wasm.h"

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::span<const bob::Primitives> primitives_of(const std::uint32_t* numbers, std::size_t count) {
    return {reinterpret_cast<const bob::Primitives*>(numbers), count};
}

}  // namespace

/// The scene without some primitives, and with others in a colour, linear RGB. Each is (count, 3): instance, begin, end.
EXPORT(select_scene)
bob::Scene* select_scene(const bob::Scene* scene, const std::uint32_t* hidden, std::size_t hidden_count, const std::uint32_t* highlighted,
                         std::size_t highlighted_count, const float* color) {
    return attempt([&] {
        const bob::Vec3 rgb{color[0], color[1], color[2]};
        return new bob::Scene(bob::selected(*scene, primitives_of(hidden, hidden_count), primitives_of(highlighted, highlighted_count), rgb));
    });
}

/// The scene cut open by planes, (count, 4): unit normals and offsets in the unit sphere.
EXPORT(section_scene) bob::Scene* section_scene(const bob::Scene* scene, const double* planes, std::size_t count) {
    return attempt([&] {
        expect(count <= bob::max_sections, "section: expected at most 6");
        std::array<bob::SectionPlane, bob::max_sections> all;
        for (std::size_t i = 0; i < count; ++i) all[i] = {{planes[4 * i], planes[4 * i + 1], planes[4 * i + 2]}, planes[4 * i + 3]};
        return new bob::Scene(scene->sectioned(std::span(all).first(count)));
    });
}

/// The user's number of the first instance that a section shows without caps, or -1.
EXPORT(first_open_instance) std::int32_t first_open_instance(const bob::Scene* scene) {
    const auto open = scene->open_instances();
    return open.empty() ? -1 : static_cast<std::int32_t>((*scene)[open[0]].number);
}

/// Writes the lowest and highest coordinates of all instances, in the unit sphere.
EXPORT(scene_box) void scene_box(const bob::Scene* scene, float* box) {
    bob::Box all;
    for (std::uint32_t k = 0; k < scene->size(); ++k) all.extend({(*scene)[k].low, (*scene)[k].high});
    for (int axis = 0; axis < 3; ++axis) box[axis] = all.low[axis], box[axis + 3] = all.high[axis];
}

/// Finds the first surface at a place of a picture. Writes 9 numbers: instance and primitive in the user's numbering, and the section of
/// a cap, or -1; the point in the unit sphere; the normal of the primitive.
EXPORT(pick)
void pick(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, float row, float column, double* found) {
    std::fill_n(found, 9, -1.);
    const bob::Projection projection(camera_of(camera), height, width);
    std::array<bob::Ray, 1> ray;
    std::array<bob::SceneHit, 1> hit;
    std::array<bob::Vec3, 1> normal;
    if (!projection.ray(row, column, ray[0])) return;
    scene->closest_hits(ray, hit);
    if (hit[0].instance == bob::no_instance) return;
    scene->face_normals(ray, hit, normal);
    const bob::Instance& instance = (*scene)[hit[0].instance];
    const bob::Hit& in_shape = hit[0].in_shape;
    const bool is_on_cap = bob::is_cap(in_shape.primitive);
    const bob::Vec3 point = ray[0].origin + hit[0].t * ray[0].direction;
    found[0] = instance.number;
    found[1] = is_on_cap ? 0 : instance.shape->place(in_shape).part;
    if (is_on_cap) found[2] = in_shape.primitive - bob::first_cap;
    for (int axis = 0; axis < 3; ++axis) {
        found[3 + axis] = static_cast<double>(point[axis]), found[6 + axis] = static_cast<double>(normal[0][axis]);
    }
}

/// Writes the box, area and volume of primitives, (count, 3), in the scene's units; the latter are NaN if unknown.
EXPORT(measure)
bool measure(const bob::Scene* scene, const std::uint32_t* primitives, std::size_t count, const bob::Sphere* sphere, double* measures) {
    return attempt([&] {
        const bob::Amount found = bob::amount(*scene, primitives_of(primitives, count), *sphere);
        std::copy_n(found.bounds.high, 3, std::copy_n(found.bounds.low, 3, measures));
        measures[6] = found.area.value_or(unknown), measures[7] = found.volume.value_or(unknown);
        return true;
    });
}
