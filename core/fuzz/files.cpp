/// Mesh files: any bytes, and any bytes in the files that they name, make parts or are refused in one line. Arrays of parts fit
/// together, and their memory is proportional to the bytes.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "files/read.h"
#include "fuzz/fuzz.h"

namespace {

constexpr std::string_view formats[] = {"ply", "stl", "off", "obj"};

void expect_rows(const bob::files::Numbers<double>& numbers, std::size_t rows, std::size_t width, const char* what) {
    fuzz::expect(numbers.empty() || numbers.size() == rows * width, what);
}

/// The numbers in a part, all fields together.
std::size_t checked(const bob::files::Part& part) {
    const std::size_t vertices = part.vertices.size() / 3, triangles = part.triangles.size() / 3;
    fuzz::expect(part.vertices.size() == 3 * vertices && part.triangles.size() == 3 * triangles, "rows of three");
    expect_rows(part.normals, vertices, 3, "a normal for each vertex");
    expect_rows(part.colors, vertices, 3, "a colour for each vertex");
    expect_rows(part.face_colors, triangles, 3, "a colour for each triangle");
    expect_rows(part.alphas, vertices, 1, "an alpha for each vertex");
    for (const auto& uv : part.uv) fuzz::expect(uv.size() == 2 * vertices, "a place on a texture for each vertex");
    return part.vertices.size() + part.triangles.size() + part.normals.size() + part.colors.size() + part.face_colors.size();
}

}  // namespace

/// A byte for the format, the model up to two zero bytes, then the file next to it.
FUZZ(files) {
    const std::string_view format = formats[source.below(static_cast<std::uint32_t>(std::size(formats)))];
    const std::string_view all = source.text();
    const std::size_t middle = format == "obj" ? all.find(std::string_view("\0\0", 2)) : std::string_view::npos;
    const auto bytes = [](std::string_view text) { return bob::files::Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()); };
    const std::string_view other = middle == std::string_view::npos ? std::string_view() : all.substr(middle + 2);
    bob::files::Reading reading(bob::files::reader_of(format), bytes(all.substr(0, middle)));
    try {
        int asked = 0;
        for (std::string wanted = reading.go_on(); !wanted.empty(); wanted = reading.go_on()) {
            fuzz::expect(++asked <= 4096, "a file for each name in the model, once");
            if (wanted.size() % 2 == 0) {
                reading.give(bytes(other));
            } else {
                reading.refuse("expected a file, got none");
            }
        }
    } catch (const std::invalid_argument& error) {
        fuzz::expect(std::string_view(error.what()).find("expected") != std::string_view::npos, "an error that says what was expected");
        return;
    }
    const bob::files::Contents& contents = reading.contents();
    std::size_t numbers = 0;
    for (const bob::files::Part& part : contents.parts) {
        numbers += checked(part);
        fuzz::expect(part.surface >= -1 && part.surface < static_cast<int>(contents.surfaces.size()), "a surface among those of the file");
    }
    fuzz::expect(numbers <= 64 * (all.size() + 16), "memory in proportion to the file");
    for (const bob::files::Surface& surface : contents.surfaces) {
        for (const bob::files::Layer* layer : {&surface.color, &surface.mask}) {
            fuzz::expect(layer->image >= -1 && layer->image < static_cast<int>(contents.images.size()), "an image among those of the file");
        }
        fuzz::expect(surface.material.shininess >= 1 && surface.material.specular <= 1, "a material in range");
    }
    const std::string described = bob::files::description(contents);
    fuzz::expect(std::ranges::all_of(described, [](char c) { return c >= ' ' && c < 127; }), "a description in ASCII");
}
