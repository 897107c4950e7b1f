/// Newton's method for ray-patch intersection, several at a time. Only for *_kernels.cpp.
#pragma once

#include <cmath>

#include "shapes/brep/look.h"
#include "shapes/bvh_traversal.h"

namespace bob::BOB_ISA {

// Hits are accepted outside their piece up to rounding errors plus this share of its size. So no ray passes between
// adjacent pieces.
constexpr float overlap = 1e-5f;

// In units: a hit lies within `aside` of its ray, and at most `beyond` past the edge of its piece. Where a ray runs
// along a piece, or a piece has no area, rounding errors are larger; then the control points decide.
constexpr float aside = 1e-6f, beyond = 2e-6f;

// Not std::fmin and std::fmax, which are calls.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }
inline float clamp(float x, float low, float high) { return smaller(larger(x, low), high); }

/// The dot product of the first three components.
inline float dot(Float4 a, Float4 b) {
    const Float4 products = a * b;
    return products[0] + products[1] + products[2];
}

inline Float4 cross(Float4 a, Float4 b) {
    const Float4 a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3), b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    const Float4 c = a * b_yzx - a_yzx * b;
    return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}

/// A ray relative to a patch's centre: from its point at t = start on.
struct LocalRay {
    Float4 origin;  // and 0
    double start;

    LocalRay(const Ray& ray, const Patch& patch, float start) : origin{}, start(start) {
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = static_cast<float>(static_cast<double>(ray.origin[axis]) +
                                              this->start * static_cast<double>(ray.direction[axis]) -
                                              static_cast<double>(patch.center[axis]));
        }
    }
};

/// A part of a patch's parameters.
struct UvRange {
    float low[2], size[2];
};

struct Solution {
    float u, v;
    double t;
};

/// Newton's method on the two planes through a ray. Each of N lanes has a ray and a part of a patch. The patches have
/// the same degrees.
///
/// Finds one hit, or that the root lies outside the part. If the part may have several roots, neither result excludes
/// another. The result of a lane does not depend on the others.
template <int N>
class Newton {
public:
    enum class Found { hit, nothing, unclear };

    [[nodiscard]] bool is_full() const { return count_ == N; }
    [[nodiscard]] int count() const { return count_; }
    void clear() { count_ = 0; }

    /// Fills the next lane; the search begins at u and v. If `normal` is given, control points are tested first.
    void add(const Ray& ray, const LocalRay& local, std::uint32_t patch, const UvRange& part, float u, float v,
             const Float4* normal = nullptr) {
        const int lane = count_++;
        for (int axis = 0; axis < 3; ++axis) {
            origin_[axis][lane] = local.origin[axis];
            direction_[axis][lane] = ray.direction[axis];
        }
        for (int k = 0; k < 2; ++k) {
            low_[k][lane] = part.low[k];
            size_[k][lane] = part.size[k];
        }
        at_[0][lane] = u, at_[1][lane] = v;
        looks_[lane] = normal ? -1 : 0;
        for (int axis = 0; axis < 3 && normal; ++axis) normal_[axis][lane] = (*normal)[axis];
        patch_[lane] = patch;
        start_[lane] = local.start;
    }

