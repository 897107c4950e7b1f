/// Distances from meshes, lane by lane. Tree searches do not vectorize, but each lane starts from the result of the
/// last. Only for *_kernels.cpp.
#pragma once

#include <cmath>

#include "formula/dual.h"
#include "formula/mesh_distance.h"

namespace bob::BOB_ISA {

inline F mesh_distance(const MeshDistance& mesh, F x, F y, F z) {
    F result{};
    MeshDistance::Known known;
    for (int i = 0; i < lanes; ++i) result[i] = static_cast<float>(mesh({x[i], y[i], z[i]}, known));
    return result;
}

template <int K>
inline Dual<F, K> mesh_distance(const MeshDistance& mesh, const Dual<F, K>& x, const Dual<F, K>& y, const Dual<F, K>& z) {
    F value{}, slope[3]{};
    MeshDistance::Known known;
    for (int i = 0; i < lanes; ++i) {
        MeshDistance::Point gradient;
        value[i] = static_cast<float>(mesh({x.value[i], y.value[i], z.value[i]}, known, gradient));
        for (std::size_t axis = 0; axis < 3; ++axis) slope[axis][i] = static_cast<float>(gradient[axis]);
    }
    Dual<F, K> result{value, {}};
    for (int k = 0; k < K; ++k) result.slope[k] = slope[0] * x.slope[k] + slope[1] * y.slope[k] + slope[2] * z.slope[k];
    return result;
}

/// The ball around a box: the distance at its centre bounds all others to within the radius.
struct Ball {
    MeshDistance::Point center;
    double radius, distance;

    Ball(const MeshDistance& mesh, const Interval& x, const Interval& y, const Interval& z, int lane, MeshDistance::Known& known) {
        double squared = 0;
        const Interval* const sides[3] = {&x, &y, &z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = sides[axis]->low[lane], high = sides[axis]->high[lane], half = (high - low) / 2;
            center[axis] = low + half;
            squared += half * half;
        }
        radius = std::sqrt(squared);
        distance = mesh(center, known);
    }
    [[nodiscard]] bool is_finite() const { return std::fabs(distance) + radius < HUGE_VAL; }
    /// The radius plus more than the rounding of distances.
    [[nodiscard]] double reach() const { return radius + 1e-10 + 1e-12 * (radius + std::fabs(distance)); }
    void bound(Interval& value, int lane) const {
        value.low[lane] = is_finite() ? static_cast<float>(distance - reach()) : -infinity;
        value.high[lane] = is_finite() ? static_cast<float>(distance + reach()) : infinity;
    }
};

inline Interval mesh_distance(const MeshDistance& mesh, const Interval& x, const Interval& y, const Interval& z) {
    Interval result{};
    MeshDistance::Known known;
    for (int i = 0; i < lanes; ++i) Ball(mesh, x, y, z, i, known).bound(result, i);
    return result;
}

template <int K>
inline Dual<Interval, K> mesh_distance(const MeshDistance& mesh, const Dual<Interval, K>& x, const Dual<Interval, K>& y,
                                       const Dual<Interval, K>& z) {
    constexpr float rounding = 1e-6f;
    Interval value{}, slope[3]{};
    MeshDistance::Known known;
    for (int i = 0; i < lanes; ++i) {
        const Ball ball(mesh, x.value, y.value, z.value, i, known);
        ball.bound(value, i);
        MeshDistance::Point low{}, high{};
        if (!ball.is_finite() || !mesh.gradients(ball.center, ball.radius, ball.distance, low, high)) low = {-1, -1, -1}, high = {1, 1, 1};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            slope[axis].low[i] = static_cast<float>(low[axis]) - rounding;
            slope[axis].high[i] = static_cast<float>(high[axis]) + rounding;
        }
    }
    Dual<Interval, K> result{value, {}};
    for (int k = 0; k < K; ++k) result.slope[k] = slope[0] * x.slope[k] + slope[1] * y.slope[k] + slope[2] * z.slope[k];
    return result;
}

}  // namespace bob::BOB_ISA
