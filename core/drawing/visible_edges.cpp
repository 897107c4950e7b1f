#include "drawing/visible_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/interruption.h"
#include "base/parallel.h"
#include "base/thread_memory.h"

namespace bob {
namespace {

/// Pixels by which a surface must leave the plane of its neighbour for a step in depth.
constexpr float least_step = 0.5f;

/// Hits are this far from their surfaces, in radii of the scene.
constexpr float hit_error = 4e-5f;

/// Intervals of half a pixel are bisected so many times.
constexpr int bisections = 4;

/// In pixels: a twentieth of a thin stroke.
constexpr float tolerance_of_curves = 0.05f;

/// Faces that meet at a smaller angle meet smoothly: borders of CAD faces agree to a degree.
constexpr float smooth_degrees = 3;

constexpr float degree = 3.14159265f / 180;

/// A place in half pixels: the centres of pixels are even, and the picture's first is 2, 2.
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
    Finder(const Scene& scene, const Camera& camera, int height, int width, bool smooth)
        : scene_(scene), projection_(camera, height, width), rows_(2 * height + 3), columns_(2 * width + 3), smooth_(smooth),
          at_(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_), untraced),
          marked_(static_cast<std::size_t>(height + 1) * static_cast<std::size_t>(width + 1)) {}

    Curves operator()() {
        look_at_pixels();
        mark_cells();
        resolve_cells();
        place_crossings();
        connect();
        return joined(network_, tolerance_of_curves);
    }

private:
    static constexpr std::uint32_t untraced = 0xffffffff;

