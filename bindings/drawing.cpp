/// Drawings: edges as curves in a picture, and their strokes.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cstdint>
#include <tuple>

#include "bindings.h"
#include "drawing/curves.h"
#include "drawing/visible_edges.h"

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

std::tuple<Places, Ends> arrays_of(const bob::Curves& found) {
    auto points = make_array<float, -1, 2>(found.points.size(), 2);
    std::copy_n(reinterpret_cast<const float*>(found.points.data()), 2 * found.points.size(), points.data());
    auto ends = make_array<std::int64_t, -1>(found.ends.size());
    std::copy(found.ends.begin(), found.ends.end(), ends.data());
    return {std::move(points), std::move(ends)};
}

std::tuple<Places, Ends> visible_edges(const bob::Scene& scene, const bob::Camera& camera, int height, int width, bool smooth) {
    bob::Curves found;
    interruptible([&] { found = bob::visible_edges(scene, camera, height, width, smooth); });
    return arrays_of(found);
}

/// Segments (m, 2) between points (n, 2), as curves.
std::tuple<Places, Ends> joined(const Array<const float, -1, 2>& points, const Array<const std::uint32_t, -1, 2>& segments, float tolerance) {
    bob::LineNetwork network;
    const auto places = items<bob::PicturePoint>(points);
    network.points.assign(places.begin(), places.end());
    for (std::size_t i = 0; i < segments.shape(0); ++i) {
        const std::uint32_t a = segments.data()[2 * i], b = segments.data()[2 * i + 1];
        expect(a < network.points.size() && b < network.points.size(), "segments: expected indices of points");
        network.segments.emplace_back(a, b);
    }
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
    m.def("visible_edges", &visible_edges, "scene"_a, "camera"_a, "height"_a, "width"_a, "smooth"_a);
    m.attr("CREASE_OF_EDGES") = bob::crease_of_edges_degrees;
    m.def("joined", &joined, "points"_a.noconvert(), "segments"_a.noconvert(), "tolerance"_a);
    m.def("dashed", &dashed, "points"_a.noconvert(), "ends"_a.noconvert(), "dash"_a, "gap"_a);
    m.def("draw_strokes", &draw_strokes, "points"_a.noconvert(), "ends"_a.noconvert(), "width"_a, "coverage"_a.noconvert());
}
