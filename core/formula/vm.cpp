#include "formula/vm.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "base/interruption.h"
#include "formula/sequenced.h"

namespace bob {
namespace {

Value zero(Value a) { return a.graph->constant(0); }
Value one(Value a) { return a.graph->constant(1); }

/// `then` if a is 0, else `otherwise`.
Value if_zero(Value a, Value then, Value otherwise) { return select(a, otherwise, select(-a, otherwise, then)); }

Value round_away(Value a) {
    const Value up = floor(a + 0.5);
    return select(a, ceil(a - 0.5), up);
}

Value compare(const Value& a, const Value& b) {
    const Value equal = zero(a), greater = one(a);
    const Value not_less = select(b - a, greater, equal);
    const Value less = -one(a);
    return select(a - b, less, not_less);
}

struct Variable {
    std::string_view name;
    Value (Graph::*make)();
};
constexpr Variable variables[] = {{"var-x", &Graph::x}, {"var-y", &Graph::y}, {"var-z", &Graph::z}};

struct Unary {
    std::string_view name;
    Value (*make)(Value);
};
constexpr Unary unaries[] = {
    {"neg", [](Value a) { return -a; }},
    {"abs", abs},
    {"recip", [](Value a) { return 1 / a; }},
    {"sqrt", sqrt},
    {"square", square},
    {"sin", sin},
    {"cos", cos},
    {"tan", tan},
    {"asin", asin},
    {"acos", acos},
    {"atan", atan},
    {"exp", exp},
    {"ln", log},
    {"floor", floor},
    {"ceil", ceil},
    {"round", round_away},
    {"not",
     [](Value a) {
         const Value otherwise = zero(a);
         return if_zero(a, one(a), otherwise);
     }},
};

struct Binary {
    std::string_view name;
    Value (*make)(const Value&, const Value&);
};
constexpr Binary binaries[] = {
    {"add", [](const Value& a, const Value& b) { return a + b; }},
    {"sub", [](const Value& a, const Value& b) { return a - b; }},
    {"mul", [](const Value& a, const Value& b) { return a * b; }},
    {"div", [](const Value& a, const Value& b) { return a / b; }},
    {"min", min},
    {"max", max},
    {"mod", [](const Value& a, const Value& b) { return modulo(a, abs(b)); }},
    {"atan2", atan2},
    {"compare", compare},
    {"and", [](const Value& a, const Value& b) { return if_zero(a, a, b); }},
    {"or", [](const Value& a, const Value& b) { return if_zero(a, b, a); }},
};

template <class Operation, std::size_t count>
const Operation* find(const Operation (&operations)[count], std::string_view name) {
    const auto found = std::ranges::find(operations, name, &Operation::name);
    return found == std::end(operations) ? nullptr : &*found;
}

constexpr std::string_view blanks = " \t\r\v\f";

/// Takes the next word off a line; empty at its end.
std::string_view take_word(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(blanks));
    line.remove_prefix(word.size());
    return word;
}

/// A word as shown in messages, whatever its bytes.
std::string shown(std::string_view word) {
    if (word.empty()) return "nothing";
    std::string result(word.substr(0, 40));
    for (char& c : result) c = c >= ' ' && c < 0x7f ? c : '?';
    return "'" + result + (word.size() > 40 ? "..." : "") + "'";
}

class Parser {
public:
    void read(std::string_view line) {
        ++number_;
        const std::string_view name = take_word(line);
        if (name.empty() || name.starts_with('#')) return;
        const std::string_view operation = take_word(line);
        last_ = value(operation, line);
        if (const std::string_view rest = take_word(line); !rest.empty()) {
            fail("the end of the line after " + shown(operation), rest);
        }
        names_[name] = *last_;
    }

    [[nodiscard]] Expression result() const {
        if (!last_) throw VmError(std::max(number_, 1), "expected a formula, got no operation in any line");
        return graph_.expression(*last_);
    }

private:
    [[noreturn]] void fail(const std::string& expected, std::string_view got) const {
        throw VmError(number_, "expected " + expected + ", got " + shown(got));
    }

    Value value(std::string_view operation, std::string_view& line) {
        try {
            if (operation == "const") return graph_.constant(constant(take_word(line)));
            if (const auto* variable = find(variables, operation)) return (graph_.*variable->make)();
            if (const auto* unary = find(unaries, operation)) return unary->make(argument(line));
            if (const auto* binary = find(binaries, operation)) {
                const Value a = argument(line);
                return binary->make(a, argument(line));
            }
        } catch (const TooLarge& error) {
            throw VmError(number_, error.what());
        }
        fail("an operation such as add, max or var-x", operation);
    }

    double constant(std::string_view word) const {
        const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
        double result = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), result);
        const bool whole = error == std::errc() && end == digits.data() + digits.size();
        if (!whole || std::isnan(result)) fail("a number", word);
        return result;
    }

    Value argument(std::string_view& line) const {
        const std::string_view word = take_word(line);
        const auto found = names_.find(word);
        if (found == names_.end()) fail("a name of a line above", word);
        return found->second;
    }

    Graph graph_;
    std::unordered_map<std::string_view, Value> names_;
    std::optional<Value> last_;
    int number_ = 0;  // line number, from 1
};

}  // namespace

VmError::VmError(int line, const std::string& message)
    : std::invalid_argument("line " + std::to_string(line) + ": " + message), line(line) {}

Expression parse_vm(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // the byte order mark of some editors
    Parser parser;
    std::size_t lines = 0;
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        if (++lines % 1024 == 0) Interruption::check();
        parser.read(line);
        text.remove_prefix(std::min(line.size() + 1, text.size()));
    }
    return parser.result();
}

}  // namespace bob
