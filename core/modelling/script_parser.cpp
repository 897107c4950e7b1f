#include <algorithm>

#include "modelling/script_syntax.h"

namespace bob::script {
namespace {

/// Binary operators with Python's precedences; `not` lies between `and` and the comparisons.
struct Binary {
    std::string_view text;
    Operator op;
    int precedence;
};
constexpr int lowest_precedence = 1, logical_not_precedence = 3, comparison_precedence = 4, power_precedence = 10;
constexpr Binary binaries[] = {
    {"or", Operator::logical_or, 1},
    {"and", Operator::logical_and, 2},
    {"<", Operator::less, 4},
    {"<=", Operator::less_equal, 4},
    {">", Operator::greater, 4},
    {">=", Operator::greater_equal, 4},
    {"==", Operator::equal, 4},
    {"!=", Operator::not_equal, 4},
    {"|", Operator::unite, 5},
    {"&", Operator::intersect, 6},
    {"+", Operator::add, 7},
    {"-", Operator::subtract, 7},
    {"*", Operator::multiply, 8},
    {"/", Operator::divide, 8},
    {"//", Operator::floor_divide, 8},
    {"%", Operator::modulo, 8},
    {"**", Operator::power, 10},  // right-associative: Parser::operand takes it
};

struct Refused {
    std::string_view name, advice;
    bool keyword;  // a keyword of Python, never a variable
};
constexpr std::string_view no_import = "scripts have every word already; delete this line";
constexpr std::string_view no_function = "scripts cannot define functions; write the steps out, or use a loop";
constexpr std::string_view no_while = "loops are written for i in range(10):";
constexpr std::string_view no_errors = "scripts have no exceptions; write if and else";
constexpr std::string_view no_scope = "all names of a script share one scope";
constexpr std::string_view no_effect = "scripts make shapes and nothing else";
constexpr std::string_view no_module = "write the name without a module before it, as in sqrt(2) or pi";
constexpr std::string_view no_file = "scripts read no fonts and no pictures; write the program in Python";
constexpr Refused refused[] = {
    {"import", no_import, true},
    {"from", no_import, true},
    {"def", no_function, true},
    {"lambda", no_function, true},
    {"return", no_function, true},
    {"yield", no_function, true},
    {"class", "scripts have no classes", true},
    {"while", no_while, true},
    {"break", "a for loop runs to its end; write if inside it", true},
    {"continue", "a for loop runs to its end; write if inside it", true},
    {"try", no_errors, true},
    {"except", no_errors, true},
    {"finally", no_errors, true},
    {"raise", no_errors, true},
    {"assert", no_errors, true},
    {"with", "scripts have no files", true},
    {"global", no_scope, true},
    {"nonlocal", no_scope, true},
    {"del", "assign the name again instead", true},
    {"async", "scripts run one step after another", true},
    {"await", "scripts run one step after another", true},
    {"in", "only for loops have it", true},
    {"is", "write == instead", true},
    {"as", "expected no such word here", true},
    {"elif", "expected an if before it, indented alike", true},
    {"else", "expected an if before it, indented alike", true},
    {"and", "expected a value before it", true},
    {"or", "expected a value before it", true},
    {"for", "expected it at the start of a line or inside [...]", true},
    {"if", "expected a value before it", true},
    {"not", "expected it in brackets here", true},
    {"pass", "expected it on its own line", true},
    {"exec", no_effect, false},
    {"eval", no_effect, false},
    {"open", no_effect, false},
    {"print", no_effect, false},
    {"input", no_effect, false},
    {"compile", no_effect, false},
    {"globals", no_effect, false},
    {"locals", no_effect, false},
    {"getattr", no_effect, false},
    {"setattr", no_effect, false},
    {"__import__", no_import, false},
    {"math", no_module, false},
    {"np", no_module, false},
    {"numpy", no_module, false},
    {"sdf", no_module, false},
    {"bob", no_module, false},
    {"dict", "scripts have lists", false},
    {"set", "scripts have lists", false},
    {"tuple", "write (a, b)", false},
    {"list", "write [a, b]", false},
    {"str", "scripts have no strings to compute with", false},
    {"map", "write [f(x) for x in items]", false},
    {"filter", "write [x for x in items if ...]", false},
    {"zip", "write for i in range(len(a)): and a[i], b[i]", false},
    {"text", no_file, false},
    {"image", no_file, false},
    {"measure_text", no_file, false},
    {"measure_image", no_file, false},
};

bool is_keyword(std::string_view name) {
    const auto found = std::ranges::find(refused, name, &Refused::name);
    return found != std::end(refused) && found->keyword;
}

class Parser {
public:
    explicit Parser(std::string_view source) : lexer_(source), token_(lexer_.next()) {}

