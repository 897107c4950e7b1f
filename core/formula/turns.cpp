#include "formula/turns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

namespace bob {
namespace {

using std::numbers::pi;

/// Sectors for one, two and three turns: 45 degrees at most, so that no sector's bounds contain the axis.
constexpr std::array<std::size_t, 3> sectors_of = {32, 16, 8};

/// Nodes of all formulas together.
constexpr std::size_t max_nodes = 1 << 22;

constexpr std::size_t max_turns = 1 << 10;

/// Overlap of sectors: more than the rounding of sine, cosine and products.
constexpr double overlap = 1e-4;

/// A node cos(angle) u ± sin(angle) v, or its negative; `differ` if the two terms have opposite signs.
struct Sum {
    std::uint32_t node, angle, u, v;
    bool differ;
};

/// The sum that a node is, if it is one.
std::optional<Sum> sum_at(const std::vector<Node>& nodes, std::uint32_t i) {
    const Node& node = nodes[i];
    if (node.op != Op::add && node.op != Op::subtract) return std::nullopt;
    struct Product {
        Op op;
        std::uint32_t angle, other;
    };
    const auto products_at = [&](std::uint32_t at) {
        std::vector<Product> found;
        if (nodes[at].op != Op::multiply) return found;
        for (const int k : {0, 1}) {
            const Node& factor = nodes[nodes[at].operand[k]];
            if (factor.op == Op::cos || factor.op == Op::sin) found.push_back({factor.op, factor.operand[0], nodes[at].operand[1 - k]});
        }
        return found;
    };
    for (const Product& a : products_at(node.operand[0])) {
        for (const Product& b : products_at(node.operand[1])) {
            if (a.angle != b.angle || a.op == b.op) continue;
            const auto [u, v] = a.op == Op::cos ? std::pair(a.other, b.other) : std::pair(b.other, a.other);
            return Sum{i, a.angle, u, v, node.op == Op::subtract};
        }
    }
    return std::nullopt;
}

/// One coordinate that was turned, or both.
struct Turn {
    Sum first;
    std::optional<Sum> second;
};

std::vector<Turn> turns_in(const Expression& f) {
    std::vector<Turn> turns;
    for (std::uint32_t i = 0; i < f.nodes().size(); ++i) {
        const auto sum = sum_at(f.nodes(), i);
        if (!sum) continue;
        if (turns.size() > max_turns) break;
        const auto partner = std::find_if(turns.begin(), turns.end(), [&](const Turn& turn) {
            const Sum& other = turn.first;
            return !turn.second && other.angle == sum->angle && other.u == sum->v && other.v == sum->u && other.differ != sum->differ;
        });
        if (partner != turns.end()) {
            partner->second = sum;
        } else {
            turns.push_back({*sum, std::nullopt});
        }
    }
    return turns;
}

/// Nothing if that takes more than `nodes`, which it reduces by their number.
std::optional<Sectors> sectors_of_one(const Expression& f, std::size_t& nodes) {
    const std::vector<Turn> turns = turns_in(f);
    if (turns.empty()) return Sectors{f};
    if (turns.size() > sectors_of.size()) return std::nullopt;
    const std::size_t sectors = sectors_of[turns.size() - 1];
    std::size_t count = 1;
    for (std::size_t i = 0; i < turns.size(); ++i) count *= sectors;
    if (count * f.nodes().size() > nodes) return std::nullopt;
    nodes -= count * f.nodes().size();

    Sectors result;
    for (std::size_t choice = 0; choice < count; ++choice) {
        Graph graph;
        // A sine of huge angles is -1 to 1 in every box, and two of different ones are apart from each other.
        double shift = 3e18;
        const auto between = [&](double a, double b) {
            const auto [low, high] = std::minmax(a, b);
            const Value any = sin(graph.x() * 1e9 + (shift += 1e18));
            return any * ((high - low) / 2 + overlap) + (low + high) / 2;
        };
        struct Turned {
            std::uint32_t node, u, v;
            Value direction;
        };
        std::vector<Turned> turned;
        std::size_t rest = choice;
        for (const Turn& turn : turns) {
            const double step = 2 * pi / static_cast<double>(sectors);
            const double from = static_cast<double>(rest % sectors) * step, to = from + step;
            rest /= sectors;
            turned.push_back({turn.first.node, turn.first.u, turn.first.v, between(std::cos(from), std::cos(to))});
            if (turn.second) turned.push_back({turn.second->node, turn.first.u, turn.first.v, between(std::sin(from), std::sin(to))});
        }
        std::vector<Value> values;
        values.reserve(f.nodes().size());
        for (std::uint32_t i = 0; i < f.nodes().size(); ++i) {
            const auto found = std::find_if(turned.begin(), turned.end(), [i](const Turned& t) { return t.node == i; });
            if (found != turned.end()) {
                values.push_back(hypot(values[found->u], values[found->v]) * found->direction);
                continue;
            }
            const Node& node = f.nodes()[i];
            Value operand[3];
            for (int k = 0; k < operands(node.op); ++k) operand[k] = values[node.operand[k]];
            values.push_back(graph.like(node, operand));
        }
        result.push_back(graph.expression(values.back()));
    }
    return result;
}

/// The formulas whose minimum f is; f itself if f is no minimum. Nothing where they take too long.
std::vector<Expression> operands_of_minimum(const Expression& f) {
    struct Operand {
        std::uint32_t node;
        double scale, offset;  // of the node, in f
    };
    Graph graph;
    const std::vector<Value> values = graph.rebuild(f, [&](std::uint32_t i, const Value* operand) { return graph.like(f.nodes()[i], operand); });
    std::vector<Operand> open{{static_cast<std::uint32_t>(f.nodes().size() - 1), 1, 0}};
    std::vector<Expression> result;
    while (!open.empty()) {
        const auto [at, scale, offset] = open.back();
        open.pop_back();
        const Node& node = f.nodes()[at];
        const Node& second = f.nodes()[node.operand[1]];
        const double constant = second.op == Op::constant ? second.value : 0;
        if (node.op == Op::minimum) {
            for (const int k : {0, 1}) open.push_back({node.operand[k], scale, offset});
        } else if (node.op == Op::add && constant != 0) {
            open.push_back({node.operand[0], scale, offset + scale * constant});
        } else if (node.op == Op::multiply && constant > 0) {
            open.push_back({node.operand[0], scale * constant, offset});
        } else {
            result.push_back(graph.expression(values[at] * scale + offset));
            if (result.size() * f.nodes().size() > max_nodes) return {};
        }
    }
    return result;
}

}  // namespace

std::vector<Sectors> in_sectors(const Expression& f) {
    const std::vector<Turn> turns = turns_in(f);
    if (turns.empty() || turns.size() > max_turns) return {};
    std::size_t nodes = max_nodes;
    std::vector<Sectors> result;
    if (turns.size() <= 1) {
        if (auto all = sectors_of_one(f, nodes)) result.push_back(std::move(*all));
        return result;
    }
    for (const Expression& part : operands_of_minimum(f)) {
        auto sectors = sectors_of_one(part, nodes);
        if (!sectors) return {};
        result.push_back(std::move(*sectors));
    }
    return result;
}

}  // namespace bob
