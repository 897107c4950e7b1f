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

/// A number clamped to low..high; `otherwise` if the value is no number.
double clamped(JsonValue value, double otherwise, double low = 0, double high = 1) {
    const std::optional<double> number = value.number();
    return number && std::isfinite(*number) ? std::clamp(*number, low, high) : otherwise;
}

double near(JsonValue value, double otherwise) {
    const std::optional<double> number = value.number();
    return number && std::fabs(*number) <= max_number ? *number : otherwise;
}

/// Linear RGB of a factor, which may have an alpha.
void set(double (&rgb)[3], JsonValue factor, double otherwise) {
    const std::vector<JsonValue> values = factor.items();
    for (std::size_t i = 0; i < 3; ++i) rgb[i] = clamped(i < values.size() ? values[i] : JsonValue(), otherwise);
}

std::array<double, 2> pair(JsonValue value, double otherwise) {
    const std::vector<JsonValue> values = value.items();
    if (values.size() != 2) return {otherwise, otherwise};
    return {near(values[0], otherwise), near(values[1], otherwise)};
}

JsonValue moved(JsonValue info) { return info["extensions"]["KHR_texture_transform"]; }

Wrap wrap_of(JsonValue number) {
    const double value = number.number().value_or(0);
    return value == 33071 ? Wrap::clamp : value == 33648 ? Wrap::mirror : Wrap::repeat;
}

/// Scaled, turned, then shifted. It turns as Khronos' sample viewer and three.js do, clockwise in the extension's own matrices.
UvSet uv_set(JsonValue info) {
    UvSet result;
    const JsonValue transform = moved(info);
    const JsonValue own = info["texCoord"], other = transform["texCoord"];
    const double chosen = (other.number() ? other : own).number().value_or(0);
    result.texcoord = chosen >= 0 && chosen <= 1000 && chosen == std::floor(chosen) ? static_cast<int>(chosen) : 0;
    if (!transform.is_object()) return result;
    const auto [u, v] = pair(transform["offset"], 0);
    const auto [wide, high] = pair(transform["scale"], 1);
    const double angle = near(transform["rotation"], 0), cosine = std::cos(angle), sine = std::sin(angle);
    result.map = {cosine * wide, sine * high, u, -sine * wide, cosine * high, v};
    return result;
}

}  // namespace


int GltfSurfaces::number(JsonValue material, const std::function<bool(int)>& has) {
    const JsonValue found = data_.item("materials", material);
    if (!found) return -1;
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
    shade(material, surface, sets, has);
    const JsonValue factor = material["pbrMetallicRoughness"]["baseColorFactor"], extension = material["extensions"][spec_gloss];
    const std::vector<JsonValue> factors = (extension.is_object() ? extension["diffuseFactor"] : factor).items();
    const auto mode = material["alphaMode"].text();
    if (mode == "BLEND") {
        surface.opacity = Opacity::translucent;
    } else if (mode == "MASK") {
        // Instead of multiplying every alpha by the factor's, divide the cutoff by it.
        const double cutoff = std::max(near(material["alphaCutoff"], 0.5), 0.0), alpha = factors.size() == 4 ? clamped(factors[3], 1) : 1;
        if (alpha > 0 || cutoff > 0) {
            surface.opacity = Opacity::cutout;
            surface.alpha_cutoff = alpha > 0 ? cutoff / alpha : std::numeric_limits<double>::infinity();
        }
    }
    contents_.surfaces.push_back(std::move(surface));
    uv_sets_.push_back(std::move(sets));
    return static_cast<int>(contents_.surfaces.size()) - 1;
}

