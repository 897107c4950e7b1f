#include "modelling/script.h"

#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/interruption.h"
#include "modelling/script_syntax.h"
#include "modelling/script_values.h"

namespace bob {
namespace script {
namespace {

class Interpreter {
public:
    Interpreter() {
        for (const Constant& constant : constants()) names_.emplace(constant.name, constant.value);
    }

    void run(const std::vector<Statement>& statements) {
        for (const Statement& statement : statements) run(statement);
    }

    [[nodiscard]] Sdf result() const {
        if (!result_) throw ScriptError(last_, "expected a shape as the script's result, but no line makes one");
        if (result_->dimensions != 3) {
            throw ScriptError(result_at_, "expected a 3D shape as the script's result, got a 2D one; .extrude(1) or "
                                          ".revolve() makes it one");
        }
        return *result_;
    }

private:
    using Kind = Term::Kind;

    // ---- Limits

    void step(Position at, std::size_t count = 1) {
        Interruption::check();
        steps_ += count;
        if (steps_ > ScriptLimits::steps) {
            throw ScriptError(at, "expected at most " + std::to_string(ScriptLimits::steps) + " steps, got more");
        }
    }

    /// Charges for the size of a value: long lists and large shapes take more time.
    void charge(Position at, const Value& value) {
        step(at, size(value) / 16);
        const Sdf* sdf = std::get_if<Sdf>(&value.value);
        if (!sdf) return;
        nodes_ += sdf->expression->nodes().size() + (sdf->color ? sdf->color->nodes().size() : 0);
        if (nodes_ > ScriptLimits::nodes) {
            throw ScriptError(at, "expected shapes of at most " + std::to_string(ScriptLimits::nodes) +
                                      " nodes in all steps together, got more");
        }
    }

    /// Runs work that takes and returns values; its errors are reported at this position.
    template <class Work>
    Value at(Position at, Work work) {
        try {
            Value value = work();
            charge(at, value);
            return value;
        } catch (const CallError& error) {
            throw ScriptError(at, error.what());
        } catch (const TooLarge& error) {
            throw ScriptError(at, error.what());
        }
    }

    // ---- Statements

    void run(const Statement& statement) {
        step(statement.at);
        last_ = statement.at;
        switch (statement.kind) {
            case Statement::Kind::assign: return assign(statement);
            case Statement::Kind::augment: return augment(statement);
            case Statement::Kind::expression: return keep(statement.at, evaluate_saved(statement.parts[0]));
            case Statement::Kind::loop: return loop(statement);
            case Statement::Kind::branch: return branch(statement);
            case Statement::Kind::pass: return;
        }
    }

    void assign(const Statement& statement) {
        const Value value = evaluate(statement.parts.back());
        for (std::size_t i = 0; i + 1 < statement.parts.size(); ++i) bind(statement.parts[i], value, true);
    }

    void augment(const Statement& statement) {
        const Term& name = statement.parts[0];
        const Value left = evaluate(name);
        const Value right = evaluate(statement.parts[1]);
        bind(name, binary(statement.at, statement.op, left, right), true);
    }

    void loop(const Statement& statement) {
        const Value values = evaluate(statement.parts[1]);
        const std::size_t count = items(statement.parts[1].at, "for", values);
        for (std::size_t i = 0; i < count; ++i) {
            step(statement.at);
            bind(statement.parts[0], item(values, i), false);
            run(statement.blocks[0]);
        }
    }

    void branch(const Statement& statement) {
        for (std::size_t i = 0; i < statement.parts.size(); ++i) {
            if (holds(statement.parts[i])) return run(statement.blocks[i]);
        }
        if (statement.blocks.size() > statement.parts.size()) run(statement.blocks.back());
    }

    /// An expression on its own line. shape.save("name.stl") evaluates to the shape, since Python programs end that
    /// way.
    Value evaluate_saved(const Term& term) {
        const bool saved = term.kind == Kind::postfix && term.parts.back().kind == Kind::method &&
                           term.parts.back().text == "save";
        if (!saved) return evaluate(term);
        const Value value = postfix(term, term.parts.size() - 1);
        if (!std::holds_alternative<Sdf>(value.value)) {
            throw ScriptError(term.parts.back().at, "save: expected a shape before it, got " + describe(value));
        }
        return value;
    }

