#include "files/read.h"

#include <cstdint>
#include <iterator>

#include "files/text.h"

namespace bob::files {
namespace {

struct Format {
    std::string_view ending;
    Reader reader;
};
constexpr Format formats[] = {{"glb", read_glb}, {"gltf", read_gltf}, {"obj", read_obj},
                              {"off", read_off}, {"ply", read_ply}, {"stl", read_stl}};

/// Writes JSON, with commas where they are due.
class Json {
public:
    [[nodiscard]] std::string text() && { return std::move(text_); }

    void open(char bracket) {
        separate();
        text_ += bracket;
        is_first_ = true;
    }
    void close(char bracket) {
        text_ += bracket;
        is_first_ = false;
    }
    void key(std::string_view name) {
        value(name);
        text_ += ':';
        is_first_ = true;
    }
    void value(std::int64_t number) {
        separate();
        text_ += std::to_string(number);
    }
    /// text: UTF-8. Its bytes from 0x80 on become escapes of their code points.
    void value(std::string_view text) {
        separate();
        text_ += '"';
        for (std::size_t at = 0; at < text.size();) {
            const auto first = static_cast<unsigned char>(text[at]);
            if (first >= 0x20 && first < 0x7f && first != '"' && first != '\\') {
                text_ += text[at++];
                continue;
            }
            const int length = first < 0xc0 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
            std::uint32_t code = length == 1 ? first : first & (0xffu >> (length + 1));
            for (int i = 1; i < length && at + static_cast<std::size_t>(i) < text.size(); ++i) {
                code = code << 6 | (static_cast<unsigned char>(text[at + static_cast<std::size_t>(i)]) & 0x3f);
            }
            at += static_cast<std::size_t>(length);
            if (code >= 0x10000) {
                escape(0xd800 + ((code - 0x10000) >> 10 & 0x3ff));
                escape(0xdc00 + ((code - 0x10000) & 0x3ff));
            } else {
                escape(code);
            }
        }
        text_ += '"';
    }

private:
    void separate() {
        if (!is_first_) text_ += ',';
        is_first_ = false;
    }
    void escape(std::uint32_t unit) {
        constexpr char digits[] = "0123456789abcdef";
        text_ += "\\u";
        for (int shift = 12; shift >= 0; shift -= 4) text_ += digits[unit >> shift & 15];
    }

    std::string text_;
    bool is_first_ = true;
};

void write(Json& json, const Layer& layer) {
    constexpr std::string_view wraps[] = {"repeat", "clamp", "mirror"};
    json.open('{');
    json.key("image"), json.value(layer.image);
    json.key("wrap"), json.open('[');
    for (const Wrap wrap : {layer.across, layer.down}) json.value(wraps[static_cast<std::size_t>(wrap)]);
    json.close(']');
    json.key("uv"), json.value(layer.uv);
    json.close('}');
}

void write(Json& json, const Surface& surface) {
    constexpr std::string_view opacities[] = {"opaque", "cutout", "translucent"};
    json.open('{');
    json.key("name"), json.value(surface.name);
    json.key("layers"), json.open('{');
    for (const auto& [name, layer] : {std::pair<std::string_view, const Layer*>{"color", &surface.color}, {"emission", &surface.emission},
                                      {"metallic_roughness", &surface.metallic_roughness}, {"mask", &surface.mask}}) {
        if (layer->image >= 0) json.key(name), write(json, *layer);
    }
    json.close('}');
    json.key("replaces_color"), json.value(surface.replaces_color);
    json.key("opacity"), json.value(opacities[static_cast<std::size_t>(surface.opacity)]);
    json.close('}');
}

}  // namespace

Reader reader_of_meshes(std::string_view ending) {
    for (const Format& format : formats) {
        if (format.ending == ending) return format.reader;
    }
    refuse({"format: expected one that this module reads, got ", ending});
}

Reader reader_of(std::string_view ending) { return ending == "3mf" ? read_3mf : reader_of_meshes(ending); }

std::string Reading::go_on() {
    if (!beside_.is_waiting()) contents_ = reader_(bytes_, beside_);
    return beside_.is_waiting() ? beside_.wanted() : std::string();
}

std::string description(const Contents& contents) {
    Json json;
    json.open('{');
    json.key("parts"), json.open('[');
    for (const Part& part : contents.parts) {
        json.open('{');
        json.key("runs"), json.open('[');
        for (const Run& run : part.runs) json.value(std::int64_t{run.label}), json.value(std::int64_t{run.count});
        json.close(']');
        json.key("surface"), json.value(part.surface);
        json.key("uv"), json.value(static_cast<std::int64_t>(part.uv.size()));
        json.close('}');
    }
    json.close(']');
    json.key("labels"), json.open('[');
    for (const Label& label : contents.labels) {
        json.open('{');
        json.key("name"), json.value(label.name);
        json.key("parent"), json.value(label.parent);
        json.close('}');
    }
    json.close(']');
    json.key("surfaces"), json.open('[');
    for (const Surface& surface : contents.surfaces) write(json, surface);
    json.close(']');
    json.key("images"), json.open('[');
    for (const Image& image : contents.images) {
        json.open('{');
        json.key("name"), json.value(image.name);
        json.key("label"), json.value(image.label.empty() ? image.name : image.label);
        json.close('}');
    }
    json.close(']');
    json.key("shapes"), json.open('[');
    for (const OtherShape& shape : contents.shapes) {
        json.open('{');
        json.key("kind"), json.value(std::holds_alternative<Beams>(shape.shape) ? "tube" : "implicit");
        json.key("name"), json.value(shape.name);
        json.close('}');
    }
    json.close(']');
    json.key("placements"), json.open('[');
    for (const Placement& placement : contents.placements) {
        json.open('[');
        json.value(static_cast<std::int64_t>(placement.shape)), json.value(std::int64_t{placement.label});
        json.close(']');
    }
    json.close(']');
    json.key("warnings"), json.open('[');
    for (const std::string& warning : contents.warnings) json.value(std::string_view(warning));
    json.close(']');
    json.key("unit"), json.value(contents.unit);
    json.close('}');
    return std::move(json).text();
}

Numbers<double> numbers(const Contents& contents) {
    Numbers<double> result;
    for (const Surface& surface : contents.surfaces) {
        const Material& m = surface.material;
        result.insert(result.end(), std::begin(m.color), std::end(m.color));
        result.insert(result.end(), {m.ambient, m.diffuse, m.specular, m.shininess, m.metallic, m.roughness});
        result.insert(result.end(), std::begin(m.emissive), std::end(m.emissive));
        result.insert(result.end(), {m.clearcoat, m.clearcoat_roughness, m.transmission, m.ior});
        result.insert(result.end(), std::begin(m.attenuation), std::end(m.attenuation));
        result.insert(result.end(), {m.attenuation_distance, m.is_thin ? 1. : 0., surface.alpha_cutoff});
    }
    for (const OtherShape& shape : contents.shapes) result.insert(result.end(), shape.color.begin(), shape.color.end());
    for (const Placement& placement : contents.placements) result.insert(result.end(), placement.place.begin(), placement.place.end());
    return result;
}

Numbers<double>& field(Part& part, std::size_t number) {
    constexpr Numbers<double> Part::*fields[] = {&Part::vertices, &Part::normals, &Part::colors, &Part::face_colors, &Part::alphas};
    return number < std::size(fields) ? part.*fields[number] : part.uv.at(number - std::size(fields));
}

}  // namespace bob::files
