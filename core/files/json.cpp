#include "files/json.h"

#include <new>
#include <stdexcept>

#include "files/text.h"

// The library is part of this file: what nothing here uses is left out of the binaries.
#define yyjson_api static
#if defined(__wasm__)
#define yyjson_inline inline  // which is half the size
#endif
#define YYJSON_DISABLE_WRITER 1
#define YYJSON_DISABLE_INCR_READER 1
#define YYJSON_DISABLE_UTILS 1
#define YYJSON_DISABLE_NON_STANDARD 1
#define YYJSON_DISABLE_FAST_FP_CONV 1
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wextra"
#endif
#include "../../vendor/yyjson/yyjson.c"
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace bob::files {
namespace {

constexpr std::size_t longest_shown = 40, max_members = 256;

yyjson_val* value_of(const void* value) { return static_cast<yyjson_val*>(const_cast<void*>(value)); }

/// The place of a byte in a text.
std::string place_of(std::string_view text, std::size_t at) {
    std::size_t line = 1, column = 1;
    for (std::size_t i = 0; i < at && i < text.size(); ++i) {
        if (text[i] == '\n') {
            ++line;
            column = 1;
        } else {
            ++column;
        }
    }
    return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

}  // namespace

JsonDocument::JsonDocument(Bytes bytes) {
    std::string_view text = text_of(bytes);
    while (!text.empty() && text.back() == 0) text.remove_suffix(1);  // some writers of GLB pad with zeros
    if (text.empty()) throw std::invalid_argument("expected JSON, got nothing");
    yyjson_read_err error{};
    // The text is only read: it is not changed without YYJSON_READ_INSITU.
    yyjson_doc* const read = yyjson_read_opts(const_cast<char*>(text.data()), text.size(), YYJSON_READ_NUMBER_AS_RAW, nullptr, &error);
    if (!read && error.code == YYJSON_READ_ERROR_MEMORY_ALLOCATION) throw std::bad_alloc();
    if (!read) throw std::invalid_argument("expected JSON, got something else at " + place_of(text, error.pos) + " (" + error.msg + ")");
    document_ = std::shared_ptr<const void>(read, [read](const void*) { yyjson_doc_free(read); });
}

JsonValue JsonDocument::root() const {
    return JsonValue(yyjson_doc_get_root(static_cast<yyjson_doc*>(const_cast<void*>(document_.get()))));
}

bool JsonValue::is_object() const { return yyjson_is_obj(value_of(value_)); }
bool JsonValue::is_list() const { return yyjson_is_arr(value_of(value_)); }

JsonValue JsonValue::operator[](std::string_view name) const {
    // They are searched one after the other, for many values that can share an object.
    if (is_object() && size() > max_members) {
        throw std::invalid_argument("expected objects of at most " + grouped(max_members) + " members, got " + grouped(size()));
    }
    return JsonValue(yyjson_obj_getn(value_of(value_), name.data(), name.size()));
}

std::vector<JsonValue> JsonValue::items() const {
    std::vector<JsonValue> result;
    if (!is_list()) return result;
    result.reserve(size());
    yyjson_arr_iter each = yyjson_arr_iter_with(value_of(value_));
    while (yyjson_val* item = yyjson_arr_iter_next(&each)) result.emplace_back(item);
    return result;
}

std::vector<JsonValue::Member> JsonValue::members() const {
    std::vector<Member> result;
    if (!is_object()) return result;
    yyjson_obj_iter each = yyjson_obj_iter_with(value_of(value_));
    while (yyjson_val* key = yyjson_obj_iter_next(&each)) {
        result.push_back({{yyjson_get_str(key), yyjson_get_len(key)}, JsonValue(yyjson_obj_iter_get_val(key))});
    }
    return result;
}

std::size_t JsonValue::size() const {
    return is_list() ? yyjson_arr_size(value_of(value_)) : is_object() ? yyjson_obj_size(value_of(value_)) : 0;
}

std::optional<double> JsonValue::number() const {
    yyjson_val* value = value_of(value_);
    if (!yyjson_is_raw(value)) return std::nullopt;
    return number_of({yyjson_get_raw(value), yyjson_get_len(value)});
}

std::optional<std::string_view> JsonValue::text() const {
    yyjson_val* value = value_of(value_);
    if (!yyjson_is_str(value)) return std::nullopt;
    return std::string_view(yyjson_get_str(value), yyjson_get_len(value));
}

std::optional<bool> JsonValue::truth() const {
    yyjson_val* value = value_of(value_);
    if (!yyjson_is_bool(value)) return std::nullopt;
    return yyjson_get_bool(value);
}

std::string JsonValue::brief() const {
    yyjson_val* value = value_of(value_);
    const auto cut = [](std::string_view text) {
        if (text.size() <= longest_shown) return std::string(text);
        std::size_t end = longest_shown;
        while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;  // whole characters of UTF-8
        return std::string(text.substr(0, end)) + "...";
    };
    if (!value) return "none";
    if (yyjson_is_raw(value)) return cut({yyjson_get_raw(value), yyjson_get_len(value)});
    if (const auto own = text()) return std::string("'").append(cut(*own)).append("'");
    if (const auto own = truth()) return *own ? "true" : "false";
    return is_list() ? "a list" : is_object() ? "an object" : "null";
}

}  // namespace bob::files
