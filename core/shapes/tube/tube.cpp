#include "shapes/tube/tube.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "base/interruption.h"
#include "shapes/sphere_around.h"

namespace bob {
namespace {

using Ball = std::array<double, 4>;  // x, y, z, radius

// Maximum distance of pieces from the curve, in space and radius: half the rounding of a float of size 1.
constexpr double tolerance = 3e-8;

// Maximum excess length of a piece's control polygon over its chord, relative to the chord.
constexpr double bend = 0.02;

// Only weights that differ by many powers of ten need this number of cuts. Beyond it, a part is a line segment between
// its ends.
constexpr int max_depth = 20;

// This number takes a few seconds, and 400 MB.
constexpr std::size_t max_pieces = 1 << 21;

// Bends are cut less often: a cusp remains one in pieces of any length.
constexpr int max_bend_depth = 6;

// Ends of pieces that are closer meet: the rounding of positions about 1 in size.
constexpr double same_place = 1e-6;

// Cost of visiting a node, in tests of a packet: of its boxes, and of some pieces. On helices and polylines of 200 and
// 1,000 pieces, 1.5 and 4 are 3 to 20 % slower.
constexpr float node_cost = 0.5f;

Ball euclidean(const Homogeneous<4>& p) { return {p[0] / p[4], p[1] / p[4], p[2] / p[4], p[3] / p[4]}; }

double distance(const Ball& a, const Ball& b) {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) sum += (b[axis] - a[axis]) * (b[axis] - a[axis]);
    return std::sqrt(sum);
}

Ball mix(const Ball& a, const Ball& b, double t) {
    Ball result;
    for (std::size_t i = 0; i < 4; ++i) result[i] = a[i] + t * (b[i] - a[i]);
    return result;
}

using Cubic = std::array<Ball, 4>;  // control points

/// The cubic with the end points and end derivatives of a rational Bezier curve. It is the curve itself if that is a
/// polynomial of degree 3 or less.
Cubic hermite(const BezierCurve<4>& curve) {
    const auto& p = curve.control_points;
    const std::size_t n = p.size() - 1;
    const Ball first = euclidean(p[0]), last = euclidean(p[n]);
    const double third = curve.degree() / 3.0;
    return {first, mix(first, euclidean(p[1]), third * p[1][4] / p[0][4]),
            mix(last, euclidean(p[n - 1]), third * p[n - 1][4] / p[n][4]), last};
}

Cubic straight(const Ball& a, const Ball& b) { return {a, mix(a, b, 1.0 / 3), mix(b, a, 1.0 / 3), b}; }

/// A bound of the distance between a rational Bezier curve and a cubic, at equal parameters.
///
/// The difference is a rational curve of degree p + 3, in the convex hull of its control points.
double deviation(const BezierCurve<4>& curve, const Cubic& cubic) {
    constexpr double of_three[4] = {1, 3, 3, 1};
    const std::size_t p = curve.control_points.size() - 1;
    std::array<Homogeneous<4>, max_degree + 4> sum{};
    double binomial = 1;
    for (std::size_t i = 0; i <= p; ++i) {
        const double weight = curve.control_points[i][4];
        const Ball point = euclidean(curve.control_points[i]);
        for (std::size_t j = 0; j < 4; ++j) {
            const double factor = binomial * of_three[j] * weight;
            for (std::size_t axis = 0; axis < 4; ++axis) sum[i + j][axis] += factor * (point[axis] - cubic[j][axis]);
            sum[i + j][4] += factor;
        }
        binomial = binomial * static_cast<double>(p - i) / static_cast<double>(i + 1);
    }
    double result = 0;
    for (std::size_t k = 0; k < p + 4; ++k) {
        for (const double difference : euclidean(sum[k])) result = std::max(result, std::fabs(difference));
    }
    return result;
}

bool is_bent(const Cubic& p) {
    return distance(p[0], p[1]) + distance(p[1], p[2]) + distance(p[2], p[3]) > (1 + bend) * distance(p[0], p[3]);
}

Ball ball_at(const TubePiece& piece, double s) {
    const double r = 1 - s;
    const double weight[4] = {r * r * r, 3 * r * r * s, 3 * r * s * s, s * s * s};
    Ball result{};
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t axis = 0; axis < 4; ++axis) result[axis] += weight[i] * piece.ball[i][axis];
    }
    return result;
}

