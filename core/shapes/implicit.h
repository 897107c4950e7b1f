/// Implicit surfaces: where a formula of x, y and z changes its sign.
#pragma once

#include <atomic>

#include "formula/expression.h"
#include "shapes/bounds.h"
#include "shapes/cells.h"
#include "shapes/outline.h"
#include "shapes/shape.h"

namespace bob {

class Implicit : public Shape {
public:
    /// The surface of f within a box, whose centre becomes the origin and whose longest half side becomes 1.
    /// Throws Stopped where building its cells shall not go on.
    Implicit(const Expression& f, const Bounds& bounds);

    [[nodiscard]] Bounds bounds(const AffineMap& map) const override;
    [[nodiscard]] double radius(const AffineMap& map, const double center[3]) const override;
    [[nodiscard]] double overshoot() const override { return 1e-6; }
    void prepare_places() const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;
    [[nodiscard]] std::size_t bytes() const override { return cells_.bytes(); }

    [[nodiscard]] const Cells& cells() const { return cells_; }

    /// How many rays so far passed a place where it could not be decided whether there is a surface, since it would
    /// turn back within 1e-6, or where f is too wild for bounds to close in on a root.
    [[nodiscard]] std::uint64_t unresolved_rays() const { return unresolved_rays_; }

private:
    Cells cells_;
    mutable Outline outline_;
    mutable std::atomic<std::uint64_t> unresolved_rays_ = 0;
};

}  // namespace bob
