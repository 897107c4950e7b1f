#include "formula/mesh_distance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/interruption.h"
#include "base/mutex.h"
#include "base/parallel.h"
#include "formula/expression.h"

namespace bob {
namespace {

using Point = MeshDistance::Point;
using Triangle = MeshDistance::Triangle;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr float float_infinity = std::numeric_limits<float>::infinity();

/// Bounds of a distance's rounding error.
constexpr double absolute_error = 1e-10, relative_error = 1e-12;

/// How far to the sides of a triangle its orientation is tested; thinner gaps are not resolved.
constexpr double aside = 1e-6;

constexpr float node_cost = 1.5f;

/// Maximum number of triangles tested for the sides of one, so that no file, however odd, takes minutes to build.
constexpr std::size_t most_beside = 2048, unlimited = std::numeric_limits<std::size_t>::max();

Point wide(Vec3 v) { return {v.x, v.y, v.z}; }

/// A box around a point in double precision, widened by `reach` on each side.
Box around(const Point& p, double reach) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
        const double at = p[static_cast<std::size_t>(axis)], slack = reach + 1e-6 * std::fabs(at) + 1e-30;
        box.low[axis] = static_cast<float>(at - slack), box.high[axis] = static_cast<float>(at + slack);
    }
    return box;
}

// ---- The meshes in use -----------------------------------------------------------------------------------

struct Registry {
    Mutex mutex;
    std::uint64_t last = 0;
    std::unordered_map<std::uint64_t, std::weak_ptr<const MeshDistance>> by_number;
    std::map<Digest, std::weak_ptr<const MeshDistance>> by_digest;
};

/// Never destroyed: formulas may live until the process ends.
Registry& registry() {
    static auto* const all = new Registry;
    return *all;
}

struct Clean {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
};

/// Merges equal vertices, in the order of their first use by triangles.
Clean merged(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
    struct Hash {
        std::size_t operator()(const std::array<std::uint32_t, 3>& bits) const {
            std::uint64_t h = 0;
            for (const std::uint32_t part : bits) h = (h ^ part) * 0x9e3779b97f4a7c15, h ^= h >> 29;
            return h;
        }
    };
    constexpr std::uint32_t unknown = 0xffffffff;
    std::unordered_map<std::array<std::uint32_t, 3>, std::uint32_t, Hash> places;
    places.reserve(vertices.size());
    std::vector<std::uint32_t> place(vertices.size(), unknown);
    Clean result;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 16384 == 0) Interruption::check();
        Triangle corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = triangles[i][k];
            if (vertex >= vertices.size()) throw std::invalid_argument("expected corners among the vertices, got another");
            if (place[vertex] == unknown) {
                const Vec3 v = vertices[vertex];
                for (int axis = 0; axis < 3; ++axis) {
                    if (!(std::fabs(v[axis]) <= 1)) throw std::invalid_argument("expected vertices in -1..1, got another");
                }
                const std::array bits{std::bit_cast<std::uint32_t>(v.x + 0.f), std::bit_cast<std::uint32_t>(v.y + 0.f),
                                      std::bit_cast<std::uint32_t>(v.z + 0.f)};
                const auto [found, is_new] = places.try_emplace(bits, static_cast<std::uint32_t>(result.vertices.size()));
                if (is_new) result.vertices.push_back({v.x + 0.f, v.y + 0.f, v.z + 0.f});  // turns -0 into 0
                place[vertex] = found->second;
            }
            corners[k] = place[vertex];
        }
        const bool has_area = corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0];
        if (has_area) result.triangles.push_back(corners);
    }
    return result;
}

