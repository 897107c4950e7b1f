/// Control points and knots as files have them, kept to what their readers let pass (shapes/splines.py).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "fuzz/fuzz.h"
#include "nurbs/nurbs.h"

namespace fuzz {

constexpr double max_weight_ratio = 1e10;

/// Knots for `count` control points: clamped, uniform, or any. Readers may refuse them.
inline std::vector<double> knots(Source& source, int count, int degree) {
    std::vector<double> result;
    const std::uint8_t kind = source.byte();
    for (int i = 0; i < count + degree + 1; ++i) {
        const bool low = i <= degree, high = i >= count;
        if (kind < 128) {
            result.push_back(kind < 96 ? std::clamp(i - degree, 0, count - degree) : i);
        } else if (kind < 240) {
            const double step = kind < 200 && ((low && i > 0) || (high && i > count)) ? 0 : source.below(4) * (kind & 1 ? 0.25 : 1e-9);
            result.push_back(i ? result.back() + step : source.number());
        } else {
            result.push_back(source.number());
        }
    }
    return result;
}

inline bool are_knots(const std::vector<double>& knots, int count, int degree) {
    const auto n = static_cast<std::size_t>(count), p = static_cast<std::size_t>(degree);
    for (std::size_t i = 0; i < knots.size(); ++i) {
        if (!in_range(knots[i]) || (i && knots[i] < knots[i - 1]) || (i > p && knots[i] == knots[i - p - 1])) return false;
    }
    return knots[p] < knots[n];
}

/// Points and their weights, usually positive; some draws lie on a coarse grid, or have equal weights.
template <std::size_t N>
std::vector<bob::Homogeneous<N>> points(Source& source, std::size_t count) {
    std::vector<bob::Homogeneous<N>> result(count);
    const std::uint8_t kind = source.byte();
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t axis = 0; axis < N; ++axis) {
            result[i][axis] = kind < 128   ? static_cast<double>(source.byte()) / 64 - 2
                              : kind < 240 ? static_cast<double>(source.below(3))
                                           : source.number();
        }
        result[i][N] = kind % 2 ? 1 : kind % 4 ? std::fabs(source.number()) : 0.25 + source.byte() / 64.;
    }
    return result;
}

template <std::size_t N>
bool are_points(std::span<const bob::Homogeneous<N>> points) {
    double least = HUGE_VAL, most = 0;
    for (const auto& point : points) {
        if (!std::all_of(point.begin(), point.end(), in_range) || !(point[N] > 0)) return false;
        least = std::min(least, point[N]), most = std::max(most, point[N]);
    }
    return !(most / max_weight_ratio > least);
}

/// A curve that readers let pass; no control points where they would not.
template <std::size_t N>
bob::NurbsCurve<N> curve(Source& source, int most_points) {
    const int count = source.between(2, most_points);
    const int degree = source.between(1, std::min(count - 1, bob::max_degree));
    bob::NurbsCurve<N> result{degree, knots(source, count, degree), points<N>(source, static_cast<std::size_t>(count))};
    if (!are_knots(result.knots, count, degree) || !are_points<N>(result.control_points)) return {};
    return result;
}

}  // namespace fuzz
