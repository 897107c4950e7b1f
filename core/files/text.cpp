#include "files/text.h"

#include <algorithm>
#include <stdexcept>

#include "files/decimal.h"

namespace bob::files {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; }

/// The length of the UTF-8 code point at the start of a text; 0 if it is invalid.
std::size_t code_point(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const auto follows = [&](std::size_t i, unsigned low = 0x80, unsigned high = 0xbf) { return byte(i) >= low && byte(i) <= high; };
    const unsigned first = byte(0);
    if (first < 0x80) return 1;
    if (first >= 0xc2 && first <= 0xdf) return follows(1) ? 2 : 0;
    if (first >= 0xe0 && first <= 0xef) {
        const bool second = follows(1, first == 0xe0 ? 0xa0 : 0x80, first == 0xed ? 0x9f : 0xbf);
        return second && follows(2) ? 3 : 0;
    }
    if (first >= 0xf0 && first <= 0xf4) {
        const bool second = follows(1, first == 0xf0 ? 0x90 : 0x80, first == 0xf4 ? 0x8f : 0xbf);
        return second && follows(2) && follows(3) ? 4 : 0;
    }
    return 0;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

std::string lower(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(), [](char c) { return lower(c); });
    return result;
}

std::string unescaped(std::string_view text) {
    const auto digit = [](char c) { return c >= '0' && c <= '9' ? c - '0' : lower(c) >= 'a' && lower(c) <= 'f' ? lower(c) - 'a' + 10 : -1; };
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && digit(text[i + 1]) >= 0 && digit(text[i + 2]) >= 0) {
            result += static_cast<char>(16 * digit(text[i + 1]) + digit(text[i + 2]));
            i += 2;
        } else {
            result += text[i];
        }
    }
    return result;
}

bool is_word(std::string_view text, std::string_view word) {
    return std::ranges::equal(text, word, [](char a, char b) { return lower(a) == b; });
}

std::string utf8(std::string_view bytes) {
    std::string result;
    while (!bytes.empty()) {
        const std::size_t length = code_point(bytes);
        result += length ? bytes.substr(0, length) : std::string_view("\xef\xbf\xbd");
        bytes.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return result;
}

std::string quoted(std::string_view text) {
    std::string result(1, '\'');
    result.append(utf8(text.substr(0, 40))).push_back('\'');
    return result;
}

std::string joined(std::initializer_list<std::string_view> texts) {
    std::string result;
    for (const std::string_view text : texts) result += text;
    return result;
}

void refuse(std::initializer_list<std::string_view> texts) { throw std::invalid_argument(joined(texts)); }

double number_of(std::string_view word) {
    if (const auto number = decimal(word)) return *number;
    const bool has_comma = word.find(',') != std::string_view::npos && word.find_first_of("0123456789") != std::string_view::npos;
    if (has_comma) refuse({"expected numbers with decimal points, got ", quoted(word), "; replace decimal commas"});
    refuse({"expected numbers, got others (", quoted(word), ")"});
}

std::string_view text_of(Bytes bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) refuse({"expected text in UTF-8, got UTF-16; save it as UTF-8"});
    return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

}  // namespace bob::files
