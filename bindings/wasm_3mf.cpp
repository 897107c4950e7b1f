/// 3MF, which may have any shapes, in the WebAssembly module; core.mesh.wasm omits it.
#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>

#include "formula/arrays.h"
#include "wasm.h"
#include "wasm_reading.h"

namespace {

template <class T>
void add(Reading& reading, std::span<const T> values) {
    Reading::Array& array = reading.arrays.emplace_back(std::vector<std::uint8_t>(values.size_bytes()), values.size());
    if (!values.empty()) std::memcpy(array.bytes.data(), values.data(), values.size_bytes());
}

template <class T>
void add(Reading& reading, const std::vector<T>& values) {
    add(reading, std::span<const T>(values));
}

/// The arrays of nodes and meshes in a scene file; empty ones without a formula.
template <class Formula>
void add_formula(Reading& reading, const Formula* formula) {
    std::vector<std::uint8_t> ops;
    std::vector<std::uint32_t> operands, sizes, triangles;
    std::vector<double> values;
    std::vector<float> vertices;
    if (formula) {
        for (const bob::Node& node : formula->nodes()) {
            ops.push_back(static_cast<std::uint8_t>(node.op));
            operands.insert(operands.end(), std::begin(node.operand), std::end(node.operand));
            values.push_back(bob::value_in_arrays(node, formula->meshes()));
        }
        for (const auto& mesh : formula->meshes()) {
            sizes.push_back(static_cast<std::uint32_t>(mesh->vertices().size()));
            sizes.push_back(static_cast<std::uint32_t>(mesh->triangles().size()));
            for (const bob::Vec3& p : mesh->vertices()) vertices.insert(vertices.end(), {p.x, p.y, p.z});
            for (const auto& corners : mesh->triangles()) triangles.insert(triangles.end(), corners.begin(), corners.end());
        }
    }
    add(reading, ops);
    add(reading, operands);
    add(reading, values);
    add(reading, sizes);
    add(reading, vertices);
    add(reading, triangles);
}

}  // namespace

/// The bytes have to stay until the reading is freed.
EXPORT(make_reading)
Reading* make_reading(const char* format, std::size_t length, const std::uint8_t* bytes, std::size_t size) {
    return attempt([&] {
        expect(std::string_view(format, length) == "3mf", "format: expected 3mf, which this module reads, got another");
        return new Reading{bob::files::Reading(bob::files::read_3mf, {bytes, size})};
    });
}

/// Sets the arrays of a shape other than a mesh, as in a scene file. Of beams: ends, knots and radii. Of a level set: bounds, then ops,
/// operands, values, and sizes, vertices and triangles of meshes; the same for its colour, and its roots.
EXPORT(read_shape) bool read_shape(Reading* reading, std::size_t number) {
    return attempt([&] {
        reading->arrays.clear();
        const auto& shape = reading->core.contents().shapes.at(number).shape;
        if (const auto* const beams = std::get_if<bob::files::Beams>(&shape)) {
            std::vector<double> knots;  // two of each number: the curve jumps
            for (std::size_t i = 0; i < beams->radii.size() + 2; ++i) knots.push_back(static_cast<double>(i / 2));
            add<double>(*reading, beams->ends);
            add(*reading, knots);
            add<double>(*reading, beams->radii);
            return true;
        }
        const auto& [formula, bounds, color] = std::get<bob::files::LevelSet>(shape);
        std::vector<double> box(std::begin(bounds.low), std::end(bounds.low));
        box.insert(box.end(), std::begin(bounds.high), std::end(bounds.high));
        add(*reading, box);
        add_formula(*reading, &formula);
        add_formula(*reading, color.get());
        if (color) add<std::uint32_t>(*reading, color->roots());
        return true;
    });
}

/// An array of the shape that was read last.
EXPORT(shape_array) const std::uint8_t* shape_array(const Reading* reading, std::size_t number) { return reading->arrays.at(number).bytes.data(); }
EXPORT(shape_array_size) std::size_t shape_array_size(const Reading* reading, std::size_t number) {
    return number < reading->arrays.size() ? reading->arrays[number].size : 0;
}
