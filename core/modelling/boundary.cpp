#include "modelling/boundary.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include "base/interruption.h"
#include "modelling/arcs.h"

namespace bob {
namespace {

/// Distance below which places are equal, relative to the extent of all loops.
constexpr double same_place = 1e-9;

/// Distance from the common end of consecutive segments, relative to their length. Crossings within it are ignored:
/// crossings of arcs with a common tangent have only half of the digits.
constexpr double near_common_end = 1e-4;

/// Outlines with more crossings make formulas that are too large.
constexpr std::size_t most_cuts = 1 << 18;

/// Segments in rows by height, to find those near a point or near each other.
class Rows {
public:
    Rows(std::span<const Segment> segments, double margin) : segments_(segments) {
        for (const Segment& segment : segments) boxes_.emplace_back().add(segment);
        Extent all;
        for (Extent& box : boxes_) {
            for (std::size_t i = 0; i < 2; ++i) box.low[i] -= margin, box.high[i] += margin;
            all.add(box.low), all.add(box.high);
        }
        low_ = all.low[1];
        rows_.resize(1 + static_cast<std::size_t>(std::sqrt(static_cast<double>(segments.size()))));
        scale_ = static_cast<double>(rows_.size()) / std::max(all.high[1] - all.low[1], 1e-300);
        for (std::uint32_t i = 0; i < segments.size(); ++i) {
            for (std::size_t row = row_of(boxes_[i].low[1]); row <= row_of(boxes_[i].high[1]); ++row) rows_[row].push_back(i);
        }
    }

    /// Calls visit(i, j) once for each pair of segments with overlapping boxes.
    template <class Visit>
    void for_each_pair(Visit visit) const {
        std::vector<std::uint32_t> upwards(boxes_.size());
        std::iota(upwards.begin(), upwards.end(), 0u);
        std::stable_sort(upwards.begin(), upwards.end(),
                         [&](std::uint32_t i, std::uint32_t j) { return boxes_[i].low[1] < boxes_[j].low[1]; });
        for (std::size_t a = 0; a < upwards.size(); ++a) {
            Interruption::check();
            const Extent& p = boxes_[upwards[a]];
            for (std::size_t b = a + 1; b < upwards.size(); ++b) {
                const Extent& q = boxes_[upwards[b]];
                if (q.low[1] > p.high[1]) break;
                if (p.low[0] <= q.high[0] && q.low[0] <= p.high[0]) visit(upwards[a], upwards[b]);
            }
        }
    }

    /// The winding number of a point. Counts the chords that cross the line from it along x, and the caps between chords
    /// and arcs.
    [[nodiscard]] int winding(const Vector<2>& p) const {
        int result = 0;
        for (const std::uint32_t i : rows_[row_of(p[1])]) {
            const Segment& segment = segments_[i];
            const double left = cross(segment.to - segment.from, p - segment.from);
            if (segment.from[1] <= p[1] && p[1] < segment.to[1] && left > 0) ++result;
            if (segment.to[1] <= p[1] && p[1] < segment.from[1] && left < 0) --result;
            if (is_straight(segment)) continue;
            const bool beside_chord = segment.bulge > 0 ? left <= 0 : left >= 0;
            const Arc arc(segment);
            const bool in_circle = length(p - arc.center) < arc.radius;
            // The cap of more than half a circle is the circle on the chord's one side. So is the cap of less.
            if (beside_chord && in_circle) result += segment.bulge > 0 ? 1 : -1;
        }
        return result;
    }

private:
    [[nodiscard]] std::size_t row_of(double y) const {
        const double row = std::clamp((y - low_) * scale_, 0.0, static_cast<double>(rows_.size() - 1));
        return static_cast<std::size_t>(row);
    }

