/// Two points in each lane: while a step of a formula waits for the one, it computes the other. Only for
/// *_kernels.cpp.
#pragma once

#include "formula/dual.h"
#include "formula/mesh_lanes.h"

namespace bob::BOB_ISA {

struct Pair {
    F first, second;
};

template <class Function>
inline Pair each(Function f, const Pair& a) {
    return {f(a.first), f(a.second)};
}
template <class Function>
inline Pair each(Function f, const Pair& a, const Pair& b) {
    return {f(a.first, b.first), f(a.second, b.second)};
}
template <class Function>
inline Pair each(Function f, const Pair& a, const Pair& b, const Pair& c) {
    return {f(a.first, b.first, c.first), f(a.second, b.second, c.second)};
}

inline void watch(const Pair&, Domain&) {}
inline void set(Pair& a, float x) { a = {constant(x), constant(x)}; }

inline Pair operator+(const Pair& a, const Pair& b) { return {a.first + b.first, a.second + b.second}; }
inline Pair operator-(const Pair& a, const Pair& b) { return {a.first - b.first, a.second - b.second}; }
inline Pair operator*(const Pair& a, const Pair& b) { return {a.first * b.first, a.second * b.second}; }
inline Pair divide(const Pair& a, const Pair& b, Domain&) { return {a.first / b.first, a.second / b.second}; }
inline Pair scaled(const Pair& a, float scale, float offset) {
    return each([=](F x) { return scaled(x, scale, offset); }, a);
}
inline Pair abs(const Pair& a) { return each([](F x) { return abs(x); }, a); }
inline Pair square(const Pair& a) { return each([](F x) { return square(x); }, a); }
inline Pair power(const Pair& a, int n) { return each([=](F x) { return power(x, n); }, a); }
inline Pair sqrt(const Pair& a, Domain&) { return each([](F x) { return sqrt(x); }, a); }
inline Pair sin(const Pair& a, Domain&) { return each([](F x) { return sin(x); }, a); }
inline Pair cos(const Pair& a, Domain&) { return each([](F x) { return cos(x); }, a); }
inline Pair tan(const Pair& a) { return each([](F x) { return tan(x); }, a); }
inline Pair asin(const Pair& a, Domain&) { return each([](F x) { return asin(x); }, a); }
inline Pair acos(const Pair& a, Domain&) { return each([](F x) { return acos(x); }, a); }
inline Pair atan(const Pair& a) { return each([](F x) { return atan(x); }, a); }
inline Pair exp(const Pair& a) { return each([](F x) { return exp(x); }, a); }
inline Pair log(const Pair& a, Domain&) { return each([](F x) { return log(x); }, a); }
inline Pair floor(const Pair& a) { return each([](F x) { return floor(x); }, a); }
inline Pair ceil(const Pair& a) { return each([](F x) { return ceil(x); }, a); }
inline Pair round(const Pair& a) { return each([](F x) { return round(x); }, a); }
inline Pair minimum(const Pair& a, const Pair& b) { return each([](F x, F y) { return minimum(x, y); }, a, b); }
inline Pair maximum(const Pair& a, const Pair& b) { return each([](F x, F y) { return maximum(x, y); }, a, b); }
inline Pair hypot(const Pair& a, const Pair& b) { return each([](F x, F y) { return hypot(x, y); }, a, b); }
inline Pair atan2(const Pair& a, const Pair& b) { return each([](F x, F y) { return atan2(x, y); }, a, b); }
inline Pair corner(const Pair& a, const Pair& b) { return each([](F x, F y) { return corner(x, y); }, a, b); }
inline Pair modulo(const Pair& a, const Pair& b, Domain&) { return each([](F x, F y) { return modulo(x, y); }, a, b); }
inline Pair select(const Pair& a, const Pair& b, const Pair& c) {
    return each([](F x, F y, F z) { return select(x, y, z); }, a, b, c);
}
inline Pair piecewise(const Pair& a, const Pair& b, const Pair& c) { return select(a, b, c); }
inline Pair mesh_distance(const MeshDistance& mesh, const Pair& x, const Pair& y, const Pair& z) {
    return each([&](F a, F b, F c) { return mesh_distance(mesh, a, b, c); }, x, y, z);
}

}  // namespace bob::BOB_ISA
