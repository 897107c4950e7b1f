#include "files/gltf_surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "files/text.h"

namespace bob::files {
namespace {

constexpr double max_number = 1e9;  // of the transforms of textures

constexpr std::string_view spec_gloss = "KHR_materials_pbrSpecularGlossiness", strength = "KHR_materials_emissive_strength";
constexpr std::string_view clearcoat = "KHR_materials_clearcoat", transmission = "KHR_materials_transmission";
constexpr std::string_view ior = "KHR_materials_ior", volume = "KHR_materials_volume";

Wrap wrap_of(JsonValue number) {
    const double value = number.number().value_or(0);
    return value == 33071 ? Wrap::clamp : value == 33648 ? Wrap::mirror : Wrap::repeat;
}

/// Replaces a diffuse colour by a base colour and metallic, with Khronos' published converter of KHR_materials_pbrSpecularGlossiness.
void convert(const double (&specular)[3], Material& shading) {
    constexpr double dielectric = 0.04, small = 1e-6;
    const auto brightness = [](const double (&rgb)[3]) { return std::sqrt(0.299 * rgb[0] * rgb[0] + 0.587 * rgb[1] * rgb[1] + 0.114 * rgb[2] * rgb[2]); };
    const double rest = (1 - std::ranges::max(specular)) / (1 - dielectric), shine = brightness(specular);
    const double half = (brightness(shading.color) * rest + shine - 2 * dielectric) / 2;
    const double root = std::sqrt(std::max(half * half - dielectric * (dielectric - shine), 0.0));
    const double metallic = shine < dielectric ? 0 : std::clamp((root - half) / dielectric, 0.0, 1.0);
    for (std::size_t k = 0; k < 3; ++k) {
        const double of_diffuse = shading.color[k] * rest / std::max(1 - metallic, small);
        const double of_specular = (specular[k] - dielectric * (1 - metallic)) / std::max(metallic, small);
        shading.color[k] = std::clamp(of_diffuse + metallic * metallic * (of_specular - of_diffuse), 0.0, 1.0);
    }
    shading.metallic = metallic;
}

}  // namespace

/// Names an invalid member among those that are not shown.
void GltfSurfaces::check(bool is_valid, std::string_view name) {
    if (!is_valid) not_shown_.add(joined({"invalid ", name}));
}

/// A member of a value, missing if it is no object.
JsonValue GltfSurfaces::object(JsonValue of, std::string_view name) {
    const JsonValue value = of[name];
    check(!value || value.is_object(), name);
    return value.is_object() ? value : JsonValue();
}

/// A number clamped to low..high; `otherwise` if there is none.
double GltfSurfaces::clamped(JsonValue of, std::string_view name, double otherwise, double low, double high) {
    const JsonValue value = of[name];
    const double number = value.number().value_or(nan);
    check(!value || std::isfinite(number), name);
    return std::isfinite(number) ? std::clamp(number, low, high) : otherwise;
}

/// Sets the numbers that a list has, each clamped to low..high.
void GltfSurfaces::set(std::span<double> to, JsonValue of, std::string_view name, double low, double high) {
    const JsonValue value = of[name];
    const std::vector<JsonValue> items = value.items();
    bool is_valid = !value || items.size() == to.size();
    for (std::size_t i = 0; i < std::min(to.size(), items.size()); ++i) {
        const double number = items[i].number().value_or(nan);
        is_valid = is_valid && std::isfinite(number);
        if (std::isfinite(number)) to[i] = std::clamp(number, low, high);
    }
    check(is_valid, name);
}

/// Scaled, turned, then shifted. It turns as Khronos' sample viewer and three.js do, clockwise in the extension's own matrices.
UvSet GltfSurfaces::uv_set(JsonValue info) {
    UvSet result;
    const JsonValue transform = object(object(info, "extensions"), "KHR_texture_transform");
    const double chosen = clamped(transform["texCoord"] ? transform : info, "texCoord", 0, -1, 1001);
    result.texcoord = chosen >= 0 && chosen <= 1000 && chosen == std::floor(chosen) ? static_cast<int>(chosen) : 0;
    if (!transform.is_object()) return result;
    double shift[2] = {0, 0}, scale[2] = {1, 1};
    set(shift, transform, "offset", -max_number, max_number);
    set(scale, transform, "scale", -max_number, max_number);
    const double angle = clamped(transform, "rotation", 0, -max_number, max_number), cosine = std::cos(angle), sine = std::sin(angle);
    result.map = {cosine * scale[0], sine * scale[1], shift[0], -sine * scale[0], cosine * scale[1], shift[1]};
    return result;
}

int GltfSurfaces::number(JsonValue material, const std::function<bool(int)>& has) {
    const JsonValue found = data_.item("materials", material);
    check(!material || found.is_object(), "materials");
    if (!found.is_object()) return -1;
    const JsonValue physical = found["pbrMetallicRoughness"], glossy = found["extensions"][spec_gloss];
    std::vector<bool> sets;
    for (const JsonValue info : {physical["baseColorTexture"], physical["metallicRoughnessTexture"], glossy["diffuseTexture"]}) {
        sets.push_back(info["index"] && has(uv_set(info).texcoord));
    }
    const auto [at, is_new] = numbers_.try_emplace({*material.number(), std::move(sets)}, 0);
    if (is_new) at->second = made(found, has);
    return at->second;
}

int GltfSurfaces::made(JsonValue material, const std::function<bool(int)>& has) {
    Surface surface;
    std::vector<UvSet> sets;
    if (const auto name = material["name"].text()) surface.name = *name;
    const double alpha = shade(material, surface, sets, has);
    const auto mode = material["alphaMode"].text();
    check(!material["alphaMode"] || mode == "OPAQUE" || mode == "MASK" || mode == "BLEND", "alphaMode");
    if (mode == "BLEND") {
        surface.opacity = Opacity::translucent;
    } else if (mode == "MASK") {
        // Instead of multiplying every alpha by the factor's, divide the cutoff by it.
        const double cutoff = clamped(material, "alphaCutoff", 0.5, 0, max_number);
        if (alpha > 0 || cutoff > 0) {
            surface.opacity = Opacity::cutout;
            surface.alpha_cutoff = alpha > 0 ? cutoff / alpha : std::numeric_limits<double>::infinity();
        }
    }
    contents_.surfaces.push_back(std::move(surface));
    uv_sets_.push_back(std::move(sets));
    return static_cast<int>(contents_.surfaces.size()) - 1;
}

/// Returns the alpha of the factor.
double GltfSurfaces::shade(JsonValue material, Surface& surface, std::vector<UvSet>& sets, const std::function<bool(int)>& has) {
    const JsonValue extensions = object(material, "extensions"), glossy = object(extensions, spec_gloss);
    const JsonValue physical = object(material, "pbrMetallicRoughness");
    Material& shading = surface.material;
    double factor[4] = {1, 1, 1, 1};
    set(factor, glossy ? glossy : physical, glossy ? "diffuseFactor" : "baseColorFactor");
    std::copy_n(factor, 3, shading.color);
    if (glossy) {
        shading.metallic = 0;
        shading.roughness = 1 - clamped(glossy, "glossinessFactor", 1);
        const JsonValue map = object(glossy, "diffuseTexture"), shine = object(glossy, "specularGlossinessTexture");
        surface.color = layer(map, sets, has);
        // One factor says little where colours are in pictures.
        if (map || shine) {
            not_shown_.add("specular colours");
        } else {
            double specular[3] = {1, 1, 1};
            set(specular, glossy, "specularFactor");
            convert(specular, shading);
        }
        if (shine) not_shown_.add("maps of glossiness");
    } else {
        shading.metallic = clamped(physical, "metallicFactor", 1);
        shading.roughness = clamped(physical, "roughnessFactor", 1);
        surface.color = layer(object(physical, "baseColorTexture"), sets, has);
        const JsonValue map = object(physical, "metallicRoughnessTexture");
        surface.metallic_roughness = layer(map, sets, has, true);
        if (map["index"] && surface.metallic_roughness.image < 0) shading.metallic = 0;  // the factors alone mean little
    }
    const double intensity = clamped(object(extensions, strength), "emissiveStrength", 1, 0, max_number);
    set(shading.emissive, material, "emissiveFactor");
    for (double& channel : shading.emissive) {
        channel *= intensity;
        if (channel > 1) not_shown_.add("KHR_materials_emissive_strength beyond white");
        channel = std::min(channel, 1.0);
    }
    if (const JsonValue map = object(material, "emissiveTexture"); map && shading.emits()) {  // whose light is not known without it
        not_shown_.add("emission maps");
        std::ranges::fill(shading.emissive, 0.0);
    }
    if (object(material, "normalTexture")) not_shown_.add("normal maps");
    if (object(material, "occlusionTexture")) not_shown_.add("occlusion maps");
    set_clearcoat(object(extensions, clearcoat), shading);
    const bool is_glass = set_glass(extensions, surface);
    for (const auto& [name, value] : extensions.members()) {
        const bool is_of_glass = name == transmission || (is_glass && (name == ior || name == volume));
        if (name != spec_gloss && name != strength && name != clearcoat && !is_of_glass) not_shown_.add(name);
    }
    return factor[3];
}

void GltfSurfaces::set_clearcoat(JsonValue coat, Material& shading) {
    shading.clearcoat = clamped(coat, "clearcoatFactor", 0);
    shading.clearcoat_roughness = clamped(coat, "clearcoatRoughnessFactor", 0);
    if (!(shading.clearcoat > 0)) return;
    const JsonValue map = object(coat, "clearcoatTexture"), roughness = object(coat, "clearcoatRoughnessTexture");
    if (map || roughness) not_shown_.add("clearcoat maps");
    if (object(coat, "clearcoatNormalTexture")) not_shown_.add("normal maps");
    if (map) shading.clearcoat = 0;  // whose places are unknown
}

/// Whether a material is glass, whose values it sets: the boundary of a volume, or a sheet.
bool GltfSurfaces::set_glass(JsonValue extensions, Surface& surface) {
    Material& shading = surface.material;
    const JsonValue glass = object(extensions, transmission);
    shading.transmission = clamped(glass, "transmissionFactor", 0);
    if (surface.metallic_roughness.image < 0) shading.transmission *= 1 - shading.metallic;  // maps lower the factor of metal
    if (const JsonValue map = object(glass, "transmissionTexture"); map && shading.transmission > 0) {  // whose glass has an unknown place
        not_shown_.add("transmission maps");
        shading.transmission = 0;
    }
    if (!(shading.transmission > 0)) return false;
    shading.ior = clamped(object(extensions, ior), "ior", 1.5, 1, max_ior);
    const JsonValue inside = object(extensions, volume);
    shading.is_thin = !(clamped(inside, "thicknessFactor", 0, 0, max_number) > 0);
    if (shading.is_thin) return true;
    set(shading.attenuation, inside, "attenuationColor");
    const double distance = clamped(inside, "attenuationDistance", 0, 0, std::numeric_limits<double>::max());
    if (distance > 0) shading.attenuation_distance = distance;
    return true;
}

Layer GltfSurfaces::layer(JsonValue info, std::vector<UvSet>& sets, const std::function<bool(int)>& has, bool has_mean) {
    Layer result;
    const UvSet wanted = uv_set(info);
    const bool is_placed = has(wanted.texcoord);
    if (info && !info["index"]) not_shown_.add("textures without an index");
    if (!info["index"]) return result;
    if (!is_placed) not_shown_.add("textures without TEXCOORD_" + std::to_string(wanted.texcoord));
    if (!is_placed && !has_mean) return result;
    result.image = image(info);
    if (result.image < 0) return result;
    const JsonValue sampler = data_.item("samplers", data_.item("textures", info["index"])["sampler"]);
    result.across = wrap_of(sampler["wrapS"]);
    result.down = wrap_of(sampler["wrapT"]);
    if (!is_placed) return result;
    const auto found = std::ranges::find(sets, wanted);
    result.uv = static_cast<int>(found - sets.begin());
    if (found == sets.end()) sets.push_back(wanted);
    return result;
}

/// The number in the contents of a texture's image; -1 if it was left out, with a warning the first time.
int GltfSurfaces::image(JsonValue info) {
    const JsonValue texture = data_.item("textures", info["index"]), extensions = texture["extensions"];
    JsonValue source = texture["source"];
    for (const std::string_view format : {"EXT_texture_webp", "EXT_texture_avif"}) {
        if (!source.number()) source = extensions[format]["source"];
    }
    const JsonValue image = data_.item("images", source);
    if (!image.is_object()) {
        if (!is_imageless_) {
            const std::vector<JsonValue::Member> kinds = extensions.members();
            leave_out(source.number() ? source.brief() : info["index"].brief(),
                      kinds.empty() ? "expected an image with a uri or a bufferView, got none"
                                    : "expected a picture in PNG, JPEG, WebP or AVIF, got " + std::string(kinds.front().name));
        }
        is_imageless_ = true;
        return -1;
    }
    const auto [at, is_new] = images_.try_emplace(*source.number(), -1);
    if (!is_new) return at->second;
    try {
        at->second = added(image, source.brief());
    } catch (const std::invalid_argument& error) {
        leave_out(source.brief(), error.what());
    }
    return at->second;
}

/// The number in the contents of an image, which is added to them.
int GltfSurfaces::added(JsonValue image, const std::string& label) {
    Image made{.name = {}, .label = label};
    if (const auto uri = image["uri"].text()) {
        if (auto data = data_of_uri(*uri)) {
            made.bytes = std::move(*data);
        } else {
            made.name = path_of_uri(*uri);
            made.label = {};
        }
    } else {
        const Bytes bytes = data_.view(image["bufferView"]);
        const auto [at, is_new] = embedded_.try_emplace({bytes.data(), bytes.size()}, static_cast<int>(contents_.images.size()));
        if (!is_new) return at->second;
        embedded_bytes_ += bytes.size();
        if (embedded_bytes_ > data_.size()) refuse({"expected pictures that do not overlap, got others"});
        made.bytes.assign(bytes.begin(), bytes.end());
    }
    contents_.images.push_back(std::move(made));
    return static_cast<int>(contents_.images.size()) - 1;
}

void GltfSurfaces::leave_out(const std::string& image, const std::string& why) {
    contents_.warnings.push_back("texture " + image + " was left out: " + why);
}

}  // namespace bob::files
