/// The signed distance of points from a closed mesh, negative inside, for formulas.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/bvh.h"
#include "base/sha256.h"
#include "base/vec.h"
#include "base/vec3d.h"

namespace bob {

class Expression;

/// Immutable and unique: equal meshes share one object and number. A point is inside if the surface winds around it in
/// either direction, so parts may overlap. Distances are Euclidean, in double precision.
class MeshDistance {
public:
    using Point = Vec3d;
    using Triangle = std::array<std::uint32_t, 3>;

    /// Merges equal vertices; drops degenerate triangles and unused vertices. Throws std::invalid_argument unless
    /// coordinates are in -1..1, corners refer to vertices, and each edge occurs equally often in both directions.
    static std::shared_ptr<const MeshDistance> of(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

    /// Null if no mesh in use has the number.
    static std::shared_ptr<const MeshDistance> numbered(double number);

    ~MeshDistance();
    MeshDistance(const MeshDistance&) = delete;
    MeshDistance& operator=(const MeshDistance&) = delete;

    [[nodiscard]] double number() const { return static_cast<double>(number_); }
    [[nodiscard]] const std::vector<Vec3>& vertices() const { return vertices_; }
    [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
    [[nodiscard]] std::size_t bytes() const;

    /// The result for a nearby point, which shortens the next search.
    struct Known {
        Point point{};
        double distance = -1;
        std::uint32_t face = no_face;
    };

    /// NaN if a coordinate is NaN, infinite if one is infinite. `known` is updated to this point.
    double operator()(const Point& p, Known& known) const;
    double operator()(const Point& p) const {
        Known nothing;
        return (*this)(p, nothing);
    }
    /// Also returns the gradient, a unit vector; zero if the distance is NaN or infinite.
    double operator()(const Point& p, Known& known, Point& gradient) const;

    /// Bounds of the gradient's components over the ball of `radius` around `center`, given the distance of `center`.
    /// False if nothing better than a unit vector is known.
    bool gradients(const Point& center, double radius, double distance, Point& low, Point& high) const;

private:
    static constexpr std::uint32_t no_face = 0xffffffff;

    /// A triangle with its orientation. `sense` is 1 if the anticlockwise side is outside and the other inside, -1 if
    /// reversed. It is 0 if both sides are inside, other triangles cut through, or too many are nearby to test.
    struct Face {
        Vec3 corner[3];
        int sense = 0;
        Point normal{};  // zero for a triangle without area
    };

    /// Eight triangles, with boxes as in BVH nodes: an absent one has a box that nothing intersects.
    struct Leaf {
        float bounds[2][3][8];
        Packet face;
    };

    struct Closest {
        double squared;  // distance
        Point point{};
        bool within = false;  // neither on an edge nor at a corner
        std::uint32_t face = no_face;
    };

    MeshDistance(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const Digest& digest);

    static Closest closest(const Face& face, const Point& p);
    static bool overlap(const Face& a, const Face& b);

    /// Calls visit(face) for faces with boxes that intersect a box, while it returns true.
    template <class Visit>
    void for_each_in(const Box& box, Visit visit) const;
    [[nodiscard]] int sense(std::uint32_t face) const;
    /// Empty if more than `most` triangles are above p.
    [[nodiscard]] std::optional<bool> is_inside(const Point& p, std::size_t most) const;
    template <class Number>
    void find_closest(const Point& p, Closest& best) const;
    [[nodiscard]] Closest closest(const Point& p, const Known& known) const;
    [[nodiscard]] double signed_distance(const Point& p, const Closest& closest, Known& known) const;

    std::uint64_t number_;
    Digest digest_;
    std::vector<Vec3> vertices_;
    std::vector<Triangle> triangles_;
    std::vector<Face> faces_;
    std::vector<BvhNode> nodes_;
    std::vector<Leaf> leaves_;
};

/// The distance from a mesh of any size and place, in the mesh's units. Vertices are rounded to 1e-7 of its size. Throws
/// as MeshDistance::of.
[[nodiscard]] Expression distance_to_mesh(std::span<const MeshDistance::Point> vertices,
                                          std::span<const MeshDistance::Triangle> triangles);

}  // namespace bob
