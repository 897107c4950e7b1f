/// Shared by tracing and completion: channels, cameras, pixel orders, and scattering of samples into planes.
#include <nanobind/operators.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "bindings.h"
#include "completion/guided_surfaces.h"
#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/displayed.h"
#include "picture/enlarging.h"
#include "picture/gbuffer.h"
#include "reprojection/history.h"
#include "sampling/adaptive.h"
#include "sampling/order.h"
#include "sampling/refresh.h"
#include "sampling/squares.h"
#include "tracing/trace.h"

using namespace nb::literals;

namespace {

nb::typed<nb::list, std::tuple<nb::str, int, float, float, float, bool>> channels() {
    nb::list result;
    for (const bob::Channel& c : bob::channels::all) {
        result.append(nb::make_tuple(nb::str(c.name.data(), c.name.size()), c.components, c.low, c.high, c.missed, c.seen));
    }
    return result;
}

using AnyOrder = nb::ndarray<const float, nb::numpy, nb::shape<-1, -1, -1>, nb::device::cpu>;
using PlaneOfAnyOrder = nb::ndarray<const float, nb::numpy, nb::shape<-1, -1>, nb::device::cpu>;

Array<std::uint8_t, -1, -1, 4> rgba(const AnyOrder& color, const PlaneOfAnyOrder& alpha) {
    const std::size_t height = alpha.shape(0), width = alpha.shape(1);
    expect(color.shape(0) == height && color.shape(1) == width && color.shape(2) == 3, "color: expected (H, W, 3) of alpha's size");
    auto output = make_array<std::uint8_t, -1, -1, 4>(height, width, 4);
    const auto plane = [&](std::ptrdiff_t c) { return bob::StridedPlane{color.data() + c * color.stride(2), color.stride(0), color.stride(1)}; };
    interruptible([&] {
        bob::write_rgba({plane(0), plane(1), plane(2)}, {alpha.data(), alpha.stride(0), alpha.stride(1)}, static_cast<int>(height),
                        static_cast<int>(width), output.data());
    });
    return output;
}

void enlarge(const ConstPlanes& from, const Planes& to) {
    expect(from.shape(0) == to.shape(0) && from.size() > 0 && to.size() > 0, "planes: expected as many of both sizes, which are not empty");
    const auto side = [](const auto& planes, std::size_t axis) { return static_cast<int>(planes.shape(axis)); };
    interruptible([&] { bob::enlarge(side(from, 0), from.data(), side(from, 1), side(from, 2), to.data(), side(to, 1), side(to, 2)); });
}

using Rays = std::tuple<Array<std::int64_t, -1>, Array<float, -1, 3>, Array<float, -1, 3>>;

Rays rays(const bob::Camera& camera, int height, int width, const Pixels& pixels) {
    const bob::Projection projection(camera, height, width);
    std::vector<std::int64_t> met;
    std::vector<bob::Ray> found;
    const auto all = items<bob::Pixel>(pixels);
    for (std::size_t i = 0; i < all.size(); ++i) {
        bob::Ray ray;
        if (!projection.ray(all[i], ray)) continue;
        met.push_back(static_cast<std::int64_t>(i));
        found.push_back(ray);
    }
    auto which = make_array<std::int64_t, -1>(met.size());
    auto origins = make_array<float, -1, 3>(met.size(), 3), directions = make_array<float, -1, 3>(met.size(), 3);
    for (std::size_t i = 0; i < met.size(); ++i) {
        which.data()[i] = met[i];
        for (int axis = 0; axis < 3; ++axis) {
            origins.data()[3 * i + static_cast<std::size_t>(axis)] = found[i].origin[axis];
            directions.data()[3 * i + static_cast<std::size_t>(axis)] = found[i].direction[axis];
        }
    }
    return {which, origins, directions};
}

Array<float, -1, 3> seen(const bob::Camera& camera, int height, int width, const Points& points) {
    const bob::Projection projection(camera, height, width);
    auto result = make_array<float, -1, 3>(points.shape(0), 3);
    float* to = result.data();
    for (const bob::Vec3 point : items<bob::Vec3>(points)) {
        const auto [row, column, depth] = projection.seen(point);
        *to++ = row, *to++ = column, *to++ = depth;
    }
    return result;
}

Array<float, -1, 3> points(const bob::Camera& camera, int height, int width, const Points& seen) {
    const bob::Projection projection(camera, height, width);
    auto result = make_array<float, -1, 3>(seen.shape(0), 3);
    float* to = result.data();
    for (const bob::Vec3 at : items<bob::Vec3>(seen)) {
        const bob::Vec3 point = projection.point(at.x, at.y, at.z);
        *to++ = point.x, *to++ = point.y, *to++ = point.z;
    }
    return result;
}

Array<float, -1, 3> in_scene(const bob::Camera& camera, int height, int width, const Points& directions,
                             const Array<const float, -1, 2>& places) {
    expect(directions.shape(0) == places.shape(0), "places: expected one for each direction");
    const bob::Projection projection(camera, height, width);
    auto result = make_array<float, -1, 3>(directions.shape(0), 3);
    float* to = result.data();
    for (std::size_t i = 0; i < directions.shape(0); ++i) {
        const float* place = places.data() + 2 * i;
        const bob::Vec3 direction = projection.in_scene(items<bob::Vec3>(directions)[i], place[0], place[1]);
        *to++ = direction.x, *to++ = direction.y, *to++ = direction.z;
    }
    return result;
}

void pixel_order(std::string_view name, std::uint64_t seed, std::uint32_t height, std::uint32_t width,
                 std::uint32_t start, const Array<std::int32_t, -1, 2>& pixels) {
    expect(std::uint64_t{start} + pixels.shape(0) <= std::uint64_t{height} * width, "start: beyond the last pixel");
    const bob::Order order = bob::make_order(name, seed, height, width);
    const std::span all(reinterpret_cast<bob::Pixel*>(pixels.data()), pixels.shape(0));
    interruptible([&] {
        bob::parallel_for(all.size(), 8192, [&](std::size_t begin, std::size_t end) {
            order(start + static_cast<std::uint32_t>(begin), all.subspan(begin, end - begin));
        });
    });
}


template <class AnyPlane>
void check_plane(const AnyPlane& plane, std::size_t height, std::size_t width) {
    expect(plane.shape(0) == height && plane.shape(1) == width, "off_center: expected one number for each pixel");
}

template <class AnyPlanes>
void check_planes(const bob::Layout& layout, const AnyPlanes& planes, std::size_t height, std::size_t width) {
    expect(planes.shape(0) == static_cast<std::size_t>(layout.width()) && planes.shape(1) == height && planes.shape(2) == width,
           "planes: expected one for each component, of the right size");
}

/// The result of next(), which changes an order.
template <class Order, class Next>
Array<std::int32_t, -1, 2> pixels_of(const Order& order, Next next) {
    const InUse in_use(&order);  // also while they are copied
    const std::span<const bob::Pixel> round = without_gil(next);
    auto pixels = make_array<std::int32_t, -1, 2>(round.size(), 2);
    std::copy(round.begin(), round.end(), reinterpret_cast<bob::Pixel*>(pixels.data()));
    return pixels;
}

void init_adaptive_order(bob::AdaptiveOrder* self, std::uint64_t seed, std::uint32_t height, std::uint32_t width,
                         const bob::Layout* guides_layout, const std::optional<ConstPlanes>& guides) {
    bob::AdaptiveOrder::Likeness likeness;
    if (guides_layout && guides) {
        check_planes(*guides_layout, *guides, height, width);
        const auto surfaces =
            std::make_shared<const bob::GuidedSurfaces>(*guides_layout, guides->data(), static_cast<int>(height), static_cast<int>(width));
        likeness = [surfaces](bob::Pixel own, bob::Pixel other) { return surfaces->likeness(own, other); };
    }
    new (self) bob::AdaptiveOrder(seed, height, width, std::move(likeness));
}

Array<std::int32_t, -1, 2> next_round(bob::RoundOrder& order, const bob::Layout& layout, const ConstPlanes& planes) {
    check_planes(layout, planes, order.height(), order.width());
    return pixels_of(order, [&] { return order.next(layout, planes.data()); });
}

Array<std::int32_t, -1, 2> next_refresh(bob::RefreshOrder& order, const bob::Layout& layout, const ConstPlanes& traced,
                                        const ConstPlanes& picture, const ConstPlane& off_center, std::size_t wanted) {
    check_plane(off_center, order.height(), order.width());
    check_planes(layout, traced, order.height(), order.width()), check_planes(layout, picture, order.height(), order.width());
    return pixels_of(order, [&] { return order.next(layout, traced.data(), picture.data(), off_center.data(), wanted); });
}

void scatter(const bob::Layout& layout, const Pixels& pixels, const Samples& samples, const Planes& planes) {
    check_pixels(pixels, static_cast<int>(planes.shape(1)), static_cast<int>(planes.shape(2)));
    check_width(layout, pixels.shape(0), samples);
    expect(planes.shape(0) == static_cast<std::size_t>(layout.width()), "planes: expected one for each component");
    without_gil([&] {
        bob::scatter(layout, items<bob::Pixel>(pixels), samples.data(), samples.shape(1), planes.data(), planes.shape(1), planes.shape(2));
    });
}

}  // namespace

