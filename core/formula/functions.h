/// Elementary functions of float vectors, after Moshier's Cephes library (single precision). They are accurate to a few
/// units in the last place, and `interval.h` allows for that. Sine and cosine lose digits beyond |x| = 1e4, as x itself
/// does. Only for *_kernels.cpp.
#pragma once

#include <limits>

#include "base/simd.h"

namespace bob::BOB_ISA {

inline M as_bits(F x) { return (M)x; }
inline F as_floats(M x) { return (F)x; }

inline const float infinity = std::numeric_limits<float>::infinity();
inline const float not_a_number = std::numeric_limits<float>::quiet_NaN();

inline M is_nan(F a) { return a != a; }
inline F abs(F a) { return as_floats(as_bits(a) & all(0x7fffffff)); }
/// The magnitude of a with the sign of b.
inline F copy_sign(F a, F b) {
    return as_floats((as_bits(a) & all(0x7fffffff)) | (as_bits(b) & all(static_cast<std::int32_t>(0x80000000))));
}

/// min and max that propagate NaN from either operand.
inline F minimum(F a, F b) { return is_nan(a) ? a : min(a, b); }
inline F maximum(F a, F b) { return is_nan(a) ? a : max(a, b); }

/// Rounds to the nearest integer, halves to even: below 2^23, adding and subtracting 2^23 rounds.
inline F round(F a) {
    const F shift = copy_sign(constant(0x1p23f), a);
    return abs(a) < constant(0x1p23f) ? copy_sign((a + shift) - shift, a) : a;
}
inline F floor(F a) {
    const F r = round(a);
    return r > a ? r - 1.f : r;
}
inline F ceil(F a) {
    const F r = round(a);
    return r < a ? r + 1.f : r;
}

/// sin(x + quarter_turns * pi / 2)
inline F sine(F x, int quarter_turns) {
    // Cody and Waite: pi / 2 in three parts, the first two short enough that their products are exact.
    constexpr float part[3] = {1.5703125f, 4.837512969970703125e-4f, 7.54978995489188216e-8f};
    const F wide = constant(1e6f);
    const F safe = abs(x) <= wide ? x : F{};  // beyond, neighbouring floats are several radians apart or infinite
    const F turns = round(safe * 0.63661977236758134f);
    F r = safe - turns * part[0];
    r = r - turns * part[1];
    r = r - turns * part[2];
    const F r2 = r * r;
    const F sin_r = r + r * r2 * (-1.6666654611e-1f + r2 * (8.3321608736e-3f - r2 * 1.9515295891e-4f));
    const F cos_r = 1.f - 0.5f * r2 +
                    r2 * r2 * (4.166664568298827e-2f + r2 * (-1.388731625493765e-3f + r2 * 2.443315711809948e-5f));
    const M quadrant = to_integers(turns) + quarter_turns;
    const F size = (quadrant & 1) != M{} ? cos_r : sin_r;
    const F result = (quadrant & 2) != M{} ? -size : size;
    return x - x == F{} ? result : constant(not_a_number);  // NaN for NaN and for infinity
}
inline F sin(F x) { return sine(x, 0); }
inline F cos(F x) { return sine(x, 1); }
inline F tan(F x) { return sin(x) / cos(x); }

inline F exp(F x) {
    const F low = constant(-103.f), high = constant(89.f);
    const F clamped = max(min(x, high), low);
    const F n = round(clamped * 1.44269504088896341f);
    F r = clamped - n * 0.693359375f;
    r = r + n * 2.12194440e-4f;
    F p = r * 1.9875691500e-4f + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    p = p * (r * r) + r + 1.f;
    // 2^n in two factors, since n may leave the range of one exponent.
    const M half = to_integers(n) >> 1, rest = to_integers(n) - half;
    const F result = p * as_floats((half + 127) << 23) * as_floats((rest + 127) << 23);
    return is_nan(x) ? x : (x > high ? constant(infinity) : (x < low ? F{} : result));
}

inline F log(F x) {
    const M tiny = x < constant(std::numeric_limits<float>::min());
    const F scaled = tiny ? x * 0x1p25f : x;
    M exponent = ((as_bits(scaled) >> 23) & 255) - 126 - (tiny ? all(25) : M{});
    F m = as_floats((as_bits(scaled) & all(0x007fffff)) | all(0x3f000000));  // 0.5..1
    const M low = m < constant(0.707106781186547524f);
    exponent = low ? exponent - 1 : exponent;
    m = low ? m + m - 1.f : m - 1.f;
    F p = m * 7.0376836292e-2f - 1.1514610310e-1f;
    p = p * m + 1.1676998740e-1f;
    p = p * m - 1.2420140846e-1f;
    p = p * m + 1.4249322787e-1f;
    p = p * m - 1.6668057665e-1f;
    p = p * m + 2.0000714765e-1f;
    p = p * m - 2.4999993993e-1f;
    p = p * m + 3.3333331174e-1f;
    const F e = to_floats(exponent), m2 = m * m;
    const F result = m + (p * m * m2 - e * 2.12194440e-4f - 0.5f * m2) + e * 0.693359375f;
    const F edge = x == F{} ? constant(-infinity) : (x > F{} ? x : constant(not_a_number));  // 0, inf, below 0 and NaN
    return ((x > F{}) & (x < constant(infinity))) ? result : edge;
}

/// The angle of (1, x) for x in 0..1.
inline F atan_of_ratio(F x) {
    const M high = x > constant(0.4142135623730950f);  // tan(pi / 8)
    const F r = high ? (x - 1.f) / (x + 1.f) : x;
    const F r2 = r * r;
    const F p = r + r * r2 * (-3.33329491539e-1f + r2 * (1.99777106478e-1f +
                                                        r2 * (-1.38776856032e-1f + r2 * 8.05374449538e-2f)));
    return high ? p + 0.785398163397448309f : p;
}

/// The angle of (x, y); 0 at the origin.
inline F atan2(F y, F x) {
    const F size_x = abs(x), size_y = abs(y);
    const M steep = size_y > size_x;
    const F ratio = (steep ? size_x : size_y) / (steep ? size_y : size_x);
    // Equal zeros and equal infinities have no ratio.
    const F of_equals = size_x > F{} ? constant(1.f) : F{};
    F angle = atan_of_ratio(size_x == size_y ? of_equals : ratio);
    angle = steep ? 1.57079632679489662f - angle : angle;
    angle = x < F{} ? 3.14159265358979324f - angle : angle;
    return copy_sign(angle, y);
}
inline F atan(F x) {
    const F size = abs(x);
    const M steep = size > constant(1.f);
    const F angle = atan_of_ratio(steep ? 1.f / size : size);
    return copy_sign(steep ? 1.57079632679489662f - angle : angle, x);
}

/// asin(x) = atan2(x, sqrt(1 - x^2)), with the square written as (1 - x)(1 + x), which loses nothing near 1.
inline F asin(F x) { return atan2(x, sqrt((1.f - x) * (1.f + x))); }
inline F acos(F x) { return atan2(sqrt((1.f - x) * (1.f + x)), x); }

inline F square(F a) { return a * a; }
inline F hypot(F a, F b) { return sqrt(a * a + b * b); }
inline F corner(F a, F b) {
    const F least = minimum(a, b);
    return is_nan(least) ? least : (least < F{} ? maximum(a, b) : hypot(a, b));
}
/// The remainder of a / b with the sign of b.
inline F modulo(F a, F b) { return a - b * floor(a / b); }

/// a^n for n >= 1, by products of magnitudes only. It is therefore monotonic in the magnitude of a to the last bit.
inline F power(F a, int n) {
    F result = a, factor = a;
    bool started = false;
    for (; n; n >>= 1) {
        if (n & 1) {
            result = started ? result * factor : factor;
            started = true;
        }
        factor = factor * factor;
    }
    return result;
}

}  // namespace bob::BOB_ISA
