/// Tubes: the volume swept by a ball of varying radius along a curve.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/bvh.h"
#include "base/once.h"
#include "nurbs/nurbs.h"
#include "shapes/edges.h"
#include "shapes/shape.h"
#include "shapes/tube/tube_pieces.h"

namespace bob {

/// A hit's primitive is the piece of the curve. Its u is the parameter 0..1 of the ball on that piece.
class Tube : public Shape {
public:
    /// The curve gives the ball's centre and radius, (x, y, z, r), about 1 in size, after normalisation from `sphere`.
    /// The radius r and the weights are above 0. The ends are round.
    explicit Tube(const NurbsCurve<4>& curve, const Sphere& sphere = {});
    Tube(Tube&&) = default;

    /// From control points of any size, not homogeneous but with weights, (x, y, z, r, w).
    [[nodiscard]] static Tube of_weighted_points(NurbsCurve<4> curve);

    [[nodiscard]] Bounds bounds(const AffineMap& map) const override;
    [[nodiscard]] double radius(const AffineMap& map, const double center[3]) const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;

    [[nodiscard]] bool prepare_inside() const override { return true; }
    void starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const override;

    /// The circles around the ends of the curve, across it, each with its centre as its only point: round ends have no edges.
    [[nodiscard]] const std::vector<ShapeEdge>* edges() const override;

    /// u is the parameter of the ball that was hit, v is 0.
    [[nodiscard]] Place place(const Hit& hit) const override;
    [[nodiscard]] std::size_t bytes() const override;

    /// Number of pieces of the curve.
    [[nodiscard]] std::size_t pieces() const { return pieces_.size(); }

    /// The maximum over the balls of a convex function f(centre, radius): too large by at most 1e-3 of its range.
    [[nodiscard]] double maximum(const std::function<double(Vec3, float)>& convex) const;

private:
    struct Parameters {
        double low, high;
    };

    /// Adds the pieces of a Bezier curve.
    void cut(const BezierCurve<4>& curve, int depth);
    [[nodiscard]] Vec3 normal(const Ray& ray, const Hit& hit) const;

    std::vector<TubePiece> pieces_;
    std::vector<Parameters> parameters_;  // of the pieces, on the curve
    std::vector<BvhNode> nodes_, packets_;
    mutable Once<std::vector<ShapeEdge>> edges_;
};

}  // namespace bob