/// Throws unless each edge occurs equally often in both directions.
void check_closed(const std::vector<Triangle>& triangles) {
    if (triangles.empty()) throw std::invalid_argument("expected a closed mesh, got no triangles");
    std::vector<std::uint64_t> edges;  // the ends, with the direction in the lowest bit
    edges.reserve(3 * triangles.size());
    for (const Triangle& t : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t from = t[k], to = t[(k + 1) % 3];
            edges.push_back(from < to ? from << 33 | to << 1 : to << 33 | from << 1 | 1);
        }
    }
    std::sort(edges.begin(), edges.end());
    std::size_t open = 0, against = 0;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t count = 0, backwards = 0;
        for (const std::uint64_t edge = edges[i] >> 1; i < edges.size() && edges[i] >> 1 == edge; ++i) ++count, backwards += edges[i] & 1;
        if (count % 2) ++open;
        if (count % 2 == 0 && 2 * backwards != count) ++against;
    }
    const auto edges_of = [](std::size_t n) { return std::to_string(n) + (n == 1 ? " edge" : " edges"); };
    if (open) throw std::invalid_argument("expected a closed mesh, got one with " + edges_of(open) + " where it is open");
    if (against) {
        throw std::invalid_argument("expected triangles that all wind the same way, got " + edges_of(against) + " between two that don't");
    }
}

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& items) {
    return std::as_bytes(std::span(items));
}

}  // namespace

std::shared_ptr<const MeshDistance> MeshDistance::of(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
    Clean mesh = merged(vertices, triangles);
    const Digest digest = Sha256().update(bytes_of(mesh.triangles)).update(bytes_of(mesh.vertices)).digest();
    Registry& all = registry();
    const auto same = [&]() -> std::shared_ptr<const MeshDistance> {
        const auto found = all.by_digest.find(digest);
        return found == all.by_digest.end() ? nullptr : found->second.lock();
    };
    {
        const std::lock_guard lock(all.mutex);
        if (auto known = same()) return known;
    }
    check_closed(mesh.triangles);
    const std::shared_ptr<MeshDistance> made(new MeshDistance(std::move(mesh.vertices), std::move(mesh.triangles), digest));
    const std::lock_guard lock(all.mutex);
    if (auto known = same()) return known;
    made->number_ = ++all.last;
    all.by_number[made->number_] = made;
    all.by_digest[digest] = made;
    return made;
}

std::shared_ptr<const MeshDistance> MeshDistance::numbered(double number) {
    if (!(number >= 1 && number <= 0x1p53 && number == std::floor(number))) return nullptr;
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    const auto found = all.by_number.find(static_cast<std::uint64_t>(number));
    return found == all.by_number.end() ? nullptr : found->second.lock();
}

MeshDistance::~MeshDistance() {
    if (!number_) return;
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    all.by_number.erase(number_);
    if (const auto found = all.by_digest.find(digest_); found != all.by_digest.end() && found->second.expired()) all.by_digest.erase(found);
}

// ---- Building --------------------------------------------------------------------------------------------

MeshDistance::MeshDistance(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const Digest& digest)
    : number_(0), digest_(digest), vertices_(std::move(vertices)), triangles_(std::move(triangles)), faces_(triangles_.size()) {
    std::vector<Box> boxes(faces_.size());
    parallel_for(faces_.size(), 16384, [&](std::size_t begin, std::size_t end) {
        Interruption::check();
        for (std::size_t i = begin; i < end; ++i) {
            Face& face = faces_[i];
            for (std::size_t k = 0; k < 3; ++k) face.corner[k] = vertices_[triangles_[i][k]], boxes[i].extend(face.corner[k]);
            const Point a = wide(face.corner[0]), n = cross(wide(face.corner[1]) - a, wide(face.corner[2]) - a);
            const double area = length(n);
            if (area > 0) face.normal = 1 / area * n;
        }
    });
    Bvh bvh = build_bvh(boxes, node_cost);
    nodes_ = std::move(bvh.nodes);
    leaves_.resize(bvh.packets.size());
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
        Leaf& leaf = leaves_[i];
        leaf.face = bvh.packets[i];
        for (std::size_t lane = 0; lane < leaf.face.size(); ++lane) {
            const bool absent = lane > 0 && leaf.face[lane] == leaf.face[0];
            const Box& box = boxes[leaf.face[lane]];
            for (int axis = 0; axis < 3; ++axis) {
                leaf.bounds[0][axis][lane] = absent ? float_infinity : box.low[axis];
                leaf.bounds[1][axis][lane] = absent ? -float_infinity : box.high[axis];
            }
        }
    }
    // Last, since it searches for triangles and tests points for inside.
    std::vector<std::int8_t> senses(faces_.size());
    parallel_for(faces_.size(), 1024, [&](std::size_t begin, std::size_t end) {
        Interruption::check();
        for (std::size_t i = begin; i < end; ++i) senses[i] = static_cast<std::int8_t>(sense(static_cast<std::uint32_t>(i)));
    });
    for (std::size_t i = 0; i < faces_.size(); ++i) faces_[i].sense = senses[i];
}