    std::span<const Segment> segments_;
    std::vector<Extent> boxes_;
    std::vector<std::vector<std::uint32_t>> rows_;
    double low_ = 0, scale_ = 1;
};

// ---- Crossings ------------------------------------------------------------------------------------

/// Intersections of the two segments' lines or circles, at most two points.
void crossings(const Segment& a, const Segment& b, std::vector<Vector<2>>& points) {
    if (is_straight(a) && is_straight(b)) {
        const Vector<2> u = a.to - a.from, v = b.to - b.from;
        const double area = cross(u, v);
        if (std::fabs(area) <= 1e-14 * length(u) * length(v)) return;
        points.push_back(a.from + u * (cross(b.from - a.from, v) / area));
        return;
    }
    if (is_straight(a)) return crossings(b, a, points);
    const Arc arc(a);
    Vector<2> middle, across;  // the crossings, if any, lie symmetrically about it
    double half = 0;
    if (is_straight(b)) {
        const Vector<2> along = normalized(b.to - b.from);
        middle = b.from + along * dot(arc.center - b.from, along);
        across = along;
        half = arc.radius * arc.radius - dot(middle - arc.center, middle - arc.center);
    } else {
        const Arc other(b);
        const Vector<2> between = other.center - arc.center;
        const double distance = length(between);
        if (distance == 0) return;
        const double to_middle =
            (distance + (arc.radius - other.radius) * (arc.radius + other.radius) / distance) / 2;
        middle = arc.center + between * (to_middle / distance);
        across = {-between[1] / distance, between[0] / distance};
        half = arc.radius * arc.radius - to_middle * to_middle;
    }
    // Touching circles have one common point.
    half = half > 0 ? std::sqrt(half) : half > -1e-12 * arc.radius * arc.radius ? 0 : -1;
    if (half < 0) return;
    points.push_back(middle - across * half);
    points.push_back(middle - across * -half);
}

/// The share of the segment before a point of it.
double share(const Segment& segment, const Vector<2>& p) {
    const Vector<2> span = segment.to - segment.from;
    if (is_straight(segment)) return dot(p - segment.from, span) / dot(span, span);
    const Arc arc(segment);
    return arc.angle_to(p) / arc.angle;
}

/// Whether a point is on a segment.
bool is_on(const Segment& segment, const Vector<2>& p, double tolerance) {
    const Vector<2> span = segment.to - segment.from, off = p - segment.from;
    if (is_straight(segment)) {
        const double beside = cross(span, off), run = dot(off, span), squared = dot(span, span);
        if (!(beside * beside <= tolerance * tolerance * squared)) return false;
        if (run >= 0 && run <= squared) return true;
    } else {
        const Arc arc(segment);
        if (!(std::fabs(length(p - arc.center) - arc.radius) <= tolerance)) return false;
        if (arc.spans(p)) return true;
    }
    return length(off) < tolerance || length(p - segment.to) < tolerance;
}

/// The segments, cut at their crossings.
std::vector<Segment> cut(const std::vector<Loop>& loops, double tolerance) {
    std::vector<Segment> segments;
    std::vector<std::uint32_t> next;  // in the loop
    for (const Loop& loop : loops) {
        const auto first = static_cast<std::uint32_t>(segments.size());
        for (const Segment& segment : loop) {
            segments.push_back(segment);
            next.push_back(static_cast<std::uint32_t>(segments.size()));
        }
        if (!loop.empty()) next.back() = first;
    }
    const Rows rows(segments, tolerance);
    std::vector<std::vector<Vector<2>>> cuts(segments.size());
    std::vector<Vector<2>> found;
    std::size_t count = 0;
    rows.for_each_pair([&](std::uint32_t i, std::uint32_t j) {
        const Segment &a = segments[i], &b = segments[j];
        found.assign({a.from, a.to, b.from, b.to});
        crossings(a, b, found);
        const double near = near_common_end * std::min(length(a.to - a.from), length(b.to - b.from));
        for (const Vector<2>& p : found) {
            if (next[i] == j && length(p - a.to) < near) continue;
            if (next[j] == i && length(p - b.to) < near) continue;
            if (!is_on(a, p, tolerance) || !is_on(b, p, tolerance)) continue;
            cuts[i].push_back(p), cuts[j].push_back(p);
            if (++count > most_cuts) throw TooLarge();
        }
    });

    std::vector<Segment> result;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const Segment& segment = segments[i];
        std::vector<std::pair<double, Vector<2>>> ordered{{1, segment.to}};
        for (const Vector<2>& p : cuts[i]) {
            if (length(p - segment.to) > tolerance) ordered.emplace_back(share(segment, p), p);
        }
        std::sort(ordered.begin(), ordered.end());
        Vector<2> from = segment.from;
        double before = 0;
        for (const auto& [at, to] : ordered) {
            if (length(to - from) <= tolerance) continue;
            result.push_back({from, to, std::tan((at - before) * std::atan(segment.bulge))});
            from = to, before = at;
        }
    }
    return result;
}

// ---- The boundary ---------------------------------------------------------------------------------

/// Numbers places; equal places have equal numbers.
class Places {
public:
    explicit Places(double tolerance) : tolerance_(tolerance) {}

