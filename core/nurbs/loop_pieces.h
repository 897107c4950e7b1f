/// Loops of trims as Bezier pieces, and their points.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <vector>

#include "nurbs/nurbs.h"
#include "nurbs/trim.h"

namespace bob {

/// The different knots of a domain, its ends included.
inline std::vector<double> distinct_knots(int degree, std::span<const double> knots) {
    const auto p = static_cast<std::ptrdiff_t>(degree);
    std::vector<double> result(knots.begin() + p, knots.end() - p);
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

using LoopPiece = BezierCurve<2>;

struct At {
    double u, v, dv;
};

/// The point of a piece at t in 0..1, and the derivative of v.
inline At at(const LoopPiece& piece, double t) {
    std::array<Homogeneous<2>, max_degree + 1> points;
    std::ranges::copy(piece.control_points, points.begin());
    const std::size_t n = piece.control_points.size();
    Homogeneous<2> by{};
    for (std::size_t left = n - 1; left > 0; --left) {
        if (left == 1) {
            for (std::size_t k = 0; k < 3; ++k) by[k] = static_cast<double>(n - 1) * (points[1][k] - points[0][k]);
        }
        for (std::size_t i = 0; i < left; ++i) {
            for (std::size_t k = 0; k < 3; ++k) points[i][k] = std::lerp(points[i][k], points[i + 1][k], t);
        }
    }
    const auto& [u, v, w] = points[0];
    return {u / w, v / w, (by[1] - by[2] * v / w) / w};
}

/// The pieces of a loop, with the lines that close its gaps.
inline std::vector<LoopPiece> pieces_of(const TrimLoop& loop) {
    std::vector<LoopPiece> result;
    const auto line_to = [&](const Homogeneous<2>& end) {
        const Homogeneous<2>& start = result.back().control_points.back();
        const Homogeneous<2> a{start[0] / start[2], start[1] / start[2], 1}, b{end[0] / end[2], end[1] / end[2], 1};
        if (a != b) result.push_back({0, 1, {a, b}});
    };
    for (const NurbsCurve<2>& curve : loop) {
        std::vector<LoopPiece> own = decompose(curve);
        if (!result.empty()) line_to(own.front().control_points.front());
        std::ranges::move(own, std::back_inserter(result));
    }
    if (!result.empty()) line_to(result.front().control_points.front());
    return result;
}

}  // namespace bob