std::size_t MeshDistance::bytes() const {
    return vertices_.size() * sizeof(Vec3) + triangles_.size() * sizeof(Triangle) + faces_.size() * sizeof(Face) +
           nodes_.size() * sizeof(BvhNode) + leaves_.size() * sizeof(Leaf);
}

template <class Visit>
void MeshDistance::for_each_in(const Box& box, Visit visit) const {
    const auto meets = [&](const float (&bounds)[2][3][8], std::size_t k) {
        bool result = true;
        for (int axis = 0; axis < 3; ++axis) {
            result = result && bounds[0][axis][k] <= box.high[axis] && bounds[1][axis][k] >= box.low[axis];
        }
        return result;
    };
    ChildRef stack[7 * Bvh::max_depth + 8];
    std::size_t open = 0;
    stack[open++] = ChildRef::node(0);
    while (open > 0) {
        const ChildRef at = stack[--open];
        if (!at.is_leaf()) {
            const BvhNode& node = nodes_[at.node_index()];
            for (std::size_t k = 0; k < 8; ++k) {
                if (meets(node.bounds, k)) stack[open++] = node.child[k];
            }
            continue;
        }
        for (std::size_t i = at.first_packet(), end = i + at.packets(); i < end; ++i) {
            const Leaf& leaf = leaves_[i];
            for (std::size_t k = 0; k < 8; ++k) {
                if (meets(leaf.bounds, k) && !visit(leaf.face[k])) return;
            }
        }
    }
}

int MeshDistance::sense(std::uint32_t index) const {
    const Face& face = faces_[index];
    if (face.normal == Point{}) return 0;
    Box box;
    for (const Vec3 corner : face.corner) box.extend(corner);
    bool is_cut = false;
    std::size_t beside = 0;
    for_each_in(box, [&](std::uint32_t other) {
        is_cut = ++beside > most_beside || (other != index && overlap(face, faces_[other]));
        return !is_cut;
    });
    if (is_cut) return 0;
    const Point middle = 1 / 3. * (wide(face.corner[0]) + wide(face.corner[1]) + wide(face.corner[2]));
    const auto above = is_inside(middle + aside * face.normal, most_beside), below = is_inside(middle - aside * face.normal, most_beside);
    return above && below ? *below - *above : 0;
}

