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

std::tuple<Places, Ends> visible_edges(const bob::Scene& scene, const bob::Camera& camera, int height, int width, bool smooth) {
    bob::Curves found;
    interruptible([&] { found = bob::visible_edges(scene, camera, height, width, smooth); });
    auto points = make_array<float, -1, 2>(found.points.size(), 2);
    for (std::size_t i = 0; i < found.points.size(); ++i) points.data()[2 * i] = found.points[i].row, points.data()[2 * i + 1] = found.points[i].column;
    auto ends = make_array<std::int64_t, -1>(found.ends.size());
    std::copy(found.ends.begin(), found.ends.end(), ends.data());
    return {std::move(points), std::move(ends)};
}

void draw_strokes(const Array<const float, -1, 2>& points, const Array<const std::int64_t, -1>& ends, float width, const Array<float, -1, -1>& coverage) {
    std::int64_t before = 0;
    for (const std::int64_t end : items<std::int64_t>(ends)) {
        expect(before <= end && end <= static_cast<std::int64_t>(points.shape(0)), "ends: expected them to ascend to the number of points");
        before = end;
    }
    interruptible([&] {
        bob::draw_strokes(items<bob::PicturePoint>(points), items<std::int64_t>(ends), width, static_cast<int>(coverage.shape(0)),
                          static_cast<int>(coverage.shape(1)), coverage.data());
    });
}

}  // namespace

void bind_drawing(nb::module_& m) {
    m.def("visible_edges", &visible_edges, "scene"_a, "camera"_a, "height"_a, "width"_a, "smooth"_a);
    m.def("draw_strokes", &draw_strokes, "points"_a.noconvert(), "ends"_a.noconvert(), "width"_a, "coverage"_a.noconvert());
}
