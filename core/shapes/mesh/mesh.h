/// Triangle meshes.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/mutex.h"
#include "base/once.h"
#include "base/vec.h"
#include "shapes/mesh/normals.h"
#include "shapes/mesh/outline.h"
#include "shapes/mesh/texture.h"
#include "shapes/mesh/triangles.h"
#include "shapes/edges.h"
#include "shapes/solid.h"

namespace bob {

/// A hit's primitive is the triangle. Its u and v are the barycentric weights of the triangle's first and second corner.
class Mesh : public SurfaceShape {
public:
    using Point = std::array<double, 3>;
    using Uv = std::array<float, 2>;

    /// The texture coordinates of a triangle's corners, and the number of texels along a length of 1.
    struct OnTexture {
        std::array<Uv, 3> corner;
        float texels;
    };

    /// The user's data, not copied. It is read until `prepare` is done, and by `bounds`, `radius` and `prepare_inside`.
    struct Arrays {
        std::span<const Point> vertices;
        std::span<const Triangle> triangles;  // at least one, of vertex indices
        std::span<const Vec3> normals;        // per vertex, or empty
        std::shared_ptr<const void> owner;    // keeps the arrays alive, if necessary
        std::span<const Vec3> colors = {};    // linear RGB per vertex, or empty
        std::span<const Vec3> face_colors = {};  // the same per triangle
        std::span<const Uv> uv = {};             // per vertex, or empty; 0, 0 at the texture's top left
        std::shared_ptr<const Texture> texture = {};
        std::span<const float> alphas = {};  // opacity per vertex, 0..1, or empty
        float alpha_cutoff = 0;              // there is no surface where the texture's alpha times the vertices' is below it
    };

    /// Normalised in double precision to the unit sphere, from `sphere`. If omitted, that is the sphere around the used
    /// vertices, about the centre of their box.
    explicit Mesh(Arrays arrays, const std::optional<Sphere>& sphere = std::nullopt);

    [[nodiscard]] Bounds bounds(const AffineMap& map) const override;
    [[nodiscard]] double radius(const AffineMap& map, const double center[3]) const override;

    [[nodiscard]] double overshoot() const override { return 1e-6; }
    void prepare_places() const override;

    /// Builds the hierarchy and the normals, which is slow.
    void prepare() const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;

    void face_normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;

    /// The product of all given colours: texture, vertices, faces.
    [[nodiscard]] bool is_colored() const override { return !arrays_.colors.empty() || !arrays_.face_colors.empty() || arrays_.texture; }
    void colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float> widths,
                std::span<Vec3> colors) const override;

    [[nodiscard]] const Arrays& arrays() const { return arrays_; }

    /// Edges where the shading normal jumps, and open borders. Not virtual: small pages leave them out.
    [[nodiscard]] const std::vector<ShapeEdge>& creases() const;

    /// The unit normals at the triangles' corners, which shading interpolates.
    [[nodiscard]] std::vector<CornerNormals> corner_normals() const;

    /// 0 until `prepare` was called.
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] const Picture* picture() const override { return arrays_.texture ? &arrays_.texture->picture() : nullptr; }
    [[nodiscard]] std::size_t bvh_bytes() const;

private:
    struct Prepared {
        std::vector<CornerNormals> normals;
        std::vector<Vec3> face_normals;
        TriangleBvh bvh;
        // The given colours of each triangle, or empty.
        std::vector<std::array<Vec3, 3>> corner_colors;
        std::vector<Vec3> face_colors;
        std::vector<OnTexture> on_texture;
        std::unique_ptr<const Holes> holes;
    };

    [[nodiscard]] Solid find_solid() const override;
    /// Each triangle is a part.
    void sides(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> sides) const override;
    [[nodiscard]] std::vector<Vec3> in_unit_sphere() const;
    [[nodiscard]] std::vector<CornerNormals> corner_normals(std::span<const Vec3> points, std::span<const Vec3> face) const;
    void prepare_colors(const std::vector<Vec3>& points, Prepared& prepared) const;
    void prepare_holes(Prepared& prepared) const;

    /// Box and sphere of the used, untransformed vertices, computed once: most scenes place a mesh without a transform.
    struct Extent {
        Bounds bounds;
        Sphere around;  // about the centre of their box

        Extent(const Arrays& arrays, const std::vector<bool>& used);
        [[nodiscard]] Sphere sphere() const {
            Sphere result = around;
            if (!(around.radius > smallest_radius)) result.radius = Sphere{}.radius;
            return result;
        }
    };

    Mesh(const Arrays& arrays, std::vector<bool> used, const std::optional<Sphere>& sphere);
    Mesh(const Arrays& arrays, std::vector<bool> used, const Extent& extent, const std::optional<Sphere>& sphere);

    [[nodiscard]] Vec3 shading_normal(const Hit& hit, Vec3 ray_direction) const;

    Arrays arrays_;
    std::vector<bool> used_;  // whether a triangle has a vertex; empty if all are used
    Extent extent_;
    mutable Outline outline_;
    mutable Mutex preparing_;
    mutable std::unique_ptr<const Prepared> prepared_;
    mutable Once<std::vector<ShapeEdge>> edges_;
};

}  // namespace bob