/// Whether two triangles share more than a corner, an edge or a touching point. If not, they have a separating axis: a
/// normal, the cross product of an edge of each or, for coplanar triangles, an edge normal in the plane.
bool MeshDistance::overlap(const Face& a, const Face& b) {
    const Point origin = wide(a.corner[0]);
    Point p[3], q[3], p_edge[3], q_edge[3];
    for (std::size_t k = 0; k < 3; ++k) p[k] = wide(a.corner[k]) - origin, q[k] = wide(b.corner[k]) - origin;
    for (std::size_t k = 0; k < 3; ++k) p_edge[k] = p[(k + 1) % 3] - p[k], q_edge[k] = q[(k + 1) % 3] - q[k];
    constexpr double touching = 1e-12;
    const auto range = [](const Point& axis, const Point (&points)[3]) {
        const double at[3] = {dot(axis, points[0]), dot(axis, points[1]), dot(axis, points[2])};
        return std::pair{std::min({at[0], at[1], at[2]}), std::max({at[0], at[1], at[2]})};
    };
    const auto apart = [&](const Point& axis) {
        const auto [p_low, p_high] = range(axis, p);
        const auto [q_low, q_high] = range(axis, q);
        const double slack = touching * length(axis);
        return slack > 0 && (p_low >= q_high - slack || q_low >= p_high - slack);
    };
    const auto [low, high] = range(a.normal, q);
    const bool coplanar = std::max(-low, high) <= touching;
    if (!coplanar && (apart(a.normal) || apart(b.normal))) return false;
    for (std::size_t i = 0; i < 3; ++i) {
        if (coplanar && (apart(cross(a.normal, p_edge[i])) || apart(cross(a.normal, q_edge[i])))) return false;
        for (std::size_t j = 0; j < 3 && !coplanar; ++j) {
            const Point axis = cross(p_edge[i], q_edge[j]);
            const bool is_axis = dot(axis, axis) > 1e-20 * dot(p_edge[i], p_edge[i]) * dot(q_edge[j], q_edge[j]);
            if (is_axis && apart(axis)) return false;
        }
    }
    return true;
}

// ---- Inside and outside ----------------------------------------------------------------------------------

/// Counts the winding of the triangles above p. A triangle's winding around the vertical line is the sum over its
/// edges, and opposite edges contribute exact negatives; so no line passes between two triangles.
std::optional<bool> MeshDistance::is_inside(const Point& p, std::size_t most) const {
    Box above = around(p, 0);
    above.high.z = float_infinity;
    int winding = 0;
    std::size_t looked_at = 0;
    for_each_in(above, [&](std::uint32_t index) {
        if (++looked_at > most) return false;
        const Face& face = faces_[index];
        const Point corner[3] = {wide(face.corner[0]) - p, wide(face.corner[1]) - p, wide(face.corner[2]) - p};
        int turns = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Point &a = corner[k], &b = corner[(k + 1) % 3];
            const bool rises = a[1] <= 0 && b[1] > 0, falls = b[1] <= 0 && a[1] > 0;
            if (!rises && !falls) continue;
            const double side = a[0] * b[1] - a[1] * b[0];
            turns += (rises && side > 0) - (falls && side < 0);
        }
        if (turns && turns * dot(cross(corner[1] - corner[0], corner[2] - corner[0]), corner[0]) > 0) winding += turns;
        return true;
    });
    if (looked_at > most) return std::nullopt;
    return winding != 0;
}

// ---- Distances -------------------------------------------------------------------------------------------

/// The closest point: Christer Ericson, "Real-Time Collision Detection", 2005, 5.1.5. Inside the triangle, the distance
/// along its normal, which is accurate for narrow triangles too.
MeshDistance::Closest MeshDistance::closest(const Face& face, const Point& p) {
    const Point a = wide(face.corner[0]), b = wide(face.corner[1]), c = wide(face.corner[2]);
    const auto at = [&](const Point& q) {
        const Point way = p - q;
        return Closest{dot(way, way), q};
    };
    const auto on_edge = [&](const Point& from, const Point& to) {
        const Point edge = to - from;
        return at(from + std::clamp(dot(p - from, edge) / dot(edge, edge), 0., 1.) * edge);
    };
    if (face.normal == Point{}) {
        const auto nearer = [](const Closest& one, const Closest& other) { return one.squared < other.squared; };
        return std::min({on_edge(a, b), on_edge(b, c), on_edge(c, a)}, nearer);
    }
    const Point ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return at(a);
    if (d3 >= 0 && d4 <= d3) return at(b);
    if (d6 >= 0 && d5 <= d6) return at(c);
    if (d1 * d4 - d3 * d2 <= 0 && d1 >= 0 && d3 <= 0) return on_edge(a, b);
    if (d5 * d2 - d1 * d6 <= 0 && d2 >= 0 && d6 <= 0) return on_edge(a, c);
    if (d3 * d6 - d5 * d4 <= 0 && d4 >= d3 && d5 >= d6) return on_edge(b, c);
    const double height = dot(ap, face.normal);
    return {height * height, p - height * face.normal, true};
}

