#include "files/draco/attributes.h"

#include <array>
#include <cstring>
#include <utility>

#include "files/draco/corrections.h"
#include "files/draco/entropy.h"
#include "files/draco/predictions.h"
#include "files/text.h"

namespace bob::files::draco {
namespace {

constexpr std::size_t max_attributes = 256;
constexpr int none = -2;  // of predictions

/// Bytes of a number by its type: 1 to 6 are integers, signed if odd.
std::size_t size_of(int type) {
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1};
    return sizes[type - 1];
}

constexpr int float32 = 9, float64 = 10;

double number_at(const std::uint8_t* from, int type) {
    switch (type) {
        case 1: return load<std::int8_t>(from, false);
        case 3: return load<std::int16_t>(from, false);
        case 4: return load<std::uint16_t>(from, false);
        case 5: return load<std::int32_t>(from, false);
        case 6: return load<std::uint32_t>(from, false);
        case 7: return static_cast<double>(load<std::int64_t>(from, false));
        case 8: return static_cast<double>(load<std::uint64_t>(from, false));
        case float32: return load<float>(from, false);
        case float64: return load<double>(from, false);
        default: return *from;
    }
}

}  // namespace

std::vector<Attribute> read_descriptions(Stream& stream) {
    const std::uint32_t count = stream.varint();
    if (count == 0 || count > max_attributes) refuse({"expected 1 to 256 attributes, got ", std::to_string(count)});
    std::vector<Attribute> result;
    for (std::uint32_t i = 0; i < count; ++i) {
        Attribute attribute{};
        attribute.kind = stream.number();
        attribute.type = stream.number();
        attribute.width = stream.number();
        static_cast<void>(stream.number());  // whether it is normalized, which the accessor says
        attribute.id = stream.varint();
        if (attribute.type < 1 || attribute.type > 11 || attribute.width == 0) refuse_values();
        result.push_back(std::move(attribute));
    }
    for (Attribute& attribute : result) {
        attribute.coding = stream.number();
        const bool is_float = attribute.coding == quantized || attribute.coding == unit_vectors;
        if (attribute.coding > unit_vectors || (is_float && attribute.type != float32)) refuse_values();
        if (attribute.coding == integers && attribute.type > 6) refuse_values();
        if (attribute.coding == unit_vectors && attribute.width != 3) refuse_values();
    }
    return result;
}

void read_stored(Stream& stream, Attribute& attribute, const Sequence& sequence, const Positions& positions, Budget& budget) {
    const std::size_t count = sequence.count;
    budget.take(8 * std::uint64_t{count} * attribute.width);
    if (attribute.coding == plain_numbers) {
        const std::size_t size = size_of(attribute.type);
        const Bytes bytes = stream.take(std::uint64_t{count} * attribute.width * size);
        for (std::size_t at = 0; at < bytes.size(); at += size) attribute.values.push_back(number_at(&bytes[at], attribute.type));
        return;
    }
    const int method = stream.number<std::int8_t>();
    const bool is_octahedral = attribute.coding == unit_vectors;
    if (method != none) {
        const int correction = stream.number<std::int8_t>();
        if (correction != (is_octahedral ? 3 : 1)) refuse_values();
    }
    attribute.stored_width = is_octahedral ? 2 : attribute.width;
    const std::size_t numbers = count * attribute.stored_width;
    if (stream.number()) {
        const std::vector<std::uint32_t> read = symbols(stream, numbers, attribute.stored_width, budget);
        attribute.stored.assign(read.begin(), read.end());
    } else {
        const std::size_t size = stream.number();
        if (size > 4) refuse_values();
        const Bytes bytes = stream.take(std::uint64_t{numbers} * size);
        attribute.stored.resize(numbers);
        for (std::size_t i = 0; i < numbers; ++i) {
            std::uint32_t number = 0;
            for (std::size_t k = 0; k < size; ++k) number |= std::uint32_t{bytes[i * size + k]} << (8 * k);
            attribute.stored[i] = static_cast<std::int32_t>(number);
        }
    }
    if (method == none || !is_octahedral) {
        for (std::int32_t& number : attribute.stored) number = static_cast<std::int32_t>(unzigzagged(static_cast<std::uint32_t>(number)));
    }
    if (method != none) add_predictions(stream, method, attribute, sequence, positions);
}

void read_values(Stream& stream, Attribute& attribute) {
    const std::vector<std::int32_t>& stored = attribute.stored;
    if (attribute.coding == plain_numbers) return;
    if (attribute.coding == unit_vectors) {
        Octahedron octahedron;
        octahedron.set_bits(stream.number());
        for (std::size_t i = 0; i < stored.size(); i += 2) {
            for (const double number : octahedron.direction(stored[i], stored[i + 1])) attribute.values.push_back(number);
        }
    } else if (attribute.coding == quantized) {
        std::vector<float> lowest;
        for (std::size_t k = 0; k < attribute.width; ++k) lowest.push_back(stream.number<float>());
        const auto range = stream.number<float>();
        const unsigned bits = stream.number();
        if (bits < 1 || bits > 30) refuse_values();
        const float unit = range / static_cast<float>((1u << bits) - 1);
        for (std::size_t i = 0; i < stored.size(); ++i) attribute.values.push_back(static_cast<float>(stored[i]) * unit + lowest[i % attribute.width]);
    } else {
        // Draco keeps the lowest bytes.
        for (const std::int32_t number : stored) {
            std::array<std::uint8_t, 8> bytes{};
            std::memcpy(bytes.data(), &number, sizeof number);
            attribute.values.push_back(number_at(bytes.data(), attribute.type));
        }
    }
}

}  // namespace bob::files::draco