    std::uint32_t number_of(const Vector<2>& p) {
        const auto x = cell(p[0]), y = cell(p[1]);
        for (std::int64_t i = x - 1; i <= x + 1; ++i) {
            for (std::int64_t j = y - 1; j <= y + 1; ++j) {
                const auto [begin, end] = known_.equal_range(key(i, j));
                for (auto at = begin; at != end; ++at) {
                    if (length(places_[at->second] - p) <= tolerance_) return at->second;
                }
            }
        }
        known_.emplace(key(x, y), static_cast<std::uint32_t>(places_.size()));
        places_.push_back(p);
        return static_cast<std::uint32_t>(places_.size() - 1);
    }
    [[nodiscard]] std::size_t count() const { return places_.size(); }

private:
    [[nodiscard]] std::int64_t cell(double x) const { return static_cast<std::int64_t>(std::floor(x / tolerance_)); }
    static std::uint64_t key(std::int64_t i, std::int64_t j) {
        return static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15 + static_cast<std::uint64_t>(j);
    }

    double tolerance_;
    std::vector<Vector<2>> places_;
    std::unordered_multimap<std::uint64_t, std::uint32_t> known_;
};

/// The segments between inside and outside, with the inside to their left.
std::vector<Segment> between_inside_and_outside(const std::vector<Segment>& segments, Winding winding, double tolerance) {
    const Rows rows(segments, tolerance);
    const auto is_inside = [&](const Vector<2>& p) {
        const int turns = rows.winding(p);
        return winding == Winding::odd ? turns % 2 != 0 : turns != 0;
    };
    std::vector<Segment> result;
    for (const Segment& segment : segments) {
        const Vector<2> chord = normalized(segment.to - segment.from), left{-chord[1], chord[0]};
        const Vector<2> middle = middle_of(segment);
        const bool inside = is_inside(middle + left * (tolerance / 4));
        if (inside == is_inside(middle - left * (tolerance / 4))) continue;
        result.push_back(inside ? segment : Segment{segment.to, segment.from, -segment.bulge});
    }
    return result;
}

/// Chains segments to loops. Where several loops touch, each keeps to the inside between two segments.
std::vector<Loop> chained(const std::vector<Segment>& segments, double tolerance) {
    Places places(2 * tolerance);
    struct Ends {
        std::uint32_t from, to;
    };
    std::vector<Ends> ends;
    for (const Segment& segment : segments) {
        const std::uint32_t from = places.number_of(segment.from);
        ends.push_back({from, places.number_of(segment.to)});
    }
    std::vector<std::vector<std::uint32_t>> leaving(places.count());
    for (std::uint32_t i = 0; i < segments.size(); ++i) {
        std::vector<std::uint32_t>& others = leaving[ends[i].from];
        const bool known = std::any_of(others.begin(), others.end(), [&](std::uint32_t j) {
            return ends[j].to == ends[i].to && std::fabs(segments[j].bulge - segments[i].bulge) < 1e-6;
        });
        if (!known) others.push_back(i);
    }
    std::vector<bool> used(segments.size(), false);
    // Among the segments that leave where `last` arrives, the one with the narrowest inside between them.
    const auto next = [&](std::uint32_t last) {
        std::optional<std::uint32_t> best;
        double least = INFINITY;
        const Vector<2> back = end_direction(segments[last]) * -1;
        for (const std::uint32_t i : leaving[ends[last].to]) {
            if (used[i]) continue;
            const Vector<2> away = start_direction(segments[i]);
            double between = std::atan2(cross(away, back), dot(away, back));
            if (between < 0) between += 2 * std::numbers::pi;
            if (between < least) least = between, best = i;
        }
        return best;
    };
    std::vector<Loop> loops;
    for (const std::vector<std::uint32_t>& starts : leaving) {
        for (const std::uint32_t start : starts) {
            if (used[start]) continue;
            Loop loop;
            std::optional<std::uint32_t> i = start;
            while (i) {
                used[*i] = true;
                loop.push_back(segments[*i]);
                if (loop.size() > 1) loop.back().from = loop[loop.size() - 2].to;
                i = ends[*i].to == ends[start].from ? std::nullopt : next(*i);
            }
            if (length(loop.back().to - loop.front().from) <= 2 * tolerance) {
                loop.back().to = loop.front().from;
            } else {
                loop.push_back({loop.back().to, loop.front().from});  // a gap from rounding
            }
            if (loop.size() > 1) loops.push_back(std::move(loop));
        }
    }
    return loops;
}

// ---- Parts ----------------------------------------------------------------------------------------

/// Anticlockwise positive.
double area(const Loop& loop) {
    double twice = 0;
    const Vector<2> origin = loop.front().from;
    for (const Segment& segment : loop) {
        twice += cross(segment.from - origin, segment.to - origin);
        if (is_straight(segment)) continue;
        const Arc arc(segment);
        twice += arc.radius * arc.radius * (arc.angle - std::sin(arc.angle));
    }
    return twice / 2;
}

/// Assigns each hole to the smallest island around it.
std::vector<Island> with_holes(std::vector<Loop> loops, double tolerance) {
    std::vector<Island> islands;
    std::vector<Loop> holes;
    for (Loop& loop : loops) {
        if (area(loop) > 0) {
            islands.push_back({std::move(loop), {}});
        } else {
            holes.push_back(std::move(loop));
        }
    }
    std::stable_sort(islands.begin(), islands.end(), [](const Island& a, const Island& b) { return area(a.around) < area(b.around); });
    std::vector<Extent> extents;
    for (const Island& island : islands) extents.emplace_back().add(island.around);
    for (Loop& hole : holes) {
        Extent extent;
        extent.add(hole);
        const Segment& segment = hole.front();
        const Vector<2> chord = normalized(segment.to - segment.from), left{-chord[1], chord[0]};
        const Vector<2> beside = middle_of(segment) + left * (tolerance / 4);
        for (std::size_t i = 0; i < islands.size(); ++i) {
            if (!extents[i].contains(extent) || Rows(islands[i].around, tolerance).winding(beside) == 0) continue;
            islands[i].holes.push_back(std::move(hole));
            break;
        }
    }
    return islands;
}

void move(Loop& loop, const Vector<2>& offset) {
    for (Segment& segment : loop) segment.from = segment.from + offset, segment.to = segment.to + offset;
}

}  // namespace

std::vector<Island> islands(const std::vector<Loop>& loops, Winding winding) {
    Extent all;
    for (const Loop& loop : loops) all.add(loop);
    const double extent = std::max(all.high[0] - all.low[0], all.high[1] - all.low[1]);
    const double tolerance = same_place * extent;
    if (!std::isnormal(tolerance)) return {};
    // Far from the origin, coordinates lose their digits.
    std::vector<Loop> here = loops;
    for (Loop& loop : here) move(loop, all.low * -1);
    const std::vector<Segment> edges = between_inside_and_outside(cut(here, tolerance), winding, tolerance);
    std::vector<Island> result = with_holes(chained(edges, tolerance), tolerance);
    for (Island& island : result) {
        move(island.around, all.low);
        for (Loop& hole : island.holes) move(hole, all.low);
    }
    return result;
}

}  // namespace bob
