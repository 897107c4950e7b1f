#include "files/mtl.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

#include "files/colors.h"
#include "files/text.h"

namespace bob::files {
namespace {

using Statements = std::map<std::string, std::string, std::less<>>;  // by their first words, in lower case

/// Statements of maps that are not shown. map_Ka is missing: it repeats map_Kd, and surfaces have one color.
constexpr std::pair<std::string_view, std::string_view> other_maps[] = {
    {"bump", "bump maps"},
    {"map_bump", "bump maps"},
    {"disp", "displacement maps"},
    {"map_disp", "displacement maps"},
    {"norm", "normal maps"},
    {"map_kn", "normal maps"},
    {"map_ke", "emission maps"},
    {"map_ks", "specular maps"},
    {"map_ns", "maps of glossiness"},
    {"map_pm", "maps of metal and roughness"},
    {"map_pr", "maps of metal and roughness"},
    {"map_ps", "sheen maps"},
    {"refl", "reflection maps"},
    {"map_refl", "reflection maps"},
    {"decal", "decals"},
};

std::optional<double> number(std::string_view word) {
    try {
        const double value = number_of(word);
        return std::isfinite(value) ? std::optional(value) : std::nullopt;
    } catch (const std::invalid_argument&) {
        return std::nullopt;
    }
}

std::string_view statement(const Statements& of, std::string_view name) {
    const auto found = of.find(name);
    return found == of.end() ? std::string_view() : std::string_view(found->second);
}

double unit(std::optional<double> value, double otherwise) { return value ? std::clamp(*value, 0., 1.) : otherwise; }

/// Linear RGB of a statement's sRGB, which has three numbers or one; null if it has other words.
std::optional<std::array<double, 3>> color(std::string_view text, double otherwise) {
    Words words(text.substr(0, text.find('#')));
    std::array<std::string_view, 3> own{words.next(), words.next(), words.next()};
    if (own[1].empty()) own[1] = own[2] = own[0];
    std::array<double, 3> rgb;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto value = number(own[k]);
        if (!value && !own[k].empty()) return std::nullopt;
        rgb[k] = linear(unit(value, otherwise));
    }
    return rgb;
}

/// A path as files have it, perhaps in quotes, or written under Windows.
std::string path_of(std::string_view name) {
    name = trimmed(name);
    if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    std::string path = utf8(name);
    std::ranges::replace(path, '\\', '/');
    return path;
}

/// The path, resolved in the folder of another file unless it begins at a root.
std::string in_folder_of(std::string_view file, const std::string& path) {
    const std::size_t folder = file.rfind('/');
    const bool is_absolute = path.starts_with('/') || (path.size() > 1 && path[1] == ':');
    return folder == std::string_view::npos || is_absolute || path.empty() ? path : std::string(file.substr(0, folder + 1)) + path;
}

/// The options of a map, and its file, whose name may have spaces and '#'.
Map map_of(std::string_view text, std::string_view library) {
    Map map;
    Words words(text);
    std::string_view rest = text;
    while (true) {
        Words ahead = words;
        std::string_view option = ahead.next();
        if (option.size() < 2 || option[0] != '-' || trimmed(ahead.rest()).empty()) break;
        words = ahead;
        if (const bool is_scale = is_word(option, "-s"); is_scale || is_word(option, "-o") || is_word(option, "-t") || is_word(option, "-mm")) {
            const int most = is_word(option, "-mm") ? 2 : 3;
            for (int count = 0; count < most; ++count) {
                ahead = words;
                const auto value = number(ahead.next());
                if (!value || trimmed(ahead.rest()).empty()) break;
                words = ahead;
                if (count < 2 && is_scale) map.scale[static_cast<std::size_t>(count)] = *value;
                if (count < 2 && is_word(option, "-o")) map.offset[static_cast<std::size_t>(count)] = *value;
            }
        } else {
            const std::string_view value = words.next();
            map.is_clamped |= is_word(option, "-clamp") && is_word(value, "on");
        }
        rest = words.rest();
    }
    map.name = in_folder_of(library, path_of(rest));
    return map;
}

MtlMaterial material_of(std::string_view own_name, const Statements& of, std::string_view library, std::vector<std::string>& warnings) {
    MtlMaterial result;
    const auto given_color = [&](std::string_view name, double otherwise) {
        const std::string_view text = statement(of, lower(name));
        const auto rgb = color(text, otherwise);
        if (!rgb) warnings.push_back(joined({name, " of material ", quoted(own_name), " was left out: expected one or three numbers, got ", quoted(text)}));
        return rgb.value_or(std::array{otherwise, otherwise, otherwise});
    };
    Material& material = result.reflecting;
    result.color = map_of(statement(of, "map_kd"), library), result.mask = map_of(statement(of, "map_d"), library);
    std::ranges::copy(given_color("Kd", 1), material.color);
    std::ranges::copy(given_color("Ke", 0), material.emissive);
    if (of.contains("map_ke")) std::ranges::fill(material.emissive, 0.0);  // which would glow everywhere without the map
    for (const auto& [name, map] : other_maps) {
        if (of.contains(name)) result.not_shown.push_back(map);
    }
    const auto first = [&](std::string_view name) { return number(Words(statement(of, name)).next()); };
    if (of.contains("pm") || of.contains("pr")) {
        material.metallic = unit(first("pm"), 0), material.roughness = unit(first("pr"), 0.5);
        material.clearcoat = unit(first("pc"), 0), material.clearcoat_roughness = unit(first("pcr"), 0);
        if (first("ps").value_or(0) > 0) result.not_shown.push_back("sheen");
        return result;
    }
    // Highlights of full strength are common in files and wash colours out: Ks scales the one that surfaces have here.
    material.specular = 0.2 * std::ranges::max(given_color("Ks", 1));
    const double exponent = first("ns").value_or(0);
    material.shininess = exponent >= 1 ? std::min(exponent, 10'000.) : 32;
    return result;
}

/// The libraries of a line: one name with spaces, or several names if that file is missing.
std::vector<std::string> libraries(const std::string& line, Beside& beside) {
    const std::string whole = path_of(line);
    if (whole.empty()) return {};
    const Beside::Answer* const answer = beside.ask(whole);
    std::vector<std::string> parts;
    if (answer && !answer->error.empty()) {
        bool is_any_there = false;
        Words words(line);
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            parts.push_back(path_of(word));
            const Beside::Answer* const own = beside.ask(parts.back());
            is_any_there |= own && own->error.empty();
        }
        if (is_any_there && parts.size() > 1) return parts;
    }
    return {whole};
}

}  // namespace

