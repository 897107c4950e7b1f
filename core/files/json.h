/// JSON, as the readers of files take it: a document, and views of its values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// A view of a value in a JsonDocument, or of a value that is missing: lookups in anything but an object or a list find
/// missing values, so that a path into foreign data needs one check at its end.
class JsonValue {
public:
    JsonValue() = default;
    explicit JsonValue(const void* value) : value_(value) {}

    /// Whether there is a value; null is one.
    explicit operator bool() const { return value_; }
    [[nodiscard]] bool is_object() const;
    [[nodiscard]] bool is_list() const;

    /// The member of an object. Throws std::invalid_argument if that has too many to search.
    [[nodiscard]] JsonValue operator[](std::string_view name) const;
    /// The items of a list.
    [[nodiscard]] std::vector<JsonValue> items() const;
    struct Member;
    /// The members of an object, in their order.
    [[nodiscard]] std::vector<Member> members() const;

    /// Length of a list, members of an object; 0 of anything else.
    [[nodiscard]] std::size_t size() const;

    /// A number; one too large for double is infinite.
    [[nodiscard]] std::optional<double> number() const;
    [[nodiscard]] std::optional<std::string_view> text() const;
    /// true or false.
    [[nodiscard]] std::optional<bool> truth() const;

    /// For errors: a number as written, a quoted text, or a word for longer values.
    [[nodiscard]] std::string brief() const;

private:
    const void* value_ = nullptr;
};

struct JsonValue::Member {
    std::string_view name;
    JsonValue value;
};

/// Keeps the values of a text.
class JsonDocument {
public:
    /// Throws std::invalid_argument of one line, with the place, if the bytes are not JSON in UTF-8.
    explicit JsonDocument(Bytes bytes);

    [[nodiscard]] JsonValue root() const;

private:
    std::shared_ptr<const void> document_;
};

}  // namespace bob::files
