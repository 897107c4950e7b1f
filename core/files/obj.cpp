/// OBJ: points, their colours, normals, places on textures and polygons, and the materials of its libraries.
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "base/counts.h"
#include "base/interruption.h"
#include "files/colors.h"
#include "files/mtl.h"
#include "files/not_shown.h"
#include "files/polygons.h"
#include "files/read.h"
#include "files/split.h"
#include "files/text.h"

namespace bob::files {
namespace {

/// Lines that end with a backslash go on in the next.
std::string joined_lines(std::string_view text) {
    std::string result(text);
    for (std::size_t at = result.find('\\'); at != std::string::npos; at = result.find('\\', at + 1)) {
        const bool is_return = result.compare(at + 1, 1, "\r") == 0, is_pair = result.compare(at + 1, 2, "\r\n") == 0;
        if (is_return || result.compare(at + 1, 1, "\n") == 0) result.replace(at, is_pair ? 3 : 2, is_pair ? 3 : 2, ' ');
    }
    return result;
}

/// The vertices of a part: distinct triples of point, texture coordinates and normal, in order of appearance.
class Vertices {
public:
    using Corner = std::array<std::int32_t, 3>;

    std::int32_t add(const Corner& corner) {
        if (4 * (corners_.size() + 1) > 3 * slots_.size()) grow();
        std::int32_t& slot = find(corner);
        if (slot < 0) {
            slot = static_cast<std::int32_t>(corners_.size());
            corners_.push_back(corner);
        }
        return slot;
    }
    /// Points, places or normals of all vertices.
    [[nodiscard]] std::vector<std::int32_t> numbers(std::size_t which) const {
        std::vector<std::int32_t> result(corners_.size());
        for (std::size_t i = 0; i < result.size(); ++i) result[i] = corners_[i][which];
        return result;
    }

private:
    std::int32_t& find(const Corner& corner) {
        std::uint64_t hash = 0;
        for (const std::int32_t number : corner) hash = (std::rotl(hash, 5) ^ static_cast<std::uint32_t>(number)) * 0x9e3779b97f4a7c15;
        std::size_t at = static_cast<std::size_t>(hash >> 20) & (slots_.size() - 1);
        while (slots_[at] >= 0 && corners_[static_cast<std::size_t>(slots_[at])] != corner) at = (at + 1) & (slots_.size() - 1);
        return slots_[at];
    }
    void grow() {
        Interruption::check();
        slots_.assign(2 * slots_.size(), -1);
        for (std::size_t i = 0; i < corners_.size(); ++i) find(corners_[i]) = static_cast<std::int32_t>(i);
    }

    std::vector<std::int32_t> slots_ = std::vector<std::int32_t>(1024, -1);
    std::vector<Corner> corners_;
};

/// A corner's index from 0 on, -1 if there is no such item. Below 0 counts back from the last item so far.
std::int32_t corner_index(std::string_view digits, std::size_t count) {
    const bool is_signed = !digits.empty() && (digits[0] == '-' || digits[0] == '+');
    std::uint64_t number = 0;
    const std::string_view own = digits.substr(is_signed ? 1 : 0);
    const bool is_whole = !own.empty() && std::ranges::all_of(own, [](char c) { return c >= '0' && c <= '9'; });
    if (!is_whole) refuse({"expected corners of faces such as 3, 3/1 or 3//2, got ", quoted(digits)});
    constexpr std::uint64_t most = std::uint64_t{1} << 31;
    for (const char c : own) number = std::min(10 * number + static_cast<std::uint64_t>(c - '0'), most);
    if (number == 0 || number >= most) return number == 0 ? -1 : digits[0] == '-' ? -1 : std::numeric_limits<std::int32_t>::max();
    if (digits[0] == '-') return number <= count ? static_cast<std::int32_t>(count - number) : -1;
    return static_cast<std::int32_t>(number - 1);
}

constexpr std::pair<std::string_view, std::string_view> elements_not_shown[] = {
    {"l", "lines"},
    {"p", "points"},
    {"curv", "curves"},
    {"curv2", "curves"},
    {"cdc", "curves"},
    {"surf", "freeform surfaces"},
    {"bsp", "freeform surfaces"},
    {"bzp", "freeform surfaces"},
    {"cdp", "freeform surfaces"},
    {"call", "files that it calls"},
};

class Obj {
public:
    Obj(std::string_view text, const MtlMaterials& materials) : has_materials_(!materials.empty()) {
        for (const auto& [name, material] : materials) is_textured_ |= !material.color.name.empty() || !material.mask.name.empty();
        for (Lines lines(text); lines.next();) {
            const std::string_view line = lines.line();
            Words words(line);
            const std::string_view word = words.next();
            if (word == "usemtl" && has_materials_) {
                used_ = trimmed(words.rest());
                continue;
            }
            if (word == "o" || word == "g") {
                (word == "o" ? object_ : group_) = trimmed(words.rest());
                if (word == "o") group_ = {};  // groups belong to their object
                label_.reset();
                continue;
            }
            if (word != "v" && word != "vn" && word != "vt" && word != "f" && word != "fo") {  // fo: f of old versions
                for (const auto& [key, name] : elements_not_shown) {
                    if (word == key) not_shown_.add(name);
                }
                continue;
            }
            Words numbers(words.rest().substr(0, words.rest().find('#')));
            if (word == "v") {
                add_point(numbers);
            } else if (word == "vn") {
                add_vector(numbers, normals_, 3);
            } else if (word == "vt") {
                add_place(numbers);
            } else {
                add_polygon(numbers);
            }
        }
    }

