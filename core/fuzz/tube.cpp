/// Tubes: curves with radii and weights as readers let them pass.
#include <algorithm>

#include "fuzz/rays.h"
#include "fuzz/splines.h"
#include "shapes/tube/tube.h"

FUZZ(tube) {
    auto path = fuzz::curve<4>(source, 5);
    auto& points = path.control_points;
    for (auto& point : points) point[3] = std::fabs(point[3]) * 0.25;
    const auto fits = [&](const auto& point) { return point[3] > 0; };
    const auto first = [&](const auto& point) { return std::equal(point.begin(), point.begin() + 3, points[0].begin()); };
    if (points.empty() || !std::all_of(points.begin(), points.end(), fits) || std::all_of(points.begin(), points.end(), first)) return;
    fuzz::meet(bob::Tube::of_weighted_points(std::move(path)), source, 6);
}
