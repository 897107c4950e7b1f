#include "files/gltf_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "base/interruption.h"
#include "files/meshopt.h"

namespace bob::files {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF's numbers are copied as they are");

constexpr std::string_view checked_lists[] = {"buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes"};
constexpr std::string_view other_lists[] = {"materials", "textures", "images", "samplers", "skins"};
constexpr std::string_view compressions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
constexpr std::uint64_t max_unpacked = 256 << 20, max_ratio = 100;  // of compressed data: the larger of a size and a ratio
constexpr std::int64_t max_bytes = std::int64_t{1} << 32, max_count = std::int64_t{1} << 53;

struct Type {
    std::string_view name;
    int width;
};
constexpr Type types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};

/// Bytes of a component; 0 of an unknown type.
std::size_t size_of(int component) {
    switch (component) {
        case 5120:
        case 5121: return 1;
        case 5122:
        case 5123: return 2;
        case 5125:
        case 5126: return 4;
        default: return 0;
    }
}

template <class T>
double value_at(const std::uint8_t* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(value);
}

double value_at(const std::uint8_t* from, int component) {
    switch (component) {
        case 5120: return value_at<std::int8_t>(from);
        case 5121: return value_at<std::uint8_t>(from);
        case 5122: return value_at<std::int16_t>(from);
        case 5123: return value_at<std::uint16_t>(from);
        case 5125: return value_at<std::uint32_t>(from);
        default: return value_at<float>(from);
    }
}

/// The largest value of a type of integers; 1 of floats.
double largest(int component) {
    const bool is_signed = component == 5120 || component == 5122;
    return component == 5126 ? 1 : std::ldexp(1.0, static_cast<int>(8 * size_of(component)) - is_signed) - 1;
}

std::size_t as_size(std::int64_t value) { return static_cast<std::size_t>(value); }

/// Whether a buffer's file, which need not exist, is another form of data that are stored compressed.
bool is_fallback(JsonValue buffer) {
    return std::ranges::any_of(compressions, [&](std::string_view name) { return buffer["extensions"][name]["fallback"].truth() == true; });
}

}  // namespace

std::int64_t integer(std::string_view name, JsonValue value, std::int64_t low, std::int64_t high, std::optional<std::int64_t> otherwise) {
    if (!value && otherwise) return *otherwise;
    const std::optional<double> number = value.number();
    if (!number || *number != std::floor(*number) || std::isinf(*number)) {
        refuse({name, ": expected an integer, got ", value.brief()});
    }
    if (!(*number >= static_cast<double>(low) && *number <= static_cast<double>(high))) {
        refuse({name, ": expected an integer in ", std::to_string(low), "..", std::to_string(high), ", got ", value.brief()});
    }
    return static_cast<std::int64_t>(*number);
}

void normalize(Numbers<double>& values, int component) {
    if (const double unit = largest(component); unit != 1) {
        for (double& value : values) value = std::max(value / unit, -1.0);
    }
}

std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    constexpr auto values = [digits] {
        std::array<std::int8_t, 256> result{};
        result.fill(-1);
        for (std::size_t i = 0; i < digits.size(); ++i) result[static_cast<unsigned char>(digits[i])] = static_cast<std::int8_t>(i);
        return result;
    }();
    std::vector<std::uint8_t> result;
    result.reserve(text.size() / 4 * 3 + 3);
    std::uint32_t bits = 0;
    std::size_t count = 0, padding = 0;
    for (const char c : text) {
        if (is_space(c)) continue;
        if (c == '=') {
            ++padding;
            continue;
        }
        const int value = values[static_cast<unsigned char>(c)];
        if (value < 0 || padding) return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        if (++count % 4 == 0) {
            for (const int shift : {16, 8, 0}) result.push_back(static_cast<std::uint8_t>(bits >> shift));
        }
    }
    if (count % 4 == 1 || padding > 2 || (padding && (count + padding) % 4)) return std::nullopt;
    if (count % 4 == 2) result.push_back(static_cast<std::uint8_t>(bits >> 4));
    if (count % 4 == 3) {
        result.push_back(static_cast<std::uint8_t>(bits >> 10));
        result.push_back(static_cast<std::uint8_t>(bits >> 2));
    }
    return result;
}

