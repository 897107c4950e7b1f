/// The trimmed domain of a NURBS surface, bounded by loops of curves in (u, v).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nurbs/nurbs.h"

namespace bob {

/// Curves end to end. Gaps between consecutive curves, and between the last and the first, are closed by line segments.
/// Weights are above 0.
using TrimLoop = std::vector<NurbsCurve<2>>;

/// A rectangle in parameter space.
struct Domain {
    double low_u, high_u, low_v, high_v;
};

class TrimRegion {
public:
    /// A point is inside if an odd number of loops surround it, in either direction; without loops, every point is.
    ///
    /// In files, loops run along the border of the surface's domain, up to rounding. Curves (or their pieces between
    /// two knots) within 1e-6 of the domain's size of its border are moved outside by 1e-3 of it. The border itself is
    /// then inside, with a narrow margin.
    TrimRegion(std::span<const TrimLoop> loops, const Domain& domain);

    /// Whether a point is inside the exact curves; points on a curve may go either way.
    [[nodiscard]] bool contains(double u, double v) const;

    enum class Coverage { none, some, all };

    /// Coverage of a rectangle by the inside. It is `some` if a curve, or a line that closes a gap, comes within 2e-9 of
    /// the domain's size. Adds the number of visited nodes.
    [[nodiscard]] Coverage coverage(const Domain& rectangle, std::size_t* visited = nullptr) const;

    /// A rectangle around the inside of a rectangle, as tight as boxes of monotone curve pieces. If empty, low > high.
    /// Adds the number of visited nodes.
    [[nodiscard]] Domain extent(const Domain& rectangle, std::size_t* visited = nullptr) const;

    [[nodiscard]] std::size_t bytes() const;

private:
    /// The box of a run of consecutive pieces of a loop, or of several loops. It may be larger by rounding. A node has
    /// 48 bytes. A node's descendants follow it, up to the node `next`.
    struct Node {
        float low_u, high_u, low_v, high_v;
        double start_v, end_v;  // of the run; equal if it closes
        std::uint32_t next;
        std::uint32_t coefficients;  // of a leaf: offset of its coefficients
        std::uint8_t degree;         // of a leaf, one piece monotone in u and in v; otherwise 0
        bool rational;

        /// Whether the run's ends are on different sides of the height v.
        [[nodiscard]] bool crosses(double v) const { return (start_v <= v) != (end_v <= v); }
    };
    class Builder;

    /// A leaf's start and end in u.
    struct Ends {
        double start, end;
    };
    [[nodiscard]] Ends ends_u(const Node& leaf) const;
    /// Whether a leaf's piece lies to the right of u at height v, which is between the heights of its ends.
    [[nodiscard]] bool right_of(const Node& leaf, double u, double v) const;
    /// Whether a leaf's piece passes through a rectangle that overlaps its box.
    [[nodiscard]] bool passes(const Node& leaf, const Domain& rectangle) const;

    std::vector<Node> nodes_;
    // The control points of each piece, times binomials. Polynomial pieces store all u, and the inner v (the node has
    // the others); for rational pieces, all w u, w v and w.
    std::vector<double> coefficients_;
    double margin_u_, margin_v_;
    bool everything_;
};

}  // namespace bob