    /// A shape becomes the script's result until the next one.
    void keep(Position at, const Value& value) {
        if (const Sdf* sdf = std::get_if<Sdf>(&value.value)) result_ = *sdf, result_at_ = at;
    }

    /// Assigns a value or its items to names. Assignments also set the script's result.
    void bind(const Term& target, const Value& value, bool assignment) {
        if (target.kind == Kind::name) {
            names_[target.text] = value;
            if (assignment) keep(target.at, value);
            return;
        }
        const std::size_t count = items(target.at, "assignment", value);
        if (count != target.parts.size()) {
            throw ScriptError(target.at, "expected a value for each of " + std::to_string(target.parts.size()) +
                                             " names, got " + std::to_string(count));
        }
        for (std::size_t i = 0; i < count; ++i) bind(target.parts[i], item(value, i), assignment);
    }

    std::size_t items(Position at, const char* what, const Value& value) {
        std::size_t count = 0;
        this->at(at, [&] { return count = length(what, value), Value{}; });
        return count;
    }

    // ---- Expressions

    Value evaluate(const Term& term) {
        step(term.at);
        switch (term.kind) {
            case Kind::number: return {term.number};
            case Kind::string: return {term.text};
            case Kind::truth: return {term.number != 0};
            case Kind::none: return {None{}};
            case Kind::name: return named(term);
            case Kind::list: return at(term.at, [&] { return make_list(all(term.parts)); });
            case Kind::comprehension: return comprehension(term);
            case Kind::chain: return chain(term);
            case Kind::comparison: return {comparison(term)};
            case Kind::logic: return logic(term);
            case Kind::negative: return at(term.at, [&] { return negative(evaluate(term.parts[0])); });
            case Kind::positive:
                return at(term.at, [&] { return arithmetic(Operator::multiply, {1.0}, evaluate(term.parts[0])); });
            case Kind::logical_not: return {!holds(term.parts[0])};
            case Kind::conditional: return evaluate(term.parts[holds(term.parts[0]) ? 1 : 2]);
            case Kind::call: return call(term);
            case Kind::postfix: return postfix(term, term.parts.size());
            default: throw ScriptError(term.at, "expected a value");  // parts of other terms, which evaluate them
        }
    }

    std::vector<Value> all(const std::vector<Term>& terms) {
        std::vector<Value> values;
        for (const Term& term : terms) values.push_back(evaluate(term));
        return values;
    }

    bool holds(const Term& term) {
        bool result = false;
        const Value value = evaluate(term);
        at(term.at, [&] { return Value{result = truth(value)}; });
        return result;
    }

    Value named(const Term& term) {
        if (const auto found = names_.find(term.text); found != names_.end()) return found->second;
        unknown(term);
    }

    /// Reports why a name that is not a variable is invalid here.
    [[noreturn]] void unknown(const Term& term) const {
        const std::string name(term.text);
        if (const std::string_view hint = advice(name); !hint.empty()) {
            throw ScriptError(term.at, name + ": " + std::string(hint));
        }
        if (module(term)) throw ScriptError(term.at, name + ": expected a word after it, as in ease.in_quad");
        const Word* word = find_word(name, 0);
        if (word && word->kind == Word::Kind::easing) {
            throw ScriptError(term.at, name + ": expected it after ease, as in ease." + name);
        }
        if (word || find_function(name)) needs_arguments(term);
        throw ScriptError(term.at, name + ": expected a word of the language or a name assigned above");
    }

    Value comprehension(const Term& term) {
        std::vector<Value> result;
        std::vector<std::pair<std::string_view, std::optional<Value>>> outer;  // names after `for` belong to the list
        for (std::size_t i = 1; i < term.parts.size(); ++i) remember(term.parts[i].parts[0], outer);
        generate(term, 1, result);
        for (auto& [name, value] : outer) {
            if (value) names_[name] = *std::move(value);
            else names_.erase(name);
        }
        return at(term.at, [&] { return make_list(std::move(result)); });
    }

    template <class Names>
    void remember(const Term& target, Names& names) const {
        for (const Term& part : target.parts) remember(part, names);
        if (target.kind != Kind::name) return;
        const auto found = names_.find(target.text);
        names.emplace_back(target.text, found == names_.end() ? std::nullopt : std::optional(found->second));
    }

