/// Shapes at a point: distances that carry a colour along. What operations do to distances says what becomes of colours, so that
/// they are written once: sums keep them, the lower or the higher of two chooses one, and mixtures mix both.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "formula/expression.h"

namespace bob {

using Rgb = std::array<Value, 3>;

struct Colored {
    Value distance;
    std::optional<Rgb> color = std::nullopt;  // white, where another shape has one
};

/// Of a and b, the second where a condition is negative.
inline Rgb chosen(Value condition, const Rgb& second, const Rgb& first) {
    Rgb result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = select(condition, second[i], first[i]);
    return result;
}

/// From one to the other, t being 0..1.
inline Rgb mixed(const Rgb& from, const Rgb& to, Value t) {
    Rgb result;
    for (std::size_t i = 0; i < 3; ++i) {
        const Value way = (to[i] - from[i]) * t;
        result[i] = from[i] == to[i] ? to[i] : from[i] + way;
    }
    return result;
}

/// The shape, white if it has no colour.
inline Colored painted(Colored shape) {
    const Value white = shape.distance.graph->constant(1);
    if (!shape.color) shape.color = Rgb{white, white, white};
    return shape;
}

/// What `f` makes of two colours, if there are any; the shape without one is white.
template <class F>
std::optional<Rgb> of_both(const Colored& a, const Colored& b, F f) {
    if (!a.color && !b.color) return std::nullopt;
    const Rgb of_a = *painted(a).color, of_b = *painted(b).color;
    return f(of_a, of_b);
}

inline Colored operator-(const Colored& a) { return {-a.distance, a.color}; }
inline Colored operator+(const Colored& a, double b) { return {a.distance + b, a.color}; }
inline Colored operator-(const Colored& a, double b) { return {a.distance - b, a.color}; }
inline Colored operator*(const Colored& a, double b) { return {a.distance * b, a.color}; }
inline Colored operator+(const Colored& a, Value b) { return {a.distance + b, a.color}; }
inline Colored abs(const Colored& a) { return {abs(a.distance), a.color}; }

/// The lower of two; the first where they are equal.
inline Colored min(const Colored& a, const Colored& b) {
    return {min(a.distance, b.distance), of_both(a, b, [&](const Rgb& of_a, const Rgb& of_b) {
                return chosen(b.distance - a.distance, of_b, of_a);
            })};
}

}  // namespace bob