std::string path_of_uri(std::string_view uri) { return utf8(unescaped(uri)); }

std::optional<std::vector<std::uint8_t>> data_of_uri(std::string_view uri) {
    constexpr std::string_view scheme = "data:", encoding = ";base64";
    if (!is_word(uri.substr(0, scheme.size()), scheme)) return std::nullopt;
    const std::size_t comma = std::min(uri.find(','), uri.size());
    const std::string content = unescaped(uri.substr(std::min(comma + 1, uri.size())));
    const bool is_base64 = comma >= encoding.size() && is_word(uri.substr(comma - encoding.size(), encoding.size()), encoding);
    if (!is_base64) return std::vector<std::uint8_t>(content.begin(), content.end());
    auto data = from_base64(content);
    if (!data) refuse({"expected data in base64, got something else"});
    return data;
}

GltfData::GltfData(Bytes text, std::optional<Bytes> chunk, Beside& beside) : document_(text) {
    const JsonValue root = document_.root();
    if (!root.is_object()) refuse({"expected a glTF, which is an object, got ", root.brief()});
    const JsonValue version = root["asset"]["version"];
    if (!version.text() || !version.text()->starts_with("2.")) {
        refuse({"asset: expected version 2.0, got ", (version.text() ? std::string(version.text()->substr(0, 40)) : version.brief()), "; export it as glTF 2.0"});
    }
    // Before anything is made for each of them.
    check_instances("nodes", root["nodes"].size());
    for (const std::string_view name : checked_lists) {
        const JsonValue list = root[name];
        std::vector<JsonValue> items = list.items();
        const bool are_objects = std::ranges::all_of(items, [](const JsonValue& item) { return item.is_object(); });
        if (list && (!list.is_list() || !are_objects)) refuse({name, ": expected a list of objects, got another"});
        lists_.emplace_back(name, std::move(items));
    }
    for (const std::string_view name : other_lists) lists_.emplace_back(name, root[name].items());

    const std::vector<JsonValue>& buffers = list("buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const JsonValue uri = buffers[i]["uri"];
        if (!uri || is_fallback(buffers[i])) {  // one without data replaces a compressed one
            buffers_.push_back(!uri && chunk ? *chunk : Bytes());
        } else if (!uri.text()) {
            refuse({"buffers[", std::to_string(i), "]: expected a uri, got ", uri.brief()});
        } else if (auto data = at_place("buffers", [&] { return data_of_uri(*uri.text()); })) {
            buffers_.push_back(decoded_.emplace_back(std::move(*data)));
        } else {
            const Beside::Answer* answer = beside.ask(path_of_uri(*uri.text()));
            if (answer && !answer->error.empty()) refuse({answer->error});
            buffers_.push_back(answer ? Bytes(answer->bytes) : Bytes());
        }
    }
    if (!beside.is_waiting()) check_views();
}

const std::vector<JsonValue>& GltfData::list(std::string_view name) const {
    static const std::vector<JsonValue> none;
    for (const auto& [known, items] : lists_) {
        if (known == name) return items;
    }
    return none;
}

JsonValue GltfData::item(std::string_view name, JsonValue number) const {
    const std::vector<JsonValue>& items = list(name);
    const std::optional<double> value = number.number();
    if (!value || !(*value >= 0 && *value < static_cast<double>(items.size())) || *value != std::floor(*value)) return {};
    return items[static_cast<std::size_t>(*value)];
}

void GltfData::check_views() {
    const std::vector<JsonValue>&views = list("bufferViews"), &accessors = list("accessors");
    budget_ = Budget(std::max<std::uint64_t>(max_unpacked, max_ratio * size()));
    for (std::size_t i = 0; i < views.size(); ++i) {
        views_.push_back(at_item("bufferViews", i, [&] {
            for (const std::string_view name : compressions) {
                if (const JsonValue compressed = views[i]["extensions"][name]) return at_place(name, [&] { return decompressed(compressed); });
            }
            return plain(views[i]);
        }));
    }
    accessors_.reserve(accessors.size());
    for (std::size_t i = 0; i < accessors.size(); ++i) accessors_.push_back(at_item("accessors", i, [&] { return checked(accessors[i]); }));
}