    std::vector<Statement> script() {
        std::vector<Statement> statements;
        while (token_.kind != Token::Kind::end) line(statements);
        return statements;
    }

private:
    using Kind = Term::Kind;

    // ---- Tokens

    [[nodiscard]] bool is(std::string_view text) const {
        return token_.text == text && (token_.kind == Token::Kind::symbol || token_.kind == Token::Kind::name);
    }

    Token take() {
        const Token taken = token_;
        token_ = lexer_.next();
        return taken;
    }

    bool take(std::string_view text) {
        if (!is(text)) return false;
        take();
        return true;
    }

    [[noreturn]] void fail(const std::string& expected) const {
        throw ScriptError(token_.at, "expected " + expected + ", got " + describe(token_));
    }

    void expect(std::string_view text) {
        if (!take(text)) fail(quoted(text));
    }

    /// Counts the parser's recursion depth, so that no text exhausts the stack.
    class Nested {
    public:
        explicit Nested(Parser& parser) : depth_(parser.depth_) {
            if (depth_ >= ScriptLimits::depth) throw ScriptError(parser.token_.at, "expected less nesting");
            ++depth_;
        }
        ~Nested() { --depth_; }
        Nested(const Nested&) = delete;
        Nested& operator=(const Nested&) = delete;

    private:
        int& depth_;
    };

    // ---- Statements

    void line(std::vector<Statement>& statements) {
        if (token_.kind == Token::Kind::indent) throw ScriptError(token_.at, "expected no indentation here");
        if (is("for")) {
            statements.push_back(loop());
        } else if (is("if")) {
            statements.push_back(branch());
        } else {
            simple_line(statements);
        }
    }

    void simple_line(std::vector<Statement>& statements) {
        do {
            statements.push_back(simple());
        } while (take(";") && token_.kind != Token::Kind::newline);
        if (token_.kind != Token::Kind::newline) fail("the end of the line");
        take();
    }

    std::vector<Statement> block() {
        const Nested nested(*this);
        std::vector<Statement> statements;
        expect(":");
        if (token_.kind != Token::Kind::newline) {
            simple_line(statements);
            return statements;
        }
        take();
        if (token_.kind != Token::Kind::indent) fail("an indented line");
        take();
        while (token_.kind != Token::Kind::dedent) line(statements);
        take();
        return statements;
    }

    Statement loop() {
        Statement result{Statement::Kind::loop, take().at, {}, {}, {}};
        result.parts = runs_through(false);
        result.blocks.push_back(block());
        return result;
    }

    /// After `for`: targets in values. Inside a list the values need brackets.
    std::vector<Term> runs_through(bool within_list) {
        std::vector<Term> parts;
        parts.push_back(expressions(comparison_precedence + 1));
        check_target(parts.back());
        expect("in");
        parts.push_back(within_list ? binary(lowest_precedence) : expressions(lowest_precedence));
        return parts;
    }

    Statement branch() {
        Statement result{Statement::Kind::branch, token_.at, {}, {}, {}};
        do {
            take();
            result.parts.push_back(expression());
            result.blocks.push_back(block());
        } while (is("elif"));
        if (take("else")) result.blocks.push_back(block());
        return result;
    }

