/// Draco's corrections of predictions: integers that wrap around, on a line or on an unfolded octahedron.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>

#include "files/binary.h"

namespace bob::files::draco {

using Integer = std::int64_t;

[[noreturn]] inline void refuse_values() { refuse({"expected values of a known kind, got others"}); }

/// Integers in an interval, beyond whose ends they go on at the other.
class Wrap {
public:
    void read(Stream& stream) {
        low_ = stream.number<std::int32_t>();
        high_ = stream.number<std::int32_t>();
        if (low_ > high_ || Integer{high_} - low_ >= std::numeric_limits<std::int32_t>::max()) refuse_values();
    }
    /// values: corrections, which become values.
    void correct(std::span<const std::int32_t> predicted, std::span<std::int32_t> values) const {
        const Integer length = Integer{high_} - low_ + 1;
        for (std::size_t k = 0; k < values.size(); ++k) {
            const auto sum = static_cast<std::int32_t>(static_cast<std::uint32_t>(std::clamp(predicted[k], low_, high_)) + static_cast<std::uint32_t>(values[k]));
            values[k] = static_cast<std::int32_t>(sum > high_ ? sum - length : sum < low_ ? sum + length : sum);
        }
    }

private:
    std::int32_t low_ = 0, high_ = 0;
};

/// A square onto which the octahedron of all directions is unfolded, with integer coordinates from 0 to 2 center.
class Octahedron {
public:
    void set_bits(unsigned bits) {
        if (bits < 2 || bits > 30) refuse_values();
        side_ = (Integer{1} << bits) - 1;
        center_ = (side_ - 1) / 2;
    }
    void read(Stream& stream) {
        const auto side = stream.number<std::int32_t>();
        static_cast<void>(stream.number<std::int32_t>());
        if (side < 0 || side % 2 == 0) refuse_values();
        set_bits(static_cast<unsigned>(std::bit_width(static_cast<std::uint32_t>(side))));
    }
    void correct(std::span<const std::int32_t> predicted, std::span<std::int32_t> values) const {
        Place place = {predicted[0] - center_, predicted[1] - center_};
        const bool is_inside = std::abs(place[0]) + std::abs(place[1]) <= center_;
        if (!is_inside) fold(place);
        const int turns = turns_of(place);
        place = turned(place, turns);
        for (std::size_t k = 0; k < 2; ++k) {
            place[k] += values[k];
            place[k] += place[k] > center_ ? -side_ : place[k] < -center_ ? side_ : 0;
        }
        place = turned(place, (4 - turns) % 4);
        if (!is_inside) fold(place);
        for (std::size_t k = 0; k < 2; ++k) values[k] = static_cast<std::int32_t>(place[k] + center_);
    }
    /// The place of a direction, which need not have unit length.
    [[nodiscard]] std::array<std::int32_t, 2> place_of(std::array<Integer, 3> v, bool is_flipped) const {
        const Integer sum = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
        if (sum == 0) {
            v[0] = center_;
        } else {
            for (std::size_t k = 0; k < 2; ++k) v[k] = v[k] * center_ / sum;
            const Integer rest = center_ - std::abs(v[0]) - std::abs(v[1]);
            v[2] = v[2] >= 0 ? rest : -rest;
        }
        if (is_flipped) v = {-v[0], -v[1], -v[2]};
        Integer s = v[1] + center_, t = v[2] + center_;
        const Integer most = 2 * center_;
        if (v[0] < 0) {
            s = v[1] < 0 ? std::abs(v[2]) : most - std::abs(v[2]);
            t = v[2] < 0 ? std::abs(v[1]) : most - std::abs(v[1]);
        }
        // Each half of an edge of the square is the same as the other half.
        if ((s == 0 && t == 0) || (s == 0 && t == most) || (s == most && t == 0)) {
            s = t = most;
        } else if ((s == 0 && t > center_) || (s == most && t < center_)) {
            t = most - t;
        } else if ((t == most && s < center_) || (t == 0 && s > center_)) {
            s = most - s;
        }
        return {static_cast<std::int32_t>(s), static_cast<std::int32_t>(t)};
    }
    [[nodiscard]] std::array<double, 3> direction(std::int32_t s, std::int32_t t) const {
        double y = static_cast<double>(s) / static_cast<double>(center_) - 1, z = static_cast<double>(t) / static_cast<double>(center_) - 1;
        const double x = 1 - std::fabs(y) - std::fabs(z), over = std::max(-x, 0.0);
        y += y < 0 ? over : -over;
        z += z < 0 ? over : -over;
        const double length = std::sqrt(x * x + y * y + z * z);
        if (length < 1e-3) return {0, 0, 0};
        return {x / length, y / length, z / length};
    }

private:
    using Place = std::array<Integer, 2>;

    /// Exchanges the inside of the diamond and the outside, in the same quarter.
    void fold(Place& place) const {
        auto& [s, t] = place;
        Integer side_s = s > 0 ? 1 : -1, side_t = t > 0 ? 1 : -1;
        if (s >= 0 && t >= 0) side_s = side_t = 1;
        if (s <= 0 && t <= 0 && !(s == 0 && t == 0)) side_s = side_t = -1;
        const Integer corner_s = side_s * center_, corner_t = side_t * center_, from_s = 2 * s - corner_s, from_t = 2 * t - corner_t;
        const bool is_same = side_s * side_t >= 0;
        s = ((is_same ? -from_t : from_t) + corner_s) / 2;
        t = ((is_same ? -from_s : from_s) + corner_t) / 2;
    }
    /// Quarter turns that bring a place to the lower left.
    static int turns_of(const Place& place) {
        const auto [s, t] = place;
        if (s == 0) return t == 0 ? 0 : t > 0 ? 3 : 1;
        if (s > 0) return t >= 0 ? 2 : 1;
        return t <= 0 ? 0 : 3;
    }
    static Place turned(const Place& place, int turns) {
        const auto [s, t] = place;
        return turns == 1 ? Place{t, -s} : turns == 2 ? Place{-s, -t} : turns == 3 ? Place{-t, s} : place;
    }

    Integer side_ = 0, center_ = 0;
};

}  // namespace bob::files::draco