/// `Number`: the type of distances from boxes.
template <class Number>
void MeshDistance::find_closest(const Point& p, Closest& best) const {
    constexpr Number none = std::numeric_limits<Number>::infinity();
    constexpr Number rounding = 8 * std::numeric_limits<Number>::epsilon();
    Number low[3], high[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<Number>(p[axis]), slack = rounding * std::fabs(at);
        low[axis] = at - slack, high[axis] = at + slack;
    }
    const auto squared_distances = [&](const float (&bounds)[2][3][8], Number (&squared)[8]) {
        for (std::size_t k = 0; k < 8; ++k) {
            Number sum = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const Number below = bounds[0][axis][k] - high[axis], above = low[axis] - bounds[1][axis][k];
                const Number outside = below > above ? below : above;
                const Number way = outside > 0 ? outside : 0;
                sum += way * way;
            }
            squared[k] = sum * (1 - rounding);
        }
    };
    struct Open {
        Number squared;
        ChildRef child;
    };
    Open stack[7 * Bvh::max_depth + 8];
    std::size_t open = 0;
    stack[open++] = {0, ChildRef::node(0)};
    while (open > 0) {
        const auto [bound, at] = stack[--open];
        if (bound > best.squared) continue;
        Number squared[8];
        if (!at.is_leaf()) {
            const BvhNode& node = nodes_[at.node_index()];
            squared_distances(node.bounds, squared);
            const std::size_t first = open;
            for (std::size_t k = 0; k < 8; ++k) {
                if (!(squared[k] <= best.squared) || squared[k] == none) continue;
                std::size_t i = open++;
                for (; i > first && stack[i - 1].squared < squared[k]; --i) stack[i] = stack[i - 1];
                stack[i] = {squared[k], node.child[k]};
            }
            continue;
        }
        for (std::size_t i = at.first_packet(), end = i + at.packets(); i < end; ++i) {
            const Leaf& leaf = leaves_[i];
            squared_distances(leaf.bounds, squared);
            for (std::size_t k = 0; k < 8; ++k) {
                if (!(squared[k] <= best.squared) || squared[k] == none) continue;
                const Closest here = closest(faces_[leaf.face[k]], p);
                if (here.squared < best.squared) best = here, best.face = leaf.face[k];
            }
        }
    }
}

MeshDistance::Closest MeshDistance::closest(const Point& p, const Known& known) const {
    // The closest triangle of a nearby point is close here; without one, any triangle will do.
    const std::uint32_t first = known.face == no_face ? 0 : known.face;
    Closest best = closest(faces_[first], p);
    best.face = first;
    // Far away, floats do not distinguish which box is closer.
    const bool is_far = std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])}) > 8;
    is_far ? find_closest<double>(p, best) : find_closest<float>(p, best);
    return best;
}

double MeshDistance::signed_distance(const Point& p, const Closest& closest, Known& known) const {
    const double distance = std::sqrt(closest.squared);
    const Face& face = faces_[closest.face];
    bool inside = false;
    if (closest.within && face.sense) {
        inside = face.sense * dot(p - wide(face.corner[0]), face.normal) < 0;
    } else if (known.face != no_face && length(p - known.point) < std::fabs(known.distance)) {
        inside = known.distance < 0;  // no surface lies between the two points
    } else {
        inside = *is_inside(p, unlimited);
    }
    const double result = inside ? -distance : distance;
    known = {p, result, closest.face};
    return result;
}

namespace {

/// The distance if a coordinate is NaN or infinite; 0 if all are finite.
double beyond(const Point& p) {
    const double size = std::fabs(p[0]) + std::fabs(p[1]) + std::fabs(p[2]);
    return size < infinity ? 0 : size;
}

}  // namespace

