#include "tracing/shade_kernels.h"

#include "base/vec_lanes.h"

namespace bob::BOB_ISA {
namespace {

/// The light in the screen space of a vector of columns, as `Projection::turned`.
inline Vector3 light_at(const Eye& eye, const Vector3& light, float row, F column) {
    const F across = (column - constant(eye.middle_column)) / constant(eye.pixels_per_radius);
    const F above = constant((eye.middle_row - row) / eye.pixels_per_radius);
    const F scale = constant(1) / sqrt(constant(1) + across * across + above * above);
    const Vector3 to_eye{-across * scale, -above * scale, scale};
    const F along = dot(light, to_eye), k = (light.z + along) / (constant(1) + to_eye.z);
    return {light.x - k * to_eye.x, light.y - k * to_eye.y, along};
}

inline F power(F base, unsigned exponent) {
    F result = constant(1);
    for (; exponent; exponent >>= 1, base *= base) {
        if (exponent & 1) result *= base;
    }
    return result;
}

void blinn_phong(const Eye& eye, const WholePhong& phong, Vec3 light, int row, int first, int count, const float* normal_x, const float* normal_y,
                 float* body, float* highlight) {
    const Vector3 straight{constant(light.x), constant(light.y), constant(light.z)};
    M columns;
    for (int k = 0; k < lanes; ++k) columns[k] = first + k;
    for (int i = 0; i < count; i += lanes, columns += all(lanes)) {
        const Vector3 toward_light = eye.in_perspective ? light_at(eye, straight, static_cast<float>(row), to_floats(columns)) : straight;
        Vector3 half{toward_light.x, toward_light.y, toward_light.z + constant(1)};
        const F scale = constant(1) / sqrt(dot(half, half));
        half = {half.x * scale, half.y * scale, half.z * scale};
        Vector3 normal{load<F>(normal_x + i), load<F>(normal_y + i), F{}};
        normal.z = sqrt(max(constant(1) - normal.x * normal.x - normal.y * normal.y, F{}));
        store(body + i, constant(phong.ambient) + constant(phong.diffuse) * max(dot(normal, toward_light), F{}));
        store(highlight + i, constant(phong.specular) * power(max(dot(normal, half), F{}), phong.shininess));
    }
}

}  // namespace

const ShadeKernels shade_kernels = {blinn_phong};

}  // namespace bob::BOB_ISA
