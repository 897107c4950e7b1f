#include "completion/guided_surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/color.h"
#include "base/parallel.h"

namespace bob {
namespace {

/// Minimum divisor when light is demodulated.
constexpr float least_albedo = 0.02f;

/// How depth changes along an axis, by the differences to the pixels before and after: the lesser, as the other may be across
/// an edge. Beyond the picture they are infinite.
float lesser(float before, float after) {
    const float slope = std::abs(before) < std::abs(after) ? before : after;
    return std::isfinite(slope) ? slope : 0;
}

}  // namespace

GuidedSurfaces::GuidedSurfaces(const Layout& layout, const float* guides, int height, int width)
    : height_(height), width_(width), stride_((static_cast<std::size_t>(width) + row_multiple - 1) / row_multiple * row_multiple),
      values_(aligned_floats(count * stride_ * static_cast<std::size_t>(height))) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const auto given = [&](const Channel& channel, int component = 0) {
        return guides + static_cast<std::size_t>(layout.place_of(channel) + component) * pixels;
    };
    const float *const mask = given(channels::mask), *const nearness = given(channels::depth);
    const float *const x = given(channels::normal), *const y = given(channels::normal, 1), *const albedo = given(channels::albedo);
    float deepest = 0;
    for (std::size_t i = 0; i < pixels; ++i) deepest = std::max(deepest, std::abs(nearness[i]));
    const float unit = deepest > 0 ? 1 / deepest : 0;
    for_rows(0, height, width, [&](int line) {
        const std::size_t first = static_cast<std::size_t>(line) * static_cast<std::size_t>(width);
        // Differences of depth to the pixel at an offset in memory, if that is in the picture.
        const auto step = [&](bool inside, std::size_t from, std::size_t to) {
            return inside ? unit * (nearness[to] - nearness[from]) : std::numeric_limits<float>::infinity();
        };
        const std::size_t below = static_cast<std::size_t>(width);
        for (std::size_t column = 0; column < stride_; ++column) {
            const int c = std::min(static_cast<int>(column), width - 1);
            const std::size_t i = first + static_cast<std::size_t>(c);
            const auto put = [&](Plane plane, float value) { row(plane, line)[column] = value; };
            put(depth, unit * nearness[i]);
            put(depth_right, lesser(step(c > 0, i - 1, i), step(c + 1 < width, i, i + 1)));
            put(depth_down, lesser(step(line > 0, i - below, i), step(line + 1 < height, i, i + below)));
            put(normal_x, x[i]), put(normal_y, y[i]);
            put(normal_z, mask[i] * whole_normal(x[i], y[i]).z);
            put(red, albedo[i]), put(green, albedo[pixels + i]), put(blue, albedo[2 * pixels + i]);
            put(coverage, mask[i]);
        }
    });
}

float GuidedSurfaces::divisor(int components, int component, int y, int x) const {
    const float rgb[] = {row(red, y)[x], row(green, y)[x], row(blue, y)[x]};
    return std::max(least_albedo, components == 3 ? rgb[component] : luminance({rgb[0], rgb[1], rgb[2]}));
}

float GuidedSurfaces::likeness(Pixel own, Pixel other) const {
    const auto here = [&](Plane plane) { return row(plane, own.row)[own.column]; };
    const auto differs = [&](Plane plane) { return row(plane, other.row)[other.column] - here(plane); };
    const float right = static_cast<float>(other.column - own.column), down = static_cast<float>(other.row - own.row);
    const float tilt[] = {differs(normal_x), differs(normal_y), differs(normal_z)}, tint[] = {differs(red), differs(green), differs(blue)};
    const float off_plane = differs(depth) - (here(depth_right) * right + here(depth_down) * down);
    const float tolerance = depth_tolerance(guided_likeness, std::abs(here(depth_right)), std::abs(here(depth_down)));
    const auto fma = [](float a, float b, float c) { return a * b + c; };
    return likeness_of(unlikeness(guided_likeness, tilt, off_plane, 1 / (tolerance * tolerance), right * right + down * down, tint,
                                  differs(coverage), fma));
}

}  // namespace bob
