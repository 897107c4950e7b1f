#include "base/affine.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/vec3d.h"

namespace bob {
namespace {

/// Rotates two vectors in their plane until they are orthogonal; returns false if they already are.
bool make_orthogonal(Vec3d& p, Vec3d& q) {
    const double pp = dot(p, p), qq = dot(q, q), pq = dot(p, q);
    if (!(std::fabs(pq) > 1e-16 * std::sqrt(pp) * std::sqrt(qq))) return false;
    const double half = (qq - pp) / (2 * pq);
    const double tangent = std::copysign(1, half) / (std::fabs(half) + std::hypot(1, half));
    const double cosine = 1 / std::hypot(1, tangent), sine = cosine * tangent;
    for (std::size_t i = 0; i < 3; ++i) {
        const double a = p[i], b = q[i];
        p[i] = cosine * a - sine * b;
        q[i] = sine * a + cosine * b;
    }
    return true;
}

}  // namespace

AffineMap affine_map(const double* matrix) {
    AffineMap map;
    std::copy_n(matrix, 12, &map.row[0][0]);
    return map;
}

// With fused sums, so that small differences of large products keep their digits.
AffineMap operator*(const AffineMap& a, const AffineMap& b) {
    AffineMap result;
    for (int i = 0; i < 3; ++i) {
        const auto& r = a.row[i];
        for (int j = 0; j < 4; ++j) {
            const double sum = std::fma(r[2], b.row[2][j], std::fma(r[1], b.row[1][j], r[0] * b.row[0][j]));
            result.row[i][j] = j < 3 ? sum : sum + r[3];
        }
    }
    return result;
}

// Gaussian elimination with partial pivoting of A X = (I | -b).
AffineMap inverse(const AffineMap& map) {
    double a[3][3], x[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    for (int i = 0; i < 3; ++i) {
        std::copy_n(map.row[i], 3, a[i]);
        x[i][3] = -map.row[i][3];
    }
    for (int k = 0; k < 3; ++k) {
        int pivot = k;
        for (int i = k + 1; i < 3; ++i) {
            if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
        }
        std::swap(a[k], a[pivot]), std::swap(x[k], x[pivot]);
        for (int i = k + 1; i < 3; ++i) {
            const double factor = a[i][k] * (1 / a[k][k]);
            for (int j = k + 1; j < 3; ++j) a[i][j] -= factor * a[k][j];
            for (int j = 0; j < 4; ++j) x[i][j] -= factor * x[k][j];
        }
    }
    AffineMap result;
    for (int j = 0; j < 4; ++j) {
        for (int i = 2; i >= 0; --i) {
            double value = x[i][j];
            for (int k = 2; k > i; --k) value -= a[i][k] * result.row[k][j];
            result.row[i][j] = value * (1 / a[i][i]);
        }
    }
    return result;
}

// One-sided Jacobi rotations of the columns, in units of about the largest number, so that squares stay in range.
std::array<double, 3> singular_values(const AffineMap& map) {
    double largest = 0;
    for (const auto& row : map.row) largest = std::max({largest, std::fabs(row[0]), std::fabs(row[1]), std::fabs(row[2])});
    int exponent = 0;
    std::frexp(largest, &exponent);
    Vec3d columns[3];
    for (int i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) columns[j][static_cast<std::size_t>(i)] = std::ldexp(map.row[i][j], -exponent);
    }
    constexpr int max_sweeps = 30;  // about 5 are enough
    for (int sweep = 0; sweep < max_sweeps; ++sweep) {
        bool turned = false;
        for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) turned |= make_orthogonal(columns[i], columns[j]);
        if (!turned) break;
    }
    std::array<double, 3> result;
    for (std::size_t i = 0; i < 3; ++i) {
        result[i] = std::ldexp(std::hypot(columns[i][0], columns[i][1], columns[i][2]), exponent);
    }
    std::sort(result.begin(), result.end(), std::greater());
    return result;
}

AffineMap to_unit_sphere(const Sphere& sphere) {
    AffineMap map;
    for (int i = 0; i < 3; ++i) map.row[i][i] = 1 / sphere.radius, map.row[i][3] = -sphere.center[i] / sphere.radius;
    return map;
}

AffineMap from_unit_sphere(const Sphere& sphere) {
    AffineMap map;
    for (int i = 0; i < 3; ++i) map.row[i][i] = sphere.radius, map.row[i][3] = sphere.center[i];
    return map;
}

}  // namespace bob
