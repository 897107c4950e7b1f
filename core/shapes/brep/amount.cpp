/// Areas and volumes of boundary representations.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/interruption.h"
#include "nurbs/moments.h"
#include "shapes/brep/brep.h"

namespace bob {
namespace {

/// As bobrossnet.measuring.volumes.OPEN: residual of a closed surface's identities above which it is open, as a share of its area.
constexpr double open = 1e-5;

/// Off a face before rays begin, as bobrossnet.measuring.crossings.APART.
constexpr double apart = 2e-5;

}  // namespace

Brep::Amount Brep::amount(std::size_t begin, std::size_t end) const {
    end = std::min(end, faces_.size());
    Amount result;
    const bool is_closed = prepare_inside();
    Vec3d normal{};
    std::array<double, 9> position{};
    bool is_known = is_closed && begin < end;
    for (std::size_t i = begin; i < end; ++i) {
        Interruption::check();
        const Moments moments = bob::moments(faces_[i].surface, faces_[i].loops);
        result.area += moments.area;
        const double sign = is_known ? outward(i, moments.inside) : 0;
        is_known = is_known && sign != 0;
        for (std::size_t k = 0; k < 3; ++k) normal[k] += sign * moments.normal[k];
        for (std::size_t k = 0; k < 9; ++k) position[k] += sign * moments.position[k];
    }
    if (!is_known) return result;
    // About the middle of the box, as in Python: where faces gape, the volume depends on it.
    const Bounds box = bounds(to_unit_sphere(sphere()));
    double size = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        size = std::max(size, box.high[i] - box.low[i]);
        for (std::size_t k = 0; k < 3; ++k) position[3 * i + k] -= 0.5 * (box.low[i] + box.high[i]) * normal[k];
    }
    const double volume = (position[0] + position[4] + position[8]) / 3;
    double missing = 0;
    for (std::size_t k = 0; k < 9; ++k) missing = std::max(missing, std::abs(position[k] - (k % 4 == 0 ? volume : 0)) / size);
    for (std::size_t k = 0; k < 3; ++k) missing = std::max(missing, std::abs(normal[k]));
    // Gaps within the tolerance of the file are no holes.
    if (missing <= std::max(open, tolerance_ / size) * result.area && volume > 0) result.volume = volume;
    return result;
}

double Brep::outward(std::size_t face, const std::array<double, 2>& inside) const {
    const auto by = surface_derivatives(faces_[face].surface, inside[0], inside[1], 1);
    const Vec3d across = cross(by[2], by[1]);
    const double size = length(across);
    if (!(size > 0)) return 0;
    const Vec3d n = 1 / size * across;
    std::array<std::uint8_t, 2> is_inside{};
    for (std::size_t side = 0; side < 2; ++side) {
        const Vec3d way = side == 0 ? n : -1 * n;
        const Ray ray{rounded(by[0] + apart * way), rounded(way)};
        Hit hit;
        closest_hits({&ray, 1}, {&hit, 1});
        if (hit.primitive != no_primitive) starts_inside({&ray, 1}, {&hit, 1}, {&is_inside[side], 1});
    }
    return static_cast<double>(is_inside[1]) - static_cast<double>(is_inside[0]);
}

}  // namespace bob
