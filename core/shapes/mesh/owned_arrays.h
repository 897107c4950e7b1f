/// Arrays that live as long as the meshes that read them.
#pragma once

#include <memory>
#include <vector>

#include "shapes/mesh/mesh.h"

namespace bob {

/// The arrays of Mesh::Arrays, owned.
struct OwnedArrays {
    std::vector<Mesh::Point> vertices = {};
    std::vector<Triangle> triangles = {};
    std::vector<Vec3> normals = {}, colors = {}, face_colors = {};
    std::vector<Mesh::Uv> uv = {};
    std::shared_ptr<const Texture> texture = {};
    std::vector<float> alphas = {};
    float alpha_cutoff = 0;

    [[nodiscard]] static Mesh::Arrays of(const std::shared_ptr<const OwnedArrays>& own) {
        return {own->vertices,    own->triangles, own->normals, own,         own->colors,
                own->face_colors, own->uv,        own->texture, own->alphas, own->alpha_cutoff};
    }
};

}  // namespace bob