    [[nodiscard]] std::size_t index(Spot p) const {
        return static_cast<std::size_t>(p.row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(p.column);
    }
    [[nodiscard]] const Look& look(Spot p) const { return looks_[at_[index(p)]]; }
    static Sight sight(Spot p) { return {0.5f * static_cast<float>(p.row) - 1, 0.5f * static_cast<float>(p.column) - 1}; }

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
            scene_.face_normals(rays, hits, face_normals);
            for (std::size_t j = 0; j < rays.size(); ++j) {
                if (hits[j].instance == no_instance) continue;
                const Vec3 point = rays[j].origin + hits[j].t * rays[j].direction;
                const float along = std::abs(dot(face_normals[j], normalized(rays[j].direction)));
                const float step = least_step * projection_.pixel_width(projection_.depth(point)) * along + hit_error;
                looks[number[j]] = {point, normals[j], face_normals[j], step, hits[j].instance,
                                    scene_[hits[j].instance].shape->face(hits[j].in_shape)};
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

    /// How much two first hits differ that continue each other within a face: above 1 there is an edge between them.
    [[nodiscard]] float unlikeness(const Look& a, const Look& b) const {
        static const float cos_crease = std::cos(crease_of_edges_degrees * degree);
        const float turned = (1 - dot(a.normal, b.normal)) / (1 - cos_crease);
        const Vec3 between = b.point - a.point;
        const auto off_plane = [&](const Look& of) { return std::abs(dot(between, of.face_normal)) / of.step; };
        const float stepped = std::min(off_plane(a), off_plane(b));
        return std::max(turned, stepped);
    }
    [[nodiscard]] static bool are_apart(const Look& a, const Look& b) { return a.instance != b.instance || a.face != b.face; }
    [[nodiscard]] bool differ(const Look& a, const Look& b) const {
        if (are_apart(a, b)) return true;
        return a.instance != no_instance && unlikeness(a, b) > 1;
    }

    void mark(int row, int column) {
        if (row < 0 || column < 0 || row >= rows_ / 2 || column >= columns_ / 2) return;
        std::uint8_t& marked = marked_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_ / 2) + static_cast<std::size_t>(column)];
        if (!marked) marked = 1, cells_.push_back({row, column});
    }
    /// Marks the cells on both sides of an interval between neighbouring pixels, or half of it.
    void mark(Spot a, Spot b) {
        const int row = a.row / 2, column = a.column / 2;
        if (a.row == b.row) {
            mark(row, column), mark(row - 1, column);
        } else {
            mark(row, column), mark(row, column - 1);
        }
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
            for (const auto& [a, b] : row) mark(a, b);
        }
    }

    /// Calls body for each interval of half a pixel in a cell, and whether it is on the cell's border.
    template <class Body>
    static void for_intervals(Spot cell, Body body) {
        const int top = 2 * cell.row, left = 2 * cell.column;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 2; ++j) {
                body(Spot{top + i, left + j}, Spot{top + i, left + j + 1}, i != 1);
                body(Spot{top + j, left + i}, Spot{top + j + 1, left + i}, i != 1);
            }
        }
    }

    /// Traces half pixels of marked cells, and marks further cells where an edge leaves them.
    void resolve_cells() {
        for (std::size_t done = 0; done < cells_.size();) {
            Interruption::check();
            const std::size_t begin = done, end = cells_.size();
            std::vector<Spot> places;
            for (std::size_t n = begin; n < end; ++n) {
                const int top = 2 * cells_[n].row, left = 2 * cells_[n].column;
                for (const auto& [down, right] : {std::pair{0, 1}, {1, 0}, {1, 1}, {1, 2}, {2, 1}}) {
                    const Spot p{top + down, left + right};
                    if (at_[index(p)] != untraced) continue;
                    at_[index(p)] = 0;  // wanted
                    places.push_back(p);
                }
            }
            trace(places);
            for (std::size_t n = begin; n < end; ++n) {
                const Spot cell = cells_[n];
                for_intervals(cell, [&](Spot a, Spot b, bool on_border) {
                    if (on_border && differ(look(a), look(b))) mark(a, b);
                });
            }
            done = end;
        }
    }

    [[nodiscard]] std::uint64_t key(Spot a, Spot b) const { return 2 * static_cast<std::uint64_t>(index(a)) + (a.row == b.row ? 0 : 1); }

    struct Interval {
        Look a, b;
        Sight from, to;
        std::uint64_t key;
    };

    void place_crossings() {
        std::vector<Interval> intervals;
        for (const Spot cell : cells_) {
            for_intervals(cell, [&](Spot a, Spot b, bool) {
                const std::uint64_t name = key(a, b);
                if (!differ(look(a), look(b)) || !crossing_.emplace(name, none).second) return;
                intervals.push_back({look(a), look(b), sight(a), sight(b), name});
            });
        }
        std::vector<Sight> middles(intervals.size());
        std::vector<Look> found(intervals.size());
        for (int step = 0; step < bisections; ++step) {
            Interruption::check();
            for (std::size_t i = 0; i < intervals.size(); ++i) {
                const auto& [a, b, from, to, name] = intervals[i];
                middles[i] = {0.5f * (from.row + to.row), 0.5f * (from.column + to.column)};
            }
            trace(middles, found);
            for (std::size_t i = 0; i < intervals.size(); ++i) {
                auto& [a, b, from, to, name] = intervals[i];
                if (is_before(a, found[i], b)) {
                    b = found[i], to = middles[i];
                } else {
                    a = found[i], from = middles[i];
                }
            }
        }
        for (const auto& [a, b, from, to, name] : intervals) {
            if (!are_apart(a, b) && !(a.instance != no_instance && unlikeness(a, b) > 1)) continue;
            if (!smooth_ && is_smooth(a, b)) continue;
            crossing_[name] = static_cast<std::uint32_t>(network_.points.size());
            network_.points.push_back({0.5f * (from.row + to.row), 0.5f * (from.column + to.column)});
        }
    }
    /// Whether the edge between two looks is before the one in their middle.
    [[nodiscard]] bool is_before(const Look& a, const Look& middle, const Look& b) const {
        const bool first = are_apart(a, middle), second = are_apart(middle, b);
        if (first != second) return first;
        if (first || a.instance == no_instance) return true;
        return unlikeness(a, middle) >= unlikeness(middle, b);
    }
    [[nodiscard]] bool is_smooth(const Look& a, const Look& b) const {
        static const float cos_smooth = std::cos(smooth_degrees * degree);
        if (a.instance != b.instance || a.instance == no_instance || dot(a.normal, b.normal) < cos_smooth) return false;
        return unlikeness(a, b) <= 1;
    }

    /// Segments of all cells of half a pixel.
    void connect() {
        const auto crossing = [&](Spot a, Spot b) {
            const auto found = crossing_.find(key(a, b));
            return found == crossing_.end() ? none : found->second;
        };
        for (const Spot cell : cells_) {
            for (const auto& [down, right] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}}) {
                const int row = 2 * cell.row + down, column = 2 * cell.column + right;
                const Spot top_left{row, column}, top_right{row, column + 1}, bottom_left{row + 1, column}, bottom_right{row + 1, column + 1};
                std::array<std::uint32_t, 4> met;
                std::size_t count = 0;
                for (const std::uint32_t one : {crossing(top_left, top_right), crossing(top_left, bottom_left), crossing(bottom_left, bottom_right),
                                                crossing(top_right, bottom_right)}) {
                    if (one != none) met[count++] = one;
                }
                if (count == 2) network_.segments.emplace_back(met[0], met[1]);
                if (count < 3) continue;
                PicturePoint middle;
                for (std::size_t i = 0; i < count; ++i) {
                    middle.row += network_.points[met[i]].row / static_cast<float>(count);
                    middle.column += network_.points[met[i]].column / static_cast<float>(count);
                    network_.segments.emplace_back(met[i], static_cast<std::uint32_t>(network_.points.size()));
                }
                network_.points.push_back(middle);
            }
        }
    }

    static constexpr std::uint32_t none = 0xffffffff;

    const Scene& scene_;
    Projection projection_;
    int rows_, columns_;  // of half pixels, one pixel beyond the picture on each side
    bool smooth_;
    std::vector<Look> looks_;
    std::vector<std::uint32_t> at_;     // indices of looks
    std::vector<std::uint8_t> marked_;  // cells of four pixels
    std::vector<Spot> cells_;          // the same, in the order in which they were found
    std::unordered_map<std::uint64_t, std::uint32_t> crossing_;  // of intervals of half a pixel: their points
    LineNetwork network_;
};

}  // namespace

Curves visible_edges(const Scene& scene, const Camera& camera, int height, int width, bool smooth) {
    return Finder(scene, camera, height, width, smooth)();
}

}  // namespace bob
