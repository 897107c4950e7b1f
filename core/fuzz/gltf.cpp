/// glTF and GLB: any bytes end in parts whose arrays fit together, or an error. Files next to it hold the bytes of the file itself.
#include <stdexcept>
#include <string>
#include <utility>

#include "base/interruption.h"
#include "files/read.h"
#include "fuzz/fuzz.h"

FUZZ(gltf) {
    using namespace bob::files;
    const std::string_view text = source.text();
    const Bytes bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    try {
        const bob::Interruption impatience(fuzz::Patience{1000});
        Reading reading(reader_of(text.starts_with("glTF") ? "glb" : "gltf"), bytes);
        for (std::string wanted = reading.go_on(); !wanted.empty(); wanted = reading.go_on()) {
            if (wanted.size() % 2) {
                reading.give(bytes);
            } else {
                reading.refuse("expected another file");
            }
        }
        const Contents& contents = reading.contents();
        for (const Part& part : contents.parts) {
            const std::size_t count = part.vertices.size() / 3;
            const auto fits = [](const auto& numbers, std::size_t size) { return numbers.empty() || numbers.size() == size; };
            fuzz::expect(part.vertices.size() == 3 * count && part.triangles.size() % 3 == 0, "vectors of three");
            fuzz::expect(fits(part.normals, 3 * count) && fits(part.colors, 3 * count) && fits(part.alphas, count), "one of a field for each vertex");
            for (const auto& uv : part.uv) fuzz::expect(fits(uv, 2 * count), "coordinates for each vertex");
            for (const std::int32_t corner : part.triangles) {
                fuzz::expect(corner == -1 || (corner >= 0 && static_cast<std::size_t>(corner) < count), "corners among the vertices");
            }
            fuzz::expect(part.surface >= -1 && part.surface < static_cast<int>(contents.surfaces.size()), "a surface of the file");
            if (part.surface < 0) continue;
            const Surface& surface = contents.surfaces[static_cast<std::size_t>(part.surface)];
            fuzz::expect(surface.color.image < static_cast<int>(contents.images.size()), "an image of the file");
            fuzz::expect(surface.color.image < 0 || static_cast<std::size_t>(surface.color.uv) < part.uv.size(), "coordinates for each image");
        }
        fuzz::expect(!description(contents).empty(), "a description");
    } catch (const std::invalid_argument&) {
    } catch (const bob::Stopped&) {
    }
}