    Statement simple() {
        const Position at = token_.at;
        if (take("pass")) return {Statement::Kind::pass, at, {}, {}, {}};
        std::vector<Term> parts;
        parts.push_back(expressions(lowest_precedence));
        for (const Binary& binary : binaries) {
            const bool arithmetic = binary.precedence > comparison_precedence;
            if (arithmetic && is(std::string(binary.text) + "=")) return augment(std::move(parts), binary.op);
        }
        while (is("=")) {
            check_target(parts.back());
            take();
            parts.push_back(expressions(lowest_precedence));
        }
        return {parts.size() > 1 ? Statement::Kind::assign : Statement::Kind::expression, at, {}, std::move(parts), {}};
    }

    Statement augment(std::vector<Term> parts, Operator op) {
        if (parts[0].kind != Kind::name) throw ScriptError(parts[0].at, "expected a name to assign to");
        const Position at = take().at;
        parts.push_back(expressions(lowest_precedence));
        return {Statement::Kind::augment, at, op, std::move(parts), {}};
    }

    static void check_target(const Term& target) {
        if (target.kind == Kind::list && !target.parts.empty()) {
            std::ranges::for_each(target.parts, check_target);
        } else if (target.kind != Kind::name) {
            throw ScriptError(target.at, "expected a name to assign to");
        }
    }

    // ---- Expressions

    static Term term(Kind kind, Position at, std::string_view text = {}) {
        Term result;
        result.kind = kind, result.at = at, result.text = text;
        return result;
    }

    /// One expression, or several with commas between: a list.
    Term expressions(int precedence) {
        const auto one = [&] { return precedence == lowest_precedence ? expression() : binary(precedence); };
        Term first = one();
        if (!is(",")) return first;
        Term list = term(Kind::list, first.at);
        list.parts.push_back(std::move(first));
        while (take(",") && starts_expression()) list.parts.push_back(one());
        return list;
    }

    [[nodiscard]] bool starts_expression() const {
        if (token_.kind == Token::Kind::number || token_.kind == Token::Kind::string) return true;
        if (token_.kind == Token::Kind::name) return is("not") || !is_keyword(token_.text);
        return is("(") || is("[") || is("-") || is("+");
    }

    Term expression() {
        const Nested nested(*this);
        Term value = binary(lowest_precedence);
        const Position at = token_.at;
        if (!take("if")) return value;
        Term result = term(Kind::conditional, at);
        result.parts.push_back(binary(lowest_precedence));
        result.parts.push_back(std::move(value));
        expect("else");
        result.parts.push_back(expression());
        return result;
    }

    [[nodiscard]] const Binary* binary_operator() const {
        const auto found = std::ranges::find_if(binaries, [&](const Binary& b) { return is(b.text); });
        return found == std::end(binaries) ? nullptr : &*found;
    }

    /// Operands and operators of at least this precedence.
    Term binary(int precedence) {
        Term left = operand(precedence);
        for (const Binary* next; (next = binary_operator()) && next->precedence >= precedence;) {
            const int level = next->precedence;
            Term row = term(level < logical_not_precedence  ? Kind::logic
                            : level == comparison_precedence ? Kind::comparison
                                                             : Kind::chain,
                            left.at);
            row.parts.push_back(std::move(left));
            for (; next && next->precedence == level; next = binary_operator()) {
                row.operators.push_back(next->op);
                row.operators_at.push_back(take().at);
                row.parts.push_back(binary(level + 1));
            }
            left = std::move(row);
        }
        return left;
    }

    Term operand(int precedence) {
        const bool negated = is("not");
        if (negated && precedence > logical_not_precedence) refuse();
        if (negated || is("-") || is("+")) {
            const Nested nested(*this);
            const Kind kind = negated ? Kind::logical_not : is("-") ? Kind::negative : Kind::positive;
            Term result = term(kind, take().at);
            result.parts.push_back(negated ? binary(logical_not_precedence) : operand(power_precedence));
            return result;
        }
        Term base = postfix();
        if (!is("**")) return base;
        const Nested nested(*this);
        Term result = term(Kind::chain, base.at);
        result.parts.push_back(std::move(base));
        result.operators.push_back(Operator::power);
        result.operators_at.push_back(take().at);
        result.parts.push_back(operand(power_precedence));
        return result;
    }

