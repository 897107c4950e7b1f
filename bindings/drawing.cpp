/// Drawings: edges as curves in a picture, and their strokes.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cstdint>
#include <tuple>

#include "bindings.h"
#include "drawing/curves.h"
#include "drawing/visible_edges.h"
#include "shapes/edges.h"

using namespace nb::literals;

namespace {

using Places = Array<float, -1, 2>;
using Ends = Array<std::int64_t, -1>;

void check_ends(const Array<const float, -1, 2>& points, const Array<const std::int64_t, -1>& ends) {
    std::int64_t before = 0;
    for (const std::int64_t end : items<std::int64_t>(ends)) {
        expect(before <= end && end <= static_cast<std::int64_t>(points.shape(0)), "ends: expected them to ascend to the number of points");
        before = end;
    }
}

template <class T>
Array<T, -1> copied(const std::vector<T>& values) {
    auto array = make_array<T, -1>(values.size());
    std::copy(values.begin(), values.end(), array.data());
    return array;
}

std::tuple<Places, Ends> arrays_of(const bob::Curves& found) {
    auto points = make_array<float, -1, 2>(found.points.size(), 2);
    std::copy_n(reinterpret_cast<const float*>(found.points.data()), 2 * found.points.size(), points.data());
    return {std::move(points), copied<std::int64_t>(found.ends)};
}

std::tuple<Places, Ends> visible_edges(const bob::Scene& scene, const bob::Camera& camera, int height, int width, bool smooth) {
    bob::Curves found;
    interruptible([&] { found = bob::visible_edges(scene, camera, height, width, smooth); });
    return arrays_of(found);
}

using Segments = Array<const std::uint32_t, -1, 2>;

void check_segments(const Segments& segments, std::size_t points) {
    for (std::size_t i = 0; i < segments.size(); ++i) expect(segments.data()[i] < points, "segments: expected indices of points");
}

std::tuple<Array<std::uint32_t, -1>, Ends> chained(std::size_t count, const Segments& segments) {
    check_segments(segments, count);
    bob::Chains found;
    interruptible([&] { found = bob::chained(count, items<bob::Segment>(segments)); });
    return {copied<std::uint32_t>(found.points), copied<std::int64_t>(found.ends)};
}

std::tuple<Places, Ends> joined(const Array<const float, -1, 2>& points, const Segments& segments, float tolerance) {
    check_segments(segments, points.shape(0));
    const auto places = items<bob::PicturePoint>(points);
    const auto pairs = items<bob::Segment>(segments);
    const bob::LineNetwork network{{places.begin(), places.end()}, {pairs.begin(), pairs.end()}};
    bob::Curves found;
    interruptible([&] { found = bob::joined(network, tolerance); });
    return arrays_of(found);
}

std::tuple<Places, Ends> dashed(const Array<const float, -1, 2>& points, const Array<const std::int64_t, -1>& ends, float dash, float gap) {
    check_ends(points, ends);
    bob::Curves found;
    interruptible([&] { found = bob::dashed(items<bob::PicturePoint>(points), items<std::int64_t>(ends), dash, gap); });
    return arrays_of(found);
}

void draw_strokes(const Array<const float, -1, 2>& points, const Array<const std::int64_t, -1>& ends, float width, const Array<float, -1, -1>& coverage) {
    check_ends(points, ends);
    interruptible([&] {
        bob::draw_strokes(items<bob::PicturePoint>(points), items<std::int64_t>(ends), width, static_cast<int>(coverage.shape(0)),
                          static_cast<int>(coverage.shape(1)), coverage.data());
    });
}

}  // namespace

void bind_drawing(nb::module_& m) {
    m.def("visible_edges", &visible_edges, "scene"_a, "camera"_a, "height"_a, "width"_a, "smooth"_a,
          "Curves: their points (n, 2), rows and columns, and each one's end among them.");
    m.attr("CREASE_OF_EDGES") = bob::crease_of_edges_degrees;
    m.def("chained", &chained, "count"_a, "segments"_a.noconvert(),
          "The numbers of points along chains of segments (m, 2) between `count` points, and each one's end among them.");
    m.def("joined", &joined, "points"_a.noconvert(), "segments"_a.noconvert(), "tolerance"_a,
          "The curves of segments (m, 2) between points (n, 2).");
    m.def("dashed", &dashed, "points"_a.noconvert(), "ends"_a.noconvert(), "dash"_a, "gap"_a);
    m.def("draw_strokes", &draw_strokes, "points"_a.noconvert(), "ends"_a.noconvert(), "width"_a, "coverage"_a.noconvert(),
          "Raises `coverage` (H, W) to that of strokes.");
}
