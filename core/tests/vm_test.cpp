#include "formula/vm.h"

#include <cmath>
#include <cstring>
#include <string>

#include "check.h"
#include "shapes/implicit/vm_solid.h"

namespace {

/// The value at (1.5, -2, 3) of the operation that `text` puts to x, y and z.
double value(const std::string& text) {
    return bob::parse_vm("x var-x\ny var-y\nz var-z\nzero const 0\n" + text)(1.5, -2, 3);
}

/// Holds if the text is refused with a message that starts so.
bool fails(const std::string& text, const char* message) {
    try {
        (void)bob::parse_vm(text);
    } catch (const bob::VmError& error) {
        const std::string what = error.what();
        if (what.starts_with(message) && what.find('\n') == std::string::npos) return true;
        test::fail(__FILE__, __LINE__, what);
    }
    return false;
}

}  // namespace

TEST(vm_operations) {
    CHECK_EQ(value("f const -0.25"), -0.25);
    CHECK_EQ(value("f const 1e3"), 1000);
    CHECK_EQ(value("f neg x"), -1.5);
    CHECK_EQ(value("f abs y"), 2);
    CHECK_EQ(value("f recip y"), -0.5);
    CHECK_NEAR(value("f sqrt z"), std::sqrt(3.0), 1e-15);
    CHECK_EQ(value("f square x"), 2.25);
    CHECK_NEAR(value("f sin x"), std::sin(1.5), 1e-15);
    CHECK_NEAR(value("f cos x"), std::cos(1.5), 1e-15);
    CHECK_NEAR(value("f tan x"), std::tan(1.5), 1e-13);
    CHECK_NEAR(value("h recip z\nf asin h"), std::asin(1 / 3.0), 1e-15);
    CHECK_NEAR(value("h recip z\nf acos h"), std::acos(1 / 3.0), 1e-15);
    CHECK_NEAR(value("f atan y"), std::atan(-2.0), 1e-15);
    CHECK_NEAR(value("f exp y"), std::exp(-2.0), 1e-15);
    CHECK_NEAR(value("f ln z"), std::log(3.0), 1e-15);
    CHECK_EQ(value("f floor x"), 1);
    CHECK_EQ(value("f ceil x"), 2);
    CHECK_EQ(value("f add x y"), -0.5);
    CHECK_EQ(value("f sub x y"), 3.5);
    CHECK_EQ(value("f mul x y"), -3);
    CHECK_EQ(value("f div z x"), 2);
    CHECK_EQ(value("f min x y"), -2);
    CHECK_EQ(value("f max x y"), 1.5);
    CHECK_NEAR(value("f atan2 y x"), std::atan2(-2.0, 1.5), 1e-15);
}

TEST(vm_operations_without_an_op_of_ours) {
    // Halves go away from zero.
    CHECK_EQ(value("f round x"), 2);
    CHECK_EQ(value("h const 2.5\nf round h"), 3);
    CHECK_EQ(value("h const -2.5\nf round h"), -3);
    CHECK_EQ(value("h const -2.4\nf round h"), -2);
    // The remainder is never negative.
    CHECK_EQ(value("f mod y x"), 1);
    CHECK_EQ(value("f mod z y"), 1);
    CHECK_EQ(value("m neg z\nf mod m y"), 1);
    CHECK_EQ(value("f compare x y"), 1);
    CHECK_EQ(value("f compare y x"), -1);
    CHECK_EQ(value("f compare x x"), 0);
    CHECK_EQ(value("f not x"), 0);
    CHECK_EQ(value("f not zero"), 1);
    CHECK_EQ(value("f and x y"), -2);
    CHECK_EQ(value("f and zero y"), 0);
    CHECK_EQ(value("f or y x"), -2);
    CHECK_EQ(value("f or zero x"), 1.5);
}

TEST(vm_lines) {
    CHECK_EQ(value("\n  # a comment\n\t f\tadd  x x \r\n\n"), 3);
    CHECK_EQ(value("f add x y\nf add f f"), -1);  // the latest line of a name
    CHECK_EQ(bob::parse_vm("\xef\xbb\xbf_0 var-y")(1, 2, 3), 2);
    CHECK_EQ(bob::parse_vm("x var-x\nunused square x\ny var-y").nodes().size(), std::size_t{1});
}