Box box_around(const TubePiece& piece) {
    Box box;
    for (const auto& p : piece.ball) {
        const auto r = static_cast<float>(std::fabs(p[3]));
        const Vec3 centre{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
        box.extend(centre - Vec3{r, r, r});
        box.extend(centre + Vec3{r, r, r});
    }
    return box;
}

}  // namespace

Tube Tube::of_weighted_points(NurbsCurve<4> curve) {
    const Sphere sphere = sphere_around([&](auto add) {
        for (const auto& point : curve.control_points) add(point.data(), point[3]);
    });
    const double center[4] = {sphere.center[0], sphere.center[1], sphere.center[2], 0};
    make_homogeneous<4>(curve.control_points, center, sphere.radius);
    return Tube(curve, sphere);
}

Tube::Tube(const NurbsCurve<4>& curve, const Sphere& sphere) : Shape(sphere) {
    for (const BezierCurve<4>& bezier : decompose(curve)) cut(bezier, 0);
    std::vector<Box> boxes;
    float extent = 0;
    for (const TubePiece& piece : pieces_) {
        const Box& box = boxes.emplace_back(box_around(piece));
        for (int axis = 0; axis < 3; ++axis) extent = std::max({extent, -box.low[axis], box.high[axis]});
    }
    const float pad = extent * 0x1p-20f;  // more than rounding moves a box's face, or the ray
    Bvh bvh = build_bvh(boxes, node_cost);
    nodes_ = std::move(bvh.nodes);
    packets_.reserve(bvh.packets.size());
    for (const Packet& packet : bvh.packets) {
        BvhNode& node = packets_.emplace_back();
        for (std::size_t lane = 0; lane < packet.size(); ++lane) {
            const bool absent = lane > 0 && packet[lane] == packet[0];
            const Box box = absent ? Box{} : boxes[packet[lane]];
            for (int axis = 0; axis < 3; ++axis) {
                node.bounds[0][axis][lane] = box.low[axis] - pad;
                node.bounds[1][axis][lane] = box.high[axis] + pad;
            }
            node.child[lane] = ChildRef::node(packet[lane]);
        }
    }
}

void Tube::cut(const BezierCurve<4>& curve, int depth) {
    Interruption::check();
    if (pieces_.size() == max_pieces) {
        throw std::invalid_argument("tube: expected a curve that " + std::to_string(max_pieces) +
                                    " cubic pieces follow, got one that takes more: of too many control points, or of weights that "
                                    "differ too much");
    }
    Cubic cubic = hermite(curve);
    const double error = deviation(curve, cubic);
    if ((depth < max_depth && error > tolerance) || (depth < max_bend_depth && is_bent(cubic))) {
        cut(part(curve, 0, 0.5), depth + 1);
        cut(part(curve, 0.5, 1), depth + 1);
        return;
    }
    if (!(error <= tolerance)) cubic = straight(cubic[0], cubic[3]);
    TubePiece& piece = pieces_.emplace_back();
    for (std::size_t i = 0; i < 4; ++i) std::copy(cubic[i].begin(), cubic[i].end(), piece.ball[i]);
    parameters_.push_back({curve.low, curve.high});
}

void Tube::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    best_tube_kernels().closest_hits(nodes_.data(), packets_.data(), pieces_.data(), rays.data(), rays.size(),
                                     hits.data());
}

void Tube::normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const {
    for (std::size_t i = 0; i < hits.size(); ++i) normals[i] = normal(rays[i], hits[i]);
}

namespace {

/// A ray next to the ball that it hits, in double precision: hit.t is less exact than the normals of a thin tube need.
struct Passage {
    double foot[3];  // of the perpendicular from the centre to the ray
    double half;     // of the ray's length in the ball
    bool leaves;     // the ray is inside before the hit

    Passage(const Ray& ray, const Hit& hit, const Ball& ball) {
        const double direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        const double from_centre[3] = {ray.origin.x - ball[0], ray.origin.y - ball[1], ray.origin.z - ball[2]};
        double scale = 0, along = 0, across = 0;
        for (int i = 0; i < 3; ++i) scale += direction[i] * direction[i];
        for (int i = 0; i < 3; ++i) along -= from_centre[i] * direction[i] / scale;
        for (int i = 0; i < 3; ++i) {
            foot[i] = from_centre[i] + along * direction[i];
            across += foot[i] * foot[i];
        }
        half = std::sqrt(std::max(ball[3] * ball[3] - across, 0.0) / scale);
        leaves = !(hit.t < along);
    }
};

}  // namespace