    [[nodiscard]] Contents contents(const MtlMaterials& materials) && {
        Contents contents;
        Part whole;
        const std::vector<std::int32_t> points = vertices_.numbers(0);
        const bool has_normals = !normals_.empty();
        // Colours are in 0..1; other numbers behind points are something else.
        const bool are_colors = std::ranges::none_of(colors_, [](double value) { return value < 0 || value > 1; });
        if (!are_colors) {
            colors_.clear();
            contents.warnings.emplace_back("numbers behind points were left out: expected colours in 0..1, got others");
        }
        if (!colors_.empty()) {
            colors_.resize(points_.size(), nan);
            make_linear(colors_, 1);
        }
        Numbers<std::int32_t> groups;
        std::vector<Part> named(has_materials_ ? names_.size() : 1);  // only their runs: of each material
        for (std::size_t i = 0; i < std::max(materials_.size(), labels_.size()); ++i) {
            const std::size_t triangles = Polygons::triangles(polygons_.sizes.empty() ? 3 : polygons_.sizes[i]);
            if (has_materials_) groups.insert(groups.end(), triangles, materials_[i]);
            if (!labels_.empty()) named[has_materials_ ? static_cast<std::size_t>(materials_[i]) : 0].add_run(labels_[i], triangles);
        }
        contents.labels = std::move(tree_);
        whole.triangles = triangulated(std::move(polygons_), points_, points, contents.warnings);
        if (has_materials_) {
            for (const std::string& name : names_) {
                const auto found = materials.find(name);
                if (found == materials.end()) continue;
                for (const std::string_view map : found->second.not_shown) not_shown_.add(map);
            }
        }
        not_shown_.report(contents, !whole.triangles.empty());
        if (whole.triangles.empty()) {
            whole.vertices = std::move(points_);
            contents.parts.push_back(std::move(whole));
            return contents;
        }
        whole.vertices = picked(points_, 3, points);
        if (has_normals) whole.normals = picked(normals_, 3, vertices_.numbers(2));
        if (!colors_.empty()) whole.colors = picked(colors_, 3, points);
        if (!has_materials_) {
            whole.runs = std::move(named[0].runs);
            contents.parts.push_back(std::move(whole));
            return contents;
        }
        whole.uv.push_back(picked(places_, 2, vertices_.numbers(1)));
        contents.parts = split(whole, groups, names_.size());
        std::unordered_map<std::string, int> images;
        std::vector<std::string> unknown;
        for (std::size_t i = 0; i < names_.size(); ++i) {
            contents.parts[i].runs = std::move(named[i].runs);
            const auto found = materials.find(names_[i]);
            if (found == materials.end() || contents.parts[i].triangles.empty()) {
                contents.parts[i].uv.clear();
                if (i > 0 && found == materials.end()) unknown.push_back(names_[i]);
            } else {
                contents.parts[i].surface = static_cast<int>(contents.surfaces.size());
                contents.surfaces.push_back(surface(found->first, found->second, images, contents, contents.parts[i]));
            }
        }
        std::erase_if(contents.parts, [](const Part& part) { return part.triangles.empty(); });
        if (!unknown.empty()) {
            const std::string further = unknown.size() > 1 ? joined({" and ", grouped(unknown.size() - 1), " more were"}) : " was";
            contents.warnings.push_back(joined({"material ", quoted(unknown[0]), further, " left out: expected a newmtl in the libraries, got none"}));
        }
        return contents;
    }

private:
    /// The number of the current material among the faces' materials.
    std::int32_t material() {
        if (used_) {
            std::string own = utf8(*used_);
            const auto [found, is_new] = numbers_.try_emplace(own, static_cast<std::int32_t>(names_.size()));
            if (is_new) names_.push_back(std::move(own));
            material_ = found->second;
            used_.reset();
        }
        return material_;
    }

    static void add_vector(Words& words, Numbers<double>& to, int width) {
        std::array<std::string_view, 3> own;
        for (int k = 0; k < width; ++k) own[static_cast<std::size_t>(k)] = words.next();
        const bool is_whole = !own[static_cast<std::size_t>(width - 1)].empty();
        for (int k = 0; k < width; ++k) to.push_back(is_whole ? number_of(own[static_cast<std::size_t>(k)]) : nan);
    }

    /// A point, and its colour in sRGB if three more numbers follow.
    void add_point(Words& words) {
        const std::size_t point = points_.size();
        add_vector(words, points_, 3);
        const std::array own{words.next(), words.next(), words.next()};
        if (own[2].empty()) return;
        colors_.resize(point, nan);
        for (const std::string_view word : own) colors_.push_back(number_of(word));
    }

