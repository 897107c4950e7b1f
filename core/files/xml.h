/// XML: elements with their attributes, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// The attributes of an element. Names are without prefixes; `space` is the namespace, empty for an attribute without a prefix.
class XmlAttributes {
public:
    struct Attribute {
        std::string_view space, name, value;
    };

    /// The value of an attribute without a prefix.
    [[nodiscard]] std::optional<std::string_view> find(std::string_view name) const {
        for (const Attribute& attribute : all_) {
            if (attribute.name == name && attribute.space.empty()) return attribute.value;
        }
        return std::nullopt;
    }
    /// That value, or another if there is none.
    [[nodiscard]] std::string_view get(std::string_view name, std::string_view otherwise = "") const { return find(name).value_or(otherwise); }

    [[nodiscard]] std::span<const Attribute> all() const { return all_; }

private:
    friend class Xml;

    std::vector<Attribute> all_;
};

/// Reads XML in UTF-8 or UTF-16; texts and comments are passed over. Functions throw std::invalid_argument if the bytes are not well
/// formed, or exceed limits that only malicious files reach: tags of 1 MiB, 100,000 levels, and elements of a few bytes. A document
/// type is refused, since its entities could expand endlessly. Checks Interruption.
class Xml {
public:
    enum class Event : std::uint8_t { start, end, finish };

    /// The bytes have to live as long.
    explicit Xml(Bytes bytes);

    Event next();

    /// Of the element that starts or ends.
    [[nodiscard]] std::string_view space() const { return element_.space; }
    [[nodiscard]] std::string_view name() const { return element_.name; }
    /// Of the element that started last; its values live until the next one starts.
    [[nodiscard]] const XmlAttributes& attributes() const { return attributes_; }

    /// The namespace of a prefix, empty if it is not declared.
    [[nodiscard]] std::string_view space_of(std::string_view prefix) const;

private:
    struct Element {
        std::string_view written, space, name;
        std::size_t declared;  // number of prefixes declared before its own
    };

    [[noreturn]] void refuse_xml(std::string_view why) const;
    /// Refuses the tag that starts here: it is too long, or the text ends within it.
    [[noreturn]] void refuse_tag() const;
    /// Passes over a tag, which the next `end` behind its start ends.
    void pass(std::string_view start, std::string_view end);
    [[nodiscard]] char next_char(std::size_t at) const;
    std::size_t skip_spaces(std::size_t at) const;
    std::string_view take_name(std::size_t& at) const;
    /// The text between quotes, with its references replaced; `to` keeps those that change.
    std::string_view take_value(std::size_t& at, std::deque<std::string>& to) const;
    [[nodiscard]] std::string replaced(std::string_view written) const;
    void start();
    void end();
    void declare(std::string_view prefix, std::string_view space);
    void split(std::string_view& space, std::string_view& name, bool has_default) const;

    std::string own_;  // the text of a file in UTF-16
    std::string_view text_;
    std::size_t at_ = 0, count_ = 0, most_ = 0;  // elements so far, and at most
    bool is_empty_ = false;                      // whether the element that started ends at once
    Element element_{};
    XmlAttributes attributes_;
    std::vector<Element> open_;
    std::map<std::string_view, std::vector<std::string_view>, std::less<>> spaces_;  // by prefix; the innermost is the last
    std::vector<std::string_view> declared_;                                          // prefixes, in order
    std::deque<std::string> values_, kept_;  // changed values of the last element, and names of namespaces
};

}  // namespace bob::files
