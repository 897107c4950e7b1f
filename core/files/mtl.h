/// MTL: the materials of an OBJ, and their textures.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// A map of an MTL: its file, and places on it are scale uv + offset, counted from the bottom up.
struct Map {
    std::string name;  // from the model's folder; empty without a picture
    std::array<double, 2> scale{1, 1}, offset{0, 0};
    bool is_clamped = false;
};

/// A material as its statements have it.
struct MtlMaterial {
    Material reflecting;
    Map color, mask;
    std::vector<std::string_view> not_shown;  // names of its other maps
};

using MtlMaterials = std::map<std::string, MtlMaterial, std::less<>>;

/// The materials of libraries by their names. lines: the text after each mtllib, perhaps several names. A library that can't be read
/// becomes a warning. Empty while `beside` waits for a file.
[[nodiscard]] MtlMaterials read_mtl(const std::vector<std::string>& lines, Beside& beside, std::vector<std::string>& warnings);

}  // namespace bob::files
