#include "completion/guided_surfaces.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace bob {
namespace {

/// The change of depth along an axis, from the differences to the pixels before and after: the lesser, as the other may be across an edge.
float lesser(float before, float after) { return std::abs(before) < std::abs(after) ? before : after; }

}  // namespace

GuidedSurfaces::GuidedSurfaces(int height, int width)
    : height_(height), width_(width), stride_((static_cast<std::size_t>(width) + row_multiple - 1) / row_multiple * row_multiple),
      values_(aligned_floats(count * stride_ * static_cast<std::size_t>(height))) {}

GuidedSurfaces::GuidedSurfaces(const Layout& layout, const float* guides, int height, int width) : GuidedSurfaces(height, width) {
    const auto columns = static_cast<std::size_t>(width);
    const std::size_t pixels = static_cast<std::size_t>(height) * columns;
    const auto given = [&](const Channel& channel, int component = 0) {
        return guides + static_cast<std::size_t>(layout.place_of(channel) + component) * pixels;
    };
    const float *const mask = given(channels::mask), *const nearness = given(channels::depth);
    const float *const x = given(channels::normal), *const y = given(channels::normal, 1), *const albedo = given(channels::albedo);
    float deepest = 0;
    for (std::size_t i = 0; i < pixels; ++i) deepest = std::max(deepest, std::abs(nearness[i]));
    const float unit = deepest > 0 ? 1 / deepest : 0;
    for_rows(0, height, width, [&](int line) {
        const std::size_t first = static_cast<std::size_t>(line) * columns;
        const float* const here = nearness + first;
        const float *const above = line > 0 ? here - width : nullptr, *const below = line + 1 < height ? here + width : nullptr;
        const auto fill = [&](Plane plane, auto of) {
            float* const to = row(plane, line);
            for (std::size_t c = 0; c < columns; ++c) to[c] = of(c);
            std::fill(to + columns, to + stride_, to[columns - 1]);
        };
        fill(depth, [=](std::size_t c) { return unit * here[c]; });
        float* const right = row(depth_right, line);
        if (width == 1) std::fill_n(right, stride_, 0.f);
        if (width > 1) {
            fill(depth_right, [=](std::size_t c) {
                const std::size_t before = c - (c > 0), after = c + (c + 1 < columns);
                return lesser(unit * (here[before + 1] - here[before]), unit * (here[after] - here[after - 1]));
            });
        }
        if (above && below) fill(depth_down, [=](std::size_t c) { return lesser(unit * (here[c] - above[c]), unit * (below[c] - here[c])); });
        else if (above) fill(depth_down, [=](std::size_t c) { return unit * (here[c] - above[c]); });
        else if (below) fill(depth_down, [=](std::size_t c) { return unit * (below[c] - here[c]); });
        else std::fill_n(row(depth_down, line), stride_, 0.f);
        fill(normal_x, [=](std::size_t c) { return x[first + c]; }), fill(normal_y, [=](std::size_t c) { return y[first + c]; });
        fill(normal_z, [=](std::size_t c) { return mask[first + c] * whole_normal(x[first + c], y[first + c]).z; });
        for (int k = 0; k < 3; ++k) {
            fill(static_cast<Plane>(red + k), [=](std::size_t c) { return albedo[static_cast<std::size_t>(k) * pixels + first + c]; });
        }
        fill(coverage, [=](std::size_t c) { return mask[first + c]; });
    });
}

GuidedSurfaces::GuidedSurfaces(const float* covered, int height, int width) : GuidedSurfaces(height, width) {
    for_rows(0, height, width, [&](int line) {
        const float* const from = covered + static_cast<std::size_t>(line) * static_cast<std::size_t>(width);
        for (const Plane plane : {red, green, blue, coverage}) std::copy_n(from, width, row(plane, line));
    });
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
