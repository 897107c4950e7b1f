#include "drawing/curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/interruption.h"

namespace bob {
namespace {

float squared_distance(PicturePoint p, PicturePoint a, PicturePoint b) {
    const float down = b.row - a.row, right = b.column - a.column;
    const float squared = down * down + right * right;
    const float along = squared > 0 ? std::clamp(((p.row - a.row) * down + (p.column - a.column) * right) / squared, 0.f, 1.f) : 0.f;
    const float y = p.row - a.row - along * down, x = p.column - a.column - along * right;
    return x * x + y * y;
}

/// Appends the points of Ramer, Douglas and Peucker's algorithm, without the first.
void append_simplified(std::span<const PicturePoint> curve, float tolerance, std::vector<PicturePoint>& to) {
    std::vector<std::pair<std::size_t, std::size_t>> left{{0, curve.size() - 1}};
    while (!left.empty()) {
        const auto [begin, end] = left.back();
        left.pop_back();
        std::size_t farthest = begin;
        float most = tolerance * tolerance;
        for (std::size_t i = begin + 1; i < end; ++i) {
            const float squared = squared_distance(curve[i], curve[begin], curve[end]);
            if (squared > most) most = squared, farthest = i;
        }
        if (farthest == begin) {
            to.push_back(curve[end]);
        } else {
            left.emplace_back(farthest, end);
            left.emplace_back(begin, farthest);
        }
    }
}

}  // namespace

Chains chained(std::size_t count, std::span<const Segment> segments) {
    const auto& [start, at] = Meetings(count, segments);
    std::vector<std::uint32_t> left(start.begin() + 1, start.end());  // past the last segment that may be unused
    std::vector<bool> used(segments.size());
    Chains chains;
    const auto walk = [&](std::uint32_t point) {
        const std::size_t first = chains.points.size();
        chains.points.push_back(point);
        for (;;) {
            while (left[point] > start[point] && used[at[left[point] - 1]]) --left[point];
            if (left[point] == start[point]) break;
            const std::uint32_t segment = at[--left[point]];
            used[segment] = true;
            const auto& [a, b] = segments[segment];
            point = a == point ? b : a;
            chains.points.push_back(point);
        }
        const bool any = chains.points.size() > first + 1;
        any ? chains.ends.push_back(static_cast<std::int64_t>(chains.points.size())) : chains.points.pop_back();
        return any;
    };
    for (const auto& [a, b] : segments) {  // open chains first
        for (const std::uint32_t point : {a, b}) {
            while ((start[point + 1] - start[point]) % 2 == 1 && walk(point)) {}
        }
    }
    for (const auto& [a, b] : segments) {
        while (walk(a)) {}
    }
    return chains;
}

Curves joined(const LineNetwork& network, float tolerance) {
    const Meetings meetings(network.points.size(), network.segments);
    Curves curves;
    std::vector<PicturePoint> walked;
    for_each_chain(meetings, network.segments, [&](std::uint32_t point) { return meetings.count(point) == 2; },
                   [&](std::span<const std::uint32_t> chain) {
        walked.clear();
        for (const std::uint32_t point : chain) walked.push_back(network.points[point]);
        curves.points.push_back(walked.front());
        append_simplified(walked, tolerance, curves.points);
        curves.ends.push_back(static_cast<std::int64_t>(curves.points.size()));
    });
    return curves;
}

Curves dashed(std::span<const PicturePoint> points, std::span<const std::int64_t> ends, float dash, float gap) {
    Curves curves;
    std::size_t begin = 0;
    for (const std::int64_t end : ends) {
        const auto curve = points.subspan(begin, static_cast<std::size_t>(end) - begin);
        begin = static_cast<std::size_t>(end);
        std::vector<float> along(curve.size(), 0.f);
        for (std::size_t i = 1; i < curve.size(); ++i) {
            along[i] = along[i - 1] + std::hypot(curve[i].row - curve[i - 1].row, curve[i].column - curve[i - 1].column);
        }
        if (curve.size() < 2 || !std::isfinite(along.back())) continue;
        // Stretched, so that a whole number of periods and a last dash fill the curve.
        const float periods = std::max(0.f, std::round((along.back() - dash) / (dash + gap)));
        const float stretch = along.back() / (periods * (dash + gap) + dash);
        std::size_t i = 1;
        const auto at = [&](float length) {
            while (i + 1 < curve.size() && along[i] < length) ++i;
            const float part = along[i] > along[i - 1] ? std::clamp((length - along[i - 1]) / (along[i] - along[i - 1]), 0.f, 1.f) : 0.f;
            return PicturePoint{curve[i - 1].row + part * (curve[i].row - curve[i - 1].row),
                                curve[i - 1].column + part * (curve[i].column - curve[i - 1].column)};
        };
        for (float n = 0; n <= periods; ++n) {
            const float from = n * (dash + gap) * stretch, to = from + dash * stretch;
            curves.points.push_back(at(from));
            for (std::size_t j = i; j < curve.size() && along[j] < to; ++j) {
                if (along[j] > from) curves.points.push_back(curve[j]);
            }
            curves.points.push_back(at(to));
            curves.ends.push_back(static_cast<std::int64_t>(curves.points.size()));
        }
    }
    return curves;
}

void draw_strokes(std::span<const PicturePoint> points, std::span<const std::int64_t> ends, float width_of_stroke, int height, int width,
                  float* coverage) {
    const float half = 0.5f * width_of_stroke, reach = half + 0.5f;
    // The share of a pixel across a line at a distance: exact for lines along rows and columns.
    const auto covered = [=](float distance) { return std::clamp(std::min(0.5f, distance + half) - std::max(-0.5f, distance - half), 0.f, 1.f); };
    const auto draw = [&](PicturePoint a, PicturePoint b) {
        const auto low = [=](float p, float q) { return static_cast<int>(std::ceil(std::max(std::min(p, q) - reach, 0.f))); };
        const auto high = [=](float p, float q, int size) {
            return static_cast<int>(std::floor(std::min(std::max(p, q) + reach, static_cast<float>(size - 1))));
        };
        const int top = low(a.row, b.row), bottom = high(a.row, b.row, height);
        const float down = b.row - a.row, right = b.column - a.column;
        for (int row = top; row <= bottom; ++row) {
            // Only the columns that the stroke reaches in this row.
            const auto y = static_cast<float>(row);
            float from = std::min(a.column, b.column), to = std::max(a.column, b.column);
            if (std::abs(down) > 1e-6f) {
                const float t = std::clamp((y - reach - a.row) / down, 0.f, 1.f), u = std::clamp((y + reach - a.row) / down, 0.f, 1.f);
                from = std::min(a.column + t * right, a.column + u * right), to = std::max(a.column + t * right, a.column + u * right);
            }
            const int last = high(to, to, width);
            for (int column = low(from, from); column <= last; ++column) {
                const float distance = std::sqrt(squared_distance({y, static_cast<float>(column)}, a, b));
                if (distance >= reach) continue;
                float& value = coverage[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
                value = std::max(value, covered(distance));
            }
        }
    };
    std::size_t begin = 0;
    for (const std::int64_t end : ends) {
        Interruption::check();
        for (std::size_t i = begin; i + 1 < static_cast<std::size_t>(end); ++i) draw(points[i], points[i + 1]);
        begin = static_cast<std::size_t>(end);
    }
}

}  // namespace bob
