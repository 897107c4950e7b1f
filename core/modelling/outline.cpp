#include "modelling/outline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace bob {
namespace {

using Vector = std::array<double, 2>;

Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1]}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1]; }
double cross(const Vector& a, const Vector& b) { return a[0] * b[1] - a[1] * b[0]; }
double length(const Vector& a) { return std::hypot(a[0], a[1]); }

struct Edge {
    Vector from, to;
    [[nodiscard]] Vector along() const { return to - from; }
    [[nodiscard]] double extent() const { return length(along()); }
};

/// Whether a point lies on an edge but not at its ends.
bool within(const Edge& edge, const Vector& p, double tolerance) {
    const double extent = edge.extent(), share = dot(p - edge.from, edge.along()) / extent;
    return std::fabs(cross(edge.along(), p - edge.from)) <= tolerance * extent && share > tolerance &&
           share < extent - tolerance;
}

/// Where two edges cross, if neither ends there.
std::optional<Vector> crossing(const Edge& a, const Edge& b, double tolerance) {
    const double turn = cross(a.along(), b.along());
    if (std::fabs(turn) <= 1e-12 * a.extent() * b.extent()) return std::nullopt;
    const double share = cross(b.from - a.from, b.along()) / turn;
    const Vector p{a.from[0] + share * a.along()[0], a.from[1] + share * a.along()[1]};
    return within(a, p, tolerance) && within(b, p, tolerance) ? std::optional(p) : std::nullopt;
}

/// The edges cut wherever they cross or touch, so that each piece has one neighbourhood all along.
std::vector<Edge> cut(const std::vector<Edge>& edges, double tolerance) {
    std::vector<std::vector<Vector>> cuts(edges.size());
    for (std::size_t i = 0; i < edges.size(); ++i) {
        cuts[i].insert(cuts[i].end(), {edges[i].from, edges[i].to});
        for (std::size_t j = 0; j < edges.size(); ++j) {
            if (within(edges[i], edges[j].from, tolerance)) cuts[i].push_back(edges[j].from);
            const std::optional<Vector> both = j < i ? crossing(edges[i], edges[j], tolerance) : std::nullopt;
            if (!both) continue;
            cuts[i].push_back(*both);
            cuts[j].push_back(*both);
        }
    }
    std::vector<Edge> pieces;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto share = [&](const Vector& p) { return dot(p - edges[i].from, edges[i].along()); };
        std::sort(cuts[i].begin(), cuts[i].end(), [&](const auto& a, const auto& b) { return share(a) < share(b); });
        for (std::size_t k = 1; k < cuts[i].size(); ++k) {
            if (length(cuts[i][k] - cuts[i][k - 1]) > tolerance) pieces.push_back({cuts[i][k - 1], cuts[i][k]});
        }
    }
    return pieces;
}

/// The signs at the left and at the right of a piece: by the edges that lie beyond its middle, along the axis that crosses
/// it more squarely.
std::pair<int, int> sides(const Edge& piece, const std::vector<Edge>& edges, double tolerance) {
    const Vector along = piece.along();
    const std::size_t u = std::fabs(along[0]) <= std::fabs(along[1]) ? 0 : 1, v = 1 - u;
    const Vector middle{(piece.from[0] + piece.to[0]) / 2, (piece.from[1] + piece.to[1]) / 2};
    int beyond = 0, here = 0;
    for (const Edge& edge : edges) {
        if ((edge.from[v] <= middle[v]) == (edge.to[v] <= middle[v])) continue;
        const double share = (middle[v] - edge.from[v]) / edge.along()[v];
        const double ahead = edge.from[u] + share * edge.along()[u] - middle[u];
        here += std::fabs(ahead) <= tolerance;
        beyond += ahead > tolerance;
    }
    const int high = beyond % 2 ? -1 : 1, low = (beyond + here) % 2 ? -1 : 1;
    const bool high_is_left = u == 0 ? along[1] < 0 : along[0] > 0;
    return high_is_left ? std::pair(high, low) : std::pair(low, high);
}

/// A piece seen from one of its ends.
struct Spoke {
    Vector direction;
    int right;
};

/// The sign where an end is nearest: none of the pieces that meet there leads that way. So it is a neighbour of the piece
/// that has all others to its left, if there is one.
std::optional<int> sign_beyond(const std::vector<Spoke>& spokes) {
    for (const Spoke& last : spokes) {
        if (std::all_of(spokes.begin(), spokes.end(), [&](const Spoke& other) {
                const double turn = cross(last.direction, other.direction);
                return turn > 1e-12 || (turn > -1e-12 && dot(last.direction, other.direction) > 0);
            })) {
            return last.right;
        }
    }
    return std::nullopt;
}

}  // namespace

std::vector<OutlinePiece> outline(std::span<const std::array<double, 2>> corners) {
    std::vector<Edge> edges;
    double size = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        edges.push_back({corners[i], corners[(i + 1) % corners.size()]});
        size = std::max(size, length(corners[i] - corners[0]));
    }
    const double tolerance = 1e-12 * size;

    std::vector<OutlinePiece> pieces;
    std::map<Vector, std::vector<Spoke>> meetings;
    for (const Edge& piece : cut(edges, tolerance)) {
        const auto [left, right] = sides(piece, edges, tolerance);
        pieces.push_back({piece.from, piece.to, left, right, {}, {}});
        const double extent = piece.extent();
        const Vector along{piece.along()[0] / extent, piece.along()[1] / extent};
        meetings[piece.from].push_back({along, right});
        meetings[piece.to].push_back({{-along[0], -along[1]}, left});
    }
    for (OutlinePiece& piece : pieces) {
        piece.beyond_from = sign_beyond(meetings[piece.from]);
        piece.beyond_to = sign_beyond(meetings[piece.to]);
    }
    return pieces;
}

std::vector<Vector> convex_hull(std::vector<Vector> points) {
    std::sort(points.begin(), points.end());
    std::vector<Vector> hull;
    // The lower half from the left to the right, then the upper half back.
    for (int half = 0; half < 2; ++half) {
        const std::size_t first = hull.size();
        for (const Vector& p : points) {
            while (hull.size() >= first + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

}  // namespace bob
