/// Float vectors: the only place that depends on instruction sets. Only for *_kernels.cpp (isa.h), since everything
/// here is in the namespace of the file's instruction set.
///
/// Products and sums are fused only by `fma` (-ffp-contract=off): two triangles that share an edge must agree to the
/// bit, independent of the compiler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#if defined(__ARM_NEON)
#include <arm_neon.h>
#endif
#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

// Short loops of known length. Unrolling turns the arrays they index into registers; keeping the loop limits the number
// of registers.
#if defined(__clang__)
#define BOB_UNROLL _Pragma("clang loop unroll(full)")
#define BOB_KEEP_LOOP _Pragma("clang loop unroll(disable)")
#else
#define BOB_UNROLL _Pragma("GCC unroll 16")
#define BOB_KEEP_LOOP _Pragma("GCC unroll 1")
#endif

namespace bob::BOB_ISA {

template <int N>
using Vector [[gnu::vector_size(N * 4)]] = float;
template <int N>
using IntVector [[gnu::vector_size(N * 4)]] = std::int32_t;

/// Floats in the widest register.
#if defined(__AVX512F__)
constexpr int lanes = 16;
#elif defined(__AVX2__)
constexpr int lanes = 8;
#else
constexpr int lanes = 4;
#endif

/// A register of floats, and its masks and integers.
using F = Vector<lanes>;
using M = IntVector<lanes>;

template <class V>
inline V load(const float* p) {
    V v;
    std::memcpy(&v, p, sizeof v);
    return v;
}

template <class V>
inline void store(float* p, V v) {
    std::memcpy(p, &v, sizeof v);
}

/// `w` in every lane. (`V{} + w` compiles to worse code on GCC 12.)
template <class V>
inline V broadcast(float w) {
    return w - V{};
}

inline F constant(float x) { return broadcast<F>(x); }
inline M all(std::int32_t x) { return x - M{}; }
inline M to_integers(F a) { return __builtin_convertvector(a, M); }
inline F to_floats(M a) { return __builtin_convertvector(a, F); }

inline M lane_numbers() {
    M result{};
    for (int i = 0; i < lanes; ++i) result[i] = i;
    return result;
}
inline M first_lanes(int count) { return lane_numbers() < all(count); }

/// a * b + c, rounded once if the instruction set supports it.
template <class V>
inline V fma(V a, V b, V c) {
#if defined(__ARM_NEON)
    if constexpr (sizeof(V) == 16) return (V)vfmaq_f32((float32x4_t)c, (float32x4_t)a, (float32x4_t)b);
#endif
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) return (V)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#endif
#if defined(__FMA__)
    if constexpr (sizeof(V) == 32) return (V)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
    if constexpr (sizeof(V) == 16) return (V)_mm_fmadd_ps((__m128)a, (__m128)b, (__m128)c);
#elif defined(__wasm_relaxed_simd__)
    if constexpr (sizeof(V) == 16) return (V)wasm_f32x4_relaxed_madd((v128_t)a, (v128_t)b, (v128_t)c);
#endif
    return a * b + c;
}

/// The minimum per lane; b if either is NaN.
template <class V>
inline V min(V a, V b) {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) return (V)_mm512_min_ps((__m512)a, (__m512)b);
#endif
#if defined(__AVX__)
    if constexpr (sizeof(V) == 32) return (V)_mm256_min_ps((__m256)a, (__m256)b);
#endif
#if defined(__SSE2__)
    if constexpr (sizeof(V) == 16) return (V)_mm_min_ps((__m128)a, (__m128)b);
#elif defined(__wasm_simd128__)
    if constexpr (sizeof(V) == 16) return (V)wasm_f32x4_pmin((v128_t)b, (v128_t)a);
#endif
    return a < b ? a : b;
}

/// The maximum per lane; b if either is NaN.
template <class V>
inline V max(V a, V b) {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) return (V)_mm512_max_ps((__m512)a, (__m512)b);
#endif
#if defined(__AVX__)
    if constexpr (sizeof(V) == 32) return (V)_mm256_max_ps((__m256)a, (__m256)b);
