/// Reads mesh files of every format: bytes in, parts out.
#pragma once

#include <string>
#include <string_view>

#include "files/part.h"

namespace bob::files {

/// A reader throws std::invalid_argument, of one line without the file's name, where it can't read a file. It checks Interruption.
using Reader = Contents (*)(Bytes bytes, Beside& beside);

[[nodiscard]] Contents read_3mf(Bytes bytes, Beside& beside);
[[nodiscard]] Contents read_glb(Bytes bytes, Beside& beside);
[[nodiscard]] Contents read_gltf(Bytes bytes, Beside& beside);
[[nodiscard]] Contents read_obj(Bytes bytes, Beside& beside);
[[nodiscard]] Contents read_off(Bytes bytes, Beside& beside);
[[nodiscard]] Contents read_ply(Bytes bytes, Beside& beside);
[[nodiscard]] Contents read_stl(Bytes bytes, Beside& beside);

/// The reader of a format whose files have meshes alone, and the reader of any format, by the ending of a file's name, in lower case and
/// without its point. Throws std::invalid_argument for other endings.
[[nodiscard]] Reader reader_of_meshes(std::string_view ending);
[[nodiscard]] Reader reader_of(std::string_view ending);

/// The reading of one file, in as many steps as it takes to fetch other files that it names.
class Reading {
public:
    /// The bytes have to live as long as the reading.
    Reading(Reader reader, Bytes bytes) : reader_(reader), bytes_(bytes) {}

    /// Reads on. Returns the name of a file that is needed first, which `give` or `refuse` has to answer; empty at the end.
    [[nodiscard]] std::string go_on();
    void give(Bytes bytes) { beside_.answer({{bytes.begin(), bytes.end()}, {}}); }
    /// why: the host's reason, in a line.
    void refuse(std::string_view why) { beside_.answer({{}, std::string(why)}); }

    /// Complete once `go_on` has returned nothing.
    [[nodiscard]] Contents& contents() { return contents_; }

private:
    Reader reader_;
    Bytes bytes_;
    Beside beside_;
    Contents contents_;
};

/// All but numbers and embedded images, as JSON in ASCII:
/// {"parts": [{"runs": [label, count, ...], "surface", "uv": number of sets}], "labels": [{"name", "parent"}],
///  "surfaces": [{"name", "layers": {"color" | "emission" | "metallic_roughness" | "mask": {"image", "wrap": ["repeat" | "clamp" |
///   "mirror", "..."], "uv"}}, "replaces_color": 0 or 1, "opacity": "opaque" | "cutout" | "translucent"}],
///  "images": [{"name", "label"}], "shapes": [{"kind": "tube" | "implicit", "name"}], "placements": [[shape, label], ...],
///  "warnings": [...], "unit"}
[[nodiscard]] std::string description(const Contents& contents);

/// The numbers that the description lacks: 22 for each surface, in the order of Material, with the alpha cutoff last; 3 for the colour of
/// each shape; 12 for each placement, the upper rows of its matrix. Writing them exactly as text would take 100 kB of tables.
[[nodiscard]] Numbers<double> numbers(const Contents& contents);

/// A part's array by its number: vertices, normals, colors, face_colors, alphas, and from 5 on uv sets. Empty if the part lacks it.
[[nodiscard]] Numbers<double>& field(Part& part, std::size_t number);

}  // namespace bob::files