GltfData::View GltfData::plain(JsonValue view) const {
    const Bytes buffer = buffers_[as_size(integer("buffer", view["buffer"], 0, static_cast<std::int64_t>(buffers_.size()) - 1))];
    const std::size_t length = as_size(integer("byteLength", view["byteLength"], 1, max_bytes));
    const std::size_t offset = as_size(integer("byteOffset", view["byteOffset"], 0, max_bytes, 0));
    const std::size_t stride = as_size(integer("byteStride", view["byteStride"], 1, max_bytes, 0));
    if (length > buffer.size() || offset > buffer.size() - length) {
        refuse({"expected buffers that hold what the bufferViews say, got one that is ", buffer.empty() ? "missing" : "shorter"});
    }
    return {buffer.subspan(offset, length), stride};
}

GltfData::View GltfData::decompressed(JsonValue compressed) {
    const std::size_t stride = as_size(integer("byteStride", compressed["byteStride"], 1, 256));
    const std::size_t count = as_size(integer("count", compressed["count"], 0, max_bytes));
    budget_.take(std::uint64_t{count} * stride);
    const auto text = [&](std::string_view name, std::string_view otherwise) { return compressed[name].text().value_or(otherwise); };
    return {decoded_.emplace_back(meshopt_decoded(plain(compressed).bytes, count, stride, text("mode", ""), text("filter", "NONE"))), stride};
}

/// The bytes between the starts of elements in a view.
std::size_t GltfData::stride(std::size_t view, std::size_t element) const { return views_[view].stride ? views_[view].stride : element; }

Accessor GltfData::checked(JsonValue json) const {
    const auto last_view = static_cast<std::int64_t>(views_.size()) - 1;
    const JsonValue type = json["type"], component = json["componentType"];
    Accessor result;
    result.width = 0;
    for (const Type& known : types) {
        if (type.text() == known.name) result.width = known.width;
    }
    const double number = component.number().value_or(0);
    result.component = number >= 5120 && number <= 5126 ? static_cast<int>(number) : 0;
    const std::size_t size = size_of(result.component);
    if (!result.width || !size || result.component != number) {
        refuse({"expected a type such as VEC3 and a componentType such as 5126, got ", type.brief(), " and ", component.brief()});
    }
    result.count = as_size(std::min<std::int64_t>(integer("count", json["count"], 0, max_count), std::numeric_limits<std::ptrdiff_t>::max()));
    result.offset = as_size(integer("byteOffset", json["byteOffset"], 0, max_bytes, 0));
    result.normalized = json["normalized"].truth().value_or(false);
    const std::size_t element = size * static_cast<std::size_t>(result.width);
    const auto check_end = [&](std::size_t view, double offset, double count, double element, double stride) {
        const double end = offset + (count - 1) * stride + element, length = static_cast<double>(views_[view].bytes.size());
        if (count > 0 && end > length) {
            refuse({"expected ", grouped(static_cast<std::uint64_t>(end)), " bytes in its view, got ", grouped(views_[view].bytes.size())});
        }
    };
    const auto count = static_cast<double>(result.count), width = static_cast<double>(element);
    if (const JsonValue view = json["bufferView"]) {
        result.view = as_size(integer("bufferView", view, 0, last_view));
        check_end(*result.view, static_cast<double>(result.offset), count, width, static_cast<double>(stride(*result.view, element)));
    }
    if (const JsonValue sparse = json["sparse"]) {
        at_place("sparse", [&] {
            const double some = static_cast<double>(integer("count", sparse["count"], 0, static_cast<std::int64_t>(result.count)));
            const JsonValue indices = sparse["indices"], values = sparse["values"];
            const auto kind = integer("componentType", indices["componentType"], 5121, 5125);
            if (kind == 5122 || kind == 5124) refuse({"componentType: expected unsigned integers, got ", std::to_string(kind)});
            const auto check = [&](JsonValue place, double bytes) {
                const std::size_t view = as_size(integer("bufferView", place["bufferView"], 0, last_view));
                check_end(view, static_cast<double>(integer("byteOffset", place["byteOffset"], 0, max_bytes, 0)), some, bytes, bytes);
            };
            check(indices, static_cast<double>(size_of(static_cast<int>(kind))));
            check(values, width);
        });
        result.sparse = sparse;
    }
    return result;
}