MtlMaterials read_mtl(const std::vector<std::string>& lines, Beside& beside, std::vector<std::string>& warnings) {
    std::vector<std::string> names;
    std::set<std::string> known;
    for (const std::string& line : lines) {
        for (std::string& name : libraries(line, beside)) {
            if (known.insert(name).second) names.push_back(std::move(name));
        }
    }
    MtlMaterials materials;
    if (beside.is_waiting()) return materials;
    for (const std::string& name : names) {
        const Beside::Answer& answer = *beside.ask(name);
        std::string_view read;
        try {
            if (!answer.error.empty()) refuse({answer.error});
            read = text_of(answer.bytes);
        } catch (const std::invalid_argument& error) {
            warnings.push_back(joined({"materials were left out: ", error.what()}));
            continue;
        }
        Statements of;
        std::optional<std::string> material;
        const auto end_material = [&] {
            if (material) materials.insert_or_assign(*material, material_of(*material, of, name, warnings));
            of.clear();
        };
        for (Lines text(read); text.next();) {
            Words words(text.line());
            const std::string_view word = words.next();
            if (is_word(word, "newmtl")) {
                end_material();
                material = utf8(trimmed(words.rest()));
            } else if (!word.empty() && word[0] != '#') {
                of.insert_or_assign(lower(word), std::string(trimmed(words.rest())));
            }
        }
        end_material();
    }
    return materials;
}

}  // namespace bob::files
