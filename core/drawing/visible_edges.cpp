#include "drawing/visible_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/interruption.h"
#include "base/parallel.h"
#include "base/thread_memory.h"
#include "shapes/edges.h"
#include "shapes/mesh/mesh.h"

namespace bob {
namespace {

/// Distance in pixels from the neighbour's plane that makes a step in depth.
constexpr float least_step = 0.5f;

/// Hits are this far from their surfaces, in radii of the scene.
constexpr float hit_error = 4e-5f;

/// Number of bisections of a pixel's interval: edges are within 1/32 pixel of their place.
constexpr int bisections = 4;

/// Where a curve turns by more within a pixel, or meets another, half pixels resolve it.
constexpr float sharp_degrees = 20;

/// Tolerance of curves in pixels: a twentieth of a thin stroke.
constexpr float tolerance_of_curves = 0.05f;

/// Faces that meet at a smaller angle meet smoothly: borders of CAD faces agree to a degree.
constexpr float smooth_degrees = 3;

constexpr float degree = 3.14159265f / 180;

/// A place in half pixels: the centres of pixels are even, and the first is 2, 2.
struct Spot {
    int row = 0, column = 0;
};

/// The first hit of a ray.
struct Look {
    Vec3 point, normal, face_normal;
    float step = 0;  // a point this far off the tangent plane is not on the same surface
    std::uint32_t instance = no_instance, face = 0;
};

struct Sight {
    float row, column;
};

class Finder {
public:
    /// Finds edges in the rows from `begin` to `end`. A `pixel` above 1 is the side of squares that are treated as pixels, without the half
    /// pixels where curves meet, end or turn.
    Finder(const Scene& scene, const Camera& camera, int height, int width, bool smooth, int begin, int end, int pixel = 1)
        : scene_(scene), projection_(camera, height, width), begin_(static_cast<float>(begin)), pixel_(static_cast<float>(pixel)),
          rows_(2 * ((end - begin + pixel - 1) / pixel) + 3), columns_(2 * ((width + pixel - 1) / pixel) + 3), smooth_(smooth), resolves_(pixel == 1),
          has_face_normals_(shades_by_other_normals(scene)), at_(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_), untraced),
          kinds_(static_cast<std::size_t>(rows_ / 2) * static_cast<std::size_t>(columns_ / 2)) {}

    Curves operator()() {
        look_at_pixels();
        mark_cells();
        place_crossings(1);
        mark_sharp_cells();
        resolve_sharp_cells();
        place_crossings(2);
        connect();
        cut_stubs();
        return joined(network_, tolerance_of_curves);
    }

private:
    /// Whether face normals are needed: only meshes shade by other normals.
    static bool shades_by_other_normals(const Scene& scene) {
        bool any = false;
        for (std::uint32_t i = 0; i < scene.size(); ++i) any = any || dynamic_cast<const Mesh*>(scene[i].shape.get());
        return any;
    }

    static constexpr std::uint32_t untraced = 0xffffffff;

