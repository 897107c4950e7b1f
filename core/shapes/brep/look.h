/// Tests of rays against control points, several at a time. Only for *_kernels.cpp.
#pragma once

#include <limits>

#include "shapes/brep/patch_lanes.h"

namespace bob::BOB_ISA {

// Bound of rounding errors of points, in units.
constexpr float rounding = 2e-7f;

/// Two directions perpendicular to a ray's and to each other, of its length; for a ray, or one per lane.
///
/// Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
template <int N>
struct Frame {
    using V = Vector<N>;

    V across[2][3], length;

    explicit Frame(const V (&d)[3]) {
        length = sqrt(fma(d[0], d[0], fma(d[1], d[1], d[2] * d[2])));
        const V sign = d[2] < 0 ? -length : length;
        const V a = -1 / (sign + d[2]), b = d[0] * d[1] * a, inverse = 1 / length;
        across[0][0] = sign * fma(d[0] * d[0], a, sign) * inverse;
        across[0][1] = sign * b * inverse, across[0][2] = -sign * d[0] * inverse;
        across[1][0] = b, across[1][1] = fma(d[1] * d[1], a, sign), across[1][2] = -d[1];
    }
};

/// Bounds from the control points of a part of a patch for a ray; N of both.
template <int N>
struct Look {
    using V = Vector<N>;
    using I = IntVector<N>;

    I passes;    // the ray surely misses the part
    I may_fold;  // the ray may intersect it more than once
    I along_v;   // the patch bends more along v than along u

    /// The ray begins at `origin`, relative to the patches' centres; the part is thinnest along `normal`.
    Look(const PatchLanes<N>& patches, const V (&origin)[3], const Frame<N>& frame, const V (&direction)[3],
         const V (&normal)[3], const V (&low)[2], const V (&size)[2]) {
        // Seen along the ray, the part is narrow in the direction of the normal.
        const V product = normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2];
        const V along = product / (frame.length * frame.length);
        V side[3], across[2][3];
        for (int axis = 0; axis < 3; ++axis) side[axis] = fma(-along, direction[axis], normal[axis]);
        const V squares = side[0] * side[0] + side[1] * side[1] + side[2] * side[2];
        const V normals = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
        const I narrow = squares > 1e-6f * normals;
        const V scale = 1 / (narrow ? sqrt(squares) : frame.length);
        for (int axis = 0; axis < 3; ++axis) across[0][axis] = (narrow ? side[axis] : frame.across[0][axis]) * scale;
        const V per_length = 1 / frame.length;
        for (int axis = 0; axis < 3; ++axis) {
            const int next = (axis + 1) % 3, last = (axis + 2) % 3;
            across[1][axis] = (direction[next] * across[0][last] - direction[last] * across[0][next]) * per_length;
        }
        const int rows = patches.rows(), columns = patches.columns(), count = rows * columns;
        V net[(max_degree + 1) * (max_degree + 1)][2];
        for (int i = 0; i < count; ++i) {
            const auto& point = patches.point(i);
            V f[3];
            for (int axis = 0; axis < 3; ++axis) f[axis] = fma(-point[3], origin[axis], point[axis]);
            for (int k = 0; k < 2; ++k) net[i][k] = fma(f[0], across[k][0], fma(f[1], across[k][1], f[2] * across[k][2]));
        }
        cut(net, rows, columns, columns, 1, low[0], size[0]);
        cut(net, columns, rows, 1, columns, low[1], size[1]);

        const V infinity = broadcast<V>(std::numeric_limits<float>::infinity());
        V least[2] = {infinity, infinity}, most[2] = {-infinity, -infinity};
        V least_by[2][2], most_by[2][2];  // of the differences along u and v
        for (int along_v = 0; along_v < 2; ++along_v) {
            for (int k = 0; k < 2; ++k) least_by[along_v][k] = infinity, most_by[along_v][k] = -infinity;
        }
        for (int i = 0; i < count; ++i) {
            for (int k = 0; k < 2; ++k) {
                least[k] = min(net[i][k], least[k]), most[k] = max(net[i][k], most[k]);
                if (i >= columns) widen(least_by[0][k], most_by[0][k], net[i][k] - net[i - columns][k]);
                if (i % columns) widen(least_by[1][k], most_by[1][k], net[i][k] - net[i - 1][k]);
            }
        }
        const V slack = broadcast<V>(rounding);
        passes = (least[0] > slack) | (most[0] < -slack) | (least[1] > slack) | (most[1] < -slack);

        // The projection along the ray has a determinant of one sign for all derivatives in their boxes. Then the ray
        // intersects the part at most once (pieces_build.cpp explains why).
        V least_plus, most_plus, least_minus, most_minus;
        products(least_by[0][0], most_by[0][0], least_by[1][1], most_by[1][1], least_plus, most_plus);
        products(least_by[0][1], most_by[0][1], least_by[1][0], most_by[1][0], least_minus, most_minus);
        may_fold = ~((least_plus > most_minus) | (most_plus < least_minus));
        const auto bend = [&](int along_v) {
            return max(most_by[along_v][0] - least_by[along_v][0], most_by[along_v][1] - least_by[along_v][1]);
        };
        along_v = bend(1) > bend(0);

        // All control points are on one side of a line through the ray in the direction of u or v.
        for (int along_v = 0; along_v < 2; ++along_v) {
            const V x = least_by[along_v][0] + most_by[along_v][0], y = least_by[along_v][1] + most_by[along_v][1];
            V lowest = infinity, highest = -infinity;
            for (int i = 0; i < count; ++i) widen(lowest, highest, x * net[i][1] - y * net[i][0]);
            const V noise = slack * ((V)((I)x & INT32_MAX) + (V)((I)y & INT32_MAX));
            passes |= ~may_fold & ((lowest > noise) | (highest < -noise));
        }
    }

private:
    static void widen(V& low, V& high, V x) { low = min(x, low), high = max(x, high); }

    /// Bounds of the products of two numbers.
    static void products(V a_low, V a_high, V b_low, V b_high, V& low, V& high) {
        const V a = a_low * b_low, b = a_low * b_high, c = a_high * b_low, d = a_high * b_high;
        low = min(min(a, b), min(c, d)), high = max(max(a, b), max(c, d));
    }

    /// Reduces each line of `count` points, `step` apart, to the control points of its part from `low` on (de
    /// Casteljau).
    static void cut(V (*net)[2], int count, int lines, int step, int line_step, V low, V size) {
        const V high = low + size, below = low / high;
        for (int line = 0; line < lines; ++line) {
            for (int k = 0; k < 2; ++k) {
                V b[max_degree + 1];
                for (int i = 0; i < count; ++i) b[i] = net[line * line_step + i * step][k];
                for (int level = 1; level < count; ++level) {
                    for (int i = count - 1; i >= level; --i) b[i] = fma(high, b[i], (1 - high) * b[i - 1]);
                }
                for (int level = 1; level < count; ++level) {
                    for (int i = 0; i < count - level; ++i) b[i] = fma(below, b[i + 1], (1 - below) * b[i]);
                }
                for (int i = 0; i < count; ++i) net[line * line_step + i * step][k] = b[i];
            }
        }
    }
};

}  // namespace bob::BOB_ISA