    void add_place(Words& words) {
        for (int k = 0; k < 2; ++k) {
            const std::string_view word = words.next();
            places_.push_back(!word.empty() ? number_of(word) : k == 0 ? nan : 0);  // v is 0 if omitted
        }
    }

    void add_polygon(Words& words) {
        polygon_.clear();
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            Vertices::Corner corner{-1, -1, -1};
            const std::size_t counts[] = {points_.size() / 3, places_.size() / 2, normals_.size() / 3};
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t slash = word.find('/');
                const std::string_view digits = word.substr(0, slash);
                if (k == 0 || !digits.empty()) corner[k] = corner_index(digits, counts[k]);
                if (slash == std::string_view::npos) break;
                word = word.substr(slash + 1);
            }
            if (!is_textured_) corner[1] = -1;
            polygon_.push_back(vertices_.add(corner));
        }
        polygons_.add(polygon_);
        if (has_materials_) materials_.push_back(material());
        if (!label_) label_ = label(group_, label(object_, -1));
        if (*label_ >= 0) labels_.resize(count_, -1);
        if (++count_; *label_ >= 0 || !labels_.empty()) labels_.push_back(*label_);
    }

    /// The number of a name below a parent's; the parent's if it is empty.
    std::int32_t label(std::string_view name, std::int32_t parent) {
        if (name.empty()) return parent;
        const auto [found, is_new] = label_numbers_.try_emplace({parent, utf8(name)}, static_cast<std::int32_t>(tree_.size()));
        if (is_new) tree_.push_back({found->first.second, parent});
        return found->second;
    }

    /// The surface of a part, whose places on it are moved as the map says.
    static Surface surface(const std::string& name, const MtlMaterial& material, std::unordered_map<std::string, int>& images,
                           Contents& contents, Part& part) {
        Surface surface;
        surface.name = name;
        surface.material = material.reflecting;
        surface.replaces_color = true;  // exporters write any Kd next to a texture, and importers such as Blender's ignore it
        surface.opacity = Opacity::translucent;
        const auto layer = [&](const Map& map) {
            Layer result;
            if (map.name.empty()) return result;
            const auto [found, is_new] = images.try_emplace(map.name, static_cast<int>(contents.images.size()));
            if (is_new) contents.images.push_back({map.name});
            result.image = found->second;
            result.across = result.down = map.is_clamped ? Wrap::clamp : Wrap::repeat;
            return result;
        };
        surface.color = layer(material.color), surface.mask = layer(material.mask);
        const Map& map = surface.color.image >= 0 ? material.color : material.mask;
        if (map.name.empty()) {
            part.uv.clear();
            return surface;
        }
        Numbers<double>& uv = part.uv[0];
        for (std::size_t i = 0; i < uv.size(); ++i) {
            const double value = map.scale[i % 2] * uv[i] + map.offset[i % 2];
            uv[i] = i % 2 ? 1 - value : value;  // an OBJ counts from the bottom up
        }
        return surface;
    }

    const bool has_materials_;
    bool is_textured_ = false;
    NotShown not_shown_;
    Numbers<double> points_, colors_, normals_, places_;
    Polygons polygons_;
    std::vector<std::int32_t> polygon_, materials_;  // materials_: of the polygons
    Vertices vertices_;
    std::vector<std::string> names_{""};  // of materials, in the order of their first faces
    std::unordered_map<std::string, std::int32_t> numbers_{{"", 0}};
    std::int32_t material_ = 0;
    std::string_view object_, group_;
    std::optional<std::int32_t> label_;  // of both, once a face has it
    std::vector<Label> tree_;
    std::map<std::pair<std::int32_t, std::string>, std::int32_t> label_numbers_;
    std::vector<std::int32_t> labels_;  // of the polygons; empty until one has a label
    std::size_t count_ = 0;             // of polygons
    std::optional<std::string_view> used_;  // the name of another one, until a face has it
};

/// The text after each mtllib.
std::vector<std::string> libraries_of(std::string_view text) {
    std::vector<std::string> names;
    if (text.find("mtllib") == std::string_view::npos || text.find("usemtl") == std::string_view::npos) return names;
    for (Lines lines(text); lines.next();) {
        Words words(lines.line());
        if (words.next() == "mtllib") names.emplace_back(trimmed(words.rest()));
    }
    return names;
}

}  // namespace

Contents read_obj(Bytes bytes, Beside& beside) {
    std::string_view text = text_of(bytes);
    std::string without_breaks;
    if (text.find('\\') != std::string_view::npos) text = without_breaks = joined_lines(text);
    std::vector<std::string> warnings;
    const MtlMaterials materials = read_mtl(libraries_of(text), beside, warnings);
    if (beside.is_waiting()) return {};
    Contents contents = Obj(text, materials).contents(materials);
    contents.warnings.insert(contents.warnings.begin(), warnings.begin(), warnings.end());
    return contents;
}

}  // namespace bob::files
