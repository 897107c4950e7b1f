/// The distance of points from a closed mesh, negative inside: what formulas have of meshes.
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

/// Immutable, and there is one of each mesh: equal meshes share it, and have its number. Inside is where the surface winds around
/// a point, in whichever direction, so parts may overlap. Distances are Euclidean, in double precision.
class MeshDistance {
public:
    using Point = Vec3d;
    using Triangle = std::array<std::uint32_t, 3>;

    /// Equal vertices become one; triangles without three corners, and vertices without triangles, are left out. Throws
    /// std::invalid_argument unless coordinates are in -1..1, corners among the vertices, and each edge as often there in one
    /// direction as in the other.
    static std::shared_ptr<const MeshDistance> of(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

    /// Null where no mesh has the number, or none that is still in use.
    static std::shared_ptr<const MeshDistance> numbered(double number);

    ~MeshDistance();
    MeshDistance(const MeshDistance&) = delete;
    MeshDistance& operator=(const MeshDistance&) = delete;

    [[nodiscard]] double number() const { return static_cast<double>(number_); }
    [[nodiscard]] const std::vector<Vec3>& vertices() const { return vertices_; }
    [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
    [[nodiscard]] std::size_t bytes() const;

    /// What is known of a point close by, which makes the next search short.
    struct Known {
        Point point{};
        double distance = -1;
        std::uint32_t face = no_face;
    };

    /// NaN where a coordinate is, infinite where one is. `known` becomes that of this point.
    double operator()(const Point& p, Known& known) const;
    double operator()(const Point& p) const {
        Known nothing;
        return (*this)(p, nothing);
    }
    /// And the gradient, a unit vector; zero where the distance is no number or infinite.
    double operator()(const Point& p, Known& known, Point& gradient) const;

    /// Bounds of the gradient's components where no point is farther than `radius` from `center`, whose distance is `distance`.
    /// False where nothing is known but that it is a unit vector.
    bool gradients(const Point& center, double radius, double distance, Point& low, Point& high) const;

private:
    static constexpr std::uint32_t no_face = 0xffffffff;

    /// `sense`: 1 where the side from which the corners are anticlockwise is outside and the other inside, -1 where it is the other
    /// way round, 0 where both are inside, or other triangles cut through
    /// or are too many to look at.
    struct Face {
        Vec3 corner[3];
        int sense = 0;
        Point normal{};  // zero of a triangle without an area
    };

    /// Eight triangles, with boxes as nodes have them: an absent one has a box that nothing meets.
    struct Leaf {
        float bounds[2][3][8];
        Packet face;
    };

    struct Closest {
        double squared;  // of the distance
        Point point{};
        bool within = false;  // neither on an edge nor at a corner
        std::uint32_t face = no_face;
    };

    MeshDistance(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const Digest& digest);

    static Closest closest(const Face& face, const Point& p);
    static bool overlap(const Face& a, const Face& b);

    /// visit(face) of those whose boxes meet a box, while it returns true.
    template <class Visit>
    void for_each_in(const Box& box, Visit visit) const;
    [[nodiscard]] int sense(std::uint32_t face) const;
    /// Nothing where more than `most` triangles are above p.
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

/// The distance from a mesh of any size and place, in its own units; its vertices are rounded to 1e-7 of its size. Throws
/// as MeshDistance::of does.
[[nodiscard]] Expression distance_to_mesh(std::span<const MeshDistance::Point> vertices,
                                          std::span<const MeshDistance::Triangle> triangles);

}  // namespace bob
