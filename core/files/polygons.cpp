#include "files/polygons.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/interruption.h"
#include "files/text.h"

namespace bob::files {
namespace {

/// Twice the tolerated area of a flipped triangle, in squares of the polygon's extent. Smaller: rounded corners on a line, as
/// float32 has them, cost a clipping each. Larger: folds of a thousandth of the extent stay.
constexpr double fold = 1e-6;

/// Corners compared in one file, a few ns each. A polygon of 10,000 corners, half of them concave, takes up to 1e8.
constexpr std::uint64_t budget = 400'000'000;

using Point = std::array<double, 2>;

double area(const Point& a, const Point& b, const Point& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

class Triangulator {
public:
    Triangulator(const Numbers<double>& vertices, std::span<const std::int32_t> points) : vertices_(vertices), points_(points) {}

    /// Whether the polygon in `at` lies in a plane, so that it can be drawn there, at extent 1 and anticlockwise.
    bool draw(std::span<const std::int32_t> polygon) {
        plane_.resize(polygon.size());
        double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (const std::int32_t corner : polygon) {
            const double* const p = place(corner);
            if (!p) return false;
            for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
        }
        double extent = 0;
        for (int k = 0; k < 3; ++k) extent = std::max(extent, high[k] - low[k]);
        if (!(extent > 0) || !std::isfinite(extent)) return false;
        double normal[3] = {};  // Newell's, twice the area in each plane
        const auto local = [&](const double* p, int k) { return (p[k] - low[k]) / extent; };
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const double *a = place(polygon[i]), *b = place(polygon[i + 1 < polygon.size() ? i + 1 : 0]);
            for (int k = 0; k < 3; ++k) {
                const int u = (k + 1) % 3, v = (k + 2) % 3;
                normal[k] += (local(a, u) - local(b, u)) * (local(a, v) + local(b, v));
            }
        }
        int axis = 0;
        for (int k = 1; k < 3; ++k) axis = std::fabs(normal[k]) > std::fabs(normal[axis]) ? k : axis;
        if (!(std::fabs(normal[axis]) > 0)) return false;
        const int u = normal[axis] > 0 ? (axis + 1) % 3 : (axis + 2) % 3, v = normal[axis] > 0 ? (axis + 2) % 3 : (axis + 1) % 3;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const double* const p = place(polygon[i]);
            plane_[i] = {local(p, u), local(p, v)};
        }
        return true;
    }

    [[nodiscard]] bool is_fan() const {
        for (std::size_t i = 2; i < plane_.size(); ++i) {
            if (area(plane_[0], plane_[i - 1], plane_[i]) < -fold) return false;
        }
        return true;
    }

    /// Cuts the drawn polygon ear by ear. False if there was too much work, and the rest is a fan.
    bool clip(std::span<const std::int32_t> polygon, std::int32_t* to) {
        const auto count = static_cast<std::uint32_t>(polygon.size());
        next_.resize(count), previous_.resize(count), concave_.clear();
        for (std::uint32_t i = 0; i < count; ++i) next_[i] = i + 1 < count ? i + 1 : 0, previous_[i] = i ? i - 1 : count - 1;
        std::uint32_t at = 0, left = count, tried = 0;
        const auto cut = [&](std::uint32_t i) {
            for (const std::uint32_t k : {previous_[i], i, next_[i]}) *to++ = polygon[k];
            next_[previous_[i]] = next_[i];
            previous_[next_[i]] = previous_[i];
            next_[i] = i;
            --left;
        };
        // First without area: corners in the place of the next one, and tips of spikes, whose neighbours share a place.
        for (std::uint32_t seen = 0; left > 3 && seen < left;) {
            const Point& after = plane_[next_[at]];
            if (plane_[at] == after || plane_[previous_[at]] == after) {
                const std::uint32_t before = previous_[at];
                cut(at);
                at = before;
                seen -= std::min(seen, 2u);
            } else {
                at = next_[at];
                ++seen;
            }
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            if (next_[i] != i && corner(i) <= 0) concave_.push_back(i);
        }
        while (left > 3) {
            Interruption::check();
            if (is_spent()) {
                for (std::uint32_t i = next_[at]; next_[i] != at; i = next_[i]) {
                    for (const std::uint32_t k : {at, i, next_[i]}) *to++ = polygon[k];
                }
                return false;
            }
            if (tried < left && !is_ear(at)) {
                at = next_[at], ++tried;
                continue;
            }
            if (tried == left) at = flattest(at);  // of polygons that cross themselves
            const std::uint32_t before = previous_[at], after = next_[at];
            cut(at);
            std::erase_if(concave_, [&](std::uint32_t i) { return next_[i] == i || ((i == before || i == after) && corner(i) > 0); });
            at = next_[after], tried = 0;  // not next to the last one, which would make slivers
        }
        for (const std::uint32_t i : {previous_[at], at, next_[at]}) *to++ = polygon[i];
        return true;
    }

