/// Scenes for rays: shapes of any kind, placed in the unit sphere, each with its material.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/affine.h"
#include "shapes/boxes.h"
#include "shapes/shape.h"
#include "tracing/material.h"
#include "tracing/section.h"

namespace bob {

struct Instance {
    std::shared_ptr<const Shape> shape;  // may be placed several times
    AffineMap to_shape;                  // from the scene's coordinates to the shape's; not singular
    Vec3 low, high;                      // the box of the placed shape, in the scene's coordinates
    Material material;
    std::uint32_t number = 0;            // the index in the user's order
};

constexpr std::uint32_t no_instance = 0xffffffff;

/// The first intersection of a ray with a scene.
struct SceneHit {
    float t = std::numeric_limits<float>::infinity();
    std::uint32_t instance = no_instance;
    float start = 0;  // the ray's origin for the shape: t = start + in_shape.t, up to rounding
    Hit in_shape;  // on a cap, only the primitive
};

class Scene {
public:
    /// The instances lie within the unit sphere, or slightly beyond; their shapes are prepared.
    explicit Scene(std::vector<Instance> instances);

    /// The same scene, cut open by at most `max_sections` planes; the part behind all of them stays. Where a plane cuts
    /// a solid there is a cap, with the solid's material. Where solids overlap, the one with the smallest box is visible.
    [[nodiscard]] Scene sectioned(std::span<const SectionPlane> planes) const;
    [[nodiscard]] std::span<const SectionPlane> sections() const { return planes_; }
    /// The instances that a section shows without caps, since they enclose no solid.
    [[nodiscard]] std::vector<std::uint32_t> open_instances() const;

    /// The first intersection with t > 0 of each ray with any instance, or with the cap of a section.
    ///
    /// Of several instances at the same t, the first is visible. A ray's hit depends on that ray alone. Rays are
    /// finite, and should come in batches of `batch_size`.
    void closest_hits(std::span<const Ray> rays, std::span<SceneHit> hits) const;

    /// The shading normal at each hit: unit length, facing the ray's origin; zero for a miss.
    void normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const;

    /// The same, and the surface colour at each hit, linear RGB, without the material's; white for a miss. `widths` are pixel
    /// footprints, in lengths of the ray's direction.
    void normals_and_colors(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<const float> widths,
                            std::span<Vec3> normals, std::span<Vec3> colors) const;

    /// The geometric normals at each hit, with the same sign convention.
    void face_normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const;

    /// Whether any shape has colours, or a section hatching.
    [[nodiscard]] bool has_colored_shapes() const { return has_colored_shapes_ || !planes_.empty(); }
    /// Whether any surface is not white; then pictures have colours.
    [[nodiscard]] bool is_colored() const;

    /// The height of the lowest box of an instance; infinite in an empty scene.
    [[nodiscard]] float lowest() const { return lowest_; }

    [[nodiscard]] std::size_t size() const { return instances_.size(); }
    [[nodiscard]] const Instance& operator[](std::uint32_t instance) const { return instances_[instance]; }

    /// Shapes placed several times are included once.
    [[nodiscard]] std::size_t bytes() const;

private:
    struct Caps;

    /// As `closest_hits`, without sections. Finds hits before the given ones, and the caps of rays.
    void hits_before(std::span<const Ray> rays, std::span<SceneHit> hits, Caps* caps) const;
    void hits_in_sections(std::span<const Ray> rays, std::span<SceneHit> hits) const;
    /// The colours of caps with their hatching.
    void color_caps(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<const float> widths, std::span<Vec3> colors) const;

    std::vector<Instance> instances_;
    BoxBvh tree_;  // of the instances large enough to be visible
    bool has_colored_shapes_ = false;
    float lowest_ = std::numeric_limits<float>::infinity();
    std::vector<SectionPlane> planes_;
    std::vector<std::uint32_t> ranks_;    // of sections: by the size of the instances' boxes, smallest first
    std::vector<std::uint8_t> is_solid_;
};

/// Batch size for `count` rays: large, for shapes that sort rays, but with several batches for each thread.
[[nodiscard]] std::size_t batch_size(std::size_t count);

}  // namespace bob