TEST(vm_errors) {
    CHECK(fails("", "line 1: expected a formula"));
    CHECK(fails("# nothing\n", "line 1: expected a formula"));
    CHECK(fails("x var-x\nf add x y\n", "line 2: expected a name of a line above, got 'y'"));
    CHECK(fails("x var-x\n\nf add x", "line 3: expected a name of a line above, got nothing"));
    CHECK(fails("x var-x\nf neg x x", "line 2: expected the end of the line after 'neg', got 'x'"));
    CHECK(fails("x", "line 1: expected an operation such as add, max or var-x, got nothing"));
    CHECK(fails("x rand", "line 1: expected an operation such as add, max or var-x, got 'rand'"));
    CHECK(fails("x const", "line 1: expected a number, got nothing"));
    CHECK(fails("x const 1e999", "line 1: expected a number, got '1e999'"));
    CHECK(fails("x const nan", "line 1: expected a number, got 'nan'"));
    CHECK(fails("x const 1,5", "line 1: expected a number, got '1,5'"));
    CHECK(fails("x var-x\nf \xff\x01\n", "line 2: expected an operation such as add, max or var-x, got '?\?'"));
    CHECK(fails("f neg f", "line 1: expected a name of a line above, got 'f'"));
}

TEST(vm_random_texts) {
    // Words of the language in random order, then random bytes put in: a formula or an error, nothing else.
    constexpr const char* words[] = {"x",   "y",    "var-x", "var-z", "const", "0.5",   "-inf", "1e308", "add", "mul",
                                     "neg", "sqrt", "mod",   "round", "and",   "atan2", "exp",  "\n",    "\n",  "#"};
    test::Random random(5);
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random(0, static_cast<float>(n))) % n; };
    int formulas = 0;
    for (int round = 0; round < 20000; ++round) {
        std::string text;
        if (random() < 0.7F) text = "x var-x\ny const 0.5\n";
        for (std::size_t i = 0, n = below(12); i < n; ++i) {
            text += words[below(std::size(words))];
            text += ' ';
            if (i % 4 == 3) text += '\n';
        }
        for (std::size_t i = 0, n = below(3); i < n && random() < 0.3F && !text.empty(); ++i) {
            text[below(text.size())] = static_cast<char>(below(256));
        }
        try {
            const bob::Expression formula = bob::parse_vm(text);
            (void)formula(0.1, 0.2, 0.3);
            ++formulas;
        } catch (const bob::VmError& error) {
            CHECK(!std::strchr(error.what(), '\n'));
        }
    }
    CHECK_LT(1000, formulas);
}

TEST(vm_solids_are_whole_where_they_end_and_cut_where_they_do_not) {
    const auto solid = [](const std::string& text) {
        return bob::vm_solid(bob::parse_vm("x var-x\ny var-y\nz var-z\na square x\nb square y\nc square z\nd add a b\n" + text));
    };
    const bob::VmSolid ball = solid("e add d c\nr const 9\nf sub e r\n");
    CHECK(!ball.cut && ball.bounds.has_value());
    CHECK(ball.bounds->low[0] <= -3 && ball.bounds->low[0] > -3.5);
    const bob::VmSolid cylinder = solid("r mul c z\nf add d r\n");
    CHECK(cylinder.cut);
    CHECK_EQ(cylinder.bounds->low[2], -1.);
    CHECK_EQ(cylinder.bounds->high[0], 1.);
    CHECK(!solid("e add d c\nr const 9\nf add e r\n").bounds.has_value());
    const bob::VmSolid flat = solid("r const 0.25\nf sub d r\n");
    CHECK(flat.cut);
    CHECK_EQ(flat.bounds->high[2], 0.1);
    CHECK_EQ(flat.formula(0.5, 0, 0.05), 0.);
    CHECK_EQ(flat.formula(0, 0, 0.06), 0.06 - 0.05);
    CHECK_EQ(flat.formula(0, 0, 0), -0.05);
}