double MeshDistance::operator()(const Point& p, Known& known) const {
    if (const double value = beyond(p); value != 0) return value;
    if (known.face != no_face && known.point == p) return known.distance;
    return signed_distance(p, closest(p, known), known);
}

double MeshDistance::operator()(const Point& p, Known& known, Point& gradient) const {
    gradient = {};
    if (const double value = beyond(p); value != 0) return value;
    const Closest found = closest(p, known);
    const double distance = signed_distance(p, found, known);
    const Face& face = faces_[found.face];
    const Point way = p - found.point;
    const bool on_surface = std::fabs(distance) <= absolute_error, along_normal = on_surface || (found.within && face.sense);
    gradient = along_normal ? (face.sense < 0 ? -1. : 1.) * face.normal : 1 / distance * way;
    return distance;
}

/// Bounds the gradients of all points of a ball.
///
/// A point's gradient is spanned by the normals of the triangles that meet at its closest surface point: inside all
/// their planes is inside the surface there. All of these triangles are at most |distance| + 2 radius from the center.
/// So the gradient is a mean of normals, scaled to length 1.
bool MeshDistance::gradients(const Point& center, double radius, double distance, Point& low, Point& high) const {
    constexpr double least_length = 0.05;
    constexpr int most_faces = 256;  // boxes small enough for a useful bound have far fewer
    const double reach = (std::fabs(distance) + 2 * radius) * (1 + relative_error) + absolute_error;
    if (!(reach < 10)) return false;
    low = {2, 2, 2}, high = {-2, -2, -2};
    double shortest = 0;
    int looked_at = 0;
    for_each_in(around(center, reach), [&](std::uint32_t index) {
        if (++looked_at > most_faces) return false;
        const Face& face = faces_[index];
        if (face.normal == Point{}) return true;  // its neighbours' normals suffice
        if (closest(face, center).squared > reach * reach) return true;
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double n = face.sense * face.normal[axis];
            low[axis] = std::min(low[axis], n), high[axis] = std::max(high[axis], n);
            const double least = std::max({low[axis], -high[axis], 0.});
            squared += least * least;
        }
        shortest = face.sense ? std::sqrt(squared) : 0;
        return shortest >= least_length;
    });
    if (looked_at > most_faces || shortest < least_length) return false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (low[axis] < 0) low[axis] = std::max(-1., low[axis] / shortest);
        if (high[axis] > 0) high[axis] = std::min(1., high[axis] / shortest);
    }
    return true;
}

Expression distance_to_mesh(std::span<const Point> vertices, std::span<const Triangle> triangles) {
    Bounds box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (const Triangle& triangle : triangles) {
        for (const std::uint32_t corner : triangle) {
            if (corner >= vertices.size()) throw std::invalid_argument("expected corners among the vertices, got another");
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.low[axis] = std::min(box.low[axis], vertices[corner][axis]);
                box.high[axis] = std::max(box.high[axis], vertices[corner][axis]);
            }
        }
    }
    double center[3] = {}, half_side = 0;
    for (std::size_t axis = 0; axis < 3 && !triangles.empty(); ++axis) {
        center[axis] = box.low[axis] / 2 + box.high[axis] / 2;
        half_side = std::max({half_side, box.high[axis] - center[axis], center[axis] - box.low[axis]});
    }
    const double scale = half_side > 0 ? half_side : 1;
    std::vector<Vec3> relative(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            relative[i][axis] = static_cast<float>((vertices[i][k] - center[k]) / scale);
        }
    }
    Graph graph;
    Value p[3] = {graph.x(), graph.y(), graph.z()};
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = (p[axis] - center[axis]) / scale;
    return graph.expression(graph.mesh_distance(MeshDistance::of(relative, triangles), p[0], p[1], p[2]) * scale);
}

}  // namespace bob
