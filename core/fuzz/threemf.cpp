/// 3MF: any bytes, and any model in a package, end in parts whose arrays fit together and in shapes, or in an error.
#include <stdexcept>
#include <string>

#include "base/interruption.h"
#include "files/read.h"
#include "fuzz/fuzz.h"
#include "fuzz/zipped.h"

/// A zip file, or a model, perhaps with a second model that it names after two zero bytes.
FUZZ(threemf) {
    using namespace bob::files;
    const std::string_view text = source.text();
    const std::size_t middle = text.find(std::string_view("\0\0", 2));
    const std::string_view other = middle == std::string_view::npos ? std::string_view() : text.substr(middle + 2);
    const std::string package = text.starts_with("PK") ? std::string(text) : fuzz::zipped({{"3D/3dmodel.model", text.substr(0, middle)}, {"b.model", other}});
    try {
        const bob::Interruption impatience(fuzz::Patience{1000});
        Reading reading(read_3mf, Bytes(reinterpret_cast<const std::uint8_t*>(package.data()), package.size()));
        fuzz::expect(reading.go_on().empty(), "no other files");
        const Contents& contents = reading.contents();
        for (const Part& part : contents.parts) {
            const std::size_t count = part.vertices.size() / 3, triangles = part.triangles.size() / 3;
            const auto fits = [](const auto& numbers, std::size_t size) { return numbers.empty() || numbers.size() == size; };
            fuzz::expect(part.vertices.size() == 3 * count && part.triangles.size() == 3 * triangles, "vectors of three");
            fuzz::expect(fits(part.colors, 3 * count) && fits(part.face_colors, 3 * triangles), "a colour for each vertex or triangle");
            for (const auto& uv : part.uv) fuzz::expect(fits(uv, 2 * count), "coordinates for each vertex");
            for (const std::int32_t corner : part.triangles) {
                fuzz::expect(corner == -1 || (corner >= 0 && static_cast<std::size_t>(corner) < count), "corners among the vertices");
            }
            fuzz::expect(part.surface >= -1 && part.surface < static_cast<int>(contents.surfaces.size()), "a surface of the file");
        }
        for (const OtherShape& shape : contents.shapes) {
            if (const auto* const beams = std::get_if<Beams>(&shape.shape)) {
                fuzz::expect(!beams->radii.empty() && beams->ends.size() == 3 * beams->radii.size(), "a radius for each end");
            } else {
                fuzz::expect(!std::get<LevelSet>(shape.shape).formula.nodes().empty(), "a formula");
            }
        }
        for (const Placement& placement : contents.placements) {
            fuzz::expect(placement.shape < contents.shapes.size() && placement.label < static_cast<int>(contents.labels.size()), "a shape with a label");
        }
        fuzz::expect(!description(contents).empty(), "a description");
    } catch (const std::invalid_argument&) {
    } catch (const bob::Stopped&) {
    }
}
