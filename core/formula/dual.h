/// Dual numbers: forward differentiation over points or intervals, by the same rules. The slope of an interval contains
/// every slope within it; where a formula may jump it is unknown. Only for *_kernels.cpp.
#pragma once

#include "formula/interval.h"

namespace bob::BOB_ISA {

// Points, with the interface of intervals. A point needs no domain: where it has no value, it is NaN.

inline F scaled(F a, float scale, float offset) { return a * scale + offset; }
inline F divide(F a, F b, Domain&) { return a / b; }
inline F sqrt(F a, Domain&) { return sqrt(a); }
inline F sin(F a, Domain&) { return sin(a); }
inline F cos(F a, Domain&) { return cos(a); }
inline F log(F a, Domain&) { return log(a); }
inline F asin(F a, Domain&) { return asin(a); }
inline F acos(F a, Domain&) { return acos(a); }
inline F modulo(F a, F b, Domain&) { return modulo(a, b); }
inline F select(F a, F b, F c) { return is_nan(a) ? a : (a < F{} ? b : c); }

inline F piecewise(F a, F b, F c) { return select(a, b, c); }
inline Interval piecewise(Interval a, Interval b, Interval c) { return select(a, b, c); }

inline void watch(F, Domain&) {}

inline void set(F& a, float x) { a = constant(x); }
inline void set(Interval& a, float x) { a = interval(x); }

/// a if s < 0, else b; both if s may have either sign.
inline F by_sign(F s, F a, F b) { return s < F{} ? a : b; }
inline Interval by_sign(Interval s, Interval a, Interval b) {
    return choose(s.high < F{}, a, choose(s.low >= F{}, b, hull(a, b)));
}

/// a where the formula does not jump.
inline F unless(M, F a) { return a; }
inline Interval unless(M jumps, Interval a) { return choose(jumps, unknown(), a); }

inline M may_change_sign(F) { return M{}; }
inline M may_change_sign(Interval a) { return ~((a.high < F{}) | (a.low >= F{})); }
inline M may_step(F, F) { return M{}; }
inline M may_step(Interval, Interval rounded) { return ~(rounded.low == rounded.high); }
inline M may_wrap(F, F) { return M{}; }
inline M may_wrap(Interval a, Interval b) { return ~same_quotient(a, b); }
inline M may_cut(F, F) { return M{}; }
inline M may_cut(Interval y, Interval x) { return crosses_cut(y, x); }
/// Whether a sum of squares overflows, which would make slopes through it 0.
inline M overflows(F) { return M{}; }
inline M overflows(Interval squares) { return ~(squares.low < constant(infinity)); }

/// a / hypot(a, b), always within -1..1; 0 at the origin.
inline F share(F a, F h) { return h > F{} ? a / h : (is_nan(h) ? h : F{}); }
inline Interval share(Interval a, Interval h) {
    const M apart = h.low > F{};
    const Interval all = {a.low < F{} ? constant(-1.f) : F{}, a.high > F{} ? constant(1.f) : F{}};
    const Interval quotient = {a.low / (a.low < F{} ? h.low : h.high), a.high / (a.high < F{} ? h.high : h.low)};
    return choose(is_nan(h.high), unknown(), choose(apart, meet(quotient, -1, 1), all));
}

/// The weight of a's slope in a corner distance outside both a and b: a / hypot(a, b), both nonnegative.
inline F share_of_corner(F a, F b) { return share(a, hypot(a, b)); }
inline Interval share_of_corner(Interval a, Interval b) {
    return share(beyond_zero(a), hypot(beyond_zero(a), beyond_zero(b)));
}

/// x if neither a nor b is negative, else y; both if either may hold.
inline F where_outside(F a, F b, F x, F y) { return minimum(a, b) < F{} ? y : x; }
inline Interval where_outside(Interval a, Interval b, Interval x, Interval y) { return by_sign(minimum(a, b), y, x); }

/// The slope s / root; 0 where s is identically 0, even if the root is 0.
inline F over_root(F s, F root) { return s == F{} ? F{} : s / root; }
inline Interval over_root(Interval s, Interval root) {
    Domain of_slope;  // undefined at a root of zero, where the value is defined
    return choose((s.low == F{}) & (s.high == F{}), interval(0), divide(s, root, of_slope));
}

template <class N, int K>
struct Dual {
    N value;
    N slope[K];
};

template <class N, int K>
inline void watch(const Dual<N, K>& a, Domain& domain) {
    watch(a.value, domain);
}

template <class N, int K>
inline void set(Dual<N, K>& a, float x) {
    set(a.value, x);
    for (N& slope : a.slope) set(slope, 0);
}

/// `value`, with slopes that a rule computes from the operands' slopes.
template <class N, int K, class Rule>
inline Dual<N, K> chain(N value, const Dual<N, K>& a, Rule rule) {
    Dual<N, K> result{value, {}};
    for (int k = 0; k < K; ++k) result.slope[k] = rule(a.slope[k]);
    return result;
}
template <class N, int K, class Rule>
inline Dual<N, K> chain(N value, const Dual<N, K>& a, const Dual<N, K>& b, Rule rule) {
    Dual<N, K> result{value, {}};
    for (int k = 0; k < K; ++k) result.slope[k] = rule(a.slope[k], b.slope[k]);
    return result;
}

template <class N, int K>
inline Dual<N, K> scaled(const Dual<N, K>& a, float scale, float offset) {
    return chain(scaled(a.value, scale, offset), a, [&](N s) { return scaled(s, scale, 0); });
}
template <class N, int K>
inline Dual<N, K> operator+(const Dual<N, K>& a, const Dual<N, K>& b) {
    return chain(a.value + b.value, a, b, [](N s, N t) { return s + t; });
}
template <class N, int K>
inline Dual<N, K> operator-(const Dual<N, K>& a, const Dual<N, K>& b) {
    return chain(a.value - b.value, a, b, [](N s, N t) { return s - t; });
}
template <class N, int K>
inline Dual<N, K> operator*(const Dual<N, K>& a, const Dual<N, K>& b) {
    return chain(a.value * b.value, a, b, [&](N s, N t) { return a.value * t + b.value * s; });
}
template <class N, int K>
inline Dual<N, K> divide(const Dual<N, K>& a, const Dual<N, K>& b, Domain& domain) {
    const N quotient = divide(a.value, b.value, domain);
    return chain(quotient, a, b, [&](N s, N t) { return divide(s - quotient * t, b.value, domain); });
}
template <class N, int K>
inline Dual<N, K> abs(const Dual<N, K>& a) {
    return chain(abs(a.value), a, [&](N s) { return by_sign(a.value, -s, s); });
}
template <class N, int K>
inline Dual<N, K> square(const Dual<N, K>& a) {
    const N twice = scaled(a.value, 2, 0);
    return chain(square(a.value), a, [&](N s) { return twice * s; });
}
template <class N, int K>
inline Dual<N, K> power(const Dual<N, K>& a, int n) {
    N factor;
    if (n > 1) {
        factor = scaled(power(a.value, n - 1), static_cast<float>(n), 0);
    } else {
        set(factor, 1);
    }
    return chain(power(a.value, n), a, [&](N s) { return factor * s; });
}
template <class N, int K>
inline Dual<N, K> sqrt(const Dual<N, K>& a, Domain& domain) {
    const N root = sqrt(a.value, domain), twice = scaled(root, 2, 0);
    return chain(root, a, [&](N s) { return over_root(s, twice); });
}
template <class N, int K>
inline Dual<N, K> hypot(const Dual<N, K>& a, const Dual<N, K>& b) {
    const N h = hypot(a.value, b.value), p = share(a.value, h), q = share(b.value, h);
    return chain(h, a, b, [&](N s, N t) { return p * s + q * t; });
}
template <class N, int K>
inline Dual<N, K> minimum(const Dual<N, K>& a, const Dual<N, K>& b) {
    const N order = a.value - b.value;
    return chain(minimum(a.value, b.value), a, b, [&](N s, N t) { return by_sign(order, s, t); });
}
template <class N, int K>
inline Dual<N, K> maximum(const Dual<N, K>& a, const Dual<N, K>& b) {
    const N order = b.value - a.value;
    return chain(maximum(a.value, b.value), a, b, [&](N s, N t) { return by_sign(order, s, t); });
}
template <class N, int K>
inline Dual<N, K> corner(const Dual<N, K>& a, const Dual<N, K>& b) {
    const N order = b.value - a.value, p = share_of_corner(a.value, b.value), q = share_of_corner(b.value, a.value);
    return chain(corner(a.value, b.value), a, b, [&](N s, N t) {
        return where_outside(a.value, b.value, p * s + q * t, by_sign(order, s, t));
    });
}
template <class N, int K>
inline Dual<N, K> select(const Dual<N, K>& a, const Dual<N, K>& b, const Dual<N, K>& c) {
    const M jumps = may_change_sign(a.value);
    return chain(select(a.value, b.value, c.value), b, c,
                 [&](N s, N t) { return unless(jumps, by_sign(a.value, s, t)); });
}
template <class N, int K>
inline Dual<N, K> piecewise(const Dual<N, K>& a, const Dual<N, K>& b, const Dual<N, K>& c) {
    return chain(select(a.value, b.value, c.value), b, c, [&](N s, N t) { return by_sign(a.value, s, t); });
}
template <class N, int K>
inline Dual<N, K> floor(const Dual<N, K>& a) {
    const N value = floor(a.value);
    return chain(value, a, [&](N s) { return unless(may_step(a.value, value), scaled(s, 0, 0)); });
}
template <class N, int K>
inline Dual<N, K> ceil(const Dual<N, K>& a) {
    const N value = ceil(a.value);
    return chain(value, a, [&](N s) { return unless(may_step(a.value, value), scaled(s, 0, 0)); });
}
template <class N, int K>
inline Dual<N, K> round(const Dual<N, K>& a) {
    const N value = round(a.value);
    return chain(value, a, [&](N s) { return unless(may_step(a.value, value), scaled(s, 0, 0)); });
}
template <class N, int K>
inline Dual<N, K> modulo(const Dual<N, K>& a, const Dual<N, K>& b, Domain& domain) {
    const N quotient = floor(divide(a.value, b.value, domain));
    const M jumps = may_wrap(a.value, b.value);
    return chain(modulo(a.value, b.value, domain), a, b, [&](N s, N t) { return unless(jumps, s - quotient * t); });
}
template <class N, int K>
inline Dual<N, K> sin(const Dual<N, K>& a, Domain& domain) {
    const N slope = cos(a.value, domain);
    return chain(sin(a.value, domain), a, [&](N s) { return slope * s; });
}
template <class N, int K>
inline Dual<N, K> cos(const Dual<N, K>& a, Domain& domain) {
    const N slope = -sin(a.value, domain);
    return chain(cos(a.value, domain), a, [&](N s) { return slope * s; });
}
template <class N, int K>
inline Dual<N, K> tan(const Dual<N, K>& a) {
    const N value = tan(a.value), slope = scaled(square(value), 1, 1);
    return chain(value, a, [&](N s) { return slope * s; });  // at poles the value shows it (watch)
}
template <class N, int K>
inline Dual<N, K> asin(const Dual<N, K>& a, Domain& domain) {
    const N root = sqrt(scaled(square(a.value), -1, 1), domain);
    return chain(asin(a.value, domain), a, [&](N s) { return over_root(s, root); });
}
template <class N, int K>
inline Dual<N, K> acos(const Dual<N, K>& a, Domain& domain) {
    const N root = sqrt(scaled(square(a.value), -1, 1), domain);
    return chain(acos(a.value, domain), a, [&](N s) { return -over_root(s, root); });
}
template <class N, int K>
inline Dual<N, K> atan(const Dual<N, K>& a) {
    Domain everywhere;
    const N denominator = scaled(square(a.value), 1, 1);
    return chain(atan(a.value), a, [&](N s) { return unless(overflows(denominator), divide(s, denominator, everywhere)); });
}
template <class N, int K>
inline Dual<N, K> atan2(const Dual<N, K>& y, const Dual<N, K>& x) {
    Domain of_slope;
    const N distance2 = square(x.value) + square(y.value);
    const M is_unknown = may_cut(y.value, x.value) | overflows(distance2);
    return chain(atan2(y.value, x.value), y, x, [&](N s, N t) {
        return unless(is_unknown, divide(x.value * s - y.value * t, distance2, of_slope));
    });
}
template <class N, int K>
inline Dual<N, K> exp(const Dual<N, K>& a) {
    const N value = exp(a.value);
    return chain(value, a, [&](N s) { return value * s; });
}
template <class N, int K>
inline Dual<N, K> log(const Dual<N, K>& a, Domain& domain) {
    return chain(log(a.value, domain), a, [&](N s) { return divide(s, a.value, domain); });
}

}  // namespace bob::BOB_ISA
