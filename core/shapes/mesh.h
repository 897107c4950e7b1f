/// Triangle meshes, ready to be traced.
#pragma once

#include <span>
#include <vector>

#include "shapes/normals.h"
#include "shapes/shape.h"
#include "shapes/triangles.h"
#include "vec.h"

namespace bob {

/// A hit's primitive is the triangle, its u and v the barycentric weights of the triangle's first and second corner.
class Mesh : public Shape {
public:
    /// `vertices` are finite and about 1 in size; `vertex_normals` is empty, or holds one normal for each vertex.
    Mesh(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::span<const Vec3> vertex_normals);

    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;

    [[nodiscard]] const TriangleBvh& bvh() const { return bvh_; }
    [[nodiscard]] std::size_t bytes() const override;

private:
    [[nodiscard]] Vec3 shading_normal(const Hit& hit, Vec3 ray_direction) const;

    std::vector<CornerNormals> normals_;
    std::vector<Vec3> face_normals_;
    TriangleBvh bvh_;
};

}  // namespace bob
