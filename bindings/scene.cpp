/// Scenes: their contents, canonical order and tracing.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/counts.h"
#include "base/parallel.h"
#include "base/thread_memory.h"
#include "bindings.h"
#include "tracing/antialiasing.h"
#include "tracing/arrangement.h"
#include "tracing/canonical.h"
#include "tracing/picture_tracing.h"
#include "tracing/selection.h"
#include "tracing/snapping.h"
#include "tracing/trace.h"

using namespace nb::literals;

namespace {

nb::bytes bytes_of(const bob::Digest& digest) { return nb::bytes(reinterpret_cast<const char*>(digest.data()), digest.size()); }

bob::Digest digest_of(const nb::bytes& bytes) {
    bob::Digest digest;
    expect(bytes.size() == digest.size(), "digest: expected 32 bytes");
    std::copy_n(bytes.c_str(), digest.size(), reinterpret_cast<char*>(digest.data()));
    return digest;
}

nb::bytes shape_digest(std::string_view kind, const nb::typed<nb::dict, nb::str, nb::ndarray<nb::numpy>>& tensors) {
    bob::ShapeDigest digest(kind);
    for (const nb::handle item : nb::steal<nb::list>(nb::module_::import_("builtins").attr("sorted")(tensors.items()).release())) {
        const auto [name, array] = nb::cast<std::tuple<std::string, nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>>>(item);
        const auto code = static_cast<nb::dlpack::dtype_code>(array.dtype().code);
        const char letter = code == nb::dlpack::dtype_code::Float ? 'f' : code == nb::dlpack::dtype_code::Int ? 'i' : 'u';
        const std::string dtype = std::string(array.itemsize() > 1 ? "<" : "|") + letter + std::to_string(array.itemsize());
        std::vector<std::size_t> shape(array.ndim());
        for (std::size_t axis = 0; axis < shape.size(); ++axis) shape[axis] = array.shape(axis);
        const auto* bytes = static_cast<const std::byte*>(array.data());
        without_gil([&] { digest.add({name, dtype, std::move(shape), {bytes, array.nbytes()}}); });
    }
    return bytes_of(digest.digest());
}

nb::bytes instance_digest(const nb::bytes& shape, const Matrix& transform, const bob::Material& material) {
    return bytes_of(bob::instance_digest(digest_of(shape), bob::affine_map(transform.data()), material));
}

void init_arrangement(bob::Arrangement* self, const std::vector<std::shared_ptr<bob::Shape>>& shapes,
                      const Array<const double, -1, 4, 4>& transforms, const std::vector<bob::Material>& materials) {
    expect(transforms.shape(0) == shapes.size() && materials.size() == shapes.size(),
           "arrangement: expected a transform and a material for each shape");
    std::vector<bob::Placed> placed;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        placed.push_back({shapes[i], bob::affine_map(transforms.data() + 16 * i), materials[i]});
    }
    std::optional<bob::Arrangement> made;  // stored only once nothing can interrupt it
    interruptible([&] { made.emplace(std::move(placed)); });
    new (self) bob::Arrangement(std::move(*made));
}

bob::Scene scene(const bob::Arrangement& arrangement, const std::vector<nb::bytes>& digests) {
    std::vector<bob::Digest> converted;
    for (const nb::bytes& digest : digests) converted.push_back(digest_of(digest));
    expect(digests.empty() || digests.size() == arrangement.size(), "digests: expected one for each shape");
    std::optional<bob::Scene> made;
    interruptible([&] {
        bob::parallel_for(converted.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const bob::Placed& placed = arrangement[i];
                converted[i] = bob::instance_digest(converted[i], placed.transform, placed.material);
            }
        });
        made.emplace(arrangement.scene(converted));
    });
    return std::move(*made);
}

Array<double, 3> center(const bob::Arrangement& arrangement) {
    auto result = make_array<double, 3>(3);
    std::copy_n(arrangement.sphere().center, 3, result.data());
    return result;
}

Array<double, -1, 2, 3> boxes(const bob::Arrangement& arrangement) {
    auto result = make_array<double, -1, 2, 3>(arrangement.size(), 2, 3);
    for (std::size_t i = 0; i < arrangement.size(); ++i) {
        std::copy_n(arrangement.bounds(i).low, 3, result.data() + 6 * i);
        std::copy_n(arrangement.bounds(i).high, 3, result.data() + 6 * i + 3);
    }
    return result;
}

