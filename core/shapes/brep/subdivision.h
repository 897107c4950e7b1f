/// All intersections of a ray with a part of a patch, without a bound on their number. Only for *_kernels.cpp.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "shapes/brep/newton.h"

namespace bob::BOB_ISA {

/// w (S - origin): 0 across the ray at an intersection.
inline Float4 from_ray(Float4 homogeneous, Float4 origin) {
    return homogeneous - __builtin_shufflevector(homogeneous, homogeneous, 3, 3, 3, 3) * origin;
}

/// The piece tested against a ray.
struct Piece {
    const Patch& patch;
    std::uint32_t patch_index;
    std::uint32_t number;   // among all pieces
    const TrimCells* trim;  // null if it is fully visible
    UvRange whole;          // its parameters
    UvRange part;           // the parameters to search

    /// `some` if the point is outside the face's region but within the margin.
    [[nodiscard]] TrimRegion::Coverage coverage(float u, float v) const {
        if (!trim) return TrimRegion::Coverage::all;
        const auto coverage = trim->at((u - whole.low[0]) / whole.size[0], (v - whole.low[1]) / whole.size[1]);
        return coverage == TrimRegion::Coverage::some ? patch.coverage(u, v) : coverage;
    }
};

/// The nearest hit of a ray, independent of the order of pieces. A hit outside its face's region, within the tolerance,
/// is used only where there is no face: its t is increased by a few tolerances until the end, so that a neighbour it
/// would show through stays in front.
struct Nearest {
    Hit hit;
    std::uint32_t piece = 0;
    float penalty = 0;
    bool is_beyond = false;

    Nearest() = default;
    Nearest(const Pieces& pieces, const Ray& ray)
        : penalty(pieces.tolerance > 0 ? 4 * pieces.tolerance / std::sqrt(bob::dot(ray.direction, ray.direction)) : 0) {}

    void offer(const Piece& from, const Solution& found) {
        const auto t = static_cast<float>(found.t);
        if (!(t > 0 && t <= hit.t)) return;
        const float u = clamp(found.u, 0, 1), v = clamp(found.v, 0, 1);
        const auto seen = from.coverage(u, v);
        if (seen == TrimRegion::Coverage::none) return;
        const bool beyond = seen == TrimRegion::Coverage::some;
        const float counted = beyond ? t + penalty : t;
        if (!(counted < hit.t || (counted == hit.t && from.number < piece))) return;
        hit = {counted, u, v, from.patch_index};
        piece = from.number;
        is_beyond = beyond;
    }

    [[nodiscard]] Hit result() const {
        Hit result = hit;
        if (is_beyond) result.t -= penalty;
        return result;
    }
};

/// A part of a patch with any number of hits. Its control points in the ray's frame are in a slot of the workspace.
struct Net {
    UvRange part;
    float nearest;  // lower bound of t, from the local ray's start
    std::size_t slot;
};

/// Control points, in a vector type private to this file: shared code would be used by other instruction sets.
class ControlPoints {
public:
    [[nodiscard]] std::size_t size() const { return items_.size(); }
    void resize(std::size_t size) { items_.resize(size); }
    Float4& operator[](std::size_t i) { return items_[i].point; }

private:
    struct Item {
        Float4 point;
    };
    std::vector<Item> items_;
};

/// Memory for subdivision, kept between rays.
struct Workspace {
    ControlPoints points;
    std::vector<Net> open;
    Newton<4> newton;
    PatchLanes<4> patches;
};

/// Finds all intersections of a ray with a part of a patch by Bezier subdivision (Nishita, Sederberg and Kakimoto, "Ray
/// Tracing Trimmed Rational Surface Patches", 1990). Near parts come first, down to parts with at most one hit, for
/// Newton's method, or of negligible size.
class Subdivision {
public:
    /// `normal`, of any length, is the part's approximate normal; the part is thinnest along it.
    Subdivision(const Pieces& pieces, const Piece& piece, const Ray& ray, const LocalRay& local,
                Nearest& nearest, Float4 normal, Workspace& workspace)
        : pieces_(pieces), piece_(piece), ray_(ray), local_(local), nearest_(nearest), points_(workspace.points),
          open_(workspace.open), newton_(workspace.newton), patches_(workspace.patches),
          rows_(piece.patch.degree_u + 1u), columns_(piece.patch.degree_v + 1u),
          size_(rows_ * columns_) {
        const Float4 direction{ray.direction.x, ray.direction.y, ray.direction.z};
        length_ = std::sqrt(dot(direction, direction));
        along_ = direction / broadcast<Float4>(length_);
        across_[0] = normal - broadcast<Float4>(dot(normal, along_)) * along_;
        if (!(dot(across_[0], across_[0]) > 1e-6f * dot(normal, normal))) {
            across_[0] = cross(along_, std::fabs(along_[0]) < 0.5f ? Float4{1, 0, 0, 0} : Float4{0, 1, 0, 0});
        }
        across_[0] /= broadcast<Float4>(std::sqrt(dot(across_[0], across_[0])));
        across_[1] = cross(along_, across_[0]);
    }

