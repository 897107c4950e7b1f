#include "shapes/mesh.h"

namespace bob {

Mesh::Mesh(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::span<const Vec3> vertex_normals)
    : normals_(vertex_normals.empty() ? crease_normals(vertices, triangles)
                                      : stored_normals(vertices, triangles, vertex_normals)),
      face_normals_(triangles.size()),
      bvh_(build_triangle_bvh(vertices, triangles)) {
    for (std::size_t i = 0; i < triangles.size(); ++i) face_normals_[i] = face_normal(vertices, triangles[i]);
}

void Mesh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    best_triangle_kernels().closest_hits(bvh_.nodes.data(), bvh_.packets.data(), rays.data(), rays.size(), hits.data());
}

void Mesh::normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const {
    for (std::size_t i = 0; i < hits.size(); ++i) normals[i] = shading_normal(hits[i], rays[i].direction);
}

Vec3 Mesh::shading_normal(const Hit& hit, Vec3 ray_direction) const {
    const CornerNormals& corner = normals_[hit.primitive];
    const Vec3 smooth = normalized(hit.u * corner[0] + hit.v * corner[1] + (1 - hit.u - hit.v) * corner[2]);
    const Vec3 face = face_normals_[hit.primitive];
    // Files disagree on which side is out, and open meshes show both: only the side that was hit counts.
    const Vec3 facing = dot(face, ray_direction) > 0 ? -face : face;
    if (dot(smooth, smooth) == 0) return facing;
    return dot(smooth, facing) < 0 ? -smooth : smooth;
}

std::size_t Mesh::bytes() const {
    return bvh_.bytes() + normals_.size() * sizeof(CornerNormals) + face_normals_.size() * sizeof(Vec3);
}

}  // namespace bob
