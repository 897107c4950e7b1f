/// Curves in a picture, and their strokes as coverage of pixels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/chains.h"

namespace bob {

/// A place in a picture: pixel centres are integers.
struct PicturePoint {
    float row = 0, column = 0;
};

/// Polylines, one after the other. Closed ones end where they begin.
struct Curves {
    std::vector<PicturePoint> points;
    std::vector<std::int64_t> ends;  // of each curve, past its last point
};

using Segment = Link;

/// Segments between numbered points.
struct LineNetwork {
    std::vector<PicturePoint> points;
    std::vector<Segment> segments;
};

/// Sequences of point numbers, one after the other. Closed ones end where they begin.
struct Chains {
    std::vector<std::uint32_t> points;
    std::vector<std::int64_t> ends;  // of each chain, past its last point
};

/// Joins segments between `count` points to as few chains as possible: where more than two meet, in any way.
[[nodiscard]] Chains chained(std::size_t count, std::span<const Segment> segments);

/// Joins segments to curves, which end at points of any number of segments but two. Leaves out points within
/// `tolerance` of the line through their neighbours, in pixels.
[[nodiscard]] Curves joined(const LineNetwork& network, float tolerance);

/// The dashes of curves, with gaps between them, both in pixels and above 0. Each curve begins and ends with a dash.
[[nodiscard]] Curves dashed(std::span<const PicturePoint> points, std::span<const std::int64_t> ends, float dash, float gap);

/// Draws curves as strokes of a constant width in pixels into `coverage`, (height, width), 0..1: the maximum over the
/// strokes and the former value. So crossing and touching strokes do not add up.
void draw_strokes(std::span<const PicturePoint> points, std::span<const std::int64_t> ends, float width_of_stroke, int height, int width,
                  float* coverage);

}  // namespace bob