    void solve(const Pieces& pieces, PatchLanes<N>& patches) {
        constexpr int most_steps = 8;
        constexpr float close = 2e-4f;  // after a smaller step, in sizes of the part, the error is negligible
        patches.load(pieces, patch_, count_);
        const Frame<N> frame(direction_);
        const V half = broadcast<V>(0.5f), one = broadcast<V>(1), inverse_size[2] = {one / size_[0], one / size_[1]};
        const V middle[2] = {low_[0] + half * size_[0], low_[1] + half * size_[1]};
        V u = at_[0], v = at_[1], last = one, t{};
        I open, hit{}, nothing{};
        for (int lane = 0; lane < N; ++lane) open[lane] = lane < count_ ? -1 : 0;
        if (bits(open & looks_)) {
            const Look<N> look(patches, origin_, frame, direction_, normal_, low_, size_);
            nothing = open & looks_ & look.passes;
            open &= ~(looks_ & (look.passes | look.may_fold));
            along_v_ = look.along_v;
        }
        for (int step = 0; step < most_steps && bits(open); ++step) {
            Jets<N> jets;
            patches.evaluate(u, v, jets);
            V f[3], f_u[3], f_v[3];
            for (int axis = 0; axis < 3; ++axis) {  // w (S - origin), which is 0 across the ray at an intersection
                f[axis] = fma(-jets.x[3], origin_[axis], jets.x[axis]);
                f_u[axis] = fma(-jets.u[3], origin_[axis], jets.u[axis]);
                f_v[axis] = fma(-jets.v[3], origin_[axis], jets.v[axis]);
            }
            const V a = product(f, frame.across[0]), a_u = product(f_u, frame.across[0]), a_v = product(f_v, frame.across[0]);
            const V b = product(f, frame.across[1]), b_u = product(f_u, frame.across[1]), b_v = product(f_v, frame.across[1]);
            const V inverse = 1 / (a_u * b_v - a_v * b_u);
            const V d_u = (a_v * b - a * b_v) * inverse, d_v = (a * b_u - a_u * b) * inverse;
            u = open ? u + d_u : u, v = open ? v + d_v : v;
            const V x = magnitude((u - middle[0]) * inverse_size[0]), y = magnitude((v - middle[1]) * inverse_size[1]);
            const V size_u = magnitude(d_u * inverse_size[0]), size_v = magnitude(d_v * inverse_size[1]);
            open &= (size_u < 2) & (size_v < 2);  // NaN is unclear
            const V size = max(size_u, size_v);
            const I converged = size < close;
            // Steps shrink quickly in pieces: a root farther away than the last step is outside.
            const I decided = step > 0 ? I(converged | (size < half * last)) : converged;
            const V slack = converged ? broadcast<V>(overlap) : size + 0.1f;
            const V noise = rounding * frame.length * magnitude(inverse);
            const V noise_x = noise * (magnitude(a_v) + magnitude(b_v)) * inverse_size[0];
            const V noise_y = noise * (magnitude(a_u) + magnitude(b_u)) * inverse_size[1];
            const I outside = open & decided & ((x > half + slack + noise_x) | (y > half + slack + noise_y));
            const I done = open & converged & ~outside;
            if (bits(done)) {
                V last_f[3];
                for (int axis = 0; axis < 3; ++axis) last_f[axis] = fma(d_u, f_u[axis], fma(d_v, f_v[axis], f[axis]));
                const V w = fma(d_u, jets.u[3], fma(d_v, jets.v[3], jets.x[3]));
                t = done ? product(last_f, direction_) / (w * frame.length * frame.length) : t;
                const V off = max(magnitude(product(last_f, frame.across[0])), magnitude(product(last_f, frame.across[1])));
                I found = done & (off <= aside * frame.length * w);  // NaN is unclear
                if (bits(found & ((x > half) | (y > half)))) {
                    const V from_edge[2] = {max(x - half, V{}) * size_[0], max(y - half, V{}) * size_[1]};
                    const V reach = from_edge[0] * speed(f_u, jets.u[3], last_f, w) + from_edge[1] * speed(f_v, jets.v[3], last_f, w);
                    found &= reach <= beyond;
                }
                hit |= found;
            }
            nothing |= outside & ~looks_;  // after a test, a root outside does not exclude one inside
            open &= ~(outside | done);
            last = size;
        }
        at_[0] = u, at_[1] = v, t_ = t, hit_ = hit, nothing_ = nothing;
    }

    [[nodiscard]] Found found(int lane) const {
        return hit_[lane] ? Found::hit : nothing_[lane] ? Found::nothing : Found::unclear;
    }

    /// Whether a part still unclear after a test is better cut along v than along u.
    [[nodiscard]] bool cut_along_v(int lane) const { return along_v_[lane]; }

    /// The solution of a lane with a hit.
    [[nodiscard]] Solution solution(int lane) const {
        return {at_[0][lane], at_[1][lane], start_[lane] + static_cast<double>(t_[lane])};
    }

private:
    using V = Vector<N>;
    using I = IntVector<N>;

    static V magnitude(V a) { return (V)((I)a & INT32_MAX); }
    /// The length of a derivative of S, from the derivatives of w (S - origin) and w.
    static V speed(const V (&by_f)[3], V by_w, const V (&f)[3], V w) {
        V x[3];
        for (int axis = 0; axis < 3; ++axis) x[axis] = fma(-by_w / w, f[axis], by_f[axis]) / w;
        return sqrt(product(x, x));
    }

    static V product(const V (&a)[3], const V (&b)[3]) { return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2])); }

    // One value per lane; unused lanes repeat old values, and their results are ignored.
    V origin_[3]{}, direction_[3]{}, normal_[3]{}, low_[2]{}, size_[2]{}, at_[2]{}, t_{};
    I looks_{}, hit_{}, nothing_{}, along_v_{};
    double start_[N]{};
    std::uint32_t patch_[N]{};
    int count_ = 0;
};

}  // namespace bob::BOB_ISA
