/// Colours and textures of a 3MF: groups of them, from which triangles and their corners choose.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/part.h"

namespace bob::files::threemf {

using Rgb = std::array<double, 3>;  // linear

/// A colour or a place on a texture: the numbers of its group, and in it; -1 without one.
struct Swatch {
    int group = -1;
    std::int32_t number = -1;

    bool operator==(const Swatch&) const = default;
};

/// Of the corners of a triangle.
using Swatches = std::array<Swatch, 3>;

/// A mesh, and the swatches of its triangles.
struct Mesh {
    Numbers<double> vertices;         // (V, 3)
    Numbers<std::int32_t> triangles;  // (T, 3)
    std::vector<Swatches> chosen;     // (T,)
};

/// A picture in the package, and how it is repeated.
struct Texture {
    std::string path;
    Wrap across = Wrap::repeat, down = Wrap::repeat;
};

/// The groups of a model. Ids are as in the file.
class Palette {
public:
    Palette() { static_cast<void>(group_number("")); }

    /// A swatch by the id of its group, and its number there.
    [[nodiscard]] Swatch swatch(std::string_view group, std::string_view number);

    void add_texture(std::string_view id, Texture texture) { textures_[texture_number(id)] = std::move(texture); }

    /// Begins a group of colours. is_flat: of base materials, which do not blend: the first corner's applies to the triangle.
    void start(std::string_view group, bool is_flat = false);
    /// Begins a group of places on a texture.
    void start_places(std::string_view group, std::string_view texture);
    /// Begins a group of mixtures of another group's colours.
    void start_mixtures(std::string_view group, std::string_view of, std::string_view numbers);

    /// Adds a colour to the group: sRGB as #rrggbb or #rrggbbaa; white if it is another.
    void add(std::string_view color);
    /// Adds a mixture to the group, by its shares; white if these are invalid.
    void add_mixture(std::string_view shares);
    void add_place(std::string_view u, std::string_view v);

    /// The colours of a triangle's corners; white for a missing one.
    [[nodiscard]] std::array<Rgb, 3> of(Swatches swatches) const;

    /// The parts of a mesh: one for each texture, and one for the rest. surface: its number by a texture, null for an unknown one; -1
    /// where it can't be shown.
    [[nodiscard]] std::vector<Part> parts(Mesh mesh, const std::function<int(const Texture*)>& surface) const;

private:
    struct Group {
        bool is_flat = false;
        std::optional<std::size_t> texture;  // its number, of a group of places
        std::vector<Rgb> colors;
        std::vector<std::array<double, 2>> places;
    };

    int group_number(std::string_view group);
    std::size_t texture_number(std::string_view texture);
    [[nodiscard]] Rgb color(Swatch swatch) const;
    [[nodiscard]] const Group* group(Swatch swatch) const { return swatch.group < 0 ? nullptr : &groups_[static_cast<std::size_t>(swatch.group)]; }
    [[nodiscard]] Part colored(Mesh mesh) const;
    [[nodiscard]] Part laid(const Mesh& mesh, std::size_t texture, const std::function<int(const Texture*)>& surface) const;

    std::map<std::string, int, std::less<>> numbers_;  // of groups by their ids
    std::vector<Group> groups_;
    std::map<std::string, std::size_t, std::less<>> texture_numbers_;  // by their ids
    std::vector<std::optional<Texture>> textures_;
    std::size_t current_ = 0;  // the number of the group that takes colours
    std::vector<Rgb> mixed_;  // the components of mixtures
    bool has_colors_ = false, has_places_ = false;
};

/// The numbers of a text.
[[nodiscard]] std::vector<double> numbers_of(std::string_view text);

}  // namespace bob::files::threemf
