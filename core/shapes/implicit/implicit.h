/// Implicit surfaces: where a formula of x, y and z changes its sign.
#pragma once

#include <atomic>
#include <optional>

#include "formula/expression.h"
#include "shapes/implicit/bounds.h"
#include "shapes/implicit/cells.h"
#include "shapes/implicit/painting.h"
#include "shapes/mesh/outline.h"
#include "shapes/shape.h"

namespace bob {

class Implicit : public Shape {
public:
    /// The surface of f within a box, whose centre becomes the origin and whose longest half side becomes 1; coloured by a formula
    /// if there is one. Throws Stopped if building its cells is interrupted.
    Implicit(const Expression& f, const Bounds& bounds, const ColorFormula* color = nullptr);

    [[nodiscard]] Bounds bounds(const AffineMap& map) const override;
    [[nodiscard]] double radius(const AffineMap& map, const double center[3]) const override;
    [[nodiscard]] double overshoot() const override { return 1e-6; }
    void prepare_places() const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const override;
    [[nodiscard]] bool is_colored() const override { return painting_.has_value(); }
    void colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float> widths,
                std::span<Vec3> colors) const override;
    /// The inside is where f is negative.
    [[nodiscard]] bool prepare_inside() const override { return true; }
    void starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const override;
    /// The colour formula's values inside the solid.
    void colors_inside(std::span<const Vec3> points, std::span<Vec3> colors) const override { this->colors(points, colors); }

    [[nodiscard]] std::size_t bytes() const override { return cells_.bytes() + (painting_ ? painting_->bytes() : 0); }

    /// Colours of a coloured shape: linear RGB, 0..1, at points in the coordinates of rays, on the surface or not.
    void colors(std::span<const Vec3> points, std::span<Vec3> colors) const;

    [[nodiscard]] const Cells& cells() const { return cells_; }

    /// How many rays so far passed a place where it could not be decided whether there is a surface, since it would
    /// turn back within 1e-6, or where f is too wild for bounds to close in on a root.
    [[nodiscard]] std::uint64_t unresolved_rays() const { return unresolved_rays_; }

private:
    /// The slope and the value of f just before each hit, or at it.
    struct Slope {
        Vec3 gradient;  // of length 1, or 0 if undefined
        float value;
    };
    template <class Use>
    void for_each_slope(std::span<const Ray> rays, std::span<const Hit> hits, Use use) const;

    Cells cells_;
    std::optional<Painting> painting_;
    mutable Outline outline_;
    mutable std::atomic<std::uint64_t> unresolved_rays_ = 0;
};

}  // namespace bob
