/// Meshes compressed by Google's Draco, version 2.2 of its bitstream, as KHR_draco_mesh_compression uses it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "files/binary.h"
#include "files/part.h"

namespace bob::files {

struct DracoMesh {
    struct Attribute {
        std::uint32_t id;        // its name in a glTF
        int component;           // type of its numbers, as an accessor has it
        std::size_t width;       // numbers of each vertex
        Numbers<double> values;  // (points, width)
    };
    std::size_t points = 0;
    Numbers<std::int32_t> triangles;  // (T, 3)
    std::vector<Attribute> attributes;
};

/// Throws std::invalid_argument if the bytes are no such mesh. max_triangles: more of them are refused before memory is allocated.
[[nodiscard]] DracoMesh draco_decoded(Bytes bytes, std::size_t max_triangles, Budget& budget);

}  // namespace bob::files
