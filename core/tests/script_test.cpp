#include "modelling/script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "check.h"

namespace {

/// Holds if two scripts make equal shapes.
bool same(const std::string& a, const std::string& b) {
    return *bob::run_script(a).expression == *bob::run_script(b).expression;
}

/// The value of an expression of the language.
double value(const std::string& expression) {
    // On the x axis, the plane's value is the number minus x.
    return bob::run_script("f = plane(X, ((" + expression + "), 0, 0))").expression->operator()(0, 0, 0);
}

/// The one-line message that refuses a script.
std::string error(const std::string& source) {
    try {
        (void)bob::run_script(source);
    } catch (const bob::ScriptError& error) {
        CHECK(!std::strpbrk(error.what(), "\r\n"));
        return error.what();
    }
    return "";
}

/// Holds if a script is refused with a message that starts so.
bool fails(const std::string& source, const std::string& start) {
    const std::string got = error(source);
    if (!got.starts_with(start)) test::fail(__FILE__, __LINE__, "expected: " + start + ", got: " + got);
    return got.starts_with(start);
}

const char* const programs[] = {
    // As fogleman/sdf shows itself.
    "f = sphere(1) & box(1.5)\n\nc = cylinder(0.5)\n"
    "f -= c.orient(X) | c.orient(Y) | c.orient(Z)\n\nf.save('out.stl')\n",
    "# a comment\nWIDTH = 12\nn = 5\nf = rounded_box((WIDTH - 0.5, 6, 2), 0.25)\n"
    "for i in range(n):\n    x = (i - (n - 1) / 2) * WIDTH / n\n    f -= cylinder(0.25).translate(X * x).k(0.1)\n"
    "if n % 2 != 0:\n    f = f.translate((WIDTH / 2, 0, 0))\n"
    "elif n > 7 or not n:\n    pass\nelse:\n    f |= sphere(2)\n",
    "points = [(cos(radians(a)), sin(radians(a))) for a in range(0, 360, 60)]\n"
    "f = polygon(points).extrude(1).twist(2 ** -1)\n"
    "f = f.bend_linear(X * 0.75, -X * 2.25, Z * -0.1875, ease.in_out_quad)\n",
    "a, (b, c) = sphere(), (2, [X, Y + Z])\n"
    "f = union(a, *[a.translate(v * b).scale(1.5) for i, v in enumerate(c) if i >= 0], k=0.5) \\\n  .dilate(0.1)\n",
};

}  // namespace

TEST(script_numbers) {
    CHECK_EQ(value("1 + 2 * 3 - 4 / 8"), 6.5);
    CHECK_EQ(value("-2 ** 2 + 2 ** 3 ** 0 + 2 ** -1"), -1.5);
    CHECK_EQ(value("(1 + 2) * 3"), 9);
    CHECK_EQ(value("-7 // 2 + -7 % 3 + 7 % -3"), -4);
    CHECK_EQ(value("-0.5 % 3"), 2.5);
    CHECK_EQ(value("1e-3 * 1_000 + .5 + 5."), 6.5);
    CHECK_NEAR(value("pi + sqrt(2) + sin(1)"), std::numbers::pi + std::sqrt(2.0) + std::sin(1.0), 1e-15);
    CHECK_EQ(value("min(3, 1, 2) + max([4, 6])"), 7);
    CHECK_EQ(value("floor(-1.5) + ceil(1.2) + abs(-4) + int(-2.7) + float(1)"), 3);
    CHECK_EQ(value("round(2.5) + round(3.5) + round(2.675, 2)"), 8.67);
    CHECK_NEAR(value("degrees(pi) + radians(180)"), 180 + std::numbers::pi, 1e-13);
    CHECK_EQ(value("len([1, (2, 3), []]) + sum(range(5)) + sum(range(10, 0, -3))"), 35);
    CHECK_EQ(value("[5, 6, 7][-1] + (1, 2)[0] + (X + 2 * Y)[1] + [[1], [2]][1][0]"), 12);
    CHECK_EQ(value("sum([x * y for x in range(4) if x % 2 for y in (1, 2)])"), 12);
    CHECK_EQ(value("len([1] + [2, 3] * 2 + 2 * (4,))"), 7);
    CHECK_EQ(value("1 if 2 > 3 else 4 if True else 5"), 4);
    CHECK_EQ(value("(3 or 1) + (0 or 2) + (0 and 5) + (4 and 5) + True"), 11);
    CHECK_EQ(value("1 if 1 < 2 <= 2 != 3 and not 3 < 2 < 1/0 else 0"), 1);
    CHECK_EQ(value("1 if None == None and not [] and [0] and 'a' else 0"), 1);
    CHECK_NEAR(value("ease.in_quad(0.5)"), 0.25, 1e-15);
}