Array<double, -1, 3, 4> to_shapes(const bob::Scene& scene) {
    auto result = make_array<double, -1, 3, 4>(scene.size(), 3, 4);
    for (std::uint32_t i = 0; i < scene.size(); ++i) {
        std::copy_n(&scene[i].to_shape.row[0][0], 12, result.data() + 12 * scene[i].number);
    }
    return result;
}

void closest_hits(const bob::Scene& scene, const Points& origins, const Points& directions,
                  const Array<float, -1>& t, const Array<std::int32_t, -1>& instance,
                  const Array<std::int32_t, -1>& primitive, const Array<double, -1>& u, const Array<double, -1>& v) {
    const std::size_t count = origins.shape(0);
    expect(directions.shape(0) == count && t.shape(0) == count && instance.shape(0) == count &&
               primitive.shape(0) == count && u.shape(0) == count && v.shape(0) == count,
           "closest_hits: expected arrays of one length");
    const auto origin = items<bob::Vec3>(origins), direction = items<bob::Vec3>(directions);
    interruptible([&] {
        bob::parallel_for(count, bob::batch_size(count), [&](std::size_t begin, std::size_t end) {
            struct Memory {
                std::vector<bob::Ray> rays;
                std::vector<bob::SceneHit> hits;
            };
            auto& [rays, hits] = bob::thread_memory<Memory>();
            rays.resize(end - begin), hits.resize(end - begin);
            for (std::size_t i = begin; i < end; ++i) rays[i - begin] = {origin[i], direction[i]};
            scene.closest_hits(rays, hits);
            for (std::size_t i = begin; i < end; ++i) {
                const bob::SceneHit& hit = hits[i - begin];
                t.data()[i] = hit.t;
                const bool missed = hit.instance == bob::no_instance, on_cap = bob::is_cap(hit.in_shape.primitive);
                instance.data()[i] = missed ? -1 : static_cast<std::int32_t>(scene[hit.instance].number);
                const bob::Place place = missed || on_cap ? bob::Place{bob::no_primitive, 0, 0}
                                                          : scene[hit.instance].shape->place(hit.in_shape);
                primitive.data()[i] = on_cap ? -2 - static_cast<std::int32_t>(hit.in_shape.primitive - bob::first_cap)
                                             : static_cast<std::int32_t>(place.part);
                u.data()[i] = place.u;
                v.data()[i] = place.v;
            }
        });
    });
}

bob::Scene sectioned(const bob::Scene& scene, const Array<const double, -1, 4>& planes) {
    std::optional<bob::Scene> made;
    interruptible([&] { made.emplace(scene.sectioned(items<bob::SectionPlane>(planes))); });
    return std::move(*made);
}

Array<float, 2, 3> box_by_rays(const bob::Scene& scene, const Array<const float, 2, 3>& around) {
    const std::span<const bob::Vec3> corners = items<bob::Vec3>(around);
    bob::Box box{corners[0], corners[1]};
    interruptible([&] { box = bob::box_by_rays(scene, box); });
    auto found = make_array<float, 2, 3>(2, 3);
    std::ranges::copy(std::array{box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z}, found.data());
    return found;
}

std::vector<std::uint32_t> open_instances(const bob::Scene& scene) {
    std::vector<std::uint32_t> open;
    for (const std::uint32_t instance : scene.open_instances()) open.push_back(scene[instance].number);
    std::sort(open.begin(), open.end());
    return open;
}

void trace(const bob::Scene& scene, const bob::Camera& camera, int height, int width, const Pixels& pixels,
           const bob::Layout& layout, const Samples& samples) {
    check_pixels(pixels, height, width);
    check_width(layout, pixels.shape(0), samples);
    interruptible([&] {
        bob::trace(scene, camera, height, width, items<bob::Pixel>(pixels), layout, samples.data());
    });
}

auto trace_means(const bob::Scene& scene, const bob::Camera& camera, int height, int width, const Pixels& pixels, int side) {
    check_pixels(pixels, height, width);
    expect(side >= 1 && side <= std::numeric_limits<int>::max() / std::max(height, width), "side: expected rays that can be counted");
    auto means = make_array<float, -1, 5>(pixels.shape(0), 5);
    interruptible([&] { bob::trace_means(scene, camera, height, width, items<bob::Pixel>(pixels), side, means.data()); });
    return means;
}

auto pixels_at_edges(const Array<const float, -1, -1, 3>& color, const ConstPlane& alpha) {
    expect(color.shape(0) == alpha.shape(0) && color.shape(1) == alpha.shape(1), "alpha: expected color's size");
    const int height = static_cast<int>(alpha.shape(0)), width = static_cast<int>(alpha.shape(1));
    std::vector<bob::Pixel> found;
    const std::array light{bob::LightPlane{color.data(), 3}, bob::LightPlane{color.data() + 1, 3}, bob::LightPlane{color.data() + 2, 3}};
    interruptible([&] { found = bob::pixels_at_edges(light, alpha.data(), height, width, 0, height); });
    return pixel_array(found);
}

