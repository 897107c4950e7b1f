#include "files/xml.h"

#include <algorithm>
#include <array>

#include "base/interruption.h"
#include "files/text.h"

namespace bob::files {
namespace {

constexpr std::size_t max_tag = 1 << 20;       // bytes of a tag or a comment; real ones have a few hundred
constexpr std::size_t max_depth = 100'000;     // real ones have ten
constexpr std::size_t many_elements = 250'000;  // that any file may have
constexpr std::size_t short_element = 16;      // bytes, on average, of any more; <v x="0" y="0" z="0"/> has 21

constexpr bool is_xml_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Whether a byte may be part of a name.
constexpr std::array<bool, 256> in_name = [] {
    std::array<bool, 256> result{};
    for (std::size_t c = 0x21; c < result.size(); ++c) result[c] = true;
    for (const char c : {'<', '>', '/', '=', '"', '\'', '&', '!', '?'}) result[static_cast<std::size_t>(c)] = false;
    return result;
}();

void append_utf8(std::string& to, std::uint32_t code) {
    const auto byte = [&](std::uint32_t value) { to += static_cast<char>(value); };
    if (code < 0x80) return byte(code);
    if (code < 0x800) {
        byte(0xc0 | code >> 6);
    } else {
        if (code < 0x10000) {
            byte(0xe0 | code >> 12);
        } else {
            byte(0xf0 | code >> 18), byte(0x80 | (code >> 12 & 63));
        }
        byte(0x80 | (code >> 6 & 63));
    }
    byte(0x80 | (code & 63));
}

/// The text of UTF-16; lone surrogates become U+FFFD.
std::string from_utf16(Bytes bytes, bool is_big) {
    std::string result;
    result.reserve(bytes.size());
    const auto unit = [&](std::size_t i) { return std::uint32_t{bytes[i + !is_big]} << 8 | bytes[i + is_big]; };
    std::uint32_t high = 0;
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
        const std::uint32_t code = unit(i);
        const bool is_low = code >> 10 == 0x37;
        if (high && !is_low) append_utf8(result, 0xfffd);
        if (code >> 10 == 0x36) {
            high = code;
            continue;
        }
        append_utf8(result, !is_low ? code : high ? 0x10000 + ((high & 0x3ff) << 10 | (code & 0x3ff)) : 0xfffd);
        high = 0;
    }
    return result;
}

}  // namespace

Xml::Xml(Bytes bytes) {
    const auto starts_with = [&](std::uint8_t a, std::uint8_t b) { return bytes.size() >= 2 && bytes[0] == a && bytes[1] == b; };
    const bool is_big = starts_with(0xfe, 0xff) || starts_with(0, '<');
    if (is_big || starts_with(0xff, 0xfe) || starts_with('<', 0)) {
        text_ = own_ = from_utf16(bytes, is_big);
    } else {
        text_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        unsigned all = 0;
        for (const std::uint8_t byte : bytes) all |= byte;
        if (all >= 0x80) text_ = own_ = utf8(text_);  // messages quote names
    }
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
    most_ = many_elements + text_.size() / short_element;
    spaces_["xml"].push_back("http://www.w3.org/XML/1998/namespace");
}

void Xml::refuse_xml(std::string_view why) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size())), '\n');
    refuse({"expected XML, got something else (", why, " in line ", grouped(static_cast<std::uint64_t>(line)), ")"});
}

void Xml::refuse_tag() const {
    if (text_.size() - at_ > max_tag) refuse({"expected XML tags of at most ", grouped(max_tag), " bytes, got a longer one"});
    refuse_xml("an unclosed tag");
}

Xml::Event Xml::next() {
    if (is_empty_) {
        is_empty_ = false;
        end();
        return Event::end;
    }
    while (true) {
        const std::size_t begin = std::min(text_.find('<', at_), text_.size());
        if (open_.empty() && !std::ranges::all_of(text_.substr(at_, begin - at_), is_xml_space)) refuse_xml("text outside of an element");
        at_ = begin;
        if (at_ == text_.size()) break;
        const std::string_view rest = text_.substr(at_);
        if (rest.starts_with("<!--")) {
            pass("<!--", "-->");
        } else if (rest.starts_with("<?")) {
            pass("<?", "?>");
        } else if (rest.starts_with("<![CDATA[") && !open_.empty()) {
            pass("<![CDATA[", "]]>");
        } else if (rest.starts_with("<!DOCTYPE")) {
            refuse({"expected XML without a document type and entities, got some"});
        } else if (rest.starts_with("</")) {
            std::size_t at = at_ + 2;
            const std::string_view name = take_name(at);
            at = skip_spaces(at);
            if (next_char(at) != '>') refuse_xml("a damaged tag");
            if (open_.empty() || open_.back().written != name) refuse_xml("a mismatched tag");
            at_ = at + 1;
            end();
            return Event::end;
        } else {
            start();
            return Event::start;
        }
    }
    if (!open_.empty()) refuse_xml("an element without an end");
    if (count_ == 0) refuse_xml("no element");
    return Event::finish;
}

void Xml::pass(std::string_view start, std::string_view end) {
    const std::size_t found = text_.substr(at_, max_tag).find(end, start.size());
    if (found == std::string_view::npos) refuse_tag();
    at_ += found + end.size();
}

/// The character at a place within the tag that starts here.
char Xml::next_char(std::size_t at) const {
    if (at >= text_.size() || at - at_ >= max_tag) refuse_tag();
    return text_[at];
}

