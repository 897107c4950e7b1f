#include <cmath>
#include <limits>
#include <vector>

#include "shapes/bvh_traversal.h"
#include "shapes/pieces.h"

namespace bob::BOB_ISA {
namespace {

using Float4 = Vector<4>;

// What rounding may do to points, in units. A hit may be found outside of its piece by as much, and by this share of the
// piece's size: no ray passes between pieces that meet, and nobody can see it.
constexpr float rounding = 2e-7f, overlap = 1e-5f;

// ---- Patches ------------------------------------------------------------------------------------------------

/// The Bernstein polynomials of degree p at t, and their derivatives; those are 0 for degree 0.
template <int P>
inline void bernstein(int p, float t, float* value, float* derivative) {
    if constexpr (P > 0) p = P;
    const float s = 1 - t;
    value[0] = 1;
    for (int k = 1; k < p; ++k) {
        float saved = 0;
        for (int i = 0; i < k; ++i) {
            const float b = value[i];
            value[i] = saved + s * b;
            saved = t * b;
        }
        value[k] = saved;
    }
    const auto degree = static_cast<float>(p);
    float before = 0;
    for (int i = 0; i < p; ++i) {
        const float b = value[i];
        derivative[i] = degree * (before - b);
        value[i] = t * before + s * b;
        before = b;
    }
    derivative[p] = degree * before;
    value[p] = t * before;
}

/// A point of a patch in homogeneous coordinates, and its derivatives.
struct Jet {
    Float4 x, u, v;
};

template <int P, int Q>
inline Jet evaluate_degrees(const float* points, int p, int q, float u, float v) {
    if constexpr (P > 0) p = P, q = Q;
    float in_u[max_degree + 1], d_u[max_degree + 1], in_v[max_degree + 1], d_v[max_degree + 1];
    bernstein<P>(p, u, in_u, d_u);
    bernstein<Q>(q, v, in_v, d_v);
    Jet jet{};
    for (int i = 0; i <= p; ++i) {
        Float4 row{}, row_v{};
        for (int j = 0; j <= q; ++j, points += 4) {
            const Float4 point = load<Float4>(points);
            row = fma(broadcast<Float4>(in_v[j]), point, row);
            row_v = fma(broadcast<Float4>(d_v[j]), point, row_v);
        }
        jet.x = fma(broadcast<Float4>(in_u[i]), row, jet.x);
        jet.u = fma(broadcast<Float4>(d_u[i]), row, jet.u);
        jet.v = fma(broadcast<Float4>(in_u[i]), row_v, jet.v);
    }
    return jet;
}

inline const float* points_of(const Pieces& pieces, const Patch& patch) {
    return pieces.control_points[patch.control_points].data();
}

inline Jet evaluate(const Pieces& pieces, const Patch& patch, float u, float v) {
    const float* points = points_of(pieces, patch);
    const int p = patch.degree_u, q = patch.degree_v;
    switch (16 * p + q) {
        case 0x11: return evaluate_degrees<1, 1>(points, p, q, u, v);
        case 0x12: return evaluate_degrees<1, 2>(points, p, q, u, v);
        case 0x21: return evaluate_degrees<2, 1>(points, p, q, u, v);
        case 0x22: return evaluate_degrees<2, 2>(points, p, q, u, v);
        case 0x13: return evaluate_degrees<1, 3>(points, p, q, u, v);
        case 0x31: return evaluate_degrees<3, 1>(points, p, q, u, v);
        case 0x23: return evaluate_degrees<2, 3>(points, p, q, u, v);
        case 0x32: return evaluate_degrees<3, 2>(points, p, q, u, v);
        case 0x33: return evaluate_degrees<3, 3>(points, p, q, u, v);
        default: return evaluate_degrees<0, 0>(points, p, q, u, v);
    }
}

inline Float4 cross(Float4 a, Float4 b) {
    const Float4 a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3), b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    const Float4 c = a * b_yzx - a_yzx * b;
    return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}

// Not std::fmin and std::fmax, which are calls.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }
inline float clamp(float x, float low, float high) { return smaller(larger(x, low), high); }

/// Of the first three components.
inline float dot(Float4 a, Float4 b) {
    const Float4 products = a * b;
    return products[0] + products[1] + products[2];
}

// ---- Rays ---------------------------------------------------------------------------------------------------

/// And what pieces need.
struct RayToPieces : RayThroughBoxes {
    Floats from[3], along[3];
    Float4 across[2];  // at right angles to the ray and to each other, of its length
    float length_squared, length;