    void find() {
        const UvRange& part = piece_.part;
        open_.clear();
        if (points_.size() < size_) points_.resize(size_);
        const float* from = pieces_.control_points[piece_.patch.control_points].data();
        for (std::size_t i = 0; i < size_; ++i) {
            const Float4 point = load<Float4>(from + 4 * i);
            const Float4 f = from_ray(point, local_.origin);
            points_[i] = Float4{dot(f, across_[0]), dot(f, across_[1]), dot(f, along_), point[3]};
        }
        for (const int along : {0, 1}) {
            const float low = part.low[along], high = low + part.size[along];
            if (high < 1) cut(0, 0, along, high, false);
            if (low > 0) cut(0, 0, along, low / high, true);
        }
        push(part, 0);
        for (int budget = most_parts; !open_.empty() && budget > 0; --budget) {
            const Net net = open_.back();
            open_.pop_back();
            if (!is_behind(net)) look_into(net);
        }
    }

private:
    static constexpr int most_parts = 1 << 16;  // more than a needle's part needs; fewer let rays pass
    static constexpr float smallest = 5e-7f;  // a smaller part is treated as a point

    [[nodiscard]] bool is_behind(const Net& net) const {
        return local_.start + static_cast<double>(net.nearest) >= static_cast<double>(nearest_.hit.t);
    }

    /// Offset between neighbours along u (0) or v (1), in points_.
    [[nodiscard]] std::size_t step(int along) const { return along == 0 ? columns_ : 1; }
    [[nodiscard]] std::size_t count(int along) const { return along == 0 ? rows_ : columns_; }

    /// Subdivides a net at t by de Casteljau's algorithm. The lower or upper part goes to another slot, or to the same.
    void cut(std::size_t slot, std::size_t to, int along, float t, bool upper) {
        const std::size_t count = this->count(along), step = this->step(along);
        const Float4 t4 = broadcast<Float4>(t);
        Float4 b[max_degree + 1];
        for (std::size_t line = 0; line < this->count(1 - along); ++line) {
            const Float4* in = &points_[slot * size_ + line * this->step(1 - along)];
            Float4* out = &points_[to * size_ + line * this->step(1 - along)];
            for (std::size_t i = 0; i < count; ++i) b[i] = in[i * step];
            for (std::size_t last = count - 1;; --last) {
                out[(upper ? last : count - 1 - last) * step] = b[upper ? last : 0];
                if (last == 0) break;
                for (std::size_t i = 0; i < last; ++i) b[i] += t4 * (b[i + 1] - b[i]);
            }
        }
    }

    /// Opens a part, unless the ray misses it.
    void push(const UvRange& part, std::size_t slot) {
        Float4 low = points_[slot * size_], high = low;
        for (std::size_t i = slot * size_ + 1; i < (slot + 1) * size_; ++i) {
            low = min(low, points_[i]), high = max(high, points_[i]);
        }
        if (low[0] > rounding || high[0] < -rounding || low[1] > rounding || high[1] < -rounding) return;
        const float nearest = low[2] / (low[2] > 0 ? high[3] : low[3]);
        const Net net{part, nearest / length_, slot};
        if (!is_behind(net)) open_.push_back(net);
    }

    void look_into(const Net& net) {
        const UvRange& part = net.part;
        const Differences in_u = differences(net, 0), in_v = differences(net, 1);
        const float u = part.low[0] + 0.5f * part.size[0], v = part.low[1] + 0.5f * part.size[1];
        if (never_folds(in_u, in_v)) {
            if (passes_by(net, in_u, in_v)) return;
            newton_.clear();
            newton_.add(ray_, local_, piece_.patch_index, part, u, v);
            newton_.solve(pieces_, patches_);
            if (newton_.found(0) == Newton<4>::Found::hit) return nearest_.offer(piece_, newton_.solution(0));
            // A root outside, for example on a silhouette's other side, does not exclude one inside.
        }
        const float extent[2] = {in_u.extent(rows_ - 1), in_v.extent(columns_ - 1)};
        if (larger(extent[0], extent[1]) < smallest) {
            return nearest_.offer(piece_, {u, v, local_.start + static_cast<double>(middle(net) / length_)});
        }
        const int along = extent[1] > extent[0];
        UvRange halves[2] = {part, part};
        for (UvRange& half : halves) half.size[along] *= 0.5f;
        halves[1].low[along] += halves[1].size[along];
        if (points_.size() < (net.slot + 2) * size_) points_.resize((net.slot + 2) * size_);
        const Float4* corners = &points_[net.slot * size_];
        const bool upper_is_nearer = corners[(count(along) - 1) * step(along)][2] < corners[0][2];
        cut(net.slot, net.slot + 1, along, 0.5f, upper_is_nearer);
        cut(net.slot, net.slot, along, 0.5f, !upper_is_nearer);
        push(halves[!upper_is_nearer], net.slot);
        push(halves[upper_is_nearer], net.slot + 1);
    }

