/// A shape in the WebAssembly modules.
#pragma once

#include <memory>
#include <vector>

#include "shapes/mesh/mesh.h"

/// A shape, and the arrays that it reads until it is in a scene.
struct Shape {
    std::shared_ptr<const bob::Shape> core;
    std::vector<bob::Mesh::Point> vertices = {};
    std::vector<bob::Triangle> triangles = {};
    std::vector<bob::Vec3> normals = {}, colors = {}, face_colors = {};
    std::vector<bob::Mesh::Uv> uv = {};
    std::vector<float> alphas = {};
    bool is_coarse = false;
};