    /// Runs the clauses of a list from the given one on. Collects an item for each iteration of the last.
    void generate(const Term& term, std::size_t clause, std::vector<Value>& result) {
        if (clause == term.parts.size()) {
            if (result.size() < ScriptLimits::items) result.push_back(evaluate(term.parts[0]));
            else throw ScriptError(term.at, "expected at most " + std::to_string(ScriptLimits::items) + " items");
            return;
        }
        const std::vector<Term>& parts = term.parts[clause].parts;
        const Value values = evaluate(parts[1]);
        const std::size_t count = items(parts[1].at, "for", values);
        for (std::size_t i = 0; i < count; ++i) {
            step(parts[0].at);
            bind(parts[0], item(values, i), false);
            bool taken = true;
            for (std::size_t j = 2; taken && j < parts.size(); ++j) taken = holds(parts[j]);
            if (taken) generate(term, clause + 1, result);
        }
    }

    Value binary(Position where, Operator op, const Value& a, const Value& b) {
        return at(where, [&]() -> Value {
            const Sdf *first = std::get_if<Sdf>(&a.value), *second = std::get_if<Sdf>(&b.value);
            const bool difference = op == Operator::subtract && (first || second);
            if (op != Operator::unite && op != Operator::intersect && !difference) return arithmetic(op, a, b);
            const char symbol = op == Operator::unite ? '|' : op == Operator::intersect ? '&' : '-';
            if (!first || !second) {
                throw CallError(symbol + (": expected two shapes, got " + describe(a)) + " and " + describe(b));
            }
            charge(where, a), charge(where, b);
            return from_object(combine(symbol, *first, *second));
        });
    }

    Value chain(const Term& term) {
        Value left = evaluate(term.parts[0]);
        for (std::size_t i = 0; i < term.operators.size(); ++i) {
            const Value right = evaluate(term.parts[i + 1]);
            left = binary(term.operators_at[i], term.operators[i], left, right);
        }
        return left;
    }

    bool comparison(const Term& term) {
        Value left = evaluate(term.parts[0]);
        for (std::size_t i = 0; i < term.operators.size(); ++i) {
            Value right = evaluate(term.parts[i + 1]);
            bool result = false;
            at(term.operators_at[i], [&] { return Value{result = compare(term.operators[i], left, right)}; });
            if (!result) return false;
            left = std::move(right);
        }
        return true;
    }

    /// The first operand that decides, as in Python.
    Value logic(const Term& term) {
        const bool any = term.operators[0] == Operator::logical_or;
        for (std::size_t i = 0;; ++i) {
            const Term& part = term.parts[i];
            const Value value = evaluate(part);
            if (i + 1 == term.parts.size()) return value;
            bool result = false;
            at(part.at, [&] { return Value{result = truth(value)}; });
            if (result == any) return value;
        }
    }

    // ---- Calls

    struct Called {
        std::vector<Value> positional;
        std::vector<std::pair<std::string, Value>> keywords;
    };

    Called arguments(const std::vector<Term>& terms) {
        Called called;
        for (const Term& term : terms) {
            if (term.kind == Kind::keyword) {
                called.keywords.emplace_back(term.text, evaluate(term.parts[0]));
            } else if (term.kind == Kind::unpacked) {
                const Value values = evaluate(term.parts[0]);
                const std::size_t count = items(term.at, "*", values);
                step(term.at, count);
                for (std::size_t i = 0; i < count; ++i) called.positional.push_back(item(values, i));
            } else {
                called.positional.push_back(evaluate(term));
            }
        }
        return called;
    }

    /// Calls a word with arguments in the vocabulary's form.
    template <class Callee>
    Value with_objects(Position where, const Called& called, Callee callee) {
        return at(where, [&] {
            std::vector<Object> positional;
            std::vector<Keyword> keywords;
            for (const Value& value : called.positional) charge(where, value), positional.push_back(to_object(value));
            for (const auto& [name, value] : called.keywords) {
                charge(where, value);
                keywords.emplace_back(name, to_object(value));
            }
            return from_object(callee(positional, keywords));
        });
    }

