/// Texts without a locale: lines, words and numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/counts.h"
#include "base/interruption.h"
#include "files/part.h"

namespace bob::files {

[[nodiscard]] constexpr bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

[[nodiscard]] std::string_view trimmed(std::string_view text);

/// ASCII in lower case.
[[nodiscard]] std::string lower(std::string_view text);

/// The bytes of a text with "%20" decoded to a space.
[[nodiscard]] std::string unescaped(std::string_view text);

/// Whether a text is `word`, which is in lower case, in any case.
[[nodiscard]] bool is_word(std::string_view text, std::string_view word);

/// UTF-8, with U+FFFD for invalid bytes.
[[nodiscard]] std::string utf8(std::string_view bytes);

/// At most 40 bytes of a text in quotes, for messages.
[[nodiscard]] std::string quoted(std::string_view text);

/// Texts as one. Small: messages are put together in many places.
[[nodiscard]] std::string joined(std::initializer_list<std::string_view> texts);

/// Throws std::invalid_argument with a message of texts.
[[noreturn]] void refuse(std::initializer_list<std::string_view> texts);

/// Calls f(), and adds the place to the message of a std::invalid_argument.
template <class F>
auto at_place(std::string_view place, F f) -> decltype(f()) {
    try {
        return f();
    } catch (const std::invalid_argument& error) {
        refuse({place, ": ", error.what()});
    }
}

/// A decimal number, infinity or NaN, rounded to the nearest double. Throws std::invalid_argument for other words, and says so
/// if it has a decimal comma.
[[nodiscard]] double number_of(std::string_view word);

/// A number that a file leaves out.
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A number as an index; -1 if it is out of range.
[[nodiscard]] constexpr std::int32_t index_of(double number) {
    return number >= 0 && number <= std::numeric_limits<std::int32_t>::max() ? static_cast<std::int32_t>(number) : -1;
}

/// The text of a file, without a byte order mark. Throws std::invalid_argument if that is one of UTF-16.
[[nodiscard]] std::string_view text_of(Bytes bytes);

/// The lines of a text, which end with LF, CR or both. Checks Interruption.
class Lines {
public:
    explicit Lines(std::string_view text) : rest_(text) {}

    /// Goes to the next line; false after the last.
    bool next() {
        if (++count_ % 4096 == 0) Interruption::check();
        if (rest_.empty()) return false;
        std::size_t end = 0;
        while (end < rest_.size() && rest_[end] != '\n' && rest_[end] != '\r') ++end;
        line_ = rest_.substr(0, end);
        const bool is_pair = end + 1 < rest_.size() && rest_[end] == '\r' && rest_[end + 1] == '\n';
        rest_.remove_prefix(end == rest_.size() ? end : end + (is_pair ? 2 : 1));
        return true;
    }
    [[nodiscard]] std::string_view line() const { return line_; }

private:
    std::string_view rest_, line_;
    std::uint64_t count_ = 0;
};

/// The words of a line, which white space separates.
class Words {
public:
    explicit Words(std::string_view line) : rest_(line) {}

    /// The next word, empty at the end.
    std::string_view next() {
        std::size_t begin = 0;
        while (begin < rest_.size() && is_space(rest_[begin])) ++begin;
        std::size_t end = begin;
        while (end < rest_.size() && !is_space(rest_[end])) ++end;
        const std::string_view word = rest_.substr(begin, end - begin);
        rest_.remove_prefix(end);
        return word;
    }
    /// The unread rest of the line.
    [[nodiscard]] std::string_view rest() const { return rest_; }

private:
    std::string_view rest_;
};

}  // namespace bob::files
