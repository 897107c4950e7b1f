/// Intervals of floats, one per lane. Every value of a formula, as the point evaluator rounds it, lies within its
/// interval.
///
/// Sums, products, quotients and roots round the same way and never cross their bounds. The elementary functions are
/// off by a few units in the last place, and their bounds are widened by more.
///
/// A NaN bound, for example from inf - inf, carries no information and compares accordingly. Points where a formula is
/// NaN are not on a surface. Intervals contain the other values only; `Domain` records boxes where such points may
/// exist and boxes with no other points. Only for *_kernels.cpp.
#pragma once

#include "formula/functions.h"

namespace bob::BOB_ISA {

struct Interval {
    F low, high;
};

/// Per lane, over all steps of a formula.
struct Domain {
    M partly{};   // some points may be NaN
    M nowhere{};  // all points are NaN
};

/// Detects possible NaN values of a step with operands that are never NaN: inf - inf, 0 * inf, inf / inf. Its bounds are then
/// NaN, or infinite on both sides. A value that is infinite on one side is valid: the minimum of a smooth union
/// discards an exponential that overflows.
inline void watch(const Interval& a, Domain& domain) { domain.partly |= is_nan(a.low + a.high); }

inline Interval interval(float x) { return {constant(x), constant(x)}; }
inline Interval unknown() { return {constant(-infinity), constant(infinity)}; }
inline Interval choose(M mask, Interval a, Interval b) { return {mask ? a.low : b.low, mask ? a.high : b.high}; }
inline Interval hull(Interval a, Interval b) { return {minimum(a.low, b.low), maximum(a.high, b.high)}; }
inline M contains_zero(Interval a) { return ~((a.low > F{}) | (a.high < F{})); }
inline Interval meet(Interval a, float low, float high) {
    return {maximum(a.low, constant(low)), minimum(a.high, constant(high))};
}
inline Interval widened(Interval a, float relative, float absolute) {
    // Infinite bounds widen like the largest floats: inf - inf and 0 * inf would carry no information.
    const F largest = constant(std::numeric_limits<float>::max());
    const F low = minimum(a.low, largest), high = maximum(a.high, -largest);
    return {low - (min(abs(low), largest) * relative + absolute),
            high + (min(abs(high), largest) * relative + absolute)};
}
/// The hull of an increasing function, from both ends, widened by a few units in the last place.
template <class Function>
inline Interval rising(Interval x, Function f) {
    return widened({f(x.low), f(x.high)}, 2e-6f, 1e-37f);
}

inline Interval operator-(Interval a) { return {-a.high, -a.low}; }
inline Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
inline Interval operator-(Interval a, Interval b) { return {a.low - b.high, a.high - b.low}; }
inline Interval hull_of(F p, F q, F r, F s) {
    const M known = ~(is_nan(p) | is_nan(q) | is_nan(r) | is_nan(s));
    return choose(known, {min(min(p, q), min(r, s)), max(max(p, q), max(r, s))}, unknown());
}
inline Interval operator*(Interval a, Interval b) {
    return hull_of(a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high);
}
inline Interval scaled(Interval a, float scale, float offset) {
    const F low = a.low * scale + offset, high = a.high * scale + offset;
    return scale < 0 ? Interval{high, low} : Interval{low, high};
}

inline Interval divide(Interval a, Interval b, Domain& domain) {
    const M through_zero = contains_zero(b);
    domain.partly |= through_zero & contains_zero(a);
    return choose(through_zero, unknown(),
                  hull_of(a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high));
}

inline Interval abs(Interval a) {
    const F low = abs(a.low), high = abs(a.high);
    return {contains_zero(a) ? (is_nan(a.low + a.high) ? constant(not_a_number) : F{}) : min(low, high),
            maximum(low, high)};
}
inline Interval square(Interval a) {
    const Interval size = abs(a);
    return {size.low * size.low, size.high * size.high};
}
inline Interval power(Interval a, int n) {
    const Interval base = n % 2 ? a : abs(a);
    return {power(base.low, n), power(base.high, n)};
}
inline Interval sqrt(Interval a, Domain& domain) {
    domain.partly |= ~(a.low >= F{});
    domain.nowhere |= a.high < F{};
    return {sqrt(maximum(a.low, F{})), sqrt(a.high)};
}
inline Interval hypot(Interval a, Interval b) {
    const Interval p = square(a), q = square(b);
    return {sqrt(p.low + q.low), sqrt(p.high + q.high)};
}
inline Interval minimum(Interval a, Interval b) { return {minimum(a.low, b.low), minimum(a.high, b.high)}; }
inline Interval maximum(Interval a, Interval b) { return {maximum(a.low, b.low), maximum(a.high, b.high)}; }
inline Interval floor(Interval a) { return {floor(a.low), floor(a.high)}; }
inline Interval ceil(Interval a) { return {ceil(a.low), ceil(a.high)}; }
inline Interval round(Interval a) { return {round(a.low), round(a.high)}; }

inline Interval exp(Interval a) { return rising(a, [](F x) { return exp(x); }); }
inline Interval log(Interval a, Domain& domain) {
    domain.partly |= ~(a.low >= F{});
    domain.nowhere |= a.high < F{};
    const Interval result = rising({maximum(a.low, F{}), a.high}, [](F x) { return log(x); });
    return widened(result, 0, 1e-6f);
}
inline Interval asin(Interval a, Domain& domain) {
    domain.partly |= ~((a.low >= constant(-1.f)) & (a.high <= constant(1.f)));
    domain.nowhere |= (a.low > constant(1.f)) | (a.high < constant(-1.f));
    return widened(rising(meet(a, -1, 1), [](F x) { return asin(x); }), 0, 1e-6f);
}
inline Interval acos(Interval a, Domain& domain) {
    domain.partly |= ~((a.low >= constant(-1.f)) & (a.high <= constant(1.f)));
    domain.nowhere |= (a.low > constant(1.f)) | (a.high < constant(-1.f));
    const Interval inside = meet(a, -1, 1);
    return widened({acos(inside.high), acos(inside.low)}, 2e-6f, 1e-6f);
}
inline Interval atan(Interval a) { return widened(rising(a, [](F x) { return atan(x); }), 0, 1e-6f); }

/// Whether the interval may contain offset + n period for an integer n.
inline M holds_multiple(Interval a, float offset, float period) {
    const F slack = 1e-5f + 1e-6f * maximum(abs(a.low), abs(a.high));
    const F first = ceil((a.low - slack - offset) * (1 / period)) * period + offset;
    return ~(first > a.high + slack);
}
inline Interval sine(Interval a, int quarter_turns) {
    constexpr float pi = 3.14159265358979324f;
    const float top = pi / 2 * static_cast<float>(1 - quarter_turns);
    const Interval ends = hull_of(sine(a.low, quarter_turns), sine(a.high, quarter_turns), sine(a.low, quarter_turns),
                                  sine(a.high, quarter_turns));
    const M far = ~(maximum(abs(a.low), abs(a.high)) <= constant(1e4f));
    const Interval result{holds_multiple(a, top - pi, 2 * pi) | far ? constant(-1.f) : ends.low,
                          holds_multiple(a, top, 2 * pi) | far ? constant(1.f) : ends.high};
    return choose(is_nan(a.low + a.high), unknown(), widened(result, 0, 1e-6f));
}
inline Interval sine(Interval a, int quarter_turns, Domain& domain) {
    domain.partly |= ~(maximum(abs(a.low), abs(a.high)) < constant(infinity));
    return sine(a, quarter_turns);
}
inline Interval sin(Interval a, Domain& domain) { return sine(a, 0, domain); }
inline Interval cos(Interval a, Domain& domain) { return sine(a, 1, domain); }
/// Whether the tangent has a pole in the interval.
inline M holds_pole(Interval a) {
    constexpr float pi = 3.14159265358979324f;
    return holds_multiple(a, pi / 2, pi) | ~(maximum(abs(a.low), abs(a.high)) <= constant(1e4f));
}
inline Interval tan(Interval a) {
    const Interval ends = rising(a, [](F x) { return tan(x); });
    return choose(holds_pole(a), unknown(), widened(ends, 1e-4f, 1e-6f));
}

/// Whether the angle of (x, y) jumps within the box, from pi to -pi.
inline M crosses_cut(Interval y, Interval x) { return ~(x.low > F{}) & contains_zero(y); }
inline Interval atan2(Interval y, Interval x) {
    // On a box that the cut does not cross, the angle has its extremes at corners.
    const Interval corners = hull_of(atan2(y.low, x.low), atan2(y.low, x.high), atan2(y.high, x.low),
                                     atan2(y.high, x.high));
    const Interval all_around = {constant(-3.1415928f), constant(3.1415928f)};
    return choose(is_nan(x.low + x.high + y.low + y.high), unknown(),
                  choose(crosses_cut(y, x), all_around, widened(corners, 2e-6f, 1e-6f)));
}

/// Whether a / b rounds down to the same integer everywhere.
inline M same_quotient(Interval a, Interval b) {
    const M one_divisor = (b.low == b.high) & (b.low != F{});
    const F quotient = floor(a.low / b.low);
    return one_divisor & (quotient == floor(a.high / b.low)) & (abs(quotient) < constant(infinity));
}
inline Interval modulo(Interval a, Interval b, Domain& domain) {
    domain.partly |= contains_zero(b);
    const F slack = 1e-6f * maximum(maximum(abs(a.low), abs(a.high)), maximum(abs(b.low), abs(b.high)));
    const F quotient = floor(a.low / b.low);
    const Interval smooth = {a.low - b.low * quotient, a.high - b.low * quotient};
    const Interval wrapped = {minimum(b.low, F{}) - slack, maximum(b.high, F{}) + slack};
    // Quotients above 1e38 would be infinite.
    const F largest = maximum(abs(a.low), abs(a.high)), divisor = minimum(abs(b.low), abs(b.high));
    const M wraps = ~contains_zero(b) & (largest / divisor < constant(1e38f));
    return choose(same_quotient(a, b), smooth, choose(wraps, wrapped, unknown()));
}

inline Interval select(Interval a, Interval b, Interval c) {
    return choose(a.high < F{}, b, choose(a.low >= F{}, c, choose(is_nan(a.low + a.high), unknown(), hull(b, c))));
}

/// The nonnegative part of a.
inline Interval beyond_zero(Interval a) { return maximum(a, interval(0)); }
inline Interval corner(Interval a, Interval b) {
    return select(minimum(a, b), maximum(a, b), hypot(beyond_zero(a), beyond_zero(b)));
}

}  // namespace bob::BOB_ISA