TEST(script_vectors) {
    const auto at = [](const std::string& vector) { return "f = sphere(1).translate(" + vector + ")"; };
    CHECK(same(at("X * 2 - Y / 4 + 1"), at("(3, 0.75, 1)")));
    CHECK(same(at("-Z + (1, 2, 3)"), at("[1, 2, 2]")));
    CHECK(same(at("abs(2 ** (X + Y) * -1)"), at("(2, 2, 1)")));
    CHECK(same(at("ORIGIN + UP // 2 - +X"), at("(-1, 0, 0)")));
    CHECK(same(at("sum([X, Y, Z])"), at("(1, 1, 1)")));
    CHECK(fails(at("(1, 2, 3) * 0.5"), "line 1, column 35: *: expected a whole number, got 0.5"));
    CHECK(fails(at("(1, 2, 3) - (1, 2, 3)"), "line 1, column 35: -: expected numbers or vectors, got a list of 3"));
    CHECK(fails(at("X + (1, 2)"), "line 1, column 27: +: expected vectors of one length, got 3 and 2 numbers"));
}

TEST(script_statements) {
    CHECK(same(programs[0], "f = difference(intersection(sphere(1), box(1.5)), union(cylinder(0.5).orient(X), "
                            "cylinder(0.5).orient(Y), cylinder(0.5).orient(Z)))"));
    CHECK(same("f = sphere(1)\nfor i in range(3):\n  for j in 1, 2:\n    f |= sphere(j).translate((i, 0, 0))\n",
               "f = sphere(1)\nfor k in [0, 1, 2]: f |= sphere(1).translate(X * k); f |= sphere(2).translate(X * k);"));
    CHECK(same("n = 7\nn //= 2; n *= 4; n -= 1; n += 2; n /= 2; n **= 2; n %= 5\nsphere(n)", "sphere(2.25)"));
    CHECK(same("r = s = 2\n(a, [b, c]), d = (1, (r, s)), 3\nsphere(a + b + c + d)", "sphere(8)"));
    CHECK(same("x = 3\ny = [x for x in (1, 2)]\nsphere(x)", "sphere(3)"));  // a list's names are its own
    CHECK(same("d2.slab(x0=1).extrude(1) | d3.slab(x0=1)", "x = slab(x0=1)\nd2.slab(x0=1).extrude(1) | x"));
    CHECK(same("circle = 2\nsphere(circle)", "sphere(2)"));                 // words can be names
    CHECK(same("'''A text\nof lines'''\nsphere(1)", "sphere(1)"));
    CHECK(same("sphere(1) | box(1) if 0 else circle(1).extrude(2)", "extrude(circle(1), 2)"));
    CHECK(same("\xef\xbb\xbfif 1:\r\n\tsphere(1)\r\n\r\n# end", "if 1:\r sphere(1)"));
    for (const char* program : programs) CHECK_LT(std::size_t{5}, bob::run_script(program).expression->nodes().size());
}

TEST(script_results) {
    CHECK(same("a = sphere(1)\nb = box(1)\nc = 3", "box(1)"));
    CHECK(same("a = sphere(1)\nb = box(1)\na", "sphere(1)"));
    CHECK(same("a = sphere(1)\nb = box(1)\na.translate(X).save('a.stl', step=0.1)", "sphere(1).translate(X)"));
    CHECK(same("a, b = sphere(1), box(1)\nfor c in [torus(2, 1)]: pass", "box(1)"));
    CHECK(fails("", "line 1, column 1: expected a shape as the script's result, but no line makes one"));
    CHECK(fails("x = 1\ny = [sphere(1)]\n\n", "line 2, column 1: expected a shape as the script's result"));
    CHECK(fails("x = 1\nf = circle(1)", "line 2, column 1: expected a 3D shape as the script's result, got a 2D one"));
}

