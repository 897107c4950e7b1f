#include "tracing/snapping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "shapes/edges.h"
#include "shapes/mesh/mesh.h"

namespace bob {
namespace {

/// Nearer edges in the foreground are found sooner than hidden ones behind them.
constexpr std::size_t most_tries = 64;

/// Surfaces that hide a point are this far in front of it, in pixels and in radii.
constexpr float in_front = 1.5f, hit_error = 4e-5f;

/// In pixels: points so close together are at one place, as those of edges along the line of sight.
constexpr float same_place = 0.01f;

/// Places of a circle that tell whether it is visible.
constexpr int around = 16;

const std::vector<ShapeEdge>* edges_of(const Shape& shape) {
    const auto* const mesh = dynamic_cast<const Mesh*>(&shape);
    return mesh ? &mesh->creases() : shape.edges();
}

struct Candidate {
    Snap snap;
    float distance;                      // in pixels
    float depth;                         // as in Projection::Seen
    const EdgeCircle* circle = nullptr;  // of a centre, in the shape

    [[nodiscard]] bool is_edge() const { return snap.kind == SnapKind::edge; }

    [[nodiscard]] bool is_before(const Candidate& other) const {
        return is_edge() != other.is_edge() ? other.is_edge() : distance < other.distance;
    }
};

class Finder {
public:
    Finder(const Scene& scene, const Camera& camera, int height, int width, float row, float column, float reach)
        : scene_(scene), projection_(camera, height, width), row_(row), column_(column), reach_(reach) {}

    std::optional<Snap> operator()() {
        for (std::uint32_t k = 0; k < scene_.size(); ++k) {
            if (is_near(scene_[k])) add(k);
        }
        std::sort(candidates_.begin(), candidates_.end(), [](const auto& a, const auto& b) { return a.is_before(b); });
        if (candidates_.size() > most_tries) candidates_.resize(most_tries);
        const auto first = std::ranges::find_if(candidates_, [&](Candidate& candidate) { return is_visible(candidate); });
        if (first == candidates_.end()) return std::nullopt;
        // Rays along a face seen edge-on miss it, so that its far end seems visible.
        auto found = first;
        for (auto next = first + 1; next != candidates_.end(); ++next) {
            if (next->is_edge() != first->is_edge() || next->distance > first->distance + same_place) break;
            if (next->depth > found->depth && is_visible(*next)) found = next;
        }
        return found->snap;
    }

private:
    [[nodiscard]] float distance(const Projection::Seen& seen) const { return std::hypot(seen.row - row_, seen.column - column_); }

    /// Whether the box of an instance is within reach in the picture.
    [[nodiscard]] bool is_near(const Instance& instance) const {
        float top = HUGE_VALF, left = HUGE_VALF, bottom = -HUGE_VALF, right = -HUGE_VALF;
        for (int corner = 0; corner < 8; ++corner) {
            const auto pick = [&](int axis) { return (corner >> axis & 1 ? instance.high : instance.low)[axis]; };
            const Projection::Seen seen = projection_.seen({pick(0), pick(1), pick(2)});
            if (!(seen.row == seen.row)) return true;
            top = std::min(top, seen.row), bottom = std::max(bottom, seen.row), left = std::min(left, seen.column), right = std::max(right, seen.column);
        }
        return top - reach_ <= row_ && row_ <= bottom + reach_ && left - reach_ <= column_ && column_ <= right + reach_;
    }

    [[nodiscard]] static Vec3d mapped(const AffineMap& map, const Vec3d& p) {
        Vec3d result;
        for (std::size_t i = 0; i < 3; ++i) result[i] = map.row[i][0] * p[0] + map.row[i][1] * p[1] + map.row[i][2] * p[2] + map.row[i][3];
        return result;
    }

    /// Adds the candidates of an instance.
    void add(std::uint32_t number) {
        const Instance& instance = scene_[number];
        const std::vector<ShapeEdge>* const edges = edges_of(instance.shape->surface());
        if (!edges) return;
        const AffineMap map = inverse(instance.to_shape);
        const auto [largest, second, smallest] = singular_values(map);
        const bool keeps_circles = largest <= (1 + 1e-6) * smallest;
        const auto add_point = [&](SnapKind kind, const Vec3d& in_shape, const ShapeEdge& edge) {
            const Vec3d point = mapped(map, in_shape);
            const Projection::Seen seen = projection_.seen(rounded(point));
            const float far = distance(seen);
            if (!(far <= reach_)) return;
            const bool has_radius = edge.circle && keeps_circles && (kind == SnapKind::center || kind == SnapKind::edge);
            const Snap snap{kind, point, has_radius ? std::optional(largest * edge.circle->radius) : std::nullopt, number, 0, 0};
            candidates_.push_back({snap, far, seen.depth, kind == SnapKind::center ? &*edge.circle : nullptr});
        };
        for (const ShapeEdge& edge : *edges) {
            if (edge.begins_at_corner) add_point(SnapKind::corner, edge.points.front(), edge);
            if (edge.ends_at_corner) add_point(SnapKind::corner, edge.points.back(), edge);
            if (edge.middle && (keeps_circles || edge.is_straight)) add_point(SnapKind::middle, *edge.middle, edge);
            if (edge.circle) add_point(SnapKind::center, edge.circle->center, edge);
            if (const auto point = nearest(map, edge)) add_point(SnapKind::edge, *point, edge);
        }
    }

