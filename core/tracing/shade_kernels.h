/// Inner loop of deferred shading, one variant for each instruction set, with identical results to the bit. Reads and
/// writes whole vectors, up to 15 numbers past the end.
#pragma once

#include <cstddef>

#include "base/isa.h"
#include "base/vec.h"
#include "picture/eye.h"

namespace bob {

/// Blinn-Phong with an integer shininess.
struct WholePhong {
    float ambient, diffuse, specular;
    unsigned shininess;
};

struct ShadeKernels {
    /// `BlinnPhong` for the normals of a row, from its first column on; `light` is in the camera's axes.
    void (*blinn_phong)(const Eye& eye, const WholePhong& phong, Vec3 light, int row, int first, int count, const float* normal_x, const float* normal_y,
                        float* body, float* highlight);
};

BOB_DECLARE_KERNELS(ShadeKernels, shade_kernels)

}  // namespace bob
