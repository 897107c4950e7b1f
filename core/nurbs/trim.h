/// The trimmed domain of a NURBS surface: what loops of curves in (u, v) leave of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nurbs/nurbs.h"

namespace bob {

/// Curves end to end. Where one does not begin at the end of the one before, or the last does not end where the first
/// begins, a straight line joins them. Weights are above 0.
using TrimLoop = std::vector<NurbsCurve<2>>;

/// A rectangle of the parameters.
struct Domain {
    double low_u, high_u, low_v, high_v;
};

class TrimRegion {
public:
    /// Inside is what an odd number of loops goes around, whichever way they turn. Without loops, everything is.
    ///
    /// Files let loops run along the border of the surface's domain, but for rounding. Curves (or pieces of them
    /// between two knots) within 1e-6 of the domain's size of its border are moved outside by 1e-3 of it, so that the
    /// border itself is inside, and so is what lies a little beyond.
    TrimRegion(std::span<const TrimLoop> loops, const Domain& domain);

    /// Whether a point is inside. The curves themselves count, not an approximation by lines; points on a curve may go
    /// either way.
    [[nodiscard]] bool contains(double u, double v) const;

    enum class Coverage { none, some, all };

    /// How much of a rectangle is inside; `some` where a curve, or a line that closes a gap, comes within 2e-9 of
    /// the domain's size of it. Adds how many nodes were visited.
    [[nodiscard]] Coverage coverage(const Domain& rectangle, std::size_t* visited = nullptr) const;

    /// A rectangle around what of another is inside, as tight as boxes of monotone pieces of the curves are; low > high
    /// where nothing is. Adds how many nodes were visited.
    [[nodiscard]] Domain extent(const Domain& rectangle, std::size_t* visited = nullptr) const;

    [[nodiscard]] std::size_t bytes() const;

private:
    /// The box of a run of pieces that follow each other along a loop, or of several loops; it may be larger by
    /// rounding. 48 bytes. A node's descendants come right after it, until the node `next`.
    struct Node {
        float low_u, high_u, low_v, high_v;
        double start_v, end_v;  // of the run; equal where it closes
        std::uint32_t next;
        std::uint32_t coefficients;  // of a leaf: where its begin
        std::uint8_t degree;         // of a leaf, which is one piece, monotone in u and in v; otherwise 0
        bool rational;

        /// Whether the run's ends are on different sides of the height v.
        [[nodiscard]] bool crosses(double v) const { return (start_v <= v) != (end_v <= v); }
    };
    class Builder;

    /// Where a leaf's piece starts and ends in u.
    struct Ends {
        double start, end;
    };
    [[nodiscard]] Ends ends_u(const Node& leaf) const;
    /// Whether a leaf's piece lies to the right of u at height v, which is between its ends.
    [[nodiscard]] bool right_of(const Node& leaf, double u, double v) const;
    /// Whether a leaf's piece passes through a rectangle, which overlaps its box.
    [[nodiscard]] bool passes(const Node& leaf, const Domain& rectangle) const;

    std::vector<Node> nodes_;
    // Of each piece's control points, times binomials: all u, and v but for the ends' which the node has; where it is
    // rational, all w u, w v and w.
    std::vector<double> coefficients_;
    double margin_u_, margin_v_;
    bool everything_;
};

}  // namespace bob