    /// The point of an edge, in its shape, that is nearest in the picture, if it is within reach.
    [[nodiscard]] std::optional<Vec3d> nearest(const AffineMap& map, const ShapeEdge& edge) const {
        float least = reach_;
        std::optional<Vec3d> found;
        const auto seen_at = [&](const Vec3d& p) { return projection_.seen(rounded(mapped(map, p))); };
        Projection::Seen before = seen_at(edge.points[0]);
        for (std::size_t i = 1; i < edge.points.size(); ++i) {
            const Projection::Seen after = seen_at(edge.points[i]);
            const float down = after.row - before.row, right = after.column - before.column, squared = down * down + right * right;
            float t = squared > 0 ? std::clamp(((row_ - before.row) * down + (column_ - before.column) * right) / squared, 0.f, 1.f) : 0.f;
            const float far = std::hypot(row_ - before.row - t * down, column_ - before.column - t * right);
            if (far <= least) {
                if (projection_.in_perspective()) {  // equal steps in space are not equal in the picture
                    const float a = projection_.pixel_width(before.depth), b = projection_.pixel_width(after.depth);
                    t = t * a / (t * a + (1 - t) * b);
                }
                least = far;
                found = edge.points[i - 1] + double{t} * (edge.points[i] - edge.points[i - 1]);
            }
            before = after;
        }
        if (found && edge.circle) {  // from the chord onto the circle
            const Vec3d from = *found - edge.circle->center;
            const double size = length(from);
            if (size > 0) found = edge.circle->center + edge.circle->radius / size * from;
        }
        return found;
    }

    [[nodiscard]] SceneHit hit(float row, float column, Ray& ray) const {
        SceneHit found;
        if (projection_.ray(row, column, ray)) scene_.closest_hits({&ray, 1}, {&found, 1});
        return found;
    }

    /// Whether nothing hides a point, and the surface next to it, of its instance, is visible at the place that is stored.
    [[nodiscard]] bool is_visible_at(const Vec3d& point, Snap& snap) const {
        for (const SectionPlane& plane : scene_.sections()) {
            const double beyond = plane.normal[0] * point[0] + plane.normal[1] * point[1] + plane.normal[2] * point[2] - plane.offset;
            if (beyond > static_cast<double>(hit_error)) return false;
        }
        const Vec3 p = rounded(point);
        const Projection::Seen seen = projection_.seen(p);
        if (!(seen.row == seen.row)) return false;
        const float pixel = projection_.pixel_width(seen.depth);
        float least = HUGE_VALF;
        constexpr float off = 0.75f;
        for (const auto& [down, right] : {std::pair{0.f, 0.f}, {row_ - seen.row, column_ - seen.column}, {-off, 0.f}, {off, 0.f}, {0.f, -off}, {0.f, off},
                                          {-off, -off}, {-off, off}, {off, -off}, {off, off}}) {
            Ray ray;
            const SceneHit found = hit(seen.row + down, seen.column + right, ray);
            if (found.instance == no_instance) continue;
            const Vec3 at = ray.origin + found.t * ray.direction;
            const bool is_first = down == 0 && right == 0;
            if (is_first && dot(p - at, ray.direction) > length(ray.direction) * (in_front * pixel + hit_error)) return false;
            const float apart = length(at - p);
            if (scene_[found.instance].number != scene_[snap.instance].number || apart >= least) continue;
            least = apart, snap.row = seen.row + down, snap.column = seen.column + right;
        }
        return least < HUGE_VALF;
    }

    /// A centre is visible if its circle is.
    [[nodiscard]] bool is_visible(Candidate& candidate) const {
        if (!candidate.circle) return is_visible_at(candidate.snap.point, candidate.snap);
        const auto& [center, axis, radius] = *candidate.circle;
        const AffineMap map = inverse(scene_[candidate.snap.instance].to_shape);
        const Vec3d aside = std::abs(axis[0]) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, across = cross(axis, aside);
        const Vec3d x = radius / length(across) * across, y = cross(axis, x);
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around;
            if (is_visible_at(mapped(map, center + std::cos(angle) * x + std::sin(angle) * y), candidate.snap)) return true;
        }
        return false;
    }

    const Scene& scene_;
    Projection projection_;
    float row_, column_, reach_;
    std::vector<Candidate> candidates_;
};

}  // namespace

std::optional<Snap> snap(const Scene& scene, const Camera& camera, int height, int width, float row, float column, float reach) {
    return Finder(scene, camera, height, width, row, column, reach)();
}

}  // namespace bob
