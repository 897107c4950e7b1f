/// Scenes, and what tracing these gives.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <vector>

#include "bindings.h"
#include "parallel.h"
#include "tracing/scene.h"
#include "tracing/trace.h"

using namespace nb::literals;

namespace {

void init_scene(bob::Scene* self, const std::vector<std::shared_ptr<bob::Shape>>& shapes,
                const Array<const double, -1, 3, 4>& to_shape, const Array<const float, -1, 2, 3>& boxes,
                const Array<const float, -1, 7>& materials) {
    const std::size_t count = shapes.size();
    expect(to_shape.shape(0) == count && boxes.shape(0) == count && materials.shape(0) == count,
           "scene: expected arrays of one length");
    std::vector<bob::Instance> instances;
    for (std::size_t i = 0; i < count; ++i) {
        const float* m = materials.data() + 7 * i;
        instances.push_back({shapes[i], items<bob::AffineMap>(to_shape)[i], items<bob::Vec3[2]>(boxes)[i][0],
                             items<bob::Vec3[2]>(boxes)[i][1], {{m[0], m[1], m[2]}, m[3], m[4], m[5], m[6]}});
    }
    new (self) bob::Scene(std::move(instances));
}

void closest_hits(const bob::Scene& scene, const Points& origins, const Points& directions,
                  const Array<float, -1>& t, const Array<std::int32_t, -1>& instance,
                  const Array<std::int32_t, -1>& primitive, const Array<double, -1>& u, const Array<double, -1>& v) {
    const std::size_t count = origins.shape(0);
    expect(directions.shape(0) == count && t.shape(0) == count && instance.shape(0) == count &&
               primitive.shape(0) == count && u.shape(0) == count && v.shape(0) == count,
           "closest_hits: expected arrays of one length");
    const auto origin = items<bob::Vec3>(origins), direction = items<bob::Vec3>(directions);
    interruptible([&](const auto& keep_going) {
        bob::parallel_for(count, bob::batch_size(count), [&](std::size_t begin, std::size_t end) {
            thread_local std::vector<bob::Ray> rays;  // kept from call to call
            thread_local std::vector<bob::SceneHit> hits;
            rays.resize(end - begin), hits.resize(end - begin);
            for (std::size_t i = begin; i < end; ++i) rays[i - begin] = {origin[i], direction[i]};
            scene.closest_hits(rays, hits);
            for (std::size_t i = begin; i < end; ++i) {
                const bob::SceneHit& hit = hits[i - begin];
                t.data()[i] = hit.t;
                instance.data()[i] = static_cast<std::int32_t>(hit.instance);
                const bob::Place place = hit.instance == bob::no_instance
                                             ? bob::Place{bob::no_primitive, 0, 0}
                                             : scene[hit.instance].shape->place(hit.in_shape);
                primitive.data()[i] = static_cast<std::int32_t>(place.part);
                u.data()[i] = place.u;
                v.data()[i] = place.v;
            }
        }, keep_going);
    });
}

void trace(const bob::Scene& scene, const bob::Camera& camera, int height, int width, const Pixels& pixels,
           const bob::Layout& layout, const Samples& samples) {
    check_pixels(pixels, height, width);
    check_width(layout, pixels.shape(0), samples);
    interruptible([&](const auto& keep_going) {
        bob::trace(scene, camera, height, width, items<bob::Pixel>(pixels), layout, samples.data(), keep_going);
    });
}

}  // namespace

void bind_scene(nb::module_& m) {
    nb::class_<bob::Scene>(m, "Scene")
        .def("__init__", &init_scene, "shapes"_a, "to_shape"_a.noconvert(), "boxes"_a.noconvert(),
             "materials"_a.noconvert())
        .def("closest_hits", &closest_hits, "origins"_a.noconvert(), "directions"_a.noconvert(), "t"_a.noconvert(),
             "instance"_a.noconvert(), "primitive"_a.noconvert(), "u"_a.noconvert(), "v"_a.noconvert())
        .def("trace", &trace, "camera"_a, "height"_a, "width"_a, "pixels"_a.noconvert(), "layout"_a,
             "samples"_a.noconvert())
        .def_prop_ro("bytes", &bob::Scene::bytes);
}
