/// Numbers of Draco's points: sequences of values, predictions, and what turns integers into numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "files/draco.h"
#include "files/draco_connectivity.h"

namespace bob::files::draco {

/// The order of an attribute's values.
struct Sequence {
    const Corners* corners = nullptr;    // null if values follow the points' order
    std::vector<std::int32_t> first;     // a corner of each value
    std::vector<std::int32_t> value_of;  // by the corners' vertices
    std::size_t count = 0;

    [[nodiscard]] std::size_t at_corner(std::int32_t c) const { return static_cast<std::size_t>(value_of[static_cast<std::size_t>(corners->vertex_of(c))]); }
};

/// Vertices in the order in which a walk over all triangles meets them.
///
/// is_by_degree: it goes to vertices first that more triangles predict.
[[nodiscard]] Sequence walk(const Corners& corners, bool is_by_degree);

/// One attribute, as it is described and as it is decoded.
struct Attribute {
    int kind, type;  // what it means, and the type of its numbers, by Draco's numbers
    std::size_t width;
    std::uint32_t id;
    int coding = 0;
    std::size_t stored_width = 0;      // of the integers
    std::vector<std::int32_t> stored;  // (values, stored_width)
    std::vector<double> values;        // (values, width)
};

/// Where predictions find integer positions.
struct Positions {
    const Sequence* sequence = nullptr;
    const Attribute* attribute = nullptr;
};

[[nodiscard]] std::vector<Attribute> read_descriptions(Stream& stream);

/// Reads integers of an attribute and adds their predictions; or plain numbers.
void read_stored(Stream& stream, Attribute& attribute, const Sequence& sequence, const Positions& positions, Budget& budget);

/// Reads how integers become numbers, and applies it.
void read_values(Stream& stream, Attribute& attribute);

}  // namespace bob::files::draco
