/// Meshes: any vertices, NaN included, any normals, valid indices. Rays agree with brute force over all
/// triangles.
#include <cmath>
#include <span>
#include <vector>

#include "fuzz/rays.h"
#include "shapes/mesh/mesh.h"

namespace {

/// The t of the triangle where a ray meets it clearly, in double precision; NaN where it does not, or it can't be told.
double clear_hit(const bob::Ray& ray, const bob::Vec3 corner[3]) {
    const auto minus = [](bob::Vec3 a, bob::Vec3 b) {
        return std::array{double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z};
    };
    const auto cross = [](const auto& a, const auto& b) {
        return std::array{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    const auto ab = minus(corner[1], corner[0]), ac = minus(corner[2], corner[0]), from = minus(ray.origin, corner[0]);
    const std::array direction{double{ray.direction.x}, double{ray.direction.y}, double{ray.direction.z}};
    const auto n = cross(ab, ac), moment = cross(from, direction);
    const double facing = -dot(direction, n);
    const double v = -dot(ac, moment) / facing, w = dot(ab, moment) / facing, t = dot(from, n) / facing;
    const bool flat = std::fabs(facing) < 1e-3 * std::sqrt(dot(n, n) * dot(direction, direction)) || dot(n, n) < 1e-8;
    constexpr double edge = 1e-3;
    const bool clear = !flat && -v > edge && -w > edge && 1 + v + w > edge && t > 1e-3;
    return clear ? t : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

FUZZ(mesh) {
    std::vector<bob::Mesh::Point> vertices(static_cast<std::size_t>(source.between(1, 40)));
    const std::uint8_t kind = source.byte();
    for (auto& vertex : vertices) {
        for (double& x : vertex) x = kind < 128 ? source.byte() / 64. - 2 : kind < 192 ? source.below(3) - 1. : source.number();
    }
    std::vector<bob::Triangle> triangles(static_cast<std::size_t>(source.between(1, 60)));
    for (auto& triangle : triangles) {
        for (std::uint32_t& index : triangle) index = source.below(static_cast<std::uint32_t>(vertices.size()));
    }
    std::vector<bob::Vec3> normals;
    if (kind % 3 == 0) {
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            auto& normal = normals.emplace_back();
            for (int axis = 0; axis < 3; ++axis) normal[axis] = static_cast<float>(source.number());
        }
    }
    const bob::Mesh mesh({vertices, triangles, normals, nullptr});
    const auto& [center, radius] = mesh.sphere();
    if (!std::isfinite(radius)) return;  // refused
    fuzz::meet(mesh, source, 8);

    mesh.prepare();
    const std::vector<bob::Ray> rays = fuzz::rays(source, 8);
    const std::vector<bob::Hit> hits = fuzz::hits(mesh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        for (const bob::Triangle& triangle : triangles) {
            bob::Vec3 corner[3];
            for (int k = 0; k < 3; ++k) {
                const auto& vertex = vertices[triangle[static_cast<std::size_t>(k)]];
                for (int axis = 0; axis < 3; ++axis) {
                    corner[k][axis] = static_cast<float>((vertex[static_cast<std::size_t>(axis)] - center[axis]) / radius);
                }
            }
            const double t = clear_hit(rays[i], corner);
            fuzz::expect(!(hits[i].t > t + 1e-4 * (1 + t)), "a hit no farther than each triangle");
        }
    }
}
