/// Jumps taken out of formulas: the same signs within the box, and nothing that jumps but the selects outside.
#include "formula/jumps.h"

#include "formula/text.h"
#include "formulas.h"

namespace {

using bob::BoxBatch;
using bob::Op;
using bob::Value;
using test::estimate;
using test::Point;
using test::Random;

/// A box in the first lane.
BoxBatch random_box(Random& random, float size) {
    BoxBatch box{};
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis][0] = random(-1, 1);
        box.high[axis][0] = box.low[axis][0] + random() * size;
    }
    return box;
}

Point random_point(Random& random, const BoxBatch& box) {
    Point p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = random(box.low[axis][0], box.high[axis][0]);
    return p;
}

/// A ball in the middle of something that jumps, as repeated and turned shapes do.
bob::Expression jumping(Random& random) {
    bob::Graph g;
    const Value axes[3] = {g.x(), g.y(), g.z()};
    const auto axis = [&] { return axes[test::pick(random, 3)]; };
    Value p[3] = {g.x(), g.y(), g.z()};
    for (int i = 0; i < 1 + static_cast<int>(test::pick(random, 3)); ++i) {
        const double period = random(0.3f, 1.5f);
        Value& to = p[test::pick(random, 3)];
        const Value from = axis() * random(-2, 2), shifted = from + random(-1, 1), scaled = shifted * (1 / period);
        switch (test::pick(random, 6)) {
            case 0: to = shifted - floor(scaled) * period; break;
            case 1: to = shifted - ceil(scaled) * period; break;
            case 2: to = shifted - round(scaled) * period; break;
            case 3: {
                const Value sum = axis() + random(-1, 1), turned = atan2(shifted, sum);
                to = turned * random(0.2f, 1);
                break;
            }
            case 4: {
                const Value is_beside = shifted * random(-2, 2), size = abs(shifted), half = max(is_beside, 0.);
                const Value one = size + half, other = axis() * 0.5 - abs(is_beside);
                to = select(is_beside, one, other);
                break;
            }
            default: {
                const Value limit = min(axis(), shifted);
                to = select(limit, shifted, axis() * 0.7);
            }
        }
    }
    const Value x = square(p[0]), y = square(p[1]), xy = x + y;
    const Value ball = sqrt(xy + square(p[2])) - random(0.1f, 1);
    const Value sheet = abs(axis()) - random(0.1f, 0.5f);
    return g.expression(random() < 0.5f ? max(ball, sheet) : min(ball, sheet));
}

/// How many decisions of a formula may jump, without the selects that it is one of.
int inner_jumps(const bob::Expression& f) {
    std::vector<bool> is_outside(f.nodes().size(), false);
    is_outside.back() = true;
    int count = 0;
    for (std::size_t i = f.nodes().size(); i-- > 0;) {
        const bob::Node& node = f.nodes()[i];
        if (is_outside[i] && node.op == Op::select) {
            is_outside[node.operand[1]] = is_outside[node.operand[2]] = true;
        } else {
            count += bob::is_rounding(node.op);
        }
    }
    return count;
}

}  // namespace

TEST(formulas_with_jumps_outside_have_the_same_signs) {
    test::for_each_isa([] {
        Random random(11);
        int taken_out = 0, constant = 0, refused = 0, judged = 0, inner = 0;
        for (int i = 0; i < 4000; ++i) {
            const bob::Expression f = bob::without_modulo(random() < 0.8f ? jumping(random) : test::random_formula(random));
            const BoxBatch box = random_box(random, std::array{0.02f, 0.2f, 1.f}[test::pick(random, 3)]);
            bob::Work work(1'000'000'000);
            const bob::Tape tape(f);
            const auto apart = with_jumps_outside(tape, box, work);
            CHECK(work.spent() > 0);
            if (!apart) {
                ++refused;
                continue;
            }
            const bool is_constant = apart->nodes().back().op == Op::constant;
            (is_constant ? constant : taken_out) += 1;
            inner += inner_jumps(*apart);  // the value of a side whose sign is known stays
            for (int k = 0; k < 16; ++k) {
                const Point p = random_point(random, box);
                const auto [expected, error] = estimate(f, p);
                const auto [got, error_of_it] = estimate(*apart, p);
                if (std::isnan(expected) || !(std::fabs(expected) > 2 * error + (is_constant ? 0 : 2 * error_of_it))) continue;
                ++judged;
                if ((expected < 0) != (got < 0)) {
                    std::ostringstream text;
                    text << expected << " became " << got << " at " << p[0] << ", " << p[1] << ", " << p[2] << " of "
                         << to_text(f) << ", now " << to_text(*apart);
                    test::fail(__FILE__, __LINE__, text.str());
                }
            }
        }
        CHECK_LT(300, taken_out);
        CHECK_LT(1000, constant);
        CHECK_LT(30, refused);
        CHECK_LT(20000, judged);
        CHECK_LT(20 * inner, taken_out);
    });
}

TEST(what_a_side_of_a_jump_knows_is_used) {
    // |x - 0.5| and the halves of select(x - 0.5, ...) need not be asked on either side; the number of a cell is known.
    bob::Graph g;
    const Value from = g.x() - 0.5, size = abs(from), half = max(from, 0.);
    const Value sum = size + half, chosen = select(from, sum, -sum), cell = g.y() - floor(g.y());
    const Value inside = chosen + cell * 0.1;
    BoxBatch box{};
    box.low[0][0] = 0.4f, box.high[0][0] = 0.6f, box.low[1][0] = 0.9f, box.high[1][0] = 1.1f;
    bob::Work work(1'000'000);
    const auto apart = with_jumps_outside(bob::Tape(g.expression(inside - 0.05)), box, work);
    CHECK(apart.has_value());
    CHECK(!apart->uses(Op::absolute));
    CHECK(!apart->uses(Op::maximum));
    CHECK(!apart->uses(Op::floor));
}

TEST(what_boxes_decide_is_no_jump_where_a_formula_is_partly_no_number) {
    // floor(z) is one number in the box, and the root is NaN in part of the box.
    bob::Graph g;
    const Value cell = g.y() - floor(g.y()), root = sqrt(g.x()) * 0.1 - 0.05, shift = floor(g.z()) * 0.1, sum = cell * 0.1 + shift;
    BoxBatch box{};
    box.low[0][0] = -0.1f, box.high[0][0] = 1, box.low[1][0] = 0.9f, box.high[1][0] = 1.1f, box.low[2][0] = 0.2f, box.high[2][0] = 0.4f;
    bob::Work work(1'000'000);
    const auto apart = with_jumps_outside(bob::Tape(g.expression(max(root, sum - 0.08))), box, work);
    CHECK(apart.has_value());
    for (const Point p : {Point{0.5f, 0.95f, 0.3f}, Point{0.01f, 1.05f, 0.3f}, Point{0.01f, 0.99f, 0.3f}}) {
        const double y = p[1] < 1 ? p[1] : p[1] - 1, expected = std::max(std::sqrt(p[0]) * 0.1 - 0.05, y * 0.1 - 0.08);
        CHECK_EQ((*apart)(p[0], p[1], p[2]) < 0, expected < 0);
    }
    CHECK(std::isnan((*apart)(-0.05, 0.95, 0.3)));
}