const Accessor& GltfData::accessor(JsonValue number) const {
    return accessors_[as_size(integer("accessor", number, 0, static_cast<std::int64_t>(accessors_.size()) - 1))];
}

DracoMesh GltfData::draco_mesh(JsonValue compressed, std::size_t max_triangles) {
    const std::size_t number = as_size(integer("bufferView", compressed["bufferView"], 0, static_cast<std::int64_t>(views_.size()) - 1));
    return draco_decoded(views_[number].bytes, max_triangles, budget_);
}

std::size_t GltfData::size() const {
    std::set<const std::uint8_t*> seen;
    std::size_t result = 0;
    for (const Bytes buffer : buffers_) {
        if (seen.insert(buffer.data()).second) result += buffer.size();
    }
    return result;
}

Bytes GltfData::view(JsonValue number) const {
    if (!item("bufferViews", number)) refuse({"expected an image with a uri or a bufferView, got none"});
    return views_[static_cast<std::size_t>(*number.number())].bytes;
}

/// Copies the numbers of a block to the given rows of its width, or to all rows.
void GltfData::copy(const Block& block, std::span<const std::size_t> rows, Numbers<double>& to) const {
    const Bytes bytes = views_[block.view].bytes;
    const std::size_t size = size_of(block.component), width = static_cast<std::size_t>(block.width);
    for (std::size_t i = 0; i < block.count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        const std::uint8_t* from = bytes.data() + block.offset + i * block.stride;
        double* const row = to.data() + width * (rows.empty() ? i : rows[i]);
        if (block.component == 5126) {
            for (std::size_t k = 0; k < width; ++k) row[k] = value_at<float>(from + k * size);
        } else {
            for (std::size_t k = 0; k < width; ++k) row[k] = value_at(from + k * size, block.component);
        }
    }
}

Numbers<double> GltfData::stored_numbers(const Accessor& accessor, int width) const {
    const std::size_t across = static_cast<std::size_t>(width), element = size_of(accessor.component) * static_cast<std::size_t>(accessor.width);
    Numbers<double> result(across * accessor.count);
    if (!accessor.view) std::ranges::fill(result, 0.0);
    if (accessor.view && accessor.count) {
        copy({*accessor.view, accessor.offset, stride(*accessor.view, element), accessor.count, accessor.component, width}, {}, result);
    }
    if (!accessor.sparse) return result;
    const auto number = [](JsonValue of, std::string_view name) { return as_size(integer(name, of[name], 0, max_bytes, 0)); };
    const JsonValue indices = accessor.sparse["indices"], values = accessor.sparse["values"];
    const std::size_t count = number(accessor.sparse, "count");
    if (!count) return result;
    const int kind = static_cast<int>(number(indices, "componentType"));
    Numbers<double> places(count);
    copy({number(indices, "bufferView"), number(indices, "byteOffset"), size_of(kind), count, kind, 1}, {}, places);
    std::vector<std::size_t> rows;
    for (const double place : places) {
        rows.push_back(static_cast<std::size_t>(place));
        if (rows.back() >= accessor.count) refuse({"sparse: expected indices below ", grouped(accessor.count), ", got ", grouped(rows.back())});
    }
    copy({number(values, "bufferView"), number(values, "byteOffset"), element, count, accessor.component, width}, rows, result);
    return result;
}

Numbers<double> GltfData::numbers(const Accessor& accessor, int width) const {
    Numbers<double> result = stored_numbers(accessor, width);
    if (accessor.normalized) normalize(result, accessor.component);
    return result;
}

Numbers<std::int32_t> GltfData::indices(const Accessor& accessor) const {
    const Numbers<double> values = stored_numbers(accessor, 1);
    Numbers<std::int32_t> result(values.size());
    std::ranges::transform(values, result.begin(), [](double value) { return index_of(value); });
    return result;
}

}  // namespace bob::files
