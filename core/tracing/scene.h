/// Scenes as rays meet them: shapes of any kind, placed in the unit sphere, each with its material.
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

namespace bob {

struct Instance {
    std::shared_ptr<const Shape> shape;  // may be placed several times
    AffineMap to_shape;                  // from the scene's coordinates to the shape's own; not singular
    Vec3 low, high;                      // the box around the placed shape, in the scene's coordinates
    Material material;
    std::uint32_t number = 0;            // which it is for whoever made the scene
};

constexpr std::uint32_t no_instance = 0xffffffff;

/// Where a ray first meets a scene.
struct SceneHit {
    float t = std::numeric_limits<float>::infinity();
    std::uint32_t instance = no_instance;
    float start = 0;  // the t at which the ray was handed to the shape: t = start + in_shape.t, but for rounding
    Hit in_shape;
};

class Scene {
public:
    /// The instances lie within the unit sphere, or little beyond; their shapes are prepared.
    explicit Scene(std::vector<Instance> instances);

    /// The first intersection with t > 0 of each ray with any instance; where several instances lie at the same t, the
    /// first of them is seen. A ray's hit depends on that ray alone. Rays are finite, and should come in batches of
    /// `batch_size`.
    void closest_hits(std::span<const Ray> rays, std::span<SceneHit> hits) const;

    /// The shading normal at each hit: unit length, turned to the side that the ray came from; zero where a ray missed.
    void normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const;

    /// The same, and the colour of the shape's surface at each hit, linear RGB, without the material's; white where a ray missed.
    /// Each hit is seen through a pixel of that width, in lengths of its ray's direction.
    void normals_and_colors(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<const float> widths,
                            std::span<Vec3> normals, std::span<Vec3> colors) const;

    /// The surfaces' own normals at each hit, likewise, where shading has others.
    void face_normals(std::span<const Ray> rays, std::span<const SceneHit> hits, std::span<Vec3> normals) const;

    /// Whether any shape has colours of its own.
    [[nodiscard]] bool has_colored_shapes() const { return has_colored_shapes_; }
    /// Whether any surface is not white, so that pictures have colours.
    [[nodiscard]] bool is_colored() const;

    [[nodiscard]] std::size_t size() const { return instances_.size(); }
    [[nodiscard]] const Instance& operator[](std::uint32_t instance) const { return instances_[instance]; }

    /// A shape that is placed several times counts once.
    [[nodiscard]] std::size_t bytes() const;

private:
    std::vector<Instance> instances_;
    BoxBvh tree_;  // of the instances that are large enough to be seen
    bool has_colored_shapes_ = false;
};

/// How many of `count` rays to hand to a scene at once: many, for shapes that sort them, but some batches for each thread.
[[nodiscard]] std::size_t batch_size(std::size_t count);

}  // namespace bob