    [[nodiscard]] std::size_t index(Spot p) const {
        return static_cast<std::size_t>(p.row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(p.column);
    }
    [[nodiscard]] const Look& look(Spot p) const { return looks_[at_[index(p)]]; }
    [[nodiscard]] Sight sight(Spot p) const {
        const auto place = [&](int half) { return (0.5f * static_cast<float>(half) - 0.5f) * pixel_ - 0.5f; };
        return {place(p.row) + begin_, place(p.column)};
    }

    /// First hits along sights; neighbours should follow each other.
    void trace(std::span<const Sight> sights, std::span<Look> looks) const {
        parallel_for(sights.size(), batch_size(sights.size()), [&](std::size_t begin, std::size_t end) {
            struct Memory {
                std::vector<Ray> rays;
                std::vector<std::size_t> number;
                std::vector<SceneHit> hits;
                std::vector<Vec3> normals, face_normals;
            };
            auto& [rays, number, hits, normals, face_normals] = thread_memory<Memory>();
            rays.clear(), number.clear();
            for (std::size_t i = begin; i < end; ++i) {
                looks[i] = {};
                Ray ray;
                if (projection_.ray(sights[i].row, sights[i].column, ray)) rays.push_back(ray), number.push_back(i);
            }
            hits.resize(rays.size()), normals.resize(rays.size()), face_normals.resize(rays.size());
            scene_.closest_hits(rays, hits);
            scene_.normals(rays, hits, normals);
            if (has_face_normals_) scene_.face_normals(rays, hits, face_normals);
            const auto& flat = has_face_normals_ ? face_normals : normals;
            for (std::size_t j = 0; j < rays.size(); ++j) {
                if (hits[j].instance == no_instance) continue;
                const Vec3 point = rays[j].origin + hits[j].t * rays[j].direction;
                const float along = std::abs(dot(flat[j], normalized(rays[j].direction)));
                const float step = least_step * pixel_ * projection_.pixel_width(projection_.depth(point)) * along + hit_error;
                const Hit& hit = hits[j].in_shape;  // a cap is a separate face
                const std::uint32_t face = is_cap(hit.primitive) ? hit.primitive : scene_[hits[j].instance].shape->face(hit);
                looks[number[j]] = {point, normals[j], flat[j], step, hits[j].instance, face};
            }
        });
    }

    /// Traces places that are untraced so far.
    void trace(std::span<const Spot> places) {
        std::vector<Sight> sights;
        for (const Spot p : places) {
            at_[index(p)] = static_cast<std::uint32_t>(looks_.size() + sights.size());
            sights.push_back(sight(p));
        }
        looks_.resize(looks_.size() + sights.size());
        trace(sights, std::span(looks_).last(sights.size()));
    }

    void look_at_pixels() {
        constexpr int tile = 16;
        std::vector<Spot> places;
        places.reserve(static_cast<std::size_t>(rows_ / 2 + 1) * static_cast<std::size_t>(columns_ / 2 + 1));
        for (int top = 0; top < rows_; top += tile) {
            for (int left = 0; left < columns_; left += tile) {
                for (int row = top; row < std::min(top + tile, rows_); row += 2) {
                    for (int column = left; column < std::min(left + tile, columns_); column += 2) places.push_back({row, column});
                }
            }
        }
        trace(places);
    }

    /// How much two first hits on one face differ: above 1, by a crease or a step.
    [[nodiscard]] static float turn(const Look& a, const Look& b) {
        static const float cos_crease = std::cos(crease_of_edges_degrees * degree);
        return (1 - dot(a.normal, b.normal)) / (1 - cos_crease);
    }
    [[nodiscard]] static float step(const Look& a, const Look& b) {
        const Vec3 between = b.point - a.point;
        return std::min(std::abs(dot(between, a.face_normal)) / a.step, std::abs(dot(between, b.face_normal)) / b.step);
    }
    [[nodiscard]] static float unlikeness(const Look& a, const Look& b) { return std::max(turn(a, b), step(a, b)); }
    [[nodiscard]] static bool are_apart(const Look& a, const Look& b) { return a.instance != b.instance || a.face != b.face; }
    [[nodiscard]] static bool differ(const Look& a, const Look& b) {
        if (are_apart(a, b)) return true;
        return a.instance != no_instance && unlikeness(a, b) > 1;
    }

    /// Cells of four pixels: without edges, with edges, and with edges to resolve by half pixels.
    enum : std::uint8_t { plain, crossed, sharp };

    [[nodiscard]] std::uint8_t& kind(Spot cell) {
        return kinds_[static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(columns_ / 2) + static_cast<std::size_t>(cell.column)];
    }
    void mark(Spot cell, std::uint8_t wanted) {
        if (!resolves_) wanted = crossed;
        if (cell.row < 0 || cell.column < 0 || cell.row >= rows_ / 2 || cell.column >= columns_ / 2 || kind(cell) >= wanted) return;
        if (kind(cell) == plain) cells_.push_back(cell);
        kind(cell) = wanted;
        if (wanted == sharp) sharp_cells_.push_back(cell);
    }
    /// Marks the cells on both sides of an interval between neighbouring pixels, or half of it.
    void mark(Spot a, Spot b, std::uint8_t wanted) {
        const int row = a.row / 2, column = a.column / 2;
        mark({row, column}, wanted);
        mark(a.row == b.row ? Spot{row - 1, column} : Spot{row, column - 1}, wanted);
    }

    void mark_cells() {
        std::vector<std::vector<std::pair<Spot, Spot>>> found(static_cast<std::size_t>(rows_ / 2 + 1));
        parallel_for(found.size(), 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const int row = 2 * static_cast<int>(i);
                for (int column = 0; column < columns_; column += 2) {
                    const Spot here{row, column}, right{row, column + 2}, below{row + 2, column};
                    if (right.column < columns_ && differ(look(here), look(right))) found[i].emplace_back(here, right);
                    if (below.row < rows_ && differ(look(here), look(below))) found[i].emplace_back(here, below);
                }
            }
        });
        for (const auto& row : found) {
            for (const auto& [a, b] : row) mark(a, b, crossed);
        }
    }