Vec3 Tube::normal(const Ray& ray, const Hit& hit) const {
    const Ball ball = ball_at(pieces_[hit.primitive], hit.u);
    const Passage at(ray, hit, ball);
    const double side = at.leaves ? -1 : 1;  // from inside, the ray sees the inside of the ball
    Vec3 result;
    for (int i = 0; i < 3; ++i) {
        result[i] = static_cast<float>((side * at.foot[i] - at.half * static_cast<double>(ray.direction[i])) / ball[3]);
    }
    return normalized(result);
}

void Tube::starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const {
    for (std::size_t i = 0; i < hits.size(); ++i) inside[i] = Passage(rays[i], hits[i], ball_at(pieces_[hits[i].primitive], hits[i].u)).leaves;
}

Place Tube::place(const Hit& hit) const {
    const auto [low, high] = parameters_[hit.primitive];
    return {0, low + hit.u * (high - low), 0};
}

const std::vector<ShapeEdge>* Tube::edges() const {
    edges_.prepare([&] {
        std::vector<ShapeEdge> ends;
        const auto add = [&](const double* at, const double* next) {
            const Vec3d center{at[0], at[1], at[2]}, along = Vec3d{next[0], next[1], next[2]} - center;
            const double size = length(along);
            const Vec3d axis = size > 0 ? 1 / size * along : Vec3d{0, 0, 1};
            ends.push_back({{center}, EdgeCircle{center, axis, at[3]}, false, false, false});
        };
        const auto are_apart = [](const double* a, const double* b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > same_place; };
        for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {  // curves that jump have ends there
            for (end = begin + 1; end < pieces_.size() && !are_apart(pieces_[end - 1].ball[3], pieces_[end].ball[0]);) ++end;
            const auto &first = pieces_[begin].ball, &last = pieces_[end - 1].ball;
            if (are_apart(first[0], last[3])) {
                add(first[0], first[1]), add(last[3], last[2]);
            } else if (end == begin + 1 && !are_apart(first[0], first[1])) {  // a ball
                add(first[0], first[1]);
            }
        }
        return ends;
    });
    return edges_.get();
}

std::size_t Tube::bytes() const {
    return pieces_.size() * (sizeof(TubePiece) + sizeof(Parameters)) +
           (nodes_.size() + packets_.size()) * sizeof(BvhNode);
}

double Tube::maximum(const std::function<double(Vec3, float)>& convex) const {
    const auto value = [&](const Ball& b) {
        return convex({static_cast<float>(b[0]), static_cast<float>(b[1]), static_cast<float>(b[2])},
                      static_cast<float>(b[3]));
    };
    // The minimum and maximum over sampled balls of the curve.
    double low = std::numeric_limits<double>::infinity(), high = -low;
    const auto sample = [&](const Ball& b) {
        const double v = value(b);
        low = std::min(low, v), high = std::max(high, v);
    };
    std::vector<std::pair<Cubic, int>> open;  // with the number of halvings
    for (const TubePiece& piece : pieces_) {
        Cubic& cubic = open.emplace_back().first;
        for (std::size_t i = 0; i < 4; ++i) {
            std::copy(std::begin(piece.ball[i]), std::end(piece.ball[i]), cubic[i].begin());
        }
        sample(cubic[0]);
        sample(cubic[3]);
    }
    // On a piece, a convex function does not exceed its maximum over the control points.
    constexpr int max_halvings = 10;
    double above = high;
    while (!open.empty()) {
        if (open.size() % 1024 == 0) Interruption::check();
        const auto [p, halvings] = open.back();
        open.pop_back();
        const double hull = std::max(value(p[1]), value(p[2]));
        if (halvings < max_halvings && hull > high + 1e-3 * (high - low)) {
            const Ball a = mix(p[0], p[1], 0.5), b = mix(p[1], p[2], 0.5), c = mix(p[2], p[3], 0.5);
            const Ball ab = mix(a, b, 0.5), bc = mix(b, c, 0.5), middle = mix(ab, bc, 0.5);
            sample(middle);
            open.push_back({{p[0], a, ab, middle}, halvings + 1});
            open.push_back({{middle, bc, c, p[3]}, halvings + 1});
        } else {
            above = std::max(above, hull);
        }
    }
    return std::max(above, high);
}

}  // namespace bob