    Value call(const Term& term) {
        if (const auto found = names_.find(term.text); found != names_.end()) {
            throw ScriptError(term.at, std::string(term.text) + ": expected a word to call, got " +
                                           describe(found->second) + " of that name");
        }
        if (const Function* function = find_function(term.text)) return call(term.at, *function, arguments(term.parts));
        const Word* word = find_word(term.text, 0);
        if (!word || word->kind == Word::Kind::easing) unknown(term);
        return call(term.at, *word, arguments(term.parts));
    }

    Value call(Position where, const Word& word, const Called& called) {
        return with_objects(where, called, [&](const auto& positional, const auto& keywords) {
            return bob::call(word, positional, keywords);
        });
    }

    Value call(Position where, const Function& function, const Called& called) {
        return at(where, [&] {
            const std::string name(function.name);
            if (!called.keywords.empty()) throw CallError(name + ": expected arguments without names");
            const std::size_t count = called.positional.size();
            if (count < function.least || count > function.most) {
                throw CallError(name + ": expected " + arguments_of(function) + ", got " + std::to_string(count));
            }
            for (const Value& value : called.positional) charge(where, value);
            return function.call(function.name, called.positional);
        });
    }

    /// The number of arguments of a function, as text.
    static std::string arguments_of(const Function& function) {
        if (function.most == 1) return "1 argument";
        if (function.most == function.least) return std::to_string(function.most) + " arguments";
        const bool any = function.most == ScriptLimits::items;
        const std::string most = any ? " or more" : " to " + std::to_string(function.most);
        return std::to_string(function.least) + most + " arguments";
    }

    /// A value with the first `count` - 1 of its methods and indices.
    Value postfix(const Term& term, std::size_t count) {
        std::size_t i = 1;
        const Term& base = term.parts[0];
        const std::optional<int> dimensions = i < count ? module(base) : std::nullopt;
        Value value = dimensions ? word_of(*dimensions, base, term.parts[i++]) : evaluate(base);
        for (; i < count; ++i) value = follow(value, term.parts[i]);
        return value;
    }

    /// The dimensions of the words of a Python module of words, 0 for easings.
    std::optional<int> module(const Term& term) const {
        if (term.kind != Kind::name || names_.contains(term.text)) return std::nullopt;
        if (term.text == "ease") return 0;
        if (term.text == "d2") return 2;
        if (term.text == "d3") return 3;
        return std::nullopt;
    }

    Value word_of(int dimensions, const Term& module, const Term& part) {
        const Word* word = part.kind == Kind::index ? nullptr : find_word(part.text, dimensions);
        if (!word || word->dimensions != dimensions) {
            throw ScriptError(part.at, "expected a word of " + std::string(module.text));
        }
        if (part.kind == Kind::attribute && dimensions > 0) needs_arguments(part);
        return call(part.at, *word, arguments(part.parts));  // an easing without arguments is the easing itself
    }

    [[noreturn]] static void needs_arguments(const Term& term) {
        const std::string name(term.text);
        throw ScriptError(term.at, name + ": expected it with arguments, as in " + name + "(...)");
    }

    Value follow(const Value& value, const Term& part) {
        step(part.at);
        if (part.kind == Kind::index) {
            const Value index = evaluate(part.parts[0]);
            return at(part.at, [&] { return element(value, index); });
        }
        const std::string name(part.text);
        const Sdf* sdf = std::get_if<Sdf>(&value.value);
        if (!sdf) throw ScriptError(part.at, name + ": expected a shape before it, got " + describe(value));
        if (part.kind == Kind::attribute) needs_arguments(part);
        if (name == "save") throw ScriptError(part.at, "save: expected it at the end of its own line");
        const Called called = arguments(part.parts);
        charge(part.at, value);
        return with_objects(part.at, called, [&](const auto& positional, const auto& keywords) {
            return call_method(*sdf, name, positional, keywords);
        });
    }

    std::unordered_map<std::string_view, Value> names_;
    std::size_t steps_ = 0;
    std::size_t nodes_ = 0;
    std::optional<Sdf> result_;
    Position result_at_;
    Position last_;  // of the last statement run
};

}  // namespace
}  // namespace script

Sdf run_script(std::string_view source) {
    const std::vector<script::Statement> statements = script::parse(source);
    script::Interpreter interpreter;
    interpreter.run(statements);
    return interpreter.result();
}

}  // namespace bob