    /// The mean depth of the corners.
    [[nodiscard]] float middle(const Net& net) const {
        float sum = 0;
        for (const std::size_t i : {std::size_t{0}, columns_ - 1, size_ - columns_, size_ - 1}) {
            const Float4& corner = points_[net.slot * size_ + i];
            sum += corner[2] / corner[3];
        }
        return sum / 4;
    }

    /// The box of the differences between neighbouring control points.
    struct Differences {
        Float4 low, high;

        /// Approximate length of the longest line of control points.
        [[nodiscard]] float extent(std::size_t differences) const {
            const Float4 largest = max(high, -low);
            return larger(larger(largest[0], largest[1]), largest[2]) * static_cast<float>(differences);
        }
    };

    [[nodiscard]] Differences differences(const Net& net, int along) const {
        const std::size_t last_row = rows_ - (along == 0), last_column = columns_ - (along == 1);
        Differences d{broadcast<Float4>(std::numeric_limits<float>::infinity()), {}};
        d.high = -d.low;
        for (std::size_t i = 0; i < last_row; ++i) {
            const Float4* row = &points_[net.slot * size_ + i * columns_];
            for (std::size_t j = 0; j < last_column; ++j) {
                const Float4 between = row[j + step(along)] - row[j];
                d.low = min(d.low, between), d.high = max(d.high, between);
            }
        }
        return d;
    }

    /// Whether the projection along the ray has a determinant of one sign for all derivatives in their boxes. Then the
    /// ray intersects the part at most once (pieces_build.cpp explains why).
    static bool never_folds(const Differences& u, const Differences& v) {
        const Float4 a{u.low[0], u.high[0], u.low[0], u.high[0]}, b{v.low[1], v.low[1], v.high[1], v.high[1]};
        const Float4 c{u.low[1], u.high[1], u.low[1], u.high[1]}, d{v.low[0], v.low[0], v.high[0], v.high[0]};
        const Float4 plus = a * b, minus = c * d;
        const auto least = [](Float4 x) { return smaller(smaller(x[0], x[1]), smaller(x[2], x[3])); };
        const auto most = [](Float4 x) { return larger(larger(x[0], x[1]), larger(x[2], x[3])); };
        return least(plus) > most(minus) || most(plus) < least(minus);
    }

    /// Whether all control points are on one side of a line through the ray. Seen along the ray, the line has the
    /// direction of u or v.
    [[nodiscard]] bool passes_by(const Net& net, const Differences& in_u, const Differences& in_v) const {
        const Float4 u = in_u.low + in_u.high, v = in_v.low + in_v.high;
        constexpr float infinity = std::numeric_limits<float>::infinity();
        Float4 low = broadcast<Float4>(infinity), high = broadcast<Float4>(-infinity);
        for (std::size_t i = net.slot * size_; i < (net.slot + 1) * size_; ++i) {
            const float a = points_[i][0], b = points_[i][1];
            const Float4 sides{u[0] * b - u[1] * a, v[0] * b - v[1] * a, 0, 0};
            low = min(low, sides), high = max(high, sides);
        }
        const auto passed = [&](int k, Float4 along) {
            const float slack = rounding * (std::fabs(along[0]) + std::fabs(along[1]));
            return low[k] > slack || high[k] < -slack;
        };
        return passed(0, u) || passed(1, v);
    }

    const Pieces& pieces_;
    const Piece& piece_;
    const Ray& ray_;
    const LocalRay& local_;
    Nearest& nearest_;
    ControlPoints& points_;
    std::vector<Net>& open_;
    Newton<4>& newton_;
    PatchLanes<4>& patches_;
    std::size_t rows_, columns_, size_;
    float length_;               // of the ray's direction
    Float4 along_, across_[2];  // unit length
};

}  // namespace bob::BOB_ISA