    Term postfix() {
        Term base = atom();
        if (!is(".") && !is("[")) return base;
        Term result = term(Kind::postfix, base.at);
        result.parts.push_back(std::move(base));
        while (is(".") || is("[")) {
            const Position at = token_.at;
            if (take(".")) {
                if (token_.kind != Token::Kind::name) fail("a name after '.'");
                const Token name = take();
                Term part = term(Kind::attribute, name.at, name.text);
                if (is("(")) part.kind = Kind::method, part.parts = arguments();
                result.parts.push_back(std::move(part));
            } else {
                take();
                Term part = term(Kind::index, at);
                if (is(":")) fail("an index; scripts have no slices");
                part.parts.push_back(expression());
                if (is(":")) fail("']'; scripts have no slices");
                expect("]");
                result.parts.push_back(std::move(part));
            }
        }
        return result;
    }

    Term atom() {
        if (is("[")) return list();
        if (is("(")) return brackets();
        if (token_.kind == Token::Kind::number) {
            Term result = term(Kind::number, token_.at);
            result.number = take().number;
            return result;
        }
        if (token_.kind == Token::Kind::string) {
            Term result = term(Kind::string, token_.at, token_.text);
            take();
            return result;
        }
        if (token_.kind != Token::Kind::name) fail("a value");
        if (is_keyword(token_.text)) refuse();
        const Token name = take();
        if (name.text == "None") return term(Kind::none, name.at);
        if (name.text == "True" || name.text == "False") {
            Term result = term(Kind::truth, name.at);
            result.number = name.text == "True";
            return result;
        }
        Term result = term(Kind::name, name.at, name.text);
        if (is("(")) result.kind = Kind::call, result.parts = arguments();
        return result;
    }

    [[noreturn]] void refuse() const {
        throw ScriptError(token_.at, std::string(token_.text) + ": " + std::string(advice(token_.text)));
    }

    /// (value), or a list: (), (a,), (a, b).
    Term brackets() {
        const Position at = take().at;
        Term inside = is(")") ? term(Kind::list, at) : expressions(lowest_precedence);
        if (is("for")) throw ScriptError(token_.at, "for: expected it inside [...], not (...)");
        expect(")");
        if (inside.kind == Kind::list) inside.at = at;
        return inside;
    }

    /// [a, b], or [item for target in values if condition].
    Term list() {
        Term result = term(Kind::list, take().at);
        while (!is("]")) {
            result.parts.push_back(expression());
            if (result.parts.size() == 1 && is("for")) {
                result.kind = Kind::comprehension;
                while (is("for")) result.parts.push_back(clause());
                break;
            }
            if (!take(",")) break;
        }
        expect("]");
        return result;
    }

    Term clause() {
        Term result = term(Kind::clause, take().at);
        result.parts = runs_through(true);
        while (take("if")) result.parts.push_back(binary(lowest_precedence));
        return result;
    }

    std::vector<Term> arguments() {
        std::vector<Term> result;
        take();
        while (!is(")")) {
            result.push_back(argument(!result.empty() && result.back().kind == Kind::keyword));
            if (is("for")) throw ScriptError(token_.at, "for: expected it inside [...]");
            if (!take(",")) break;
        }
        expect(")");
        return result;
    }

    Term argument(bool after_keyword) {
        const Position at = token_.at;
        if (is("**")) throw ScriptError(at, "expected keyword arguments written out, as name=value");
        const bool unpacked = take("*");
        Term value = expression();
        if (!unpacked && value.kind == Kind::name && take("=")) {
            Term result = term(Kind::keyword, at, value.text);
            result.parts.push_back(expression());
            return result;
        }
        if (after_keyword) throw ScriptError(at, "expected only name=value arguments after the first of them");
        if (!unpacked) return value;
        Term result = term(Kind::unpacked, at);
        result.parts.push_back(std::move(value));
        return result;
    }

    Lexer lexer_;
    Token token_;
    int depth_ = 0;
};

}  // namespace

std::string_view advice(std::string_view name) {
    const auto found = std::ranges::find(refused, name, &Refused::name);
    return found == std::end(refused) ? std::string_view() : found->advice;
}

std::vector<Statement> parse(std::string_view source) { return Parser(source).script(); }

}  // namespace bob::script
