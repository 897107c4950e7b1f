/// The syntax of shape scripts: from text to tokens, and from tokens to trees. Texts in both refer to the source.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "modelling/script.h"

namespace bob::script {

// ---- Tokens ----------------------------------------------------------------------------------------------

struct Token {
    enum class Kind { number, string, name, symbol, newline, indent, dedent, end };
    Kind kind = Kind::end;
    Position at;
    std::string_view text;  // verbatim; of a string, the text between its quotes
    double number = 0;
};

/// Splits a source into tokens as Python does: lines end where no bracket is open, indentation opens and closes blocks.
class Lexer {
public:
    explicit Lexer(std::string_view source);

    /// The next token; after the last, always `end`.
    Token next();

private:
    struct Indentation {
        int columns, characters;  // with tabs to the next multiple of eight, and as single characters
    };
    struct Bracket {
        char closing;
        Position at;
    };

    [[nodiscard]] char peek(std::size_t ahead = 0) const;
    void advance(std::size_t bytes);
    [[nodiscard]] std::size_t line_break() const;
    bool skip_to_token();
    bool indentation(Token& token);
    Token number();
    Token string();
    Token symbol();
    Token token(Token::Kind kind, std::size_t bytes);

    std::string_view source_;
    std::size_t place_ = 0;
    Position at_;
    bool line_start_ = true;
    int dedents_ = 0;  // still to be returned
    std::vector<Indentation> indentations_{{0, 0}};
    std::vector<Bracket> brackets_;
};

[[nodiscard]] std::string quoted(std::string_view text);

/// A token as shown in messages.
[[nodiscard]] std::string describe(const Token& token);

// ---- Trees -----------------------------------------------------------------------------------------------

enum class Operator {
    add, subtract, multiply, divide, floor_divide, modulo, power, unite, intersect,
    less, less_equal, greater, greater_equal, equal, not_equal,
    logical_and, logical_or,
};

/// A part of an expression. A run of operators of equal precedence is one term, and so are the methods and indices
/// after a value: long runs then need no deep recursion.
struct Term {
    enum class Kind {
        number,         // number
        string,         // text
        truth,          // number: 0 or 1
        none,
        name,           // text
        list,           // items
        comprehension,  // the item, then clauses
        clause,         // the target, the values, then conditions
        chain,          // operands, one more than operators: left to right
        comparison,     // the same; each compares neighbours
        logic,          // the same, all operators `and` or all `or`
        negative,       // operand
        positive,       // operand
        logical_not,    // operand
        conditional,    // condition, value if true, value if not
        call,           // of the function `text` with arguments
        postfix,        // a value, then methods, attributes and indices
        method,         // text; arguments
        attribute,      // text
        index,          // the index
        keyword,        // an argument text=value
        unpacked,       // an argument *value
    };
    Kind kind = Kind::none;
    Position at;
    std::string_view text;
    double number = 0;
    std::vector<Term> parts;
    std::vector<Operator> operators;
    std::vector<Position> operators_at;
};

struct Statement {
    enum class Kind {
        assign,      // targets, then the value
        augment,     // a name, then the right side; op
        expression,  // the value
        loop,        // a target and the values; one block
        branch,      // conditions; a block for each, and one more for else
        pass,
    };
    Kind kind = Kind::pass;
    Position at;
    Operator op = Operator::add;
    std::vector<Term> parts;
    std::vector<std::vector<Statement>> blocks;
};

/// The replacement for a Python name that scripts lack; empty for all others.
[[nodiscard]] std::string_view advice(std::string_view name);

/// Throws ScriptError at the first syntax error.
[[nodiscard]] std::vector<Statement> parse(std::string_view source);

}  // namespace bob::script
