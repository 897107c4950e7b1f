/// Visible edges of a scene: borders of faces, creases and silhouettes.
#pragma once

#include <span>

#include "drawing/curves.h"
#include "picture/camera.h"
#include "tracing/scene.h"

namespace bob {

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

/// Draws the same of a whole picture from first hits `step` pixels apart, in much less time, without edges of things that are smaller than
/// that. Strokes keep their width, and are within step / 32 pixels of their place but for corners.
void draw_coarse_edges(const Scene& scene, const Camera& camera, int height, int width, int step, float width_of_stroke, std::span<float> coverage);

}  // namespace bob