    explicit RayToPieces(const Ray& ray) : RayThroughBoxes(ray) {
        for (int axis = 0; axis < 3; ++axis) {
            from[axis] = broadcast<Floats>(origin[axis]);
            along[axis] = broadcast<Floats>(direction[axis]);
        }
        length_squared = dot(direction, direction);
        length = std::sqrt(length_squared);
        // Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
        const float x = direction[0], y = direction[1], z = direction[2];
        const float sign = std::copysign(length, z);
        const float a = -1 / (sign + z), b = x * y * a;
        across[0] = Float4{sign * (sign + x * x * a), sign * b, -sign * x, 0} / length;
        across[1] = Float4{b, sign + y * y * a, -y, 0};
    }
};

/// A ray seen from a patch' centre: from its point at t = start on.
struct LocalRay {
    Float4 origin;  // and 0
    double start;

    LocalRay(const RayToPieces& ray, const Patch& patch, float start) : origin{}, start(start) {
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = static_cast<float>(static_cast<double>(ray.origin[axis]) +
                                              this->start * static_cast<double>(ray.direction[axis]) -
                                              static_cast<double>(patch.center[axis]));
        }
    }
};

/// w (S - origin): 0 across the ray where it meets the patch.
inline Float4 from_ray(Float4 homogeneous, Float4 origin) {
    return homogeneous - __builtin_shufflevector(homogeneous, homogeneous, 3, 3, 3, 3) * origin;
}

/// A part of a patch' parameters.
struct Part {
    float low[2], size[2];
};

enum class Found { hit, nothing, unclear };

struct Solution {
    float u, v;
    double t;
};

/// Newton's method on the two planes through the ray, from `at` on. Finds one hit, or that the root lies outside of the
/// part; where the part may hold more than one, neither says anything of the others.
inline Found newton(const Pieces& pieces, const Patch& patch, const RayToPieces& ray, const LocalRay& local,
                    const Part& part, Solution& at) {
    constexpr int most_steps = 8;
    constexpr float close = 2e-4f;  // a step from here on, in sizes of the part, leaves no error to speak of
    const float inverse_size[2] = {1 / part.size[0], 1 / part.size[1]};
    float last = 1;
    for (int step = 0; step < most_steps; ++step) {
        const Jet jet = evaluate(pieces, patch, at.u, at.v);
        const Float4 f = from_ray(jet.x, local.origin), f_u = from_ray(jet.u, local.origin),
                     f_v = from_ray(jet.v, local.origin);
        const float a = dot(f, ray.across[0]), b = dot(f, ray.across[1]);
        const float a_u = dot(f_u, ray.across[0]), b_u = dot(f_u, ray.across[1]);
        const float a_v = dot(f_v, ray.across[0]), b_v = dot(f_v, ray.across[1]);
        const float inverse = 1 / (a_u * b_v - a_v * b_u);
        const float d_u = (a_v * b - a * b_v) * inverse, d_v = (a * b_u - a_u * b) * inverse;
        at.u += d_u, at.v += d_v;
        const float x = (at.u - part.low[0]) * inverse_size[0] - 0.5f, y = (at.v - part.low[1]) * inverse_size[1] - 0.5f;
        const float size = larger(std::fabs(d_u) * inverse_size[0], std::fabs(d_v) * inverse_size[1]);
        if (!(size < 2)) return Found::unclear;  // or NaN
        const bool converged = size < close;
        // Steps shrink fast in pieces: where the root is farther away than the last one, it is outside.
        if (!converged && !(step > 0 && size < 0.5f * last)) {
            last = size;
            continue;
        }
        const float slack = converged ? overlap : size + 0.1f;
        const float noise = rounding * ray.length * std::fabs(inverse);
        const float noise_x = noise * (std::fabs(a_v) + std::fabs(b_v)) * inverse_size[0];
        const float noise_y = noise * (std::fabs(a_u) + std::fabs(b_u)) * inverse_size[1];
        if (std::fabs(x) > 0.5f + slack + noise_x || std::fabs(y) > 0.5f + slack + noise_y) return Found::nothing;
        if (converged) {
            const Float4 last_f = f + broadcast<Float4>(d_u) * f_u + broadcast<Float4>(d_v) * f_v;
            const float w = jet.x[3] + d_u * jet.u[3] + d_v * jet.v[3];
            at.t = local.start + static_cast<double>(dot(last_f, ray.direction) / (w * ray.length_squared));
            return Found::hit;
        }
        last = size;
    }
    return Found::unclear;
}