using Vector = std::array<double, 3>;

std::optional<std::tuple<std::string_view, Vector, std::optional<double>, Vector, Vector>> snap(const bob::Scene& scene, const bob::Camera& camera,
                                                                                               int height, int width, float row, float column, float reach) {
    std::optional<bob::Snap> found;
    interruptible([&] { found = bob::snap(scene, camera, height, width, row, column, reach); });
    bob::Ray ray;
    if (!found || !bob::Projection(camera, height, width).ray(found->row, found->column, ray)) return std::nullopt;
    const auto vector = [](bob::Vec3 v) { return Vector{double{v.x}, double{v.y}, double{v.z}}; };
    return std::tuple{bob::name_of(found->kind), found->point, found->radius, vector(ray.origin), vector(ray.direction)};
}

void init_picture_tracing(bob::PictureTracing* self, const bob::Scene& scene, const bob::Camera& camera, int height, int width,
                          const bob::Layout& layout, std::string_view order, std::uint64_t seed) {
    without_gil([&] { new (self) bob::PictureTracing(scene, camera, height, width, layout, order, seed); });
}

void trace_picture(bob::PictureTracing& tracing, std::size_t count, const Planes& planes) {
    const std::size_t height = planes.shape(1), width = planes.shape(2);
    expect(planes.shape(0) == static_cast<std::size_t>(tracing.layout().width()) && height == static_cast<std::size_t>(tracing.height()) &&
               width == static_cast<std::size_t>(tracing.width()),
           "planes: expected one for each component, of the right size");
    expect(count <= height * width, "count: expected at most all pixels");
    const InUse in_use(&tracing);
    interruptible([&] { tracing.trace(count, planes.data()); });
}

}  // namespace

