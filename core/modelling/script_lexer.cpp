#include <algorithm>
#include <charconv>
#include <cstdio>

#include "modelling/script_syntax.h"

namespace bob {

ScriptError::ScriptError(Position at, const std::string& message)
    : std::invalid_argument("line " + std::to_string(at.line) + ", column " + std::to_string(at.column) + ": " +
                            message),
      at(at) {}

namespace script {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool starts_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool continues_name(char c) { return starts_name(c) || is_digit(c); }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\f'; }

/// Decodes one UTF-8 character at the start of `text`, which is not empty. Returns its length in bytes, 0 if it is
/// invalid.
std::size_t decode(std::string_view text, char32_t& character) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const std::size_t length = byte(0) < 0x80 ? 1 : byte(0) < 0xc2 ? 0 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3
                               : byte(0) < 0xf5 ? 4 : 0;
    if (length == 0 || length > text.size()) return 0;
    character = length == 1 ? byte(0) : byte(0) & (0x7fu >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0;
        character = character << 6 | (byte(i) & 0x3fu);
    }
    constexpr char32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = character >= 0xd800 && character < 0xe000;
    return character < smallest[length] || character > 0x10ffff || surrogate ? 0 : length;
}

}  // namespace

std::string quoted(std::string_view text) {
    std::string result;
    result += '\'';
    result += text;
    return result += '\'';
}

std::string describe(const Token& token) {
    using Kind = Token::Kind;
    switch (token.kind) {
        case Kind::string: return "a string";
        case Kind::newline: return "the end of the line";
        case Kind::indent: return "an indented line";
        case Kind::dedent: return "a line indented less";
        case Kind::end: return "the end of the script";
        default: return quoted(token.text.substr(0, 40));
    }
}

Lexer::Lexer(std::string_view source) : source_(source) {
    if (source.size() > ScriptLimits::bytes) {
        throw ScriptError(at_, "expected at most " + std::to_string(ScriptLimits::bytes) + " bytes, got " +
                                   std::to_string(source.size()));
    }
    if (source_.starts_with("\xef\xbb\xbf")) source_.remove_prefix(3);  // the byte order mark of some editors
}

char Lexer::peek(std::size_t ahead) const { return place_ + ahead < source_.size() ? source_[place_ + ahead] : '\0'; }

/// Advances within a line.
void Lexer::advance(std::size_t bytes) {
    for (const std::size_t end = place_ + bytes; place_ < end; ++at_.column) {
        char32_t character;
        const std::size_t length = decode(source_.substr(place_), character);
        if (length == 0) throw ScriptError(at_, "expected valid UTF-8, got an invalid byte");
        place_ += length;
    }
}

/// Length in bytes of a line break at the current place, else 0.
std::size_t Lexer::line_break() const {
    if (peek() == '\n') return 1;
    if (peek() == '\r') return peek(1) == '\n' ? 2 : 1;
    return 0;
}

/// Skips blanks, comments and insignificant line breaks; false at a significant one or at the end.
bool Lexer::skip_to_token() {
    while (place_ < source_.size()) {
        if (is_blank(peek())) {
            advance(1);
        } else if (peek() == '#') {
            while (place_ < source_.size() && line_break() == 0) advance(1);
        } else if (const std::size_t bytes = line_break()) {
            if (brackets_.empty()) return false;
            place_ += bytes, at_ = {at_.line + 1, 1};
        } else if (peek() == '\\') {
            advance(1);
            const std::size_t broken = line_break();
            if (broken == 0 && place_ < source_.size()) throw ScriptError(at_, "expected a new line after '\\'");
            place_ += broken, at_ = {at_.line + 1, 1};
        } else {
            return true;
        }
    }
    return false;
}

/// Measures the indentation at the start of a line. True if it opens or closes blocks.
bool Lexer::indentation(Token& token) {
    Indentation here{0, 0};
    for (;; advance(1)) {
        if (peek() == '\t') here = {here.columns / 8 * 8 + 8, here.characters + 1};
        else if (peek() == ' ') here = {here.columns + 1, here.characters + 1};
        else if (peek() == '\f') here = {0, 0};
        else break;
    }
    if (place_ >= source_.size() || peek() == '#' || line_break() > 0) return false;  // an empty line
    line_start_ = false;
    const auto compare = [&](Indentation other) {
        const int columns = here.columns - other.columns, characters = here.characters - other.characters;
        if ((columns > 0) != (characters > 0) || (columns < 0) != (characters < 0)) {
            throw ScriptError(at_, "expected the same tabs and spaces as in the lines above");
        }
        return columns;
    };
    token = {Token::Kind::indent, at_, {}};
    if (compare(indentations_.back()) > 0) {
        indentations_.push_back(here);
        return true;
    }
    while (compare(indentations_.back()) < 0) indentations_.pop_back(), ++dedents_;
    if (compare(indentations_.back()) != 0) throw ScriptError(at_, "expected the indentation of a line above");
    return false;
}

Token Lexer::token(Token::Kind kind, std::size_t bytes) {
    const Token result{kind, at_, source_.substr(place_, bytes)};
    advance(bytes);
    return result;
}

