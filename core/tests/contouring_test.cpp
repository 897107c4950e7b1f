/// Dual contouring: closed meshes of any formula, the same on every instruction set up to rounding, and an end on demand.
#include "shapes/implicit/contouring.h"

#include <map>
#include <stdexcept>
#include <utility>

#include "base/interruption.h"
#include "check.h"

namespace {

using bob::Value;

bob::Implicit surface(Value (*build)(Value, Value, Value)) {
    bob::Graph g;
    return {g.expression(build(g.x(), g.y(), g.z())), bob::Bounds{{-1, -1, -1}, {1, 1, 1}}};
}

/// How many edges are not in one triangle in each direction.
int open_edges(const bob::Triangulation& mesh) {
    std::map<std::pair<std::int32_t, std::int32_t>, int> sides;
    for (const auto& t : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto a = t[i], b = t[(i + 1) % 3];
            sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : 1000;
        }
    }
    int open = 0;
    for (const auto& [edge, count] : sides) open += count != 1001;
    return open;
}

double volume(const bob::Triangulation& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangles) {
        const auto &a = mesh.vertices[static_cast<std::size_t>(t[0])], &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                   &c = mesh.vertices[static_cast<std::size_t>(t[2])];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

Value ball(Value x, Value y, Value z) { return sqrt(square(x) + square(y) + square(z)) - 0.7; }

Value waves(Value x, Value y, Value z) { return sin(31 * x + 3 * y) * cos(29 * y) + sin(37 * z) * cos(23 * x - z); }

TEST(a_ball_has_its_volume) {
    test::for_each_isa([] {
        const bob::Triangulation mesh = bob::dual_contour(surface(ball), 0.03);
        CHECK_EQ(open_edges(mesh), 0);
        CHECK_EQ(mesh.vertices.size() + mesh.triangles.size() - 3 * mesh.triangles.size() / 2, 2u);
        CHECK_NEAR(volume(mesh), 4.0 / 3 * 3.141592653589793 * 0.343, 1e-3);
    });
}

TEST(signs_as_good_as_random_make_closed_meshes) {
    const bob::Implicit wild = surface(waves);
    for (int cells = 3; cells < 40; ++cells) CHECK_EQ(open_edges(bob::dual_contour(wild, 2.0 / cells)), 0);
}

TEST(contouring_says_what_it_does_not_do) {
    bool refused = false;
    try {
        (void)bob::dual_contour(surface(ball), 1e-4);
    } catch (const std::invalid_argument&) {
        refused = true;
    }
    CHECK(refused);
}

TEST(contouring_can_be_stopped) {
    const bob::Implicit shape = surface(ball);
    int asked = 0;
    const bob::KeepGoing keep_going = [&] { return ++asked < 3; };
    const bob::Interruption interruption(keep_going);
    bool stopped = false;
    try {
        (void)bob::dual_contour(shape, 0.004);
    } catch (const bob::Stopped&) {
        stopped = true;
    }
    CHECK(stopped);
}

}  // namespace
