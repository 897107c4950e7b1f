#include "tracing/canonical.h"

#include <algorithm>
#include <numeric>

namespace bob {
namespace {

/// The shape in Python's notation for a tuple.
std::string text_of(std::span<const std::size_t> shape) {
    std::string text = "(";
    for (std::size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
    return text + (shape.size() == 1 ? ",)" : ")");
}

}  // namespace

void ShapeDigest::add(const ShapeTensor& tensor) {
    hash_.update(std::string(tensor.name) + " " + std::string(tensor.dtype) + " " + text_of(tensor.shape));
    hash_.update(tensor.bytes);
}

void ShapeDigest::add(std::string_view name, std::string_view text) { hash_.update(name).update(" ").update(text); }

Digest instance_digest(const Digest& shape, const AffineMap& transform, const Material& m) {
    constexpr double last_row[4] = {0, 0, 0, 1};
    const double material[] = {m.color[0], m.color[1], m.color[2], m.ambient, m.diffuse, m.specular, m.shininess};
    const double physical[] = {m.metallic, m.roughness, m.emissive[0], m.emissive[1], m.emissive[2]};
    Sha256 hash;
    hash.update(std::as_bytes(std::span(shape)));
    for (const auto& row : transform.row) hash.update(std::as_bytes(std::span(row)));
    hash.update(std::as_bytes(std::span(last_row))).update(std::as_bytes(std::span(material)));
    if (m.is_physical() || m.emits()) hash.update(std::as_bytes(std::span(physical)));  // else the established order stays
    const double coat[] = {m.clearcoat, m.clearcoat_roughness};
    if (m.clearcoat > 0) hash.update("clearcoat").update(std::as_bytes(std::span(coat)));
    const double glass[] = {m.transmission, m.ior, m.attenuation[0], m.attenuation[1], m.attenuation[2], m.attenuation_distance};
    if (m.transmission > 0) hash.update(std::as_bytes(std::span(glass)));
    if (m.transmission > 0 && m.is_thin) hash.update("thin");
    return hash.digest();
}

std::vector<std::uint32_t> canonical_order(std::span<const Digest> digests) {
    std::vector<std::uint32_t> order(digests.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return digests[a] < digests[b]; });
    return order;
}

}  // namespace bob
