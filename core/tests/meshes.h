/// Meshes to test with.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "check.h"
#include "shapes/mesh/mesh.h"

namespace test {

struct TriangleMesh {
    std::vector<bob::Vec3> vertices;
    std::vector<bob::Triangle> triangles;
};

/// Triangles anywhere in the unit sphere, of a size up to `size`.
inline TriangleMesh soup(int count, float size, std::uint64_t seed) {
    Random random(seed);
    TriangleMesh mesh;
    for (int i = 0; i < count; ++i) {
        const bob::Vec3 center{random(-0.5f, 0.5f), random(-0.5f, 0.5f), random(-0.5f, 0.5f)};
        for (int corner = 0; corner < 3; ++corner) {
            mesh.vertices.push_back(center + bob::Vec3{random(-size, size), random(-size, size), random(-size, size)});
        }
        const auto first = static_cast<std::uint32_t>(3 * i);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

/// A closed sphere: an octahedron whose triangles are split in four, `levels` times over.
inline TriangleMesh sphere(int levels, float radius) {
    TriangleMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [entry, added] = middles.try_emplace(std::minmax(a, b), mesh.vertices.size());
            if (added) mesh.vertices.push_back(normalized(mesh.vertices[a] + mesh.vertices[b]));
            return entry->second;
        };
        std::vector<bob::Triangle> split;
        for (const auto& [a, b, c] : mesh.triangles) {
            const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            split.insert(split.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        mesh.triangles = split;
    }
    for (auto& v : mesh.vertices) v = radius * v;
    return mesh;
}

/// A mesh for rays in the coordinates of these vertices.
inline std::shared_ptr<bob::Mesh> prepared(std::span<const bob::Vec3> vertices, std::span<const bob::Triangle> triangles,
                                           std::span<const bob::Vec3> normals = {}) {
    const auto points = std::make_shared<std::vector<bob::Mesh::Point>>();
    for (const bob::Vec3 v : vertices) points->push_back({v.x, v.y, v.z});
    const auto mesh = std::make_shared<bob::Mesh>(bob::Mesh::Arrays{*points, triangles, normals, points}, bob::Sphere{});
    mesh->prepare();
    return mesh;
}

inline bob::Vec3 random_direction(Random& random) {
    while (true) {
        const bob::Vec3 v{random(-1, 1), random(-1, 1), random(-1, 1)};
        if (dot(v, v) > 0.01f && dot(v, v) < 1) return normalized(v);
    }
}

}  // namespace test