void bind_scene(nb::module_& m) {
    m.attr("MAX_IOR") = bob::max_ior;
    nb::class_<bob::Material>(m, "Material", "`color` is linear RGB.")
        .def("__init__", [](bob::Material* self, const std::array<double, 3>& color, double ambient, double diffuse,
                            double specular, double shininess, double metallic, double roughness, const std::array<double, 3>& emissive,
                            double clearcoat, double clearcoat_roughness, double transmission, double ior,
                            const std::array<double, 3>& attenuation, double attenuation_distance, bool is_thin) {
            new (self) bob::Material{{color[0], color[1], color[2]}, ambient, diffuse, specular, shininess, metallic, roughness,
                                     {emissive[0], emissive[1], emissive[2]}, clearcoat, clearcoat_roughness, transmission, ior,
                                     {attenuation[0], attenuation[1], attenuation[2]}, attenuation_distance, is_thin};
        }, "color"_a, "ambient"_a, "diffuse"_a, "specular"_a, "shininess"_a, "metallic"_a, "roughness"_a, "emissive"_a,
             "clearcoat"_a = 0.0, "clearcoat_roughness"_a = 0.0, "transmission"_a = 0.0, "ior"_a = 1.5, "attenuation"_a = std::array{1.0, 1.0, 1.0},
             "attenuation_distance"_a = std::numeric_limits<double>::infinity(), "is_thin"_a = false)
        .def_prop_ro("color", [](const bob::Material& m) { return std::to_array(m.color); })
        .def_ro("ambient", &bob::Material::ambient)
        .def_ro("diffuse", &bob::Material::diffuse)
        .def_ro("specular", &bob::Material::specular)
        .def_ro("shininess", &bob::Material::shininess)
        .def_ro("metallic", &bob::Material::metallic)
        .def_ro("roughness", &bob::Material::roughness, "Below 0 of Blinn-Phong.")
        .def_prop_ro("emissive", [](const bob::Material& m) { return std::to_array(m.emissive); })
        .def_ro("clearcoat", &bob::Material::clearcoat)
        .def_ro("clearcoat_roughness", &bob::Material::clearcoat_roughness)
        .def_ro("transmission", &bob::Material::transmission)
        .def_ro("ior", &bob::Material::ior)
        .def_prop_ro("attenuation", [](const bob::Material& m) { return std::to_array(m.attenuation); })
        .def_ro("attenuation_distance", &bob::Material::attenuation_distance)
        .def_ro("is_thin", &bob::Material::is_thin);

    m.def("linear_color", &bob::linear_color, "text"_a, "Linear RGB of \"#rrggbb\", \"#rgb\" or a CSS color name; None of another text.");
    m.def("shape_digest", &shape_digest, "kind"_a, "tensors"_a, "SHA-256 of a shape's kind and tensors.");
    m.def("singular_values", [](const Matrix& map) { return bob::singular_values(bob::affine_map(map.data())); },
          "map"_a.noconvert(), "Of the linear part of a map, (4, 4): three, the largest first.");
    m.def("instance_digest", &instance_digest, "shape"_a, "transform"_a, "material"_a,
          "SHA-256 of a shape's digest, its transform (4, 4), and its material.");

    nb::class_<bob::Arrangement>(m, "Arrangement",
        "Shapes in their places: `transforms` (n, 4, 4) take their own units to those of all. ValueError if they are in one point, or "
        "beyond what float64 holds.")
        .def("__init__", &init_arrangement, "shapes"_a, "transforms"_a.noconvert(), "materials"_a)
        .def("scene", &scene, "digests"_a,
             "The scene in the unit sphere: in canonical order if there is a digest for each shape, else in the given order.")
        .def_prop_ro("boxes", &boxes, nb::rv_policy::move, "(n, 2, 3): the lowest and highest coordinates of each.")
        .def_prop_ro("center", &center, nb::rv_policy::move)
        .def_prop_ro("radius", [](const bob::Arrangement& arrangement) { return arrangement.sphere().radius; });

    m.attr("MAX_INSTANCES") = bob::max_instances;
    m.attr("MAX_SECTIONS") = bob::max_sections;
    nb::class_<bob::Scene>(m, "Scene",
        "Where instances coincide, the first is seen. Their numbers are those that they have in the arrangement.")
        .def("closest_hits", &closest_hits, "origins"_a.noconvert(), "directions"_a.noconvert(), "t"_a.noconvert(),
             "instance"_a.noconvert(), "primitive"_a.noconvert(), "u"_a.noconvert(), "v"_a.noconvert())
        .def("trace", &trace, "camera"_a, "height"_a, "width"_a, "pixels"_a.noconvert(), "layout"_a,
             "samples"_a.noconvert(), "Writes samples (n, C): the first number of each says whether the ray hit.")
        .def("sectioned", &sectioned, "planes"_a.noconvert(),
             "The same scene, cut by planes (n, 4): normals of length 1, and offsets, in the unit sphere.")
        .def_prop_ro("open_instances", &open_instances, "The instances that a section shows without caps, in the caller's order.")
        .def("box_by_rays", &box_by_rays, "around"_a.noconvert(), nb::rv_policy::move,
             "The box (2, 3) of all surfaces by rays from the six sides of a box around them; both in the unit sphere.")
        .def("trace_means", &trace_means, "camera"_a, "height"_a, "width"_a, "pixels"_a.noconvert(), "side"_a, nb::rv_policy::move,
             "The means over side x side rays in each pixel, (n, 5): whether they need more, linear RGB, coverage.")
        .def_prop_ro("to_shapes", &to_shapes, nb::rv_policy::move,
             "(n, 3, 4): maps from the unit sphere to the coordinates of each shape's rays, in the caller's order.")
        .def_prop_ro("bytes", [](const bob::Scene& scene) { return without_gil([&] { return scene.bytes(); }); });

    m.def("snap", &snap, "scene"_a, "camera"_a, "height"_a, "width"_a, "row"_a, "column"_a, "reach"_a,
          "The corner, center, middle or edge within `reach` pixels of a place: its kind and point, the circle's radius, and a ray to the "
          "surface next to it, all in the unit sphere. None if there is none.");
    m.def("pixels_at_edges", &pixels_at_edges, "color"_a.noconvert(), "alpha"_a.noconvert(), nb::rv_policy::move,
          "The pixels, (n, 2), of color (H, W, 3) and alpha (H, W) that are far from the mean of two opposite neighbours.");

    nb::class_<bob::PictureTracing>(m, "PictureTracing",
        "The pixels of an order, or \"tiles\" for all of them, from rays to planes (C, H, W) that are 0 at first.")
        .def("__init__", &init_picture_tracing, "scene"_a, "camera"_a, "height"_a, "width"_a, "layout"_a, "order"_a, "seed"_a,
             nb::keep_alive<1, 2>())
        .def("trace", &trace_picture, "count"_a, "planes"_a.noconvert(), "Traces until `count` pixels are done.")
        .def_prop_ro("done", &bob::PictureTracing::done);
}