#endif
#if defined(__SSE2__)
    if constexpr (sizeof(V) == 16) return (V)_mm_max_ps((__m128)a, (__m128)b);
#elif defined(__wasm_simd128__)
    if constexpr (sizeof(V) == 16) return (V)wasm_f32x4_pmax((v128_t)b, (v128_t)a);
#endif
    return a > b ? a : b;
}

template <class V>
inline V sqrt(V a) {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) return (V)_mm512_sqrt_ps((__m512)a);
#endif
#if defined(__AVX__)
    if constexpr (sizeof(V) == 32) return (V)_mm256_sqrt_ps((__m256)a);
#endif
#if defined(__SSE2__)
    if constexpr (sizeof(V) == 16) return (V)_mm_sqrt_ps((__m128)a);
#elif defined(__wasm_simd128__)
    if constexpr (sizeof(V) == 16) return (V)wasm_f32x4_sqrt((v128_t)a);
#endif
    for (std::size_t i = 0; i < sizeof(V) / 4; ++i) a[i] = __builtin_sqrtf(a[i]);
    return a;
}

/// One bit for each lane of a mask, lane 0 lowest.
template <class M>
inline unsigned bits(M mask) {
#if defined(__AVX512DQ__)
    if constexpr (sizeof(M) == 64) return _mm512_movepi32_mask((__m512i)mask);
#endif
#if defined(__AVX__)
    if constexpr (sizeof(M) == 32) return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
#endif
#if defined(__SSE2__)
    if constexpr (sizeof(M) == 16) return static_cast<unsigned>(_mm_movemask_ps((__m128)mask));
#elif defined(__wasm_simd128__)
    if constexpr (sizeof(M) == 16) return wasm_i32x4_bitmask((v128_t)mask);
#endif
    unsigned result = 0;
    for (std::size_t i = 0; i < sizeof(M) / 4; ++i) result |= (mask[i] ? 1u : 0u) << i;
    return result;
}

/// p[index[i]] in each lane i.
template <class I>
inline I gather(const std::int32_t* p, I index) {
#if defined(__AVX512F__)
    if constexpr (sizeof(I) == 64) return (I)_mm512_i32gather_epi32((__m512i)index, p, 4);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(I) == 32) return (I)_mm256_i32gather_epi32(p, (__m256i)index, 4);
#endif
    for (std::size_t i = 0; i < sizeof(I) / 4; ++i) index[i] = p[index[i]];
    return index;
}

/// The byte p[index[i]] in each lane i; reads up to three bytes past it.
template <class I>
inline I gather_bytes(const std::uint8_t* p, I index) {
#if defined(__AVX512F__)
    if constexpr (sizeof(I) == 64) return (I)_mm512_i32gather_epi32((__m512i)index, p, 1) & 255;
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(I) == 32) return (I)_mm256_i32gather_epi32(reinterpret_cast<const int*>(p), (__m256i)index, 1) & 255;
#endif
    for (std::size_t i = 0; i < sizeof(I) / 4; ++i) index[i] = p[index[i]];
    return index;
}

namespace detail {

template <int Scale, int Offset, int Divide, class V, int... I>
inline V pick(V a, V b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b, (Scale * I / Divide + Offset)...);
}

template <int First, class V, int... I>
inline V zip(V a, V b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b, (First + I / 2 + I % 2 * static_cast<int>(sizeof(V) / 4))...);
}

/// From each four lanes of a and b, the first or the last two, interleaved.
template <bool last, class V, int... I>
inline V zip_fours(V a, V b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b, (I / 4 * 4 + last * 2 + I % 4 / 2 + I % 2 * static_cast<int>(sizeof(V) / 4))...);
}

/// The first or the second of each pair of groups: first a's, then b's.
template <int group, bool second, class V, int... I>
inline V groups(V a, V b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b, ((I & ~group) + second * group + (I & group ? static_cast<int>(sizeof(V) / 4) : 0))...);
}

template <class V>
using Lanes = std::make_integer_sequence<int, sizeof(V) / 4>;

