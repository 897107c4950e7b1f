/// The models of a 3MF: their objects, and the items to build.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/part.h"
#include "files/threemf/functions.h"
#include "files/threemf/lattice.h"
#include "files/threemf/package.h"
#include "files/threemf/palette.h"

namespace bob::files::threemf {

/// The number of an object's model in the package, and its id there.
using Key = std::pair<std::size_t, std::string>;

struct Reference {
    Key key;
    Rows place;
};

struct Object {
    std::string name;
    Mesh mesh;
    std::shared_ptr<const Palette> palette;  // of its model
    std::vector<OtherShape> shapes;
    std::vector<Reference> components;
};

struct Model {
    std::map<Key, Object> objects;
    std::vector<Reference> built;
    std::string_view unit = "mm";
    std::vector<std::size_t> named;  // other models in the package
};

/// Reads a model, by its number in the package. Throws std::invalid_argument, of one line.
[[nodiscard]] Model read_model(Package& package, std::size_t number, LeftOut& left);

}  // namespace bob::files::threemf