TEST(script_errors) {
    CHECK(fails("f = sphere(1)\n\n import math", "line 3, column 2: expected no indentation here"));
    CHECK(fails("f = sphere(1)\n\nimport math", "line 3, column 1: import: scripts have every word already"));
    CHECK(fails("from sdf import *", "line 1, column 1: from: scripts have every word already; delete this line"));
    CHECK(fails("def f(x):", "line 1, column 1: def: scripts cannot define functions"));
    CHECK(fails("while True: pass", "line 1, column 1: while: loops are written for i in range(10):"));
    CHECK(fails("f = lambda x: x", "line 1, column 5: lambda: scripts cannot define functions"));
    CHECK(fails("x = math.pi", "line 1, column 5: math: write the name without a module before it"));
    CHECK(fails("open('x')", "line 1, column 1: open: scripts make shapes and nothing else"));
    CHECK(fails("f = spere(1)", "line 1, column 5: spere: expected a word of the language or a name assigned above"));
    CHECK(fails("f = sphere", "line 1, column 5: sphere: expected it with arguments, as in sphere(...)"));
    CHECK(fails("e = in_quad", "line 1, column 5: in_quad: expected it after ease, as in ease.in_quad"));
    CHECK(fails("f = ease", "line 1, column 5: ease: expected a word after it"));
    CHECK(fails("f = ease.box", "line 1, column 10: expected a word of ease"));
    CHECK(fails("f = d2.box(1)", "line 1, column 8: expected a word of d2"));
    CHECK(fails("f = d2.circle", "line 1, column 8: circle: expected it with arguments"));
    CHECK(fails("f = 3\nf(2)", "line 2, column 1: f: expected a word to call, got a number of that name"));
    CHECK(fails("# \xc3\xa9\nx = '\xc3\xa9\xe2\x82\xac' | sphere('a')", "line 2, column 12: sphere: "));
    CHECK(fails("f = sphere(1) | \\\n  box(1).translate(3)", "line 2, column 10: translate: "));
    CHECK(fails("f = sphere(1).nothing(3)", "line 1, column 15: "));
    CHECK(fails("f = sphere(1).k", "line 1, column 15: k: expected it with arguments, as in k(...)"));
    CHECK(fails("x = 3 + box(1)", "line 1, column 7: +: expected numbers or vectors, got a number and a 3D shape"));
    CHECK(fails("x = 3 | box(1)", "line 1, column 7: |: expected two shapes, got a number and a 3D shape"));
    CHECK(fails("x = 1 / 0", "line 1, column 7: /: division by zero"));
    CHECK(fails("x = 10.0 ** 400", "line 1, column 10: **: the result is too large or not a real number"));
    CHECK(fails("x = sqrt(-1)", "line 1, column 5: sqrt: the result is too large or not a real number"));
    CHECK(fails("x = [1][1]", "line 1, column 8: []: expected an index in -1..0, got 1"));
    CHECK(fails("x = 1e400", "line 1, column 5: expected a number that float64 can hold, got '1e400'"));
    CHECK(fails("x = 0x10", "line 1, column 6: expected a decimal number, got 'x' in it"));
    CHECK(fails("x = (1,\n 2]", "line 2, column 3: expected ')', got ']'"));
    CHECK(fails("x = (1,\n 2", "line 1, column 5: this bracket is never closed"));
    CHECK(fails("x = 'abc\ny = 1", "line 1, column 5: this string is never closed"));
    CHECK(fails("x = {1: 2}", "line 1, column 5: expected a word, a number or an operator, got '{'"));
    CHECK(fails("x = \xe2\x82\xac", "line 1, column 5: expected a word, a number or an operator, got U+20AC"));
    CHECK(fails("x = 1 # \xff", "line 1, column 9: expected valid UTF-8"));
    CHECK(fails(std::string("x\0", 2), "line 1, column 2: expected a word, a number or an operator, got U+0000"));
    CHECK(fails("if 1:\n\tx = 1\n        y = 2", "line 3, column 9: expected the same tabs and spaces"));
    CHECK(fails("if 1:\n    x = 1\n  y = 2", "line 3, column 3: expected the indentation of a line above"));
    CHECK(fails("if 1:\nx = 1", "line 2, column 1: expected an indented line, got 'x'"));
    CHECK(fails("x[0] = 1", "line 1, column 1: expected a name to assign to"));
    CHECK(fails("a, b = 1, 2, 3", "line 1, column 1: expected a value for each of 2 names, got 3"));
    CHECK(fails("for i in 3: pass", "line 1, column 10: for: expected a list, got a number"));
    CHECK(fails("x = range(1, 2, 0)", "line 1, column 5: range: expected a step other than 0"));
    CHECK(fails("x = sin(1, 2)", "line 1, column 5: sin: expected 1 argument, got 2"));
    CHECK(fails("x = [1, 2][:1]", "line 1, column 12: expected an index; scripts have no slices, got ':'"));
    CHECK(fails("x = sphere(radius=1, 2)", "line 1, column 22: expected only name=value arguments after the first"));
    CHECK(fails("if sphere(1): pass", "line 1, column 4: expected something true or false, got a 3D shape"));
}

