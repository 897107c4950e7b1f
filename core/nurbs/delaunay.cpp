#include "nurbs/delaunay.h"

#include <algorithm>
#include <bit>
#include <deque>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/interruption.h"

namespace bob {
namespace {

__extension__ using Wide = __int128;  // the sums below are less than 2^120

constexpr int turn(int i) { return i == 2 ? 0 : i + 1; }
constexpr int back(int i) { return i == 0 ? 2 : i - 1; }

struct Triangle {
    std::array<std::int32_t, 3> corner;          // anticlockwise
    std::array<std::int32_t, 3> beside;          // the triangle opposite each corner; -1 if there is none
    std::array<bool, 3> is_fixed{}, is_border{};  // whether the edge opposite each corner is fixed, and whether it separates inside from outside
};

class Delaunay {
public:
    explicit Delaunay(std::span<const PlanePoint> points) : count_(static_cast<std::int32_t>(points.size())) {
        for (const PlanePoint& p : points) {
            if (std::min(p[0], p[1]) < 0 || std::max(p[0], p[1]) > max_plane) throw std::invalid_argument("a point is out of range");
            points_.push_back({p[0], p[1]});
        }
        // A square far around all points.
        constexpr std::int64_t low = -3 * std::int64_t{max_plane}, high = 4 * std::int64_t{max_plane};
        points_.insert(points_.end(), {{low, low}, {high, low}, {high, high}, {low, high}});
        at_.assign(points_.size(), 0);
        triangles_.push_back({{count_, count_ + 1, count_ + 2}, {-1, 1, -1}});
        triangles_.push_back({{count_, count_ + 2, count_ + 3}, {-1, -1, 0}});
        // Inserts points in rounds, each of about twice as many points as all rounds before. Row by row, a grid's
        // triangles would be flipped again and again (Amenta, Choi and Rote, "Incremental constructions con BRIO",
        // 2003). Each round goes to and fro in bands, so that consecutive points are near each other.
        struct Turn {
            int round, band;
            std::int64_t x;
            std::int32_t point;

            bool operator<(const Turn& other) const {
                return std::tie(round, band, x, point) < std::tie(other.round, other.band, other.x, other.point);
            }
        };
        std::vector<Turn> turns;
        turns.reserve(points.size());
        const int rounds = std::bit_width(points.size());
        for (std::int32_t i = 0; i < count_; ++i) {
            const auto mixed = (static_cast<std::uint64_t>(i) + 1) * 0x9e3779b97f4a7c15;
            const int round = rounds - std::min(std::countl_zero(mixed), rounds);  // the last has half of the points
            const auto [x, y] = points[index(i)];
            const int band = static_cast<int>(y >> (25 - std::min(round / 2, 25)));
            turns.push_back({round, band, band % 2 ? -x : x, i});
        }
        std::sort(turns.begin(), turns.end());
        for (std::size_t i = 0; i < turns.size(); ++i) {
            if (i % 1024 == 0) Interruption::check();
            add(turns[i].point);
        }
        for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles_.size()); ++t) {
            for (const std::int32_t corner : triangles_[index(t)].corner) at_[index(corner)] = t;
        }
    }

    /// Fixes the line between two points as an edge; points on it split it.
    void fix(std::int32_t a, std::int32_t b) {
        while (a != b) a = fix_part(a, b);
    }

    [[nodiscard]] std::vector<std::array<std::int32_t, 3>> inside() const {
        std::vector<std::int8_t> is_inside(triangles_.size(), -1);
        std::vector<std::array<std::int32_t, 3>> result;
        std::vector<std::int32_t> open{at_[index(count_)]};  // a corner of the square
        is_inside[index(open[0])] = 0;
        while (!open.empty()) {
            const std::int32_t t = open.back();
            open.pop_back();
            const Triangle& triangle = triangles_[index(t)];
            if (is_inside[index(t)]) result.push_back(triangle.corner);
            for (std::size_t i = 0; i < 3; ++i) {
                const std::int32_t next = triangle.beside[i];
                if (next < 0 || is_inside[index(next)] >= 0) continue;
                is_inside[index(next)] = static_cast<std::int8_t>(is_inside[index(t)] ^ triangle.is_border[i]);
                open.push_back(next);
            }
        }
        return result;
    }

private:
    using Point = std::array<std::int64_t, 2>;

