// Heightmaps by libfive, for bench/libfive.py: `libfive SIZE FILE` draws a .vm file's formula for each line of its input, seen
// along -z in the cube -1..1, SIZE pixels and steps of depth along each axis, on one thread; and answers with how many
// pixels show the surface.

#include <immintrin.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include <libfive/eval/evaluator.hpp>
#include <libfive/render/discrete/heightmap.hpp>
#include <libfive/tree/tree.hpp>

// Intervals set the rounding mode for each operation, which takes two thirds of the time in glibc. These set SSE's alone, which
// is all that floats need, and are several times faster: the rival is spared the rest.
extern "C" int fesetround(int mode) noexcept {
    _mm_setcsr((_mm_getcsr() & ~0x6000u) | static_cast<unsigned>(mode) << 3);
    return 0;
}
extern "C" int fegetround() noexcept { return static_cast<int>(_mm_getcsr() >> 3 & 0xc00u); }

namespace {

using libfive::Tree;

Tree unary(const std::string& op, const Tree& a) {
    if (op == "neg") return -a;
    if (op == "abs") return abs(a);
    if (op == "square") return square(a);
    if (op == "sqrt") return sqrt(a);
    if (op == "sin") return sin(a);
    if (op == "cos") return cos(a);
    if (op == "exp") return exp(a);
    if (op == "ln") return log(a);
    throw std::runtime_error("unknown operation " + op);
}

Tree binary(const std::string& op, const Tree& a, const Tree& b) {
    if (op == "add") return a + b;
    if (op == "sub") return a - b;
    if (op == "mul") return a * b;
    if (op == "div") return a / b;
    if (op == "min") return min(a, b);
    if (op == "max") return max(a, b);
    throw std::runtime_error("unknown operation " + op);
}

/// A formula of a .vm file.
Tree read(const char* path) {
    std::ifstream file(path);
    std::map<std::string, Tree> named;
    Tree last = Tree(0.f);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string name, op, a, b;
        if (line.empty() || line[0] == '#') continue;
        words >> name >> op >> a >> b;
        last = op == "var-x"   ? Tree::X()
               : op == "var-y" ? Tree::Y()
               : op == "var-z" ? Tree::Z()
               : op == "const" ? Tree(std::stof(a))
               : b.empty()     ? unary(op, named.at(a))
                               : binary(op, named.at(a), named.at(b));
        named.insert_or_assign(name, last);
    }
    return last;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    const float size = std::stof(argv[1]);
    const Tree formula = read(argv[2]).optimized();
    const libfive::Voxels cube({-1, -1, -1}, {1, 1, 1}, size / 2);
    const std::atomic_bool abort{false};
    while (std::getchar() != EOF) {
        const auto picture = libfive::Heightmap::render(formula, cube, abort, 1);
        std::printf("%ld\n", static_cast<long>((picture->depth > -2.f).count()));
        std::fflush(stdout);
    }
}
