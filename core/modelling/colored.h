/// Signed distances with colours. Operations on distances determine the colours: sums keep them, minima and maxima
/// choose one, and blends mix both.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "formula/expression.h"

namespace bob {

using Rgb = std::array<Value, 3>;

struct Colored {
    Value distance;
    std::optional<Rgb> color = std::nullopt;  // white if only the other shape has one
};

/// `second` where the condition is negative, else `first`.
inline Rgb chosen(Value condition, const Rgb& second, const Rgb& first) {
    Rgb result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = select(condition, second[i], first[i]);
    return result;
}

/// Interpolates linearly, t being 0..1.
inline Rgb mixed(const Rgb& from, const Rgb& to, Value t) {
    Rgb result;
    for (std::size_t i = 0; i < 3; ++i) {
        const Value way = (to[i] - from[i]) * t;
        result[i] = from[i] == to[i] ? to[i] : from[i] + way;
    }
    return result;
}

/// The shape, with white if it has no colour.
inline Colored painted(Colored shape) {
    const Value white = shape.distance.graph->constant(1);
    if (!shape.color) shape.color = Rgb{white, white, white};
    return shape;
}

/// `f` of two colours, if there are any; a shape without one is white.
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

/// The minimum of two; the first if they are equal.
inline Colored min(const Colored& a, const Colored& b) {
    return {min(a.distance, b.distance), of_both(a, b, [&](const Rgb& of_a, const Rgb& of_b) {
                return chosen(b.distance - a.distance, of_b, of_a);
            })};
}

}  // namespace bob