Token Lexer::number() {
    std::string digits;  // without underscores
    std::size_t bytes = 0;
    const auto take_digits = [&] {
        for (; is_digit(peek(bytes)) || (peek(bytes) == '_' && is_digit(peek(bytes + 1)) && bytes > 0); ++bytes) {
            if (peek(bytes) != '_') digits += peek(bytes);
        }
    };
    take_digits();
    if (peek(bytes) == '.') digits += peek(bytes++), take_digits();
    if (peek(bytes) == 'e' || peek(bytes) == 'E') {
        const bool sign = peek(bytes + 1) == '+' || peek(bytes + 1) == '-';
        if (is_digit(peek(bytes + 1 + sign))) {
            digits += 'e';
            if (peek(bytes + 1) == '-') digits += '-';
            bytes += 1 + sign;
            take_digits();
        }
    }
    if (continues_name(peek(bytes))) {
        Position at = at_;
        at.column += static_cast<int>(bytes);
        throw ScriptError(at, "expected a decimal number, got " + quoted(source_.substr(place_ + bytes, 1)) + " in it");
    }
    Token result = token(Token::Kind::number, bytes);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), result.number);
    if (error != std::errc() || end != digits.data() + digits.size()) {
        throw ScriptError(result.at, "expected a number that float64 can hold, got " + describe(result));
    }
    return result;
}

/// A string in single, double or triple quotes. Escapes are kept verbatim: no word of the language reads them.
Token Lexer::string() {
    const Position at = at_;
    const char quote = peek();
    const bool triple = peek(1) == quote && peek(2) == quote;
    const std::size_t quotes = triple ? 3 : 1;
    advance(quotes);
    const std::size_t begin = place_;
    const auto closes = [&] { return peek() == quote && (!triple || (peek(1) == quote && peek(2) == quote)); };
    while (!closes()) {
        if (peek() == '\\' && place_ + 1 < source_.size()) advance(1);
        const std::size_t broken = line_break();
        if (place_ >= source_.size() || (broken > 0 && !triple)) throw ScriptError(at, "this string is never closed");
        if (broken > 0) place_ += broken, at_ = {at_.line + 1, 1};
        else advance(1);
    }
    const Token result{Token::Kind::string, at, source_.substr(begin, place_ - begin)};
    advance(quotes);
    return result;
}

Token Lexer::symbol() {
    // Longer symbols first.
    constexpr std::string_view symbols[] = {"**=", "//=", "**", "//", "+=", "-=", "*=", "/=", "%=", "|=", "&=",
                                            "<=",  ">=",  "==", "!=", "+",  "-",  "*",  "/",  "%",  "|",  "&",
                                            "<",   ">",   "=",  "(",  ")",  "[",  "]",  ",",  ".",  ":",  ";"};
    const std::string_view rest = source_.substr(place_);
    const auto found = std::ranges::find_if(symbols, [&](std::string_view s) { return rest.starts_with(s); });
    if (found == std::end(symbols)) {
        char32_t character = 0;
        if (decode(rest, character) == 0) advance(1);  // throws
        char text[16];
        const bool printable = character > ' ' && character < 0x7f;
        std::snprintf(text, sizeof text, printable ? "'%c'" : "U+%04X", static_cast<unsigned>(character));
        throw ScriptError(at_, std::string("expected a word, a number or an operator, got ") + text);
    }
    const Token result = token(Token::Kind::symbol, found->size());
    const char c = result.text[0];
    if (c == '(' || c == '[') {
        brackets_.push_back({c == '(' ? ')' : ']', result.at});
    } else if (c == ')' || c == ']') {
        if (brackets_.empty()) throw ScriptError(result.at, "expected a bracket opened before this one");
        if (brackets_.back().closing != c) {
            const std::string expected = quoted({&brackets_.back().closing, 1});
            throw ScriptError(result.at, "expected " + expected + ", got " + quoted(result.text));
        }
        brackets_.pop_back();
    }
    return result;
}

Token Lexer::next() {
    for (;;) {
        if (dedents_ > 0) return --dedents_, Token{Token::Kind::dedent, at_, {}};
        if (line_start_) {
            Token token;
            if (indentation(token)) return token;
            if (dedents_ > 0) continue;
        }
        if (skip_to_token()) break;
        if (place_ >= source_.size()) {
            if (!brackets_.empty()) throw ScriptError(brackets_.back().at, "this bracket is never closed");
            if (!line_start_) return line_start_ = true, Token{Token::Kind::newline, at_, {}};
            if (indentations_.size() == 1) return {Token::Kind::end, at_, {}};
            indentations_.pop_back(), ++dedents_;
            continue;
        }
        const bool counts = !line_start_;
        const Token newline{Token::Kind::newline, at_, {}};
        place_ += line_break(), at_ = {at_.line + 1, 1};
        line_start_ = true;
        if (counts) return newline;
    }
    line_start_ = false;
    const char c = peek();
    if (is_digit(c) || (c == '.' && is_digit(peek(1)))) return number();
    if (c == '"' || c == '\'') return string();
    if (!starts_name(c)) return symbol();
    std::size_t bytes = 1;
    while (continues_name(peek(bytes))) ++bytes;
    return token(Token::Kind::name, bytes);
}

}  // namespace script
}  // namespace bob