    static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

    /// Above 0 if a, b and c turn left.
    [[nodiscard]] std::int64_t side(std::int32_t a, std::int32_t b, std::int32_t c) const {
        const Point &p = points_[index(a)], &q = points_[index(b)], &r = points_[index(c)];
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    }

    /// Whether d lies inside the circle through a, b and c, which turn left.
    [[nodiscard]] bool is_in_circle(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const {
        const Point& o = points_[index(d)];
        std::int64_t x[3], y[3];
        Wide square[3];
        const std::int32_t corner[3] = {a, b, c};
        for (int i = 0; i < 3; ++i) {
            x[i] = points_[index(corner[i])][0] - o[0], y[i] = points_[index(corner[i])][1] - o[1];
            square[i] = Wide{x[i] * x[i] + y[i] * y[i]};
        }
        return square[0] * (x[1] * y[2] - x[2] * y[1]) + square[1] * (x[2] * y[0] - x[0] * y[2]) +
                   square[2] * (x[0] * y[1] - x[1] * y[0]) > 0;
    }

    [[nodiscard]] int place_of(std::int32_t t, std::int32_t corner) const {
        const auto& corners = triangles_[index(t)].corner;
        return corners[0] == corner ? 0 : corners[1] == corner ? 1 : 2;
    }
    /// The corner of triangle t opposite its neighbour `other`.
    [[nodiscard]] int place_beside(std::int32_t t, std::int32_t other) const {
        const auto& beside = triangles_[index(t)].beside;
        return beside[0] == other ? 0 : beside[1] == other ? 1 : 2;
    }

    void add(std::int32_t p) {
        std::int32_t t = last_;
        int on = -1;  // the corner opposite the edge that contains p
        for (int i = 0; i < 3;) {
            const Triangle& triangle = triangles_[index(t)];
            const std::int64_t s = side(triangle.corner[index(turn(i))], triangle.corner[index(back(i))], p);
            if (s < 0) {
                t = triangle.beside[index(i)];
                i = 0, on = -1;
                continue;
            }
            if (s == 0) {
                if (on >= 0) throw std::invalid_argument("a point is there twice");
                on = i;
            }
            ++i;
        }
        std::vector<std::pair<std::int32_t, int>>& suspects = suspects_;  // edges opposite p
        suspects.clear();
        const Triangle old = triangles_[index(t)];
        const auto fresh = static_cast<std::int32_t>(triangles_.size());
        if (on < 0) {
            // Triangle k has the old edge opposite corner k.
            const std::int32_t number[3] = {t, fresh, fresh + 1};
            triangles_.resize(triangles_.size() + 2);
            for (int k = 0; k < 3; ++k) {
                triangles_[index(number[k])] = {{p, old.corner[index(turn(k))], old.corner[index(back(k))]},
                                                {old.beside[index(k)], number[turn(k)], number[back(k)]}};
                relink(old.beside[index(k)], t, number[k]);
                suspects.push_back({number[k], 0});
            }
        } else {
            // Splits both triangles at the edge at p.
            const std::int32_t other = old.beside[index(on)];
            const int across = place_beside(other, t);
            const Triangle opposite = triangles_[index(other)];
            const std::int32_t a = old.corner[index(on)], b = old.corner[index(turn(on))], c = old.corner[index(back(on))],
                               d = opposite.corner[index(across)];
            const std::int32_t ab = old.beside[index(back(on))], ca = old.beside[index(turn(on))],
                               bd = opposite.beside[index(turn(across))], dc = opposite.beside[index(back(across))];
            triangles_.resize(triangles_.size() + 2);
            triangles_[index(t)] = {{p, a, b}, {ab, other, fresh}};
            triangles_[index(fresh)] = {{p, c, a}, {ca, t, fresh + 1}};
            triangles_[index(other)] = {{p, b, d}, {bd, fresh + 1, t}};
            triangles_[index(fresh + 1)] = {{p, d, c}, {dc, fresh, other}};
            relink(ca, t, fresh);
            relink(dc, other, fresh + 1);
            for (const std::int32_t each : {t, fresh, other, fresh + 1}) suspects.push_back({each, 0});
        }
        while (!suspects.empty()) {
            const auto [own, place] = suspects.back();
            suspects.pop_back();
            const Triangle& triangle = triangles_[index(own)];
            const std::int32_t other = triangle.beside[index(place)];
            if (other < 0) continue;
            const std::int32_t far = triangles_[index(other)].corner[index(place_beside(other, own))];
            if (!is_in_circle(triangle.corner[0], triangle.corner[1], triangle.corner[2], far)) continue;
            flip(own, place);
            suspects.push_back({own, place_of(own, p)});
            suspects.push_back({other, place_of(other, p)});
        }
        last_ = t;
    }

    void relink(std::int32_t t, std::int32_t from, std::int32_t to) {
        if (t >= 0) triangles_[index(t)].beside[index(place_beside(t, from))] = to;
    }

    /// Flips the edge opposite a corner of triangle t: it then joins that corner to the opposite one.
    void flip(std::int32_t t, int i) {
        Triangle& near = triangles_[index(t)];
        const std::int32_t other = near.beside[index(i)];
        Triangle& far = triangles_[index(other)];
        const int j = place_beside(other, t);
        const Triangle a = near, b = far;
        const std::int32_t p = a.corner[index(i)], q = a.corner[index(turn(i))], r = a.corner[index(back(i))], s = b.corner[index(j)];
        // (p, q, r) and (s, r, q) become (p, q, s) and (p, s, r).
        const auto take = [](Triangle& to, int place, const Triangle& from, int was) {
            to.beside[index(place)] = from.beside[index(was)];
            to.is_fixed[index(place)] = from.is_fixed[index(was)];
            to.is_border[index(place)] = from.is_border[index(was)];
        };
        near = {{p, q, s}, {}}, far = {{p, s, r}, {}};
        take(near, 0, b, turn(j));  // q s
        near.beside[1] = other;     // s p
        take(near, 2, a, back(i));  // p q
        take(far, 0, b, back(j));   // s r
        take(far, 1, a, turn(i));   // r p
        far.beside[2] = t;          // p s
        relink(near.beside[0], other, t);
        relink(far.beside[1], t, other);
        at_[index(p)] = at_[index(q)] = at_[index(s)] = t;
        at_[index(r)] = other;
    }

    /// Fixes the line from a towards b up to the first point on it, and returns that point.
    std::int32_t fix_part(std::int32_t a, std::int32_t b) {
        // The triangle at a that the line passes through.
        std::int32_t t = at_[index(a)];
        const std::int32_t start = t;
        int i = 0;
        while (true) {
            i = place_of(t, a);
            const std::int32_t right = triangles_[index(t)].corner[index(turn(i))], left = triangles_[index(t)].corner[index(back(i))];
            const std::int64_t of_right = side(a, b, right), of_left = side(a, b, left);
            if (of_right == 0 && is_ahead(a, b, right)) return mark(t, back(i)), right;
            if (of_left == 0 && is_ahead(a, b, left)) return mark(t, turn(i)), left;
            if (of_right < 0 && of_left > 0) break;
            t = triangles_[index(t)].beside[index(turn(i))];  // anticlockwise around a, which is inside the square
            if (t == start) throw std::invalid_argument("a point is there twice");
        }
        // The edges that it crosses, as pairs of points, until it reaches a point.
        std::deque<std::pair<std::int32_t, std::int32_t>> crossed;
        std::int32_t right = triangles_[index(t)].corner[index(turn(i))], left = triangles_[index(t)].corner[index(back(i))], end;
        while (true) {
            if (triangles_[index(t)].is_fixed[index(i)]) throw std::invalid_argument("two edges cross");
            crossed.push_back({right, left});
            const std::int32_t next = triangles_[index(t)].beside[index(i)];
            const int across = place_beside(next, t);
            const std::int32_t beyond = triangles_[index(next)].corner[index(across)];
            const std::int64_t s = side(a, b, beyond);
            end = beyond;
            if (s == 0) break;
            t = next;
            // Leaves through the edge between `beyond` and the corner on the other side of the line.
            i = place_of(t, s > 0 ? left : right);
            (s > 0 ? left : right) = beyond;
        }
        // Flips them, if their quadrilateral is convex, until no edge crosses the line.
        std::vector<std::pair<std::int32_t, std::int32_t>> made;
        while (!crossed.empty()) {
            Interruption::check();
            const auto [p, q] = crossed.front();
            crossed.pop_front();
            const auto [own, place] = edge(p, q);
            const std::int32_t other = triangles_[index(own)].beside[index(place)];
            const std::int32_t r = triangles_[index(own)].corner[index(place)],
                               s = triangles_[index(other)].corner[index(place_beside(other, own))];
            const std::int64_t of_p = side(r, s, p), of_q = side(r, s, q);
            if (!((of_p > 0 && of_q < 0) || (of_p < 0 && of_q > 0))) {
                crossed.push_back({p, q});
                continue;
            }
            flip(own, place);
            const bool touches = r == a || r == end || s == a || s == end;
            const std::int64_t of_r = side(a, end, r), of_s = side(a, end, s);
            if (!touches && ((of_r > 0 && of_s < 0) || (of_r < 0 && of_s > 0))) {
                crossed.push_back({r, s});
            } else {
                made.push_back({r, s});
            }
        }
        // The new edges except the line itself may not be Delaunay.
        for (bool changed = true; changed;) {
            changed = false;
            for (auto& [p, q] : made) {
                if ((p == a && q == end) || (p == end && q == a)) continue;
                const auto [own, place] = edge(p, q);
                const Triangle& triangle = triangles_[index(own)];
                if (triangle.is_fixed[index(place)]) continue;
                const std::int32_t other = triangle.beside[index(place)];
                const std::int32_t r = triangle.corner[index(place)],
                                   s = triangles_[index(other)].corner[index(place_beside(other, own))];
                if (!is_in_circle(triangle.corner[0], triangle.corner[1], triangle.corner[2], s)) continue;
                flip(own, place);
                p = r, q = s;
                changed = true;
            }
        }
        const auto [own, place] = edge(a, end);
        mark(own, place);
        return end;
    }

    /// Whether c, on the line through a and b, is on b's side of a.
    [[nodiscard]] bool is_ahead(std::int32_t a, std::int32_t b, std::int32_t c) const {
        const Point &p = points_[index(a)], &q = points_[index(b)], &r = points_[index(c)];
        return (q[0] - p[0]) * (r[0] - p[0]) + (q[1] - p[1]) * (r[1] - p[1]) > 0;
    }

    /// A triangle with the edge between p and q, and the corner opposite it.
    [[nodiscard]] std::pair<std::int32_t, int> edge(std::int32_t p, std::int32_t q) const {
        if (p >= count_) std::swap(p, q);  // the square's corners lack triangles on some sides
        std::int32_t t = at_[index(p)];
        while (true) {
            const int i = place_of(t, p);
            if (triangles_[index(t)].corner[index(turn(i))] == q) return {t, back(i)};
            t = triangles_[index(t)].beside[index(turn(i))];
        }
    }

    void mark(std::int32_t t, int i) {
        Triangle& triangle = triangles_[index(t)];
        Triangle& other = triangles_[index(triangle.beside[index(i)])];
        const int j = place_beside(triangle.beside[index(i)], t);
        triangle.is_fixed[index(i)] = other.is_fixed[index(j)] = true;
        triangle.is_border[index(i)] = other.is_border[index(j)] = !triangle.is_border[index(i)];
    }

    std::int32_t count_;
    std::vector<Point> points_;  // followed by the square's corners
    std::vector<Triangle> triangles_;
    std::vector<std::int32_t> at_;  // a triangle at each point
    std::int32_t last_ = 0;
    std::vector<std::pair<std::int32_t, int>> suspects_;
};

}  // namespace

std::vector<std::array<std::int32_t, 3>> triangulate(std::span<const PlanePoint> points,
                                                     std::span<const std::array<std::int32_t, 2>> edges) {
    const auto count = static_cast<std::int32_t>(points.size());
    Delaunay triangles(points);
    for (const auto& [a, b] : edges) {
        if (std::min(a, b) < 0 || std::max(a, b) >= count) throw std::invalid_argument("an edge's point is out of range");
        triangles.fix(a, b);
    }
    return triangles.inside();
}

}  // namespace bob
