/// The data of a glTF: its JSON, its buffers, and numbers out of them. Nothing in it is trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "files/binary.h"
#include "files/draco/mesh.h"
#include "files/json.h"
#include "files/part.h"
#include "files/text.h"

namespace bob::files {

/// As `at_place`, for an item of a list.
template <class F>
auto at_item(std::string_view list, std::size_t number, F f) -> decltype(f()) {
    return at_place(std::string(list) + "[" + std::to_string(number) + "]", f);
}

/// A whole number in low..high; `otherwise`, if there is one, where the value is missing.
[[nodiscard]] std::int64_t integer(std::string_view name, JsonValue value, std::int64_t low, std::int64_t high,
                                   std::optional<std::int64_t> otherwise = {});

/// Bytes in base64; nothing if the text is something else.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

/// The path of a URI, with "%20" decoded to a space.
[[nodiscard]] std::string path_of_uri(std::string_view uri);

/// The content of a "data:" URI; nothing of another URI. Throws std::invalid_argument if its base64 is invalid.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> data_of_uri(std::string_view uri);

/// An array of vectors; `width` numbers of each are used.
struct Accessor {
    std::size_t count = 0;
    int width = 1;        // numbers of each element
    int component = 5126;  // type of these, by the numbers of WebGL
    bool normalized = false;
    std::optional<std::size_t> view;
    std::size_t offset = 0;
    JsonValue sparse;

    [[nodiscard]] bool is_float() const { return component == 5126; }
};

/// Scales integers in place to -1..1 or 0..1.
void normalize(Numbers<double>& values, int component);

/// The document, whose lists, indices and sizes are checked when it is made.
class GltfData {
public:
    /// text: its JSON. chunk: the binary chunk of a GLB; empty for a .gltf. Asks for its buffers, and is incomplete if the host has
    /// to answer first.
    GltfData(Bytes text, std::optional<Bytes> chunk, Beside& beside);

    [[nodiscard]] JsonValue root() const { return document_.root(); }
    /// An item of a list of the root; a missing value if absent.
    [[nodiscard]] JsonValue item(std::string_view list, JsonValue number) const;
    /// The items of a list of the root.
    [[nodiscard]] const std::vector<JsonValue>& list(std::string_view name) const;

    [[nodiscard]] const Accessor& accessor(JsonValue number) const;

    /// An accessor's numbers, `width` of each element; normalized integers in 0..1 or -1..1. The caller counts them first.
    [[nodiscard]] Numbers<double> numbers(const Accessor& accessor, int width) const;
    /// An accessor's unsigned integers; those beyond 2^31 - 1 are -1.
    [[nodiscard]] Numbers<std::int32_t> indices(const Accessor& accessor) const;

    /// The bytes of an image's view. Throws std::invalid_argument if it has no view.
    [[nodiscard]] Bytes view(JsonValue number) const;

    /// A primitive's mesh by its extension KHR_draco_mesh_compression.
    ///
    /// max_triangles: more of them are refused.
    [[nodiscard]] DracoMesh draco_mesh(JsonValue compressed, std::size_t max_triangles);

    /// Bytes in all buffers, each counted once.
    [[nodiscard]] std::size_t size() const;

private:
    struct View {
        Bytes bytes;
        std::size_t stride;  // 0: elements lie next to each other
    };
    void check_views();
    View plain(JsonValue view) const;
    View decompressed(JsonValue compressed);
    Accessor checked(JsonValue accessor) const;
    /// Elements that lie in a view.
    struct Block {
        std::size_t view, offset, stride, count;
        int component, width;
    };
    void copy(const Block& block, std::span<const std::size_t> rows, Numbers<double>& to) const;
    [[nodiscard]] Numbers<double> stored_numbers(const Accessor& accessor, int width) const;
    [[nodiscard]] std::size_t stride(std::size_t view, std::size_t element) const;

    JsonDocument document_;
    std::vector<std::pair<std::string_view, std::vector<JsonValue>>> lists_;
    std::vector<Bytes> buffers_;
    std::deque<std::vector<std::uint8_t>> decoded_;  // of data: URIs, and of compressed views
    std::vector<View> views_;
    Budget budget_{0};  // of compressed data
    std::vector<Accessor> accessors_;
};

}  // namespace bob::files
