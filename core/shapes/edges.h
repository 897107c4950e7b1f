/// Edges of a shape as curves in space: straight ones, arcs of circles, and free ones.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/chains.h"
#include "base/vec3d.h"

namespace bob {

/// A smaller angle between the normals on both sides is no crease. Above 30 degrees, common chamfers would be lost;
/// below 20, scanned surfaces get lines from noise. Meshes whose normals are not given are smooth up to 40 degrees.
constexpr float crease_of_edges_degrees = 25;

struct EdgeCircle {
    Vec3d center, axis;  // a unit vector
    double radius;
};

/// A smooth edge.
struct ShapeEdge {
    std::vector<Vec3d> points;         // along it; of a closed edge the last is the first
    std::optional<EdgeCircle> circle;  // that it is a part of
    bool is_straight = false;
    bool begins_at_corner = true, ends_at_corner = true;
    std::optional<Vec3d> middle = std::nullopt;  // of a straight edge, or of an arc with two ends
};

/// Points may be this far from a line or a circle; the second is in radii.
struct EdgeTolerance {
    double length, relative;
};

/// An edge through points, at least two. It is an arc if all of at least four points lie on a circle.
[[nodiscard]] ShapeEdge edge_through(std::vector<Vec3d> points, const EdgeTolerance& tolerance);

/// The edges that segments between points approximate. They end where segments do, where more than two meet, where they turn by more than
/// 35 degrees, and between straight edges and arcs of at least 45 degrees.
[[nodiscard]] std::vector<ShapeEdge> edges_between(std::span<const Vec3d> points, std::span<const Link> segments, const EdgeTolerance& tolerance);

}  // namespace bob
