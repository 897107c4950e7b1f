/// A shape in the WebAssembly modules.
#pragma once

#include <memory>

#include "shapes/shape.h"

struct Shape {
    std::shared_ptr<const bob::Shape> core;
    bool is_coarse = false;
};