/// The piece that a ray is tested against.
struct Piece {
    const Patch& patch;
    std::uint32_t index;  // of the patch
    bool trimmed;
    Part part;
};

/// The nearest hit of a ray. One beyond its face's region, within the tolerance, only counts where no face is: until the
/// end its t is larger by a few tolerances, so that it stays behind a neighbour that it would show through.
struct Nearest {
    Hit hit;
    float penalty;
    bool is_beyond = false;

    Nearest(const Pieces& pieces, const RayToPieces& ray) : penalty(4 * pieces.tolerance / ray.length) {}

    void offer(const Piece& piece, const Solution& found) {
        const auto t = static_cast<float>(found.t);
        if (!(t > 0 && t < hit.t)) return;
        const float u = clamp(found.u, 0, 1), v = clamp(found.v, 0, 1);
        const auto seen = piece.trimmed ? piece.patch.coverage(u, v) : TrimRegion::Coverage::all;
        const bool beyond = seen == TrimRegion::Coverage::some;
        if (seen == TrimRegion::Coverage::none || (beyond && t + penalty >= hit.t)) return;
        hit = {beyond ? t + penalty : t, u, v, piece.index};
        is_beyond = beyond;
    }

    [[nodiscard]] Hit result() const {
        Hit result = hit;
        if (is_beyond) result.t -= penalty;
        return result;
    }
};

// ---- Subdivision --------------------------------------------------------------------------------------------

/// A part of a patch that may hold any number of hits. Its control points as the ray sees them are in a slot of the
/// workspace.
struct Net {
    Part part;
    float nearest;  // lower bound of t, from the local ray's start on
    std::size_t slot;
};

/// Control points, in a vector of a type of this file's own: code for one that others have, too, would be shared with
/// other instruction sets.
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

/// What subdivision needs, kept from ray to ray.
struct Workspace {
    ControlPoints points;
    std::vector<Net> open;
};

/// All hits of a ray with a part of a patch, where nothing is known of how many there are: Bezier subdivision
/// (Nishita, Sederberg and Kakimoto, "Ray Tracing Trimmed Rational Surface Patches", 1990), near parts first, down to
/// parts that hold one hit at most, for Newton's method, or that are too small to matter.
class Subdivision {
public:
    /// `normal`, of any length, is about that of the part, which is thinnest along it.
    Subdivision(const Pieces& pieces, const Piece& piece, const RayToPieces& ray, const LocalRay& local,
                Nearest& nearest, Float4 normal, Workspace& workspace)
        : pieces_(pieces), piece_(piece), ray_(ray), local_(local), nearest_(nearest), points_(workspace.points),
          open_(workspace.open), rows_(piece.patch.degree_u + 1u), columns_(piece.patch.degree_v + 1u),
          size_(rows_ * columns_) {
        along_ = ray.direction / broadcast<Float4>(ray.length);
        across_[0] = normal - broadcast<Float4>(dot(normal, along_)) * along_;
        if (!(dot(across_[0], across_[0]) > 1e-6f * dot(normal, normal))) across_[0] = ray.across[0];
        across_[0] /= broadcast<Float4>(std::sqrt(dot(across_[0], across_[0])));
        across_[1] = cross(along_, across_[0]);
    }

