/// The same nodes in the same order from every compiler, so that files of formulas are equal wherever they are written.
#include <span>
#include <string>

#include "check.h"
#include "formula/vm.h"
#include "modelling/script.h"
#include "sha256.h"

namespace {

/// SHA-256 of the ops, the operands and the values, as scene files hold them, in hex.
std::string digest(const bob::Expression& f) {
    std::vector<std::uint8_t> ops;
    std::vector<std::uint32_t> operands;
    std::vector<double> values;
    for (const bob::Node& node : f.nodes()) {
        ops.push_back(static_cast<std::uint8_t>(node.op));
        operands.insert(operands.end(), std::begin(node.operand), std::end(node.operand));
        values.push_back(node.value);
    }
    bob::Sha256 hash;
    hash.update(std::as_bytes(std::span(ops))).update(std::as_bytes(std::span(operands))).update(std::as_bytes(std::span(values)));
    std::string text;
    for (const std::uint8_t byte : hash.digest()) text += "0123456789abcdef"[byte >> 4], text += "0123456789abcdef"[byte & 15];
    return text;
}

void check_digest(const char* what, const bob::Expression& f, const std::string& expected) {
    if (const std::string got = digest(f); got != expected) {
        test::fail(__FILE__, __LINE__, std::string(what) + ": expected " + expected + ", got " + got);
    }
}

}  // namespace

TEST(scripts_make_the_same_nodes_with_every_compiler) {
    // Numbers that no library function rounds.
    const struct {
        const char *script, *expected;
    } cases[] = {
        {"pyramid(1)",
         "d7e265cfdbed27f506226e5eff8d360723517d4b783588eb4951298c8d042e0e"},
        {"tetrahedron(1) | torus(1, 0.25)",
         "6809bfdeca744f2f55d4e846ffe7f89ed983fff2769853fa03434016ca280d4f"},
        {"rounded_cylinder(0.5, 0.125, 2) & sphere(1).k(0.25)",
         "c66a20bc9806dad198c900fef16258f6b37a77f320d0090330a95feb159d4d18"},
        {"box(1).twist(0.5) - cylinder(0.5).k(0.125)",
         "e39ddb1878f6ddee53574d4b8821c8413a208d2806e87068b73bd86eb83edce0"},
        {"box(1).bend_radial(0.25, 2, -0.5, ease.in_out_cubic)",
         "94c5a06496969fac967c9631a3b6a0cf133cd89b035a39fa6d348c8a8b5e82d6"},
        {"box(1).transition_linear(sphere(1), e=ease.in_out_quad)",
         "b13281fcfeea61dde5b9bd45cd43f6eccb0fca7ce7085b4677f7976633124787"},
        {"(rounded_rectangle((2, 3), (0.125, 0.25, 0.375, 0.5)) - vesica(1.25, 0.75)).extrude(1)",
         "02fee4bb92a894012a8db7980ec420ea0c95eea61ca49bde463e3ed56c1f4e58"},
        {"rounded_x(1, 0.25).extrude_to(circle(1), 2, ease.in_out_back)",
         "6ca4ebeb1349224e5a48c657e405164bfe5ebea90cfb4596e7177f68c98de616"},
        {"polygon([(0, 0), (4, 0), (4, 3), (1, 1), (0, 3)]).revolve(3)",
         "01930dfd7205ac2e53b750cf1fb8c992986dc8979ee7edc7ba752c07f2f01ae7"},
    };
    for (const auto& [script, expected] : cases) check_digest(script, *bob::run_script(script).expression, expected);
}

TEST(vm_files_make_the_same_nodes_with_every_compiler) {
    check_digest("compare, round, not", bob::parse_vm("x var-x\ny var-y\na compare x y\nb round a\nc not b\nd add c x\n"),
                 "945edfcda51750701c5d55af8398e1d1ca20323d0f22cd936b00cadf9b9d0ad8");
}