void GltfSurfaces::shade(JsonValue material, Surface& surface, std::vector<UvSet>& sets, const std::function<bool(int)>& has) {
    const JsonValue extensions = material["extensions"], glossy = extensions[spec_gloss], physical = material["pbrMetallicRoughness"];
    Material& shading = surface.material;
    if (glossy.is_object()) {
        set(shading.color, glossy["diffuseFactor"], 1);
        shading.metallic = 0;
        shading.roughness = 1 - clamped(glossy["glossinessFactor"], 1);
        surface.color = layer(glossy["diffuseTexture"], sets, has);
        not_shown_.add("specular colours");
        if (glossy["specularGlossinessTexture"].is_object()) not_shown_.add("maps of glossiness");
    } else {
        set(shading.color, physical["baseColorFactor"], 1);
        shading.metallic = clamped(physical["metallicFactor"], 1);
        shading.roughness = clamped(physical["roughnessFactor"], 1);
        surface.color = layer(physical["baseColorTexture"], sets, has);
        const JsonValue map = physical["metallicRoughnessTexture"];
        if (map["index"]) surface.metallic_roughness = layer(map, sets, has, true);
        if (map["index"] && surface.metallic_roughness.image < 0) shading.metallic = 0;  // the factors alone mean little
    }
    const double intensity = clamped(extensions[strength]["emissiveStrength"], 1, 0, max_number);
    set(shading.emissive, material["emissiveFactor"], 0);
    for (double& channel : shading.emissive) {
        channel *= intensity;
        if (channel > 1) not_shown_.add("KHR_materials_emissive_strength beyond white");
        channel = std::min(channel, 1.0);
    }
    if (shading.emits() && material["emissiveTexture"].is_object()) {  // whose light is not known without it
        not_shown_.add("emission maps");
        std::ranges::fill(shading.emissive, 0.0);
    }
    if (material["normalTexture"].is_object()) not_shown_.add("normal maps");
    if (material["occlusionTexture"].is_object()) not_shown_.add("occlusion maps");
    set_clearcoat(extensions[clearcoat], shading);
    const bool is_glass = set_glass(extensions, surface);
    for (const auto& [name, value] : extensions.members()) {
        const bool is_of_glass = name == transmission || (is_glass && (name == ior || name == volume));
        if (name != spec_gloss && name != strength && name != clearcoat && !is_of_glass) not_shown_.add(name);
    }
}

void GltfSurfaces::set_clearcoat(JsonValue coat, Material& shading) {
    shading.clearcoat = clamped(coat["clearcoatFactor"], 0);
    shading.clearcoat_roughness = clamped(coat["clearcoatRoughnessFactor"], 0);
    if (!(shading.clearcoat > 0)) return;
    const bool has_map = coat["clearcoatTexture"].is_object();
    if (has_map || coat["clearcoatRoughnessTexture"].is_object()) not_shown_.add("clearcoat maps");
    if (coat["clearcoatNormalTexture"].is_object()) not_shown_.add("normal maps");
    if (has_map) shading.clearcoat = 0;  // whose places are unknown
}

/// Whether a material is glass, whose values it sets: the boundary of a volume, or a sheet.
bool GltfSurfaces::set_glass(JsonValue extensions, Surface& surface) {
    Material& shading = surface.material;
    const JsonValue glass = extensions[transmission];
    shading.transmission = clamped(glass["transmissionFactor"], 0);
    if (surface.metallic_roughness.image < 0) shading.transmission *= 1 - shading.metallic;  // maps lower the factor of metal
    if (shading.transmission > 0 && glass["transmissionTexture"].is_object()) {  // whose glass has an unknown place
        not_shown_.add("transmission maps");
        shading.transmission = 0;
    }
    if (!(shading.transmission > 0)) return false;
    shading.ior = clamped(extensions[ior]["ior"], 1.5, 1, max_ior);
    const JsonValue inside = extensions[volume];
    shading.is_thin = !(clamped(inside["thicknessFactor"], 0, 0, max_number) > 0);
    if (shading.is_thin) return true;
    set(shading.attenuation, inside["attenuationColor"], 1);
    const double distance = inside["attenuationDistance"].number().value_or(0);
    if (distance > 0) shading.attenuation_distance = distance;
    return true;
}

Layer GltfSurfaces::layer(JsonValue info, std::vector<UvSet>& sets, const std::function<bool(int)>& has, bool has_mean) {
    Layer result;
    const UvSet wanted = uv_set(info);
    const bool is_placed = has(wanted.texcoord);
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
