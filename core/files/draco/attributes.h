/// Attributes of Draco's points: how they are stored, and how integers become numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "files/draco/walk.h"

namespace bob::files::draco {

/// How numbers are stored.
enum Coding : std::uint8_t { plain_numbers, integers, quantized, unit_vectors };

/// One attribute, as it is described and as it is decoded.
struct Attribute {
    int kind, type;  // its meaning and the type of its numbers, by Draco's numbers
    std::size_t width;
    std::uint32_t id;
    int coding = 0;
    std::size_t stored_width = 0;      // of the integers
    std::vector<std::int32_t> stored;  // (values, stored_width)
    std::vector<double> values;        // (values, width)
};

[[nodiscard]] std::vector<Attribute> read_descriptions(Stream& stream);

struct Positions;

/// Reads integers of an attribute and adds their predictions; or plain numbers.
void read_stored(Stream& stream, Attribute& attribute, const Sequence& sequence, const Positions& positions, Budget& budget);

/// Reads how integers become numbers, and applies it.
void read_values(Stream& stream, Attribute& attribute);

}  // namespace bob::files::draco