TEST(script_limits) {
    const auto repeat = [](const std::string& text, int times) {
        std::string result;
        for (int i = 0; i < times; ++i) result += text;
        return result;
    };
    CHECK(fails("x = " + repeat("(", 99999), "line 1, column 105: expected less nesting"));
    CHECK(fails("x = " + repeat("[", 99999), "line 1, column 105: expected less nesting"));
    CHECK(fails("x = " + repeat("-", 99999) + "1", "line 1, column "));
    CHECK(fails("x = " + repeat("not ", 99999) + "1", "line 1, column "));
    CHECK(fails("x = 1" + repeat("**1", 99999), "line 1, column "));
    CHECK(fails("x = " + repeat("1 if 1 else ", 9999) + "1", "line 1, column "));
    CHECK(fails(repeat("if 1: ", 9999) + "x = 1", "line 1, column 7: if: "));
    std::string blocks;
    for (int depth = 0; depth < 200; ++depth) blocks += repeat(" ", depth) + "if 1:\n";
    CHECK(fails(blocks, "line 101, column 104: expected less nesting"));
    CHECK(fails(std::string(bob::ScriptLimits::bytes + 1, ' '), "line 1, column 1: expected at most 1048576 bytes"));

    // Long rows nest nothing.
    CHECK(same("x = 1" + repeat(" + 0 * 2", 99999) + "\nsphere(x)", "sphere(1)"));
    CHECK(same("sphere(1)" + repeat(".k()", 9999), "sphere(1)"));
    CHECK(same("if 0: pass\n" + repeat("elif 0: pass\n", 9999) + "else: sphere(1)", "sphere(1)"));

    CHECK(fails("for i in range(9999):\n  for j in range(9999):\n    pass", "line 3, column 5: expected at most 1000"));
    CHECK(fails("x = [1]\nfor i in range(99):\n  x += x", "line 3, column 5: expected at most 100000 items"));
    CHECK(fails("x = [1]\nfor i in range(99):\n  x = [x, x]", "line 3, column 7: expected at most 100000 items"));
    CHECK(fails("x = 1\nfor i in range(999):\n  x = [x]", "line 3, column 7: expected less nesting of lists"));
    CHECK(fails("x = range(10 ** 9)", "line 1, column 5: expected at most 100000 items"));
    CHECK(fails("x = [0] * 10 ** 9", "line 1, column 9: expected at most 100000 items"));
    CHECK(fails("x = 2\nfor i in range(99): x **= 2", "line 2, column 23: **: the result is too large"));
    CHECK(fails("f = sphere(1)\nfor i in range(99999): f |= sphere(i)", "line 2, column "));
    CHECK(fails("f = sphere(1)\nfor i in range(99): f |= f.translate(X * 2 ** i).twist(i)", "line 2, column "));
}

TEST(script_random_texts) {
    // Programs with pieces moved about, words put in and bytes changed: a shape or an error, and soon.
    constexpr const char* words[] = {
        "sphere",  "box",     "union(", "f",        "x",    "i",      "for i in", "range(9)", "if", "else:", "\n",
        "\n    ",  "\n\t",    ":",      "(",        ")",    "[",      "]",        ",",        "=",  "|=",    "+",
        "*",       "**",      "-",      "not",      "and",  "<",      "9",        "1e300",    "0.5", "pi",   "X",
        ".k(1)",   ".shell(", ".twist(", ".repeat(", "'",   "'''",    "#",        "\\\n",     "pass", "*[",  "k=",
        "ease.",   "None",    "save",   "polygon(", "[1]*", "range(", "99999999", ".rotate(", "-1", "circle(", ";",
    };
    test::Random random(3);
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random(0, static_cast<float>(n))) % n; };
    int shapes = 0;
    for (int round = 0; round < 20000; ++round) {
        std::string text = random() < 0.8F ? programs[below(std::size(programs))] : "";
        for (std::size_t i = 0, n = 1 + below(random() < 0.5F ? 2 : 12); i < n; ++i) {
            const std::size_t place = below(text.size() + 1);
            const std::size_t length = std::min(text.size() - place, below(random() < 0.2F ? 40 : 4));
            const float kind = random();
            if (kind < 0.3F) text.erase(place, length);
            else if (kind < 0.5F) text.insert(below(text.size() + 1), text.substr(place, length));
            else if (kind < 0.9F) text.insert(place, words[below(std::size(words))]);
            else if (place < text.size()) text[place] = static_cast<char>(below(256));
        }
        try {
            CHECK_EQ(bob::run_script(text).dimensions, 3);
            ++shapes;
        } catch (const bob::ScriptError& error) {
            CHECK(!std::strpbrk(error.what(), "\r\n"));
        }
    }
    CHECK_LT(500, shapes);
}

