/// Geometry of a single segment of an outline: straight or a circular arc.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "modelling/boundary.h"
#include "modelling/words.h"

namespace bob {

inline double cross(const Vector<2>& a, const Vector<2>& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Whether an arc's height above its chord is below the rounding of its middle.
inline bool is_straight(const Segment& segment) { return std::fabs(segment.bulge) < 1e-9; }

/// The circle of a segment that is not straight.
struct Arc {
    Vector<2> center, from;
    double radius;
    double angle;  // from start to end, anticlockwise positive

    explicit Arc(const Segment& segment) : from(segment.from), angle(4 * std::atan(segment.bulge)) {
        const Vector<2> chord = segment.to - segment.from, left{-chord[1], chord[0]};
        const double b = segment.bulge;
        center = (segment.from + segment.to) * 0.5 + left * ((1 - b * b) / (4 * b));
        radius = length(chord) * (1 + b * b) / (4 * std::fabs(b));
    }

    /// The angle from its start to a point, as seen from its center. In the arc's direction, unless the other is much
    /// shorter.
    [[nodiscard]] double angle_to(const Vector<2>& p) const {
        const Vector<2> a = from - center, b = p - center;
        const double turn = angle < 0 ? -1 : 1, way = turn * std::atan2(cross(a, b), dot(a, b));
        const double back = (std::fabs(angle) - 2 * std::numbers::pi) / 2;
        return turn * (way < back ? way + 2 * std::numbers::pi : way);
    }

    /// Whether the ray from its center through a point intersects it.
    [[nodiscard]] bool spans(const Vector<2>& p) const {
        const double way = angle_to(p) / angle;
        return way >= 0 && way <= 1;
    }
};

inline Vector<2> middle_of(const Segment& segment) {
    const Vector<2> chord = segment.to - segment.from, right{chord[1], -chord[0]};
    return (segment.from + segment.to) * 0.5 + right * (segment.bulge / 2);
}

/// An axis-aligned rectangle.
struct Extent {
    Vector<2> low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};

    void add(const Vector<2>& p) {
        for (std::size_t i = 0; i < 2; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
    }
    void add(const Segment& segment) {
        add(segment.from), add(segment.to);
        if (is_straight(segment)) return;
        const Arc arc(segment);
        for (std::size_t i = 0; i < 2; ++i) {
            for (const double side : {-arc.radius, arc.radius}) {
                Vector<2> p = arc.center;
                p[i] += side;
                if (arc.spans(p)) add(p);
            }
        }
    }
    void add(const Loop& loop) {
        for (const Segment& segment : loop) add(segment);
    }
    [[nodiscard]] bool contains(const Extent& other) const {
        return other.low[0] >= low[0] && other.low[1] >= low[1] && other.high[0] <= high[0] && other.high[1] <= high[1];
    }
};

inline Vector<2> turned(const Vector<2>& v, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * v[0] - s * v[1], s * v[0] + c * v[1]};
}

/// The segment in the minimum number of equal parts of at most a quarter of a circle each.
inline std::vector<Segment> quarters(const Segment& segment) {
    if (is_straight(segment)) return {segment};
    const Arc arc(segment);
    const double count = std::ceil(std::fabs(arc.angle) / (std::numbers::pi / 2) - 1e-9);
    std::vector<Segment> result;
    Vector<2> from = segment.from;
    for (double i = 1; i <= count; ++i) {
        const Vector<2> on_circle = arc.center + turned(segment.from - arc.center, arc.angle * i / count);
        const Vector<2> to = i < count ? on_circle : segment.to;
        result.push_back({from, to, std::tan(arc.angle / count / 4)});
        from = to;
    }
    return result;
}

/// The directions of a segment at its start and at its end.
inline Vector<2> start_direction(const Segment& segment) {
    return turned(normalized(segment.to - segment.from), -2 * std::atan(segment.bulge));
}
inline Vector<2> end_direction(const Segment& segment) {
    return turned(normalized(segment.to - segment.from), 2 * std::atan(segment.bulge));
}

}  // namespace bob
