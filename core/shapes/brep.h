/// Boundary representations: trimmed NURBS surfaces, traced as one shape.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "nurbs/nurbs.h"
#include "nurbs/trim.h"
#include "shapes/shape.h"

namespace bob {

struct Face {
    NurbsSurface surface;
    std::vector<TrimLoop> loops;  // none: all of the surface
};

class Brep : public Shape {
public:
    /// The faces' control points are about 1 in size; weights are above 0.
    explicit Brep(std::span<const Face> faces);
    ~Brep() override;

    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;
    [[nodiscard]] Place place(const Hit& hit) const override;
    [[nodiscard]] std::size_t bytes() const override;

    /// How many Bezier patches there are, and how many pieces they were cut into.
    [[nodiscard]] std::size_t patches() const;
    [[nodiscard]] std::size_t pieces() const;

    /// The largest value of a convex function over the faces, at most 1e-3 of its range too large.
    [[nodiscard]] double maximum(const std::function<double(Vec3)>& convex) const;
};

}  // namespace bob
