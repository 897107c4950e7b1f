/// Boundary representations: trimmed NURBS surfaces, traced as one shape.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/once.h"
#include "nurbs/nurbs.h"
#include "nurbs/trim.h"
#include "shapes/brep/pieces.h"
#include "shapes/edges.h"
#include "shapes/solid.h"

namespace bob {

struct Face {
    NurbsSurface surface;
    std::vector<TrimLoop> loops;  // empty: the whole surface
    std::optional<Vec3> color = std::nullopt;  // linear RGB, 0..1; white if absent
    std::optional<std::uint32_t> number = std::nullopt;  // equal for pieces of one face; if absent, that in the brep
};

/// Multiplies control points by their weights, after they are moved and scaled from `sphere` to the unit sphere.
void make_homogeneous(Face& face, const Sphere& sphere = {});

class Brep : public SurfaceShape {
public:
    /// The faces' control points are about 1 in size, after normalisation from `sphere`; weights are above 0. Trimmed
    /// faces extend about `tolerance` past their trims where no other face is near: this closes gaps between edges that
    /// agree only to the tolerance.
    explicit Brep(std::span<const Face> faces, double tolerance = 0, const Sphere& sphere = {});
    Brep(Brep&&) = default;  // not copyable: pieces point to regions

    /// From control points of any size, not homogeneous but with weights, (x, y, z, w) and, for trims, (u, v, w). A
    /// single face ends at its trims for any tolerance. Throws std::invalid_argument if the trims leave nothing.
    [[nodiscard]] static Brep of_weighted_points(std::vector<Face> faces, double tolerance);

    [[nodiscard]] Bounds bounds(const AffineMap& map) const override;
    [[nodiscard]] double radius(const AffineMap& map, const double center[3]) const override;
    [[nodiscard]] double overshoot() const override { return 2e-3; }
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;

    /// Whether any face has a colour.
    [[nodiscard]] bool is_colored() const override { return !colors_.empty(); }
    void colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float> widths,
                std::span<Vec3> colors) const override;

    void starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const override;

    /// The face, and its parameters.
    [[nodiscard]] Place place(const Hit& hit) const override;
    [[nodiscard]] std::uint32_t face(const Hit& hit) const override { return numbers_[pieces_.patches[hit.primitive].face]; }
    /// Borders of faces, each once, without seams between pieces of one face.
    [[nodiscard]] const std::vector<ShapeEdge>* edges() const override;
    [[nodiscard]] std::size_t bytes() const override;

    [[nodiscard]] const Pieces& pieces() const { return pieces_; }

    /// The area of faces, and the volume that they enclose if they are closed; in the coordinates of rays.
    struct Amount {
        double area = 0;
        std::optional<double> volume;
    };
    [[nodiscard]] Amount amount(std::size_t begin, std::size_t end) const;

    /// The maximum of a convex function over the faces, at most `tolerance` too large; -inf if the trims leave nothing.
    [[nodiscard]] double maximum(const std::function<double(Vec3)>& convex, double tolerance) const;

private:
    /// Caches the parts of patches visited.
    class Search {
    public:
        Search();
        Search(Search&&) noexcept;
        ~Search();

        [[nodiscard]] double maximum(const Pieces& pieces, const std::function<double(Vec3)>& convex, double tolerance) const;

    private:
        struct SubPatch;
        struct Kept;

        std::unique_ptr<Kept> kept_;
    };

    [[nodiscard]] Solid find_solid() const override;
    /// Each face is a part; dS/du x dS/dv points out of its front.
    void sides(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> sides) const override;
    /// 1 if dS/du x dS/dv leads out of the solid at a point of a face, -1 if into it; 0 if both sides are inside or both outside.
    [[nodiscard]] double outward(std::size_t face, const std::array<double, 2>& inside) const;
    /// Whether first hits tell that rays start inside, 1, or outside, -1. 0 beyond trims and where a face is edge-on.
    void vote(std::span<const Ray> rays, std::span<const Hit> hits, std::span<int> votes) const;

    std::vector<Face> faces_;
    std::vector<std::unique_ptr<const TrimRegion>> regions_;
    Pieces pieces_;
    Search search_;
    std::vector<Vec3> colors_;  // of the faces, if any has one
    std::vector<std::uint32_t> numbers_;  // of the faces
    double tolerance_;
    mutable Once<std::vector<ShapeEdge>> edges_;
};

}  // namespace bob
