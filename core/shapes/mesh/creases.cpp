/// Edges of meshes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "shapes/mesh/mesh.h"

namespace bob {
namespace {

/// Tolerance of coordinates in single precision or six digits, and of circles written with them.
constexpr EdgeTolerance tolerance{2e-6, 1e-4};

/// A side of a triangle.
struct Hinge {
    Link ends;    // the lower number first
    Vec3 normal;  // of the shading, in the middle
};

}  // namespace

const std::vector<ShapeEdge>& Mesh::creases() const {
    edges_.prepare([&] {
        const std::vector<Vec3> places = in_unit_sphere();
        const std::vector<std::uint32_t> same = merge_positions(places);
        const std::vector<CornerNormals> normals = corner_normals();
        static const float cos_crease = std::cos(crease_of_edges_degrees * std::numbers::pi_v<float> / 180);
        std::vector<Hinge> hinges;
        for (std::size_t i = 0; i < arrays_.triangles.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t next = (k + 1) % 3;
                const std::uint32_t a = same[arrays_.triangles[i][k]], b = same[arrays_.triangles[i][next]];
                if (a != b) hinges.push_back({std::minmax(a, b), normals[i][k] + normals[i][next]});
            }
        }
        std::sort(hinges.begin(), hinges.end(), [](const Hinge& a, const Hinge& b) { return a.ends < b.ends; });
        std::vector<Link> segments;
        for (std::size_t i = 0; i < hinges.size();) {
            std::size_t end = i + 1;
            while (end < hinges.size() && hinges[end].ends == hinges[i].ends) ++end;
            const Vec3 a = hinges[i].normal, b = hinges[end - 1].normal;
            if (end != i + 2 || !(dot(a, b) >= cos_crease * length(a) * length(b))) segments.push_back(hinges[i].ends);
            i = end;
        }
        const auto& [center, radius] = sphere();
        std::vector<Vec3d> points;
        points.reserve(arrays_.vertices.size());
        for (const Point& p : arrays_.vertices) points.push_back({(p[0] - center[0]) / radius, (p[1] - center[1]) / radius, (p[2] - center[2]) / radius});
        return edges_between(points, segments, tolerance);
    });
    return *edges_.get();
}

}  // namespace bob
