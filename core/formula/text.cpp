#include "formula/text.h"

#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

namespace bob {
namespace {

constexpr int max_depth = 40;

/// Operator precedence; an operand of lower precedence needs brackets.
enum Binding { sum, product, sign, exponent, atom };

class Writer {
public:
    Writer(const std::vector<Node>& nodes, std::size_t length) : nodes_(nodes), length_(length) {}

    std::string operator()() && {
        write(static_cast<std::uint32_t>(nodes_.size() - 1), sum, 0);
        if (text_.size() > length_) text_.replace(length_ < 3 ? 0 : length_ - 3, std::string::npos, "...");
        return std::move(text_);
    }

private:
    void write(std::uint32_t index, Binding around, int depth) {
        if (text_.size() > length_) return;
        if (depth > max_depth) {
            text_ += "...";
            return;
        }
        const Node& node = nodes_[index];
        const Binding binding = binds(node);
        if (binding < around) text_ += '(';
        const auto operand = [&](int k, Binding least) { write(node.operand[k], least, depth + 1); };
        // Operators are left-associative; a right operand of equal precedence needs brackets.
        const auto infix = [&](const char* op) {
            operand(0, binding);
            text_ += op;
            operand(1, static_cast<Binding>(binding + 1));
        };
        switch (node.op) {
            case Op::constant: number(node.value); break;
            case Op::negate: text_ += '-', operand(0, sign); break;
            case Op::square: operand(0, atom), text_ += "**2"; break;
            case Op::power: operand(0, atom), text_ += "**", number(node.value); break;
            case Op::add:
                if (nodes_[node.operand[1]].op == Op::constant && nodes_[node.operand[1]].value < 0) {
                    operand(0, sum), text_ += " - ", number(-nodes_[node.operand[1]].value);
                } else {
                    infix(" + ");
                }
                break;
            case Op::subtract: infix(" - "); break;
            case Op::multiply: infix(" * "); break;
            case Op::divide: infix(" / "); break;
            case Op::modulo: infix(" % "); break;
            case Op::select:
                text_ += "where(", operand(0, sum), text_ += " < 0, ", operand(1, sum), text_ += ", ";
                operand(2, sum), text_ += ')';
                break;
            default:
                text_ += name(node.op);
                for (int k = 0; k < operands(node.op); ++k) text_ += k ? ", " : "(", operand(k, sum);
                if (operands(node.op)) text_ += ')';
        }
        if (binding < around) text_ += ')';
    }

    static Binding binds(const Node& node) {
        switch (node.op) {
            case Op::add:
            case Op::subtract: return sum;
            case Op::multiply:
            case Op::divide:
            case Op::modulo: return product;
            case Op::negate: return sign;
            case Op::constant: return std::signbit(node.value) ? sign : atom;
            case Op::square:
            case Op::power: return exponent;
            default: return atom;
        }
    }

    void number(double value) {
        char digits[32];
        text_.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
    }

    const std::vector<Node>& nodes_;
    std::size_t length_;
    std::string text_;
};

}  // namespace

std::string to_text(const Expression& expression, std::size_t length) {
    return Writer(expression.nodes(), length)();
}

}  // namespace bob
