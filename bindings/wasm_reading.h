/// A reading of a file in the WebAssembly modules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "files/read.h"

/// A reading, and its texts and arrays while the page reads them.
struct Reading {
    /// Of a shape other than a mesh.
    struct Array {
        std::vector<std::uint8_t> bytes;
        std::size_t size;  // elements
    };

    bob::files::Reading core;
    std::string text = {};
    bob::files::Numbers<double> numbers = {};
    std::vector<Array> arrays = {};
};
