/// Formulas as arrays, the form of files and bindings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "formula/expression.h"
#include "formula/mesh_distance.h"

namespace bob {

/// ops: (n,), operands: (n, 3), values: (n,). A node refers to a mesh by its index in `meshes`; the caller keeps
/// `meshes` until the formula holds them.
[[nodiscard]] inline std::vector<Node> nodes_of(const std::uint8_t* ops, const std::uint32_t* operands, const double* values,
                                                std::size_t count, const Meshes& meshes) {
    std::vector<Node> nodes(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t* operand = operands + 3 * i;
        Node& node = nodes[i] = {static_cast<Op>(ops[i]), {operand[0], operand[1], operand[2]}, values[i]};
        if (node.op != Op::mesh_distance) continue;
        std::size_t place = 0;
        while (place < meshes.size() && static_cast<double>(place) != node.value) ++place;
        if (place == meshes.size()) throw std::invalid_argument("node " + std::to_string(i) + ": expected the place of a mesh, got another");
        node.value = meshes[place]->number();
    }
    return nodes;
}

/// A node's value as `nodes_of` expects it.
[[nodiscard]] inline double value_in_arrays(const Node& node, const Meshes& meshes) {
    if (node.op != Op::mesh_distance) return node.value;
    return static_cast<double>(find_mesh(meshes, node.value) - meshes.begin());
}

/// Meshes one after the other. sizes: (m, 2), the numbers of vertices and triangles of each; vertices: (v, 3),
/// triangles: (t, 3), concatenated.
struct MeshArrays {
    std::span<const std::uint32_t> sizes;
    std::span<const float> vertices;
    std::span<const std::uint32_t> triangles;
};

/// Throws std::invalid_argument unless the sizes match the arrays and the meshes are valid for formulas.
[[nodiscard]] inline Meshes meshes_of(const MeshArrays& arrays) {
    Meshes meshes;
    std::size_t vertex = 0, triangle = 0;
    const std::size_t vertices = arrays.vertices.size() / 3, triangles = arrays.triangles.size() / 3;
    for (std::size_t i = 0; i + 1 < arrays.sizes.size(); i += 2) {
        const std::size_t v = arrays.sizes[i], t = arrays.sizes[i + 1];
        if (v > vertices - vertex || t > triangles - triangle) break;
        std::vector<Vec3> points(v);
        for (std::size_t k = 0; k < v; ++k) {
            const float* p = &arrays.vertices[3 * (vertex + k)];
            points[k] = {p[0], p[1], p[2]};
        }
        std::vector<MeshDistance::Triangle> corners(t);
        for (std::size_t k = 0; k < t; ++k) {
            const std::uint32_t* c = &arrays.triangles[3 * (triangle + k)];
            corners[k] = {c[0], c[1], c[2]};
        }
        meshes.push_back(MeshDistance::of(points, corners));
        vertex += v, triangle += t;
    }
    if (2 * meshes.size() != arrays.sizes.size() || vertex != vertices || triangle != triangles) {
        throw std::invalid_argument("expected as many vertices and triangles as the meshes have, got others");
    }
    return meshes;
}

}  // namespace bob