void check_pixels(const Pixels& pixels, int height, int width) {
    for (const bob::Pixel p : items<bob::Pixel>(pixels)) {
        if (p.row >= 0 && p.row < height && p.column >= 0 && p.column < width) continue;
        const auto pair = [](int row, int column) { return "(" + std::to_string(row) + ", " + std::to_string(column) + ")"; };
        throw std::invalid_argument("pixels: expected each at least (0, 0) and below " + pair(height, width) + ", got " + pair(p.row, p.column));
    }
}

void check_width(const bob::Layout& layout, std::size_t count, const Samples& samples) {
    expect(samples.shape(0) == count, "samples: expected one for each pixel");
    expect(samples.shape(1) == static_cast<std::size_t>(layout.width()), "samples: expected the layout's width");
}

void bind_picture(nb::module_& m) {
    nb::class_<bob::Layout>(m, "Layout",
        "Channels one after the other, by names separated by commas; ValueError for an unknown name.")
        .def(nb::init<std::string_view>(), "names"_a)
        .def_prop_ro("names", &bob::Layout::names)
        .def_prop_ro("width", &bob::Layout::width, "Components of all channels.")
        .def(nb::self == nb::self, nb::sig("def __eq__(self, arg: object, /) -> bool"));
    m.def("channels", &channels,
          "(name, components, low, high, value for a miss, whether it is seen) of each channel.");
    m.def("gbuffer_layout", &bob::gbuffer_layout, nb::rv_policy::copy, "The layout of a G-buffer, the tracer's output; the mask comes first.");
    m.def("remembered_layout", &bob::remembered_layout, nb::rv_policy::copy, "is_colored"_a,
          "The same and the channels from which a moving camera shades reprojected pixels again.");

    nb::class_<bob::Camera>(m, "Camera",
        "The fields of bobrossnet.Camera; `standpoint`: its position, target and up in the unit sphere's coordinates.")
        .def("__init__", [](bob::Camera* self, float azimuth, float elevation, float roll, float zoom, std::array<float, 2> pan,
                            float fov, const std::optional<std::array<std::array<double, 3>, 3>>& standpoint) {
            new (self) bob::Camera{azimuth, elevation, roll, zoom, pan[0], pan[1], fov};
            if (standpoint) self->standpoint = {(*standpoint)[0], (*standpoint)[1], (*standpoint)[2]};
        }, "azimuth"_a, "elevation"_a, "roll"_a, "zoom"_a, "pan"_a, "fov"_a, "standpoint"_a)
        .def("pose", [](const bob::Camera& camera, int height, int width) {
            const auto pose = bob::Projection(camera, height, width).pose();
            return std::make_tuple(pose.right, pose.up, pose.toward, pose.origin, pose.pixel);
        }, "height"_a, "width"_a,
             "Axes to the right, up and toward the camera; the eye, or the picture's centre before the unit sphere; and the side of a "
             "pixel, in perspective at a distance of 1.")
        .def("rays", &rays, "height"_a, "width"_a, "pixels"_a.noconvert(),
             "The indices of pixels whose rays meet the unit sphere, (k,); the rays' origins, just outside the sphere or at the camera, "
             "and directions, (k, 3) each.")
        .def("seen", &seen, "height"_a, "width"_a, "points"_a.noconvert(),
             "Row, column and depth of points (n, 3) of the unit sphere, (n, 3); row and column are NaN behind the camera.")
        .def("points", &points, "height"_a, "width"_a, "seen"_a.noconvert(),
             "The points, (n, 3), at rows, columns and depths (n, 3).")
        .def("in_scene", &in_scene, "height"_a, "width"_a, "directions"_a.noconvert(), "places"_a.noconvert(),
             "Directions (n, 3) of the screen space at rows and columns (n, 2), in the scene's axes.");

    m.def("pixel_order", &pixel_order, "order"_a, "seed"_a, "height"_a, "width"_a, "start"_a, "pixels"_a.noconvert());
    nb::class_<bob::RoundOrder>(m, "RoundOrder", "The next pixels, chosen round by round from the pixels before.")
        .def("next", &next_round, "layout"_a, "planes"_a.noconvert(),
             "The next round, (n, 2) rows and columns; all pixels of the rounds before are in planes (C, H, W).")
        .def_prop_ro("bytes", [](const bob::RoundOrder& order) { return changing(order, [&] { return order.bytes(); }); });
    nb::class_<bob::AdaptiveOrder, bob::RoundOrder>(m, "AdaptiveOrder",
        "Pixels by need; with guides (C, H, W), also at surfaces that no traced pixel shows.")
        .def("__init__", &init_adaptive_order, "seed"_a, "height"_a, "width"_a, "guides_layout"_a = nb::none(), "guides"_a.noconvert() = nb::none());
    nb::class_<bob::SquaresOrder, bob::RoundOrder>(m, "SquaresOrder",
        "Squares of different corners, row by row, after the traced pixels of a mask (H, W). By priority, large ones first.")
        .def("__init__", [](bob::SquaresOrder* self, std::uint32_t height, std::uint32_t width, const std::optional<ConstPlane>& traced, bool by_priority) {
            if (traced) check_plane(*traced, height, width);
            using First = bob::SquaresOrder::First;
            new (self) bob::SquaresOrder(height, width, traced ? traced->data() : nullptr, by_priority ? First::priority : First::contrast);
        }, "height"_a, "width"_a, "traced"_a.noconvert() = nb::none(), "by_priority"_a = false);
    m.def("displayed", [](const Array<const float, -1>& light) {
        auto output = make_array<std::uint8_t, -1>(light.size());
        interruptible([&] {
            bob::parallel_for(light.size(), 8192, [&](std::size_t begin, std::size_t end) {
                std::transform(light.data() + begin, light.data() + end, output.data() + begin, bob::displayed);
            });
        });
        return output;
    }, "light"_a, "Linear light as bytes of sRGB, (n,).");
    m.def("rgba", &rgba, "color"_a, "alpha"_a, "sRGB with straight alpha, (H, W, 4), of linear RGB times coverage, (H, W, 3), and coverage, (H, W).");
    m.def("enlarge", &enlarge, "planes"_a.noconvert(), "output"_a.noconvert(), "Writes planes (C, h, w), enlarged bilinearly, to (C, H, W).");
    m.def("clear", [](const Planes& planes) { interruptible([&] { bob::clear(planes.data(), planes.size()); }); }, "planes"_a.noconvert(),
          "Sets new planes (C, H, W) to 0.");
    m.def("scatter", &scatter, "layout"_a, "pixels"_a.noconvert(), "samples"_a.noconvert(), "planes"_a.noconvert(),
          "Writes samples (n, C) to their pixels in planes (C, H, W).");

    nb::class_<bob::History>(m, "History", "Reprojects samples of earlier pictures.")
        .def(nb::init<const bob::Layout&, std::uint32_t, std::uint32_t>(), "layout"_a, "height"_a, "width"_a)
        .def("add", [](bob::History& history, const bob::Camera& camera, const ConstPlanes& planes) {
            check_planes(history.layout(), planes, history.height(), history.width());
            changing(history, [&] { history.add(camera, planes.data()); });
        }, "camera"_a, "planes"_a.noconvert(), "Adds the traced pixels of planes (C, H, W).")
        .def("expect", [](bob::History& history, const bob::Camera& camera, const Planes& planes, const Plane& off_center, const bob::Scene* scene) {
            check_planes(history.layout(), planes, history.height(), history.width());
            check_plane(off_center, history.height(), history.width());
            return changing(history, [&] {
                if (!scene) return history.expect(camera, planes.data(), off_center.data());
                const bob::Shading shading(*scene, camera, static_cast<int>(history.height()), static_cast<int>(history.width()), history.layout(), planes.data());
                return history.expect(camera, planes.data(), off_center.data(), shading);
            });
        }, "camera"_a, "planes"_a.noconvert(), "off_center"_a.noconvert(), "scene"_a.none() = nb::none(),
             "Writes reprojected samples to planes (C, H, W) and their distances from pixel centres to `off_center` (H, W); returns the "
             "number of pixels with a surface. If the layout has the instance, the scene shades gray and colour again.")
        .def("clear", [](bob::History& history) { changing(history, [&] { history.clear(); }); })
        .def_prop_ro("bytes", [](const bob::History& history) { return changing(history, [&] { return history.bytes(); }); });
    nb::class_<bob::RefreshOrder>(m, "RefreshOrder", "The next pixels to trace among reprojected ones.")
        .def(nb::init<std::uint32_t, std::uint32_t>(), "height"_a, "width"_a)
        .def("begin", [](bob::RefreshOrder& order, std::uint64_t seed) { changing(order, [&] { order.begin(seed); }); }, "seed"_a,
             "Begins another picture.")
        .def("next", &next_refresh, "layout"_a, "traced"_a.noconvert(), "picture"_a.noconvert(), "off_center"_a.noconvert(),
             "wanted"_a, "The next round, (n, 2) rows and columns; traced and picture are planes (C, H, W).");
}
