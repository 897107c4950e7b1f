/// Edges as lines, and snapping to them, in the WebAssembly modules of all shapes and of meshes with lights.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "drawing/visible_edges.h"
#include "tracing/snapping.h"
#include "wasm.h"

namespace {

void write_levels(std::span<const float> coverage, std::uint8_t* covered) {
    for (std::size_t i = 0; i < coverage.size(); ++i) covered[i] = static_cast<std::uint8_t>(255 * coverage[i] + 0.5f);
}

}  // namespace

/// Writes the share of each pixel that visible edges cover, 0..255, for the rows from `begin` to `end` of a picture.
EXPORT(draw_edges)
bool draw_edges(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, std::int32_t begin, std::int32_t end,
                float width_of_stroke, std::uint8_t* covered) {
    return attempt([&] {
        std::vector<float> coverage(static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(width));
        bob::draw_visible_edges(*scene, camera_of(camera), height, width, begin, end, width_of_stroke, coverage);
        write_levels(coverage, covered);
        return true;
    });
}

/// Writes the same for a whole picture, from first hits `step` pixels apart.
EXPORT(draw_coarse_edges)
bool draw_coarse_edges(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, std::int32_t step, float width_of_stroke,
                       std::uint8_t* covered) {
    return attempt([&] {
        std::vector<float> coverage(static_cast<std::size_t>(height) * static_cast<std::size_t>(width));
        bob::draw_coarse_edges(*scene, camera_of(camera), height, width, step, width_of_stroke, coverage);
        write_levels(coverage, covered);
        return true;
    });
}

/// Finds the corner, centre, middle or edge within `reach` pixels of a place. Writes 7 numbers: the kind as bob::SnapKind, or -1; the
/// circle's radius, or NaN; the point in the unit sphere; row and column where the surface next to it is visible.
EXPORT(snap)
bool snap(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, float row, float column, float reach, double* found) {
    return attempt([&] {
        std::fill_n(found, 7, -1.);
        if (const auto snapped = bob::snap(*scene, camera_of(camera), height, width, row, column, reach)) {
            found[0] = static_cast<double>(snapped->kind), found[1] = snapped->radius.value_or(std::numeric_limits<double>::quiet_NaN());
            std::copy_n(snapped->point.data(), 3, found + 2);
            found[5] = double{snapped->row}, found[6] = double{snapped->column};
        }
        return true;
    });
}
