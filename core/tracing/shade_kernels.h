/// The inner loop of shading rows of a picture anew, one variant for each instruction set; all give the same bits. It reads and writes in
/// whole vectors, up to 15 numbers beyond the end.
#pragma once

#include <cstddef>

#include "base/isa.h"
#include "base/vec.h"
#include "picture/eye.h"

namespace bob {

/// Of Blinn and Phong's model, with a whole number as the shininess.
struct WholePhong {
    float ambient, diffuse, specular;
    unsigned shininess;
};

struct ShadeKernels {
    /// `BlinnPhong` of normals of a row, from its first column on; `light` is that of the camera's own axes.
    void (*blinn_phong)(const Eye& eye, const WholePhong& phong, Vec3 light, int row, int first, int count, const float* normal_x, const float* normal_y,
                        float* body, float* highlight);
};

BOB_DECLARE_KERNELS(ShadeKernels, shade_kernels)

}  // namespace bob
