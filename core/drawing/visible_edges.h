/// Visible edges of a scene: borders of faces, creases and silhouettes.
#pragma once

#include <span>

#include "drawing/curves.h"
#include "picture/camera.h"
#include "tracing/scene.h"

namespace bob {

/// A smaller angle between the normals on both sides is no crease. Above 30 degrees, common chamfers would be lost;
/// below 20, scanned surfaces get lines from noise. Meshes whose normals are not given are smooth up to 40 degrees.
constexpr float crease_of_edges_degrees = 25;

/// Curves in the picture between first hits on different surfaces.
///
/// There is an edge where neighbouring rays meet different instances or faces (`Shape::face`), or one face with a step
/// in depth or a jump of the normal. First hits at pixel centres find edges, those at half pixels resolve them, and
/// bisection places them within 1/32 pixel. With `smooth` false, borders of faces that meet without a crease are left
/// out.
[[nodiscard]] Curves visible_edges(const Scene& scene, const Camera& camera, int height, int width, bool smooth = true);

/// Draws the strokes of visible edges in the rows from `begin` to `end` of a picture into `coverage`, (end - begin, width), 0..1, as
/// draw_strokes. Rows drawn apart fit together, but for differences of the curves within their tolerance.
void draw_visible_edges(const Scene& scene, const Camera& camera, int height, int width, int begin, int end, float width_of_stroke,
                        std::span<float> coverage);

}  // namespace bob