    void find() {
        const Part& part = piece_.part;
        open_.clear();
        if (points_.size() < size_) points_.resize(size_);
        const float* from = points_of(pieces_, piece_.patch);
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
    static constexpr int most_parts = 1000;
    static constexpr float smallest = 5e-7f;  // extent of a part that is taken for a point

    [[nodiscard]] bool is_behind(const Net& net) const {
        return local_.start + static_cast<double>(net.nearest) >= static_cast<double>(nearest_.hit.t);
    }

    /// Between neighbours along u (0) or v (1), in points_.
    [[nodiscard]] std::size_t step(int along) const { return along == 0 ? columns_ : 1; }
    [[nodiscard]] std::size_t count(int along) const { return along == 0 ? rows_ : columns_; }

    /// Subdivides a net at t by de Casteljau's algorithm; the lower or upper part goes to another slot, or the same.
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

    /// Opens a part, unless the ray passes it by.
    void push(const Part& part, std::size_t slot) {
        Float4 low = points_[slot * size_], high = low;
        for (std::size_t i = slot * size_ + 1; i < (slot + 1) * size_; ++i) {
            low = min(low, points_[i]), high = max(high, points_[i]);
        }
        if (low[0] > rounding || high[0] < -rounding || low[1] > rounding || high[1] < -rounding) return;
        const float nearest = low[2] / (low[2] > 0 ? high[3] : low[3]);
        const Net net{part, nearest / ray_.length, slot};
        if (!is_behind(net)) open_.push_back(net);
    }

    void look_into(const Net& net) {
        const Part& part = net.part;
        const Differences in_u = differences(net, 0), in_v = differences(net, 1);
        const float u = part.low[0] + 0.5f * part.size[0], v = part.low[1] + 0.5f * part.size[1];
        if (never_folds(in_u, in_v)) {
            if (passes_by(net, in_u, in_v)) return;
            Solution at{u, v, 0};
            if (newton(pieces_, piece_.patch, ray_, local_, part, at) == Found::hit) {
                return nearest_.offer(piece_, at);
            }
            // A root outside, such as that of a silhouette's other side, does not exclude one inside.
        }
        const float extent[2] = {in_u.extent(rows_ - 1), in_v.extent(columns_ - 1)};
        if (larger(extent[0], extent[1]) < smallest) {
            return nearest_.offer(piece_, {u, v, local_.start + static_cast<double>(middle(net) / ray_.length)});
        }
        const int along = extent[1] > extent[0];
        Part halves[2] = {part, part};
        for (Part& half : halves) half.size[along] *= 0.5f;
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

        /// About the length of the longest line of control points.
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

    /// Whether the projection along the ray has a determinant of one sign for all derivatives in their boxes: then the
    /// ray meets the part once at most (pieces_build.cpp says why).
    static bool never_folds(const Differences& u, const Differences& v) {
        const Float4 a{u.low[0], u.high[0], u.low[0], u.high[0]}, b{v.low[1], v.low[1], v.high[1], v.high[1]};
        const Float4 c{u.low[1], u.high[1], u.low[1], u.high[1]}, d{v.low[0], v.low[0], v.high[0], v.high[0]};
        const Float4 plus = a * b, minus = c * d;
        const auto least = [](Float4 x) { return smaller(smaller(x[0], x[1]), smaller(x[2], x[3])); };
        const auto most = [](Float4 x) { return larger(larger(x[0], x[1]), larger(x[2], x[3])); };
        return least(plus) > most(minus) || most(plus) < least(minus);
    }

    /// Whether all control points are on one side of a line through the ray, seen along it, that runs along u or v.
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
    const RayToPieces& ray_;
    const LocalRay& local_;
    Nearest& nearest_;
    ControlPoints& points_;
    std::vector<Net>& open_;
    std::size_t rows_, columns_, size_;
    Float4 along_, across_[2];  // unit length
};

// ---- Packets ------------------------------------------------------------------------------------------------

/// Intersects the pieces whose boxes the ray enters, and keeps the nearest hit.
inline void intersect(const Pieces& pieces, const PiecePacket& packet, const RayToPieces& ray, Workspace& workspace,
                      Nearest& nearest) {
    for (int i = 0; i < 8; i += width) {
        Floats o[3], d[3];
        Floats enter = broadcast<Floats>(0.f), leave = broadcast<Floats>(nearest.hit.t);
        for (int axis = 0; axis < 3; ++axis) {
            const auto& row = packet.to_box[axis];
            const Floats x = load<Floats>(&row[0][i]), y = load<Floats>(&row[1][i]), z = load<Floats>(&row[2][i]);
            o[axis] = fma(x, ray.from[0], fma(y, ray.from[1], fma(z, ray.from[2], load<Floats>(&row[3][i]))));
            d[axis] = fma(x, ray.along[0], fma(y, ray.along[1], z * ray.along[2]));
            const Floats half = axis < 2 ? load<Floats>(&packet.half[axis][i]) : broadcast<Floats>(1.f);
            const Floats inverse = 1.f / d[axis];
            const Floats a = (-half - o[axis]) * inverse, b = (half - o[axis]) * inverse;
            enter = max(min(a, b), enter);
            leave = min(max(a, b), leave);
        }
        for (unsigned entered = bits(enter <= leave); entered; entered &= entered - 1) {
            const int lane = __builtin_ctz(entered);
            if (!(enter[lane] < nearest.hit.t)) continue;
            const int k = i + lane;
            const std::uint32_t index = packet.patch[k] & ~PiecePacket::trimmed;
            const Piece piece{pieces.patches[index], index, (packet.patch[k] & PiecePacket::trimmed) != 0,
                              {{packet.low[0][k], packet.low[1][k]}, {packet.size[0][k], packet.size[1][k]}}};
            const Part& part = piece.part;
            const float slant = d[2][lane];
            if (std::fabs(slant) > packet.fold[k] * ray.length) {
                const float t = clamp(-o[2][lane] / slant, enter[lane], leave[lane]);
                const LocalRay local(ray, piece.patch, t);
                const float x = clamp(o[0][lane] + t * d[0][lane], -1, 1);
                const float y = clamp(o[1][lane] + t * d[1][lane], -1, 1);
                Solution at{part.low[0] + (0.5f + 0.5f * x) * part.size[0],
                            part.low[1] + (0.5f + 0.5f * y) * part.size[1], 0};
                const Found found = newton(pieces, piece.patch, ray, local, part, at);
                if (found == Found::hit) nearest.offer(piece, at);
                // Closer to tangent, a root outside may be a second one.
                const bool only_root = std::fabs(slant) > 2 * packet.fold[k] * ray.length;
                if (found == Found::hit || (found == Found::nothing && only_root)) continue;
            }
            const LocalRay local(ray, piece.patch, enter[lane]);
            const auto& z = packet.to_box[2];
            const Float4 normal{z[0][k], z[1][k], z[2][k], 0};
            Subdivision(pieces, piece, ray, local, nearest, normal, workspace).find();
        }
    }
}

void closest_hits(const Pieces& pieces, std::span<const Ray> rays, Hit* hits) {
    Workspace workspace;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const RayToPieces ray(rays[i]);
        Nearest nearest(pieces, ray);
        traverse(pieces.nodes.data(), ray, nearest.hit, [&](std::uint32_t packet) {
            intersect(pieces, pieces.packets[packet], ray, workspace, nearest);
        });
        hits[i] = nearest.result();
    }
}

/// dS/du x dS/dv, of any length; 0 at a pole, and where the squared sine of the angle between the two is not above `parallel`.
inline Float4 normal_at(const Pieces& pieces, const Patch& patch, float u, float v, float parallel) {
    const Jet jet = evaluate(pieces, patch, u, v);
    const Float4 x = jet.x / broadcast<Float4>(jet.x[3]);
    const Float4 s_u = from_ray(jet.u, x), s_v = from_ray(jet.v, x);
    const Float4 n = cross(s_u, s_v);
    return dot(n, n) > parallel * dot(s_u, s_u) * dot(s_v, s_v) ? n : Float4{};
}

void normals(const Pieces& pieces, std::span<const Ray> rays, const Hit* hits, Vec3* normals) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Patch& patch = pieces.patches[hits[i].primitive];
        float u = hits[i].u, v = hits[i].v;
        constexpr float but_for_rounding = 1e-9f;
        Float4 n = normal_at(pieces, patch, u, v, but_for_rounding);
        // At a pole it is that of a point near it, towards the middle of the patch.
        for (float nearer = 1e-3f; dot(n, n) == 0 && nearer < 0.5f; nearer *= 4) {
            n = normal_at(pieces, patch, u + nearer * (0.5f - u), v + nearer * (0.5f - v), but_for_rounding);
        }
        if (dot(n, n) == 0) n = normal_at(pieces, patch, u, v, 0);  // a needle's
        const Vec3 normal = normalized({n[0], n[1], n[2]});
        normals[i] = bob::dot(normal, rays[i].direction) > 0 ? -normal : normal;
    }
}

}  // namespace

const PieceKernels piece_kernels = {closest_hits, normals};

}  // namespace bob::BOB_ISA