/// In each 2 x 2 block of groups, swaps the groups above and below the diagonal.
template <int group, class V>
inline void exchange(V* square) {
    BOB_UNROLL
    for (std::size_t i = 0; i < sizeof(V) / 4; ++i) {
        if (i & group) continue;
        const V a = square[i], b = square[i + group];
        square[i] = groups<group, false>(a, b, Lanes<V>{}), square[i + group] = groups<group, true>(a, b, Lanes<V>{});
    }
}

}  // namespace detail

/// The even lanes of a, then of b.
template <class V>
inline V even(V a, V b) {
    return detail::pick<2, 0, 1>(a, b, detail::Lanes<V>{});
}

/// The odd lanes of a, then of b.
template <class V>
inline V odd(V a, V b) {
    return detail::pick<2, 1, 1>(a, b, detail::Lanes<V>{});
}

/// A vector's width of the lanes of a followed by b, from the lane `First` on.
template <int First, class V>
inline V window(V a, V b) {
    return detail::pick<1, First, 1>(a, b, detail::Lanes<V>{});
}

/// The lower halves of a and b, interleaved.
template <class V>
inline V zip_low(V a, V b) {
    return detail::zip<0>(a, b, detail::Lanes<V>{});
}

/// The upper halves of a and b, interleaved.
template <class V>
inline V zip_high(V a, V b) {
    return detail::zip<static_cast<int>(sizeof(V) / 8)>(a, b, detail::Lanes<V>{});
}

/// Transposes a square of vectors: lane j of vector i becomes lane i of vector j. First within groups of four lanes,
/// since few instruction sets move lanes across these cheaply, then the groups.
template <class V>
inline void transpose(V* square) {
    constexpr int side = sizeof(V) / 4;
    constexpr detail::Lanes<V> each;
    BOB_UNROLL
    for (int i = 0; i < side; i += 4) {
        V* const v = square + i;
        const V upper[2] = {detail::zip_fours<false>(v[0], v[2], each), detail::zip_fours<true>(v[0], v[2], each)};
        const V lower[2] = {detail::zip_fours<false>(v[1], v[3], each), detail::zip_fours<true>(v[1], v[3], each)};
        BOB_UNROLL
        for (int k = 0; k < 2; ++k) {
            v[2 * k] = detail::zip_fours<false>(upper[k], lower[k], each), v[2 * k + 1] = detail::zip_fours<true>(upper[k], lower[k], each);
        }
    }
    if constexpr (side > 4) detail::exchange<4>(square);
    if constexpr (side > 8) detail::exchange<8>(square);
}

/// Loads rows of a table as columns, a multiple of `lanes`. Lane i of column k is number k of row i.
template <int columns>
inline void load_rows(const float* const (&rows)[lanes], F (&to)[columns]) {
    static_assert(columns % lanes == 0);
    BOB_UNROLL
    for (int first = 0; first < columns; first += lanes) {
        BOB_UNROLL
        for (int i = 0; i < lanes; ++i) to[first + i] = load<F>(rows[i] + first);
        transpose(to + first);
    }
}

/// Stores the columns from `first` on to `count` rows. Transposes the columns.
template <int first, int columns>
inline void store_rows(F (&from)[columns], float* const (&rows)[lanes], int count) {
    static_assert((columns - first) % lanes == 0);
    BOB_UNROLL
    for (int column = first; column < columns; column += lanes) {
        transpose(from + column);
        BOB_UNROLL
        for (int i = 0; i < lanes; ++i) {
            if (i < count) store(rows[i] + column, from[column + i]);
        }
    }
}

/// Each lane of the lower half, twice.
template <class V>
inline V twice_low(V a) {
    return detail::pick<1, 0, 2>(a, a, detail::Lanes<V>{});
}

/// Each lane of the upper half, twice.
template <class V>
inline V twice_high(V a) {
    return detail::pick<1, static_cast<int>(sizeof(V) / 8), 2>(a, a, detail::Lanes<V>{});
}

}  // namespace bob::BOB_ISA
