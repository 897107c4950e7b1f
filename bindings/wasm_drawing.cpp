/// Edges in the WebAssembly modules that have shapes of all kinds.
#include <cstdint>
#include <vector>

#include "drawing/visible_edges.h"
#include "wasm.h"

/// Writes the share of each pixel that visible edges cover, 0..255, for the rows from `begin` to `end` of a picture.
EXPORT(draw_edges)
bool draw_edges(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, std::int32_t begin, std::int32_t end,
                float width_of_stroke, std::uint8_t* covered) {
    return attempt([&] {
        std::vector<float> coverage(static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(width));
        bob::draw_visible_edges(*scene, camera_of(camera), height, width, begin, end, width_of_stroke, coverage);
        for (std::size_t i = 0; i < coverage.size(); ++i) covered[i] = static_cast<std::uint8_t>(255 * coverage[i] + 0.5f);
        return true;
    });
}
