/// Evaluation of Bezier patches, with one patch and its parameters per lane. Only for *_kernels.cpp.
#pragma once

#include "base/simd.h"
#include "shapes/brep/pieces.h"

namespace bob::BOB_ISA {

using Float4 = Vector<4>;

/// Points in homogeneous coordinates and their derivatives: w x, w y, w z and w of each.
template <int N>
struct Jets {
    Vector<N> x[4], u[4], v[4];
};

/// Patches of the same degrees, one in each of N lanes.
template <int N>
class PatchLanes {
public:
    using V = Vector<N>;

    /// Loads the first `count` patches, one per lane; the other lanes repeat the first.
    void load(const Pieces& pieces, const std::uint32_t* patches, int count) {
        const Patch& first = pieces.patches[patches[0]];
        p_ = first.degree_u, q_ = first.degree_v;
        evaluate_ = evaluator(16 * p_ + q_);
        const float* from[N];
        bool all_equal = true;
        for (int lane = 0; lane < N; ++lane) {
            const std::uint32_t patch = patches[lane < count ? lane : 0];
            all_equal &= patch == patches[0];
            from[lane] = pieces.control_points[pieces.patches[patch].control_points].data();
        }
        const int size = (p_ + 1) * (q_ + 1);
        if (all_equal) {
            for (int i = 0; i < size; ++i) {
                for (int k = 0; k < 4; ++k) points_[i][k] = broadcast<V>(from[0][4 * i + k]);
            }
            return;
        }
        for (int i = 0; i < size; ++i) {
            for (int lane = 0; lane < N; lane += 4) {
                const Float4 a = load4(from[lane] + 4 * i), b = load4(from[lane + 1] + 4 * i);
                const Float4 c = load4(from[lane + 2] + 4 * i), d = load4(from[lane + 3] + 4 * i);
                const Float4 ac_low = __builtin_shufflevector(a, c, 0, 4, 1, 5);
                const Float4 ac_high = __builtin_shufflevector(a, c, 2, 6, 3, 7);
                const Float4 bd_low = __builtin_shufflevector(b, d, 0, 4, 1, 5);
                const Float4 bd_high = __builtin_shufflevector(b, d, 2, 6, 3, 7);
                float* const to = reinterpret_cast<float*>(points_[i]) + lane;
                store(to, __builtin_shufflevector(ac_low, bd_low, 0, 4, 1, 5));
                store(to + N, __builtin_shufflevector(ac_low, bd_low, 2, 6, 3, 7));
                store(to + 2 * N, __builtin_shufflevector(ac_high, bd_high, 0, 4, 1, 5));
                store(to + 3 * N, __builtin_shufflevector(ac_high, bd_high, 2, 6, 3, 7));
            }
        }
    }

    void evaluate(const V& u, const V& v, Jets<N>& jets) const { evaluate_(*this, u, v, jets); }

    [[nodiscard]] int rows() const { return p_ + 1; }
    [[nodiscard]] int columns() const { return q_ + 1; }
    /// A control point's w x, w y, w z and w; v fastest.
    [[nodiscard]] const V (&point(int i) const)[4] { return points_[i]; }

private:
    static Float4 load4(const float* p) { return bob::BOB_ISA::load<Float4>(p); }

    /// The Bernstein polynomials of degree p at t, and their derivatives, which are 0 for degree 0.
    template <int P>
    static void bernstein(int p, V t, V* value, V* derivative) {
        if constexpr (P > 0) p = P;
        const V s = 1 - t;
        value[0] = broadcast<V>(1);
        for (int k = 1; k < p; ++k) {
            V saved{};
            for (int i = 0; i < k; ++i) {
                const V b = value[i];
                value[i] = fma(s, b, saved);
                saved = t * b;
            }
            value[k] = saved;
        }
        const auto degree = static_cast<float>(p);
        V before{};
        for (int i = 0; i < p; ++i) {
            const V b = value[i];
            derivative[i] = degree * (before - b);
            value[i] = fma(t, before, s * b);
            before = b;
        }
        derivative[p] = degree * before;
        value[p] = t * before;
    }

    template <int P, int Q>
    static void evaluate_degrees(const PatchLanes& patches, const V& u, const V& v, Jets<N>& jets) {
        int p = patches.p_, q = patches.q_;
        if constexpr (P > 0) p = P, q = Q;
        V in_u[max_degree + 1], d_u[max_degree + 1], in_v[max_degree + 1], d_v[max_degree + 1];
        bernstein<P>(p, u, in_u, d_u);
        bernstein<Q>(q, v, in_v, d_v);
        for (int k = 0; k < 4; ++k) {
            V x{}, by_u{}, by_v{};
            for (int i = 0; i <= p; ++i) {
                V row{}, row_v{};
                for (int j = 0; j <= q; ++j) {
                    const V point = patches.points_[i * (q + 1) + j][k];
                    row = fma(in_v[j], point, row);
                    row_v = fma(d_v[j], point, row_v);
                }
                x = fma(in_u[i], row, x);
                by_u = fma(d_u[i], row, by_u);
                by_v = fma(in_u[i], row_v, by_v);
            }
            jets.x[k] = x, jets.u[k] = by_u, jets.v[k] = by_v;
        }
    }

    using Evaluate = void (*)(const PatchLanes&, const V&, const V&, Jets<N>&);

    static Evaluate evaluator(int degrees) {
        switch (degrees) {
            case 0x11: return evaluate_degrees<1, 1>;
            case 0x12: return evaluate_degrees<1, 2>;
            case 0x21: return evaluate_degrees<2, 1>;
            case 0x22: return evaluate_degrees<2, 2>;
            case 0x13: return evaluate_degrees<1, 3>;
            case 0x31: return evaluate_degrees<3, 1>;
            case 0x23: return evaluate_degrees<2, 3>;
            case 0x32: return evaluate_degrees<3, 2>;
            case 0x33: return evaluate_degrees<3, 3>;
            default: return evaluate_degrees<0, 0>;
        }
    }

    int p_, q_;
    Evaluate evaluate_;
    V points_[(max_degree + 1) * (max_degree + 1)][4];
};

}  // namespace bob::BOB_ISA