std::size_t Xml::skip_spaces(std::size_t at) const {
    while (is_xml_space(next_char(at))) ++at;
    return at;
}

std::string_view Xml::take_name(std::size_t& at) const {
    const std::size_t begin = at;
    while (in_name[static_cast<unsigned char>(next_char(at))]) ++at;
    if (at == begin) refuse_xml("a damaged tag");
    return text_.substr(begin, at - begin);
}

std::string_view Xml::take_value(std::size_t& at, std::deque<std::string>& to) const {
    const char quote = next_char(at);
    if (quote != '"' && quote != '\'') refuse_xml("an attribute without a value");
    const std::size_t begin = ++at, end = std::min(text_.size(), at_ + max_tag);
    bool changes = false;
    for (; at < end && text_[at] != quote; ++at) changes |= text_[at] == '&' || text_[at] == '<' || text_[at] < ' ';
    if (at == end) refuse_tag();
    const std::string_view written = text_.substr(begin, at++ - begin);
    return changes ? to.emplace_back(replaced(written)) : written;
}

std::string Xml::replaced(std::string_view written) const {
    constexpr std::pair<std::string_view, char> named[] = {{"lt", '<'}, {"gt", '>'}, {"amp", '&'}, {"quot", '"'}, {"apos", '\''}};
    std::string result;
    for (std::size_t at = 0; at < written.size(); ++at) {
        const char c = written[at];
        if (c == '<') refuse_xml("a damaged tag");
        if (c != '&') {
            result += is_xml_space(c) ? ' ' : c;
            continue;
        }
        const std::size_t end = written.find(';', at);
        if (end == std::string_view::npos) refuse_xml("a reference without an end");
        const std::string_view name = written.substr(at + 1, end - at - 1);
        at = end;
        if (name.starts_with('#')) {
            const bool is_hex = name.starts_with("#x");
            const std::string_view digits = name.substr(is_hex ? 2 : 1);
            std::uint32_t code = digits.empty() ? 0x110000 : 0;
            for (const char digit : digits) {
                const int letter = digit | 32, high = is_hex && letter >= 'a' && letter <= 'f' ? letter - 'a' + 10 : -1;
                const int value = digit >= '0' && digit <= '9' ? digit - '0' : high;
                code = value < 0 || code > 0x10ffff ? 0x110000 : (is_hex ? 16 : 10) * code + static_cast<std::uint32_t>(value);
            }
            if (code == 0 || code > 0x10ffff || code >> 11 == 0x1b) refuse_xml("a reference to no character");
            append_utf8(result, code);
        } else {
            const auto found = std::ranges::find(named, name, [](const auto& entity) { return entity.first; });
            if (found == std::end(named)) refuse_xml("an undefined entity");
            result += found->second;
        }
    }
    return result;
}

void Xml::start() {
    if (open_.empty() && count_ > 0) refuse_xml("a second element");
    if (++count_ % 4096 == 0) Interruption::check();
    if (count_ > most_) refuse({"expected XML with at most ", grouped(many_elements), " elements of a few bytes, got more"});
    if (open_.size() == max_depth) refuse({"expected XML of at most ", grouped(max_depth), " levels, got more"});
    std::size_t at = at_ + 1;
    element_ = {.written = take_name(at), .space = {}, .name = {}, .declared = declared_.size()};
    values_.clear();
    std::vector<XmlAttributes::Attribute>& attributes = attributes_.all_;
    attributes.clear();
    while (true) {
        const std::size_t begin = at;
        at = skip_spaces(at);
        if (text_[at] == '>' || text_[at] == '/') break;
        if (at == begin) refuse_xml("a damaged tag");
        const std::string_view name = take_name(at);
        at = skip_spaces(at);
        if (text_[at] != '=') refuse_xml("an attribute without a value");
        at = skip_spaces(at + 1);
        if (name == "xmlns") {
            declare("", take_value(at, kept_));
        } else if (name.starts_with("xmlns:")) {
            declare(name.substr(6), take_value(at, kept_));
        } else {
            attributes.push_back({{}, name, take_value(at, values_)});
        }
    }
    is_empty_ = text_[at] == '/';
    if (is_empty_ && next_char(++at) != '>') refuse_xml("a damaged tag");
    element_.name = element_.written;
    split(element_.space, element_.name, true);
    for (XmlAttributes::Attribute& attribute : attributes) split(attribute.space, attribute.name, false);
    open_.push_back(element_);
    at_ = at + 1;
}

void Xml::end() {
    element_ = open_.back();
    open_.pop_back();
    for (; declared_.size() > element_.declared; declared_.pop_back()) spaces_.find(declared_.back())->second.pop_back();
}

void Xml::declare(std::string_view prefix, std::string_view space) {
    declared_.push_back(prefix);
    spaces_[prefix].push_back(space);
}

std::string_view Xml::space_of(std::string_view prefix) const {
    const auto found = spaces_.find(prefix);
    return found == spaces_.end() || found->second.empty() ? std::string_view() : found->second.back();
}

/// Replaces the prefix of a name by its namespace.
void Xml::split(std::string_view& space, std::string_view& name, bool has_default) const {
    const std::size_t colon = name.find(':');
    if (colon != std::string_view::npos) {
        space = space_of(name.substr(0, colon));
        if (space.empty()) refuse_xml("a prefix without a namespace");
        name.remove_prefix(colon + 1);
    } else if (has_default) {
        space = space_of("");
    }
}

}  // namespace bob::files