    /// The corners of the four sides of a cell, from the pixel at its top left on.
    static std::array<std::pair<Spot, Spot>, 4> sides(Spot cell) {
        const int top = 2 * cell.row, left = 2 * cell.column;
        const Spot top_left{top, left}, top_right{top, left + 2}, bottom_left{top + 2, left}, bottom_right{top + 2, left + 2};
        return {{{top_left, top_right}, {top_left, bottom_left}, {bottom_left, bottom_right}, {top_right, bottom_right}}};
    }
    static Spot middle(Spot a, Spot b) { return {(a.row + b.row) / 2, (a.column + b.column) / 2}; }

    /// Calls body for each interval of half a pixel in a cell, and whether it is on the cell's border.
    template <class Body>
    static void for_halves(Spot cell, Body body) {
        const int top = 2 * cell.row, left = 2 * cell.column;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 2; ++j) {
                body(Spot{top + i, left + j}, Spot{top + i, left + j + 1}, i != 1);
                body(Spot{top + j, left + i}, Spot{top + j + 1, left + i}, i != 1);
            }
        }
    }

    /// Along a curve that fills the plane: rays of neighbours are faster after each other.
    static bool is_before_along_curve(Spot a, Spot b) { return along_curve(a) < along_curve(b); }
    static std::uint64_t along_curve(Spot p) {
        const auto spread = [](int number) {
            auto bits = static_cast<std::uint64_t>(number);
            bits = (bits | bits << 16) & 0x0000ffff0000ffff, bits = (bits | bits << 8) & 0x00ff00ff00ff00ff;
            bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0f, bits = (bits | bits << 2) & 0x3333333333333333;
            return (bits | bits << 1) & 0x5555555555555555;
        };
        return 2 * spread(p.row) + spread(p.column);
    }

    /// Traces half pixels of sharp cells. Their neighbours are sharp as well where these show more than pixels do.
    void resolve_sharp_cells() {
        for (std::size_t done = 0; done < sharp_cells_.size();) {
            Interruption::check();
            const std::size_t begin = done, end = sharp_cells_.size();
            std::sort(sharp_cells_.begin() + static_cast<std::ptrdiff_t>(begin), sharp_cells_.end(), is_before_along_curve);
            std::vector<Spot> spots;
            for (std::size_t n = begin; n < end; ++n) {
                const int top = 2 * sharp_cells_[n].row, left = 2 * sharp_cells_[n].column;
                for (const auto& [down, right] : {std::pair{0, 1}, {1, 0}, {1, 1}, {1, 2}, {2, 1}}) {
                    const Spot p{top + down, left + right};
                    if (at_[index(p)] != untraced) continue;
                    at_[index(p)] = 0;  // wanted
                    spots.push_back(p);
                }
            }
            trace(spots);
            for (std::size_t n = begin; n < end; ++n) {
                const Spot cell = sharp_cells_[n];
                for_halves(cell, [&](Spot a, Spot b, bool on_border) {
                    if (on_border && differ(look(a), look(b)) != (crossing(a, b) != none)) mark(a, b, sharp);
                });
            }
            done = end;
        }
    }

    /// A half or a quarter of an interval between pixels, by its first end.
    [[nodiscard]] std::uint64_t key(Spot a, Spot b) const { return 2 * static_cast<std::uint64_t>(index(a)) + (a.row == b.row ? 0 : 1); }

    /// The number of the crossing within half a pixel, if any.
    [[nodiscard]] std::uint32_t crossing(Spot a, Spot b) const {
        const auto found = crossings_.find(key(a, b));
        return found == crossings_.end() ? none : found->second;
    }
    /// The same within a pixel.
    [[nodiscard]] std::uint32_t crossing_of_side(Spot a, Spot b) const {
        const std::uint32_t first = crossing(a, middle(a, b));
        return first != none ? first : crossing(middle(a, b), b);
    }

    struct Interval {
        Look a, b;
        Sight from, to;
        Spot first, last;
        float step = 0;  // two bisections before the last
    };

    /// Bisects the intervals of all cells between pixels, or of sharp cells between half pixels.
    void place_crossings(int division) {
        std::vector<Interval> intervals;
        std::unordered_set<std::uint64_t> known;
        const auto add = [&](Spot a, Spot b) {
            if (differ(look(a), look(b)) && known.insert(key(a, b)).second) intervals.push_back({look(a), look(b), sight(a), sight(b), a, b, 0});
        };
        if (division == 1) {
            std::sort(cells_.begin(), cells_.end(), is_before_along_curve);
            for (const Spot cell : cells_) {
                for (const auto& [a, b] : sides(cell)) add(a, b);
            }
        } else {
            for (const Spot cell : sharp_cells_) {
                for_halves(cell, [&](Spot a, Spot b, bool) {
                    if (crossing(a, b) == none) add(a, b);
                });
            }
        }
        std::vector<Sight> middles(intervals.size());
        std::vector<Look> found(intervals.size());
        for (int level = division - 1; level < bisections; ++level) {
            Interruption::check();
            for (std::size_t i = 0; i < intervals.size(); ++i) {
                Interval& interval = intervals[i];
                if (level == bisections - 2) interval.step = step(interval.a, interval.b);
                middles[i] = {0.5f * (interval.from.row + interval.to.row), 0.5f * (interval.from.column + interval.to.column)};
            }
            trace(middles, found);
            for (std::size_t i = 0; i < intervals.size(); ++i) {
                Interval& interval = intervals[i];
                const bool before = are_apart(interval.a, found[i]), after = are_apart(found[i], interval.b);
                if (before && after && division == 1) mark(interval.first, interval.last, sharp);  // a third surface
                if (is_before(interval.a, found[i], interval.b)) {
                    interval.b = found[i], interval.to = middles[i];
                } else {
                    interval.a = found[i], interval.from = middles[i];
                }
            }
        }
        for (const Interval& interval : intervals) {
            const auto& [a, b, from, to, first, last, step_before] = interval;
            if (!is_edge(interval) || (!smooth_ && is_smooth(a, b))) continue;
            const PicturePoint at{0.5f * (from.row + to.row), 0.5f * (from.column + to.column)};
            const Spot half = middle(first, last);
            const bool is_first = division == 2 || at.row + at.column < sight(half).row + sight(half).column;
            crossings_[is_first ? key(first, division == 2 ? last : half) : key(half, last)] = static_cast<std::uint32_t>(network_.points.size());
            network_.points.push_back(at);
        }
    }

    /// Marks cells where curves meet, end or turn.
    void mark_sharp_cells() {
        static const float cos_sharp = std::cos(sharp_degrees * degree);
        struct Passage {
            Spot cell{-1, -1};
            PicturePoint from;
        };
        std::vector<Passage> passages(network_.points.size());
        for (std::size_t n = 0; n < cells_.size(); ++n) {
            const Spot cell = cells_[n];
            std::array<std::uint32_t, 4> met;
            std::size_t count = 0;
            for (const auto& [a, b] : sides(cell)) {
                if (const std::uint32_t one = crossing_of_side(a, b); one != none) met[count++] = one;
            }
            if (count == 1 || count > 2) mark(cell, sharp);
            if (count != 2) continue;
            for (const auto& [at, from] : {std::pair{met[0], met[1]}, {met[1], met[0]}}) {
                const PicturePoint here = network_.points[at], other = network_.points[from];
                Passage& passage = passages[at];
                if (passage.cell.row < 0) {
                    passage = {cell, other};
                    continue;
                }
                const float down = here.row - passage.from.row, right = here.column - passage.from.column;
                const float on_down = other.row - here.row, on_right = other.column - here.column;
                const float cosine = (down * on_down + right * on_right) / std::max(std::hypot(down, right) * std::hypot(on_down, on_right), 1e-9f);
                if (cosine < cos_sharp) mark(cell, sharp), mark(passage.cell, sharp);
            }
        }
    }

    /// Whether the edge between two looks is before the one in their middle.
    [[nodiscard]] static bool is_before(const Look& a, const Look& middle, const Look& b) {
        const bool first = are_apart(a, middle), second = are_apart(middle, b);
        if (first != second) return first;
        if (first || a.instance == no_instance) return true;
        return unlikeness(a, middle) >= unlikeness(middle, b);
    }
    /// Near a silhouette, depth changes by much without a step, but by ever less in smaller intervals.
    [[nodiscard]] static bool is_edge(const Interval& interval) {
        constexpr float lasting = 0.75f;
        const Look &a = interval.a, &b = interval.b;
        if (are_apart(a, b)) return true;
        if (a.instance == no_instance) return false;
        return turn(a, b) > 1 || step(a, b) > std::max(1.f, lasting * interval.step);
    }
    [[nodiscard]] static bool is_smooth(const Look& a, const Look& b) {
        static const float cos_smooth = std::cos(smooth_degrees * degree);
        if (a.instance != b.instance || a.instance == no_instance || dot(a.normal, b.normal) < cos_smooth) return false;
        return unlikeness(a, b) <= 1;
    }

    /// Makes segments in all cells, and in the four halves of sharp ones.
    void connect() {
        for (const Spot cell : cells_) {
            if (kind(cell) == crossed) {
                std::array<std::uint32_t, 4> met;
                for (std::size_t i = 0; i < met.size(); ++i) met[i] = crossing_of_side(sides(cell)[i].first, sides(cell)[i].second);
                connect(met);
                continue;
            }
            for (const auto& [down, right] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}}) {
                const int row = 2 * cell.row + down, column = 2 * cell.column + right;
                const Spot top_left{row, column}, top_right{row, column + 1}, bottom_left{row + 1, column}, bottom_right{row + 1, column + 1};
                connect({crossing(top_left, top_right), crossing(top_left, bottom_left), crossing(bottom_left, bottom_right),
                         crossing(top_right, bottom_right)});
            }
        }
    }
    void connect(const std::array<std::uint32_t, 4>& around) {
        std::array<std::uint32_t, 4> met;
        std::size_t count = 0;
        for (const std::uint32_t one : around) {
            if (one != none) met[count++] = one;
        }
        if (count == 2) network_.segments.emplace_back(met[0], met[1]);
        if (count < 3) return;
        PicturePoint meeting;
        for (std::size_t i = 0; i < count; ++i) {
            meeting.row += network_.points[met[i]].row / static_cast<float>(count);
            meeting.column += network_.points[met[i]].column / static_cast<float>(count);
            network_.segments.emplace_back(met[i], static_cast<std::uint32_t>(network_.points.size()));
        }
        network_.points.push_back(meeting);
    }

    /// Leaves out curves that end within half a pixel of another: noise of grazing surfaces, not an edge.
    void cut_stubs() {
        std::vector<std::uint8_t> meets(network_.points.size());
        for (const auto& [a, b] : network_.segments) ++meets[a], ++meets[b];
        std::erase_if(network_.segments, [&](const auto& segment) {
            const auto& [a, b] = segment;
            if (std::min(meets[a], meets[b]) != 1 || std::max(meets[a], meets[b]) < 3) return false;
            --meets[a], --meets[b];
            return true;
        });
    }

    static constexpr std::uint32_t none = 0xffffffff;

    const Scene& scene_;
    Projection projection_;
    float begin_, pixel_;
    int rows_, columns_;  // of half pixels, one pixel beyond the picture on each side
    bool smooth_, resolves_, has_face_normals_;
    std::vector<Look> looks_;
    std::vector<std::uint32_t> at_;     // indices of looks
    std::vector<std::uint8_t> kinds_;   // of cells
    std::vector<Spot> cells_, sharp_cells_;  // that are crossed or sharp, and the latter
    std::unordered_map<std::uint64_t, std::uint32_t> crossings_;  // points of the network, by the key of half a pixel
    LineNetwork network_;
};

}  // namespace

Curves visible_edges(const Scene& scene, const Camera& camera, int height, int width, bool smooth) {
    return Finder(scene, camera, height, width, smooth, 0, height)();
}

void draw_visible_edges(const Scene& scene, const Camera& camera, int height, int width, int begin, int end, float width_of_stroke,
                        std::span<float> coverage) {
    const int beyond = 2 + static_cast<int>(std::ceil(width_of_stroke));  // strokes from there reach the rows
    Curves curves = Finder(scene, camera, height, width, true, std::max(0, begin - beyond), std::min(height, end + beyond))();
    for (PicturePoint& point : curves.points) point.row -= static_cast<float>(begin);
    draw_strokes(curves.points, curves.ends, width_of_stroke, end - begin, width, coverage.data());
}

void draw_coarse_edges(const Scene& scene, const Camera& camera, int height, int width, int step, float width_of_stroke, std::span<float> coverage) {
    const Curves curves = Finder(scene, camera, height, width, true, 0, height, step)();
    draw_strokes(curves.points, curves.ends, width_of_stroke, height, width, coverage.data());
}

}  // namespace bob
