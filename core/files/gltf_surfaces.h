/// The materials of a glTF.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "files/gltf_data.h"
#include "files/not_shown.h"

namespace bob::files {

/// One set of texture coordinates: an attribute of the vertices, moved.
struct UvSet {
    int texcoord = 0;
    std::array<double, 6> map = {1, 0, 0, 0, 1, 0};  // rows of an affine map

    bool operator==(const UvSet&) const = default;
};

/// Surfaces by the numbers of their materials.
class GltfSurfaces {
public:
    /// contents: takes surfaces, images and warnings.
    GltfSurfaces(const GltfData& data, Contents& contents, NotShown& not_shown) : data_(data), contents_(contents), not_shown_(not_shown) {}

    /// The number of a primitive's surface in the contents; -1 without a valid material.
    ///
    /// has: whether the primitive has a set of texture coordinates, TEXCOORD_n. Images on others are not shown.
    int number(JsonValue material, const std::function<bool(int)>& has);

    /// The coordinates on the images of a surface, in the order of Layer::uv.
    [[nodiscard]] const std::vector<UvSet>& uv_sets(int surface) const { return uv_sets_[static_cast<std::size_t>(surface)]; }

private:
    void check(bool is_valid, std::string_view name);
    JsonValue object(JsonValue of, std::string_view name);
    double clamped(JsonValue of, std::string_view name, double otherwise, double low = 0, double high = 1);
    void set(std::span<double> to, JsonValue of, std::string_view name, double low = 0, double high = 1);
    UvSet uv_set(JsonValue info);
    int made(JsonValue material, const std::function<bool(int)>& has);
    double shade(JsonValue material, Surface& surface, std::vector<UvSet>& sets, const std::function<bool(int)>& has);
    void set_clearcoat(JsonValue coat, Material& shading);
    bool set_glass(JsonValue extensions, Surface& surface);
    /// has_mean: whether the image is needed even without texture coordinates.
    Layer layer(JsonValue info, std::vector<UvSet>& sets, const std::function<bool(int)>& has, bool has_mean = false);
    int image(JsonValue info);
    int added(JsonValue image, const std::string& label);
    void leave_out(const std::string& image, const std::string& why);

    const GltfData& data_;
    Contents& contents_;
    NotShown& not_shown_;
    std::map<std::pair<double, std::vector<bool>>, int> numbers_;  // by numbers of materials, and their sets of coordinates
    std::vector<std::vector<UvSet>> uv_sets_;                      // by surface
    std::map<double, int> images_;  // by numbers of images; -1 if one was left out
    std::map<std::pair<const std::uint8_t*, std::size_t>, int> embedded_;  // by their places in buffers
    std::size_t embedded_bytes_ = 0;
    bool is_imageless_ = false;
};

}  // namespace bob::files