TEST(what_is_said_not_to_jump_does_not) {
    // Along many lines, from one of close points to the next no value differs by more than slopes of signed distances allow.
    constexpr const char* shapes[] = {
        "polygon([(-1, -0.8), (1, -0.7), (0.9, 0.6), (-0.8, 0.9)]).extrude(1)",
        "polygon([(-1, -1), (1, -1), (1, 1), (0.1, -0.5), (-0.2, 0.8), (-0.4, -0.2), (-1, 0.7)]).extrude(1)",
        "polygon([(0.4, -1), (1, -1), (1, 1), (0.5, 1), (0.52, 0.2), (0.4, 0.1)]).revolve()",
        "polygon([(-1, -1), (1, 1), (-1, 1), (1, -1)]).extrude(1)",
        "polygon([(cos(0.5 * i) * (0.9 if i % 2 else 0.5), sin(0.5 * i) * (0.9 if i % 2 else 0.5)) for i in range(12)]).extrude(1)",
        "hexagon(0.8).extrude(1)", "vesica(1, 0.4).extrude(1)", "rounded_cone(0.7, 0.3, 0.8)", "rounded_cone(0.2, 0.6, 0.9)",
        "capped_cone(-Z * 0.5, Z * 0.5, 0.9, 0.2)", "capped_cone(-Z * 0.1, Z * 0.1, 1, 0.1)",
        "box((1, 0.8, 0.6)) | cylinder(0.3) & box(1.4)",
    };
    constexpr int steps = 4000;
    std::uint32_t state = 1;
    const auto random = [&] { return static_cast<double>((state = state * 1664525 + 1013904223) >> 8) / (1 << 23) - 1; };
    for (const char* shape : shapes) {
        const bob::Sdf sdf = bob::run_script("f = " + std::string(shape));
        const auto& nodes = sdf.expression->nodes();
        CHECK(std::none_of(nodes.begin(), nodes.end(), [](const bob::Node& n) { return n.op == bob::Op::select && n.value != bob::meets; }));
        CHECK(std::any_of(nodes.begin(), nodes.end(), [](const bob::Node& n) { return n.op == bob::Op::select; }));
        for (int line = 0; line < 25; ++line) {
            double from[3], span[3];
            for (int axis = 0; axis < 3; ++axis) from[axis] = 1.5 * random(), span[axis] = 1.5 * random() - from[axis];
            double before = (*sdf.expression)(from[0], from[1], from[2]);
            const double most = 1.1 / steps * std::sqrt(span[0] * span[0] + span[1] * span[1] + span[2] * span[2]);
            for (int i = 1; i <= steps; ++i) {
                const double t = static_cast<double>(i) / steps;
                const double here = (*sdf.expression)(from[0] + t * span[0], from[1] + t * span[1], from[2] + t * span[2]);
                if (!(std::fabs(here - before) <= most)) {
                    test::fail(__FILE__, __LINE__, std::string(shape) + " jumps by " + std::to_string(here - before) + " to " + std::to_string(here));
                    break;
                }
                before = here;
            }
        }
    }
}

TEST(script_colors) {
    const bob::Sdf sdf = bob::run_script("f = sphere().color('#f00') | box(1).color([0, 0.5, 1]).translate(X)\n");
    CHECK((*sdf.color)(-1, 0, 0) == (std::array{1.0, 0.0, 0.0}));
    CHECK((*sdf.color)(1.5, 0, 0) == (std::array{0.0, 0.5, 1.0}));
    CHECK(*sdf.expression == *bob::run_script("f = sphere() | box(1).translate(X)\n").expression);
    CHECK(bob::run_script("sphere()").color == nullptr);
    CHECK(fails("sphere().color('rot')", "line 1, column 10: color: c: expected #rrggbb, a CSS name or 3 numbers, got \"rot\""));
    CHECK(fails("sphere().color()", "line 1, column 10: color: c: expected #rrggbb, a CSS name or 3 numbers, got nothing"));
    CHECK(fails("f = sphere().color(2 * X)", "line 1, column 14: color: c: expected numbers in 0..1, got (2, 0, 0)"));
}