    [[nodiscard]] bool is_spent() const { return spent_ >= budget; }

private:
    /// The coordinates of a corner; null if it does not exist.
    [[nodiscard]] const double* place(std::int32_t corner) const {
        if (!points_.empty()) corner = points_[static_cast<std::size_t>(corner)];
        if (corner < 0 || 3 * static_cast<std::size_t>(corner) >= vertices_.size()) return nullptr;
        const double* const p = &vertices_[3 * static_cast<std::size_t>(corner)];
        return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]) ? p : nullptr;
    }

    [[nodiscard]] double corner(std::uint32_t i) const { return area(plane_[previous_[i]], plane_[i], plane_[next_[i]]); }

    /// Whether a corner is convex, and its triangle has no other corner in it. Corners in the same place, where an edge leads to a hole
    /// and back, do not count: their edges lie outside.
    bool is_ear(std::uint32_t i) {
        const Point &a = plane_[previous_[i]], &b = plane_[i], &c = plane_[next_[i]];
        spent_ += concave_.size() + 1;
        if (!(area(a, b, c) > 0)) return false;
        for (const std::uint32_t other : concave_) {
            const Point& p = plane_[other];
            if (area(a, b, p) < 0 || area(b, c, p) < 0 || area(c, a, p) < 0) continue;
            if (p != a && p != b && p != c) return false;
        }
        return true;
    }

    std::uint32_t flattest(std::uint32_t start) {
        std::uint32_t best = start;
        for (std::uint32_t i = next_[start]; i != start; i = next_[i], ++spent_) {
            if (std::fabs(corner(i)) < std::fabs(corner(best))) best = i;
        }
        return best;
    }

    const Numbers<double>& vertices_;
    std::span<const std::int32_t> points_;
    std::vector<Point> plane_;                     // of the corners
    std::vector<std::uint32_t> next_, previous_;   // corners that are left; next_[i] is i of one that is cut
    std::vector<std::uint32_t> concave_;
    std::uint64_t spent_ = 0;
};

}  // namespace

void Polygons::add(std::span<const std::int32_t> polygon) {
    if (sizes.empty() && polygon.size() != 3) sizes.assign(corners.size() / 3, 3);
    if (polygon.size() != 3 || !sizes.empty()) sizes.push_back(static_cast<std::int32_t>(polygon.size()));
    corners.insert(corners.end(), polygon.begin(), polygon.end());
}

Numbers<std::int32_t> triangulated(Polygons&& polygons, const Numbers<double>& vertices, std::span<const std::int32_t> points,
                                   std::vector<std::string>& warnings) {
    if (polygons.sizes.empty()) return std::move(polygons.corners);
    std::size_t count = 0, fans = 0, flat = 0;
    for (const std::int32_t size : polygons.sizes) count += Polygons::triangles(size), flat += size < 3;
    Numbers<std::int32_t> triangles(3 * count);
    Triangulator triangulator(vertices, points);
    const std::int32_t* polygon = polygons.corners.data();
    std::int32_t* to = triangles.data();
    for (std::size_t n = 0; n < polygons.sizes.size(); ++n) {
        if (n % 4096 == 0) Interruption::check();
        const std::size_t size = static_cast<std::size_t>(polygons.sizes[n]);
        const std::span<const std::int32_t> corners(polygon, size);
        const bool is_concave = size > 3 && triangulator.draw(corners) && !triangulator.is_fan();
        if (is_concave && !triangulator.is_spent()) {
            fans += !triangulator.clip(corners, to);
            to += 3 * (size - 2);
        } else {
            fans += is_concave;
            for (std::size_t i = 2; i < size; ++i) *to++ = polygon[0], *to++ = polygon[i - 1], *to++ = polygon[i];
        }
        polygon += size;
    }
    if (fans) warnings.push_back(joined({grouped(fans), " concave polygons were cut into fans: they have too many corners"}));
    if (flat && count) warnings.push_back(joined({"left out ", grouped(flat), flat > 1 ? " faces" : " face", " of fewer than three corners"}));
    return triangles;
}

Numbers<double> of_triangles(Numbers<double>&& values, std::size_t width, const Polygons& polygons) {
    if (polygons.sizes.empty() || values.empty()) return std::move(values);
    std::size_t count = 0;
    for (const std::int32_t size : polygons.sizes) count += Polygons::triangles(size);
    Numbers<double> result(width * count);
    double* to = result.data();
    const double* from = values.data();
    for (const std::int32_t size : polygons.sizes) {
        for (std::size_t i = Polygons::triangles(size); i > 0; --i) to = std::copy_n(from, width, to);
        from += width;
    }
    return result;
}

}  // namespace bob::files
