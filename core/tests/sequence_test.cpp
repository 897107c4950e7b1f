/// The same nodes in the same order from every compiler, so that files of formulas are equal wherever they are written.
#include <span>
#include <string>

#include "base/sha256.h"
#include "check.h"
#include "formula/vm.h"
#include "modelling/script.h"

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
         "da07dc042dafd966f3863619caa8299b4f333547d850ea2440c23f68c37ef6c8"},
        {"box(1).twist(0.5) - cylinder(0.5).k(0.125)",
         "0f1008cd4cda3e918dc8d8386878056e94c87b7da7e57ee60ce24ecd520ea7b9"},
        {"box(1).bend_radial(0.25, 2, -0.5, ease.in_out_cubic)",
         "71dd49e525973b4ef3cfde5a3fbb14e743271b48b4e61603ef77f372e138dc44"},
        {"box(1).transition_linear(sphere(1), e=ease.in_out_quad)",
         "d605155d1f199ddad2d2a087afedda41a3b3eef57e39b0bb1bb8f6308cec3345"},
        {"(rounded_rectangle((2, 3), (0.125, 0.25, 0.375, 0.5)) - vesica(1.25, 0.75)).extrude(1)",
         "eb4e16557ee64804e8f8d8497fc709c99ed2a97736f2c930a0c206bb60da7578"},
        {"rounded_x(1, 0.25).extrude_to(circle(1), 2, ease.in_out_back)",
         "75ab5338f50dfecc45974c18c52330153c15cff80a1728111e1f063277ba1ba8"},
        {"polygon([(0, 0), (4, 0), (4, 3), (1, 1), (0, 3)]).revolve(3)",
         "efde77e36d57eed135e3d288dddb47050a0fa0f3feb2a63aeb5e9f09261410ac"},
    };
    for (const auto& [script, expected] : cases) check_digest(script, *bob::run_script(script).expression, expected);
}

TEST(vm_files_make_the_same_nodes_with_every_compiler) {
    check_digest("compare, round, not", bob::parse_vm("x var-x\ny var-y\na compare x y\nb round a\nc not b\nd add c x\n"),
                 "945edfcda51750701c5d55af8398e1d1ca20323d0f22cd936b00cadf9b9d0ad8");
}
