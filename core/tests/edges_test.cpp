#include "shapes/edges.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "check.h"

using namespace bob;

namespace {

constexpr EdgeTolerance tolerance{1e-6, 1e-4};

std::vector<Link> ring(std::size_t count) {
    std::vector<Link> links;
    for (std::uint32_t i = 0; i < count; ++i) links.emplace_back(i, (i + 1) % static_cast<std::uint32_t>(count));
    return links;
}

TEST(a_ring_of_short_segments_is_a_circle) {
    std::vector<Vec3d> points;
    for (int i = 0; i < 24; ++i) points.push_back({1 + 2 * std::cos(i * std::numbers::pi / 12), 3, 2 * std::sin(i * std::numbers::pi / 12)});
    const auto edges = edges_between(points, ring(points.size()), tolerance);
    CHECK(edges.size() == 1);
    CHECK(edges[0].circle.has_value());
    CHECK(!edges[0].begins_at_corner && !edges[0].ends_at_corner && !edges[0].middle);
    CHECK(std::abs(edges[0].circle->radius - 2) < 1e-9);
    const Vec3d center{1, 3, 0};
    CHECK(length(edges[0].circle->center - center) < 1e-9);
    CHECK(std::abs(std::abs(edges[0].circle->axis[1]) - 1) < 1e-9);
}

TEST(rings_of_uneven_segments_are_circles_of_the_least_squares) {
    // Most points lie in a twentieth of the circle, and have errors as of five digits: three of them alone err by 1e-4.
    std::vector<Vec3d> points;
    const auto add = [&](double angle, int i) {
        const double r = 1 + 1e-6 * std::sin(1e3 * i);
        points.push_back({3 + r * std::cos(angle), r * std::sin(angle), 0});
    };
    for (int i = 0; i < 200; ++i) add(0.3 * i / 200, i);
    for (int i = 0; i < 13; ++i) add(0.3 + (2 * std::numbers::pi - 0.3) * i / 13, 200 + i);
    const auto edges = edges_between(points, ring(points.size()), tolerance);
    CHECK(edges.size() == 1 && edges[0].circle.has_value());
    CHECK(std::abs(edges[0].circle->radius - 1) < 1e-6);
    const Vec3d center{3, 0, 0};
    CHECK(length(edges[0].circle->center - center) < 1e-6);
}

TEST(a_slot_has_two_lines_and_two_arcs) {
    std::vector<Vec3d> points;
    for (int i = 0; i <= 12; ++i) points.push_back({2 + std::sin(i * std::numbers::pi / 12), -std::cos(i * std::numbers::pi / 12), 0});
    for (int i = 0; i <= 12; ++i) points.push_back({-2 - std::sin(i * std::numbers::pi / 12), std::cos(i * std::numbers::pi / 12), 0});
    const auto edges = edges_between(points, ring(points.size()), tolerance);
    CHECK(edges.size() == 4);
    int lines = 0, arcs = 0;
    for (const ShapeEdge& edge : edges) {
        CHECK(edge.begins_at_corner && edge.ends_at_corner && edge.middle.has_value());
        if (edge.is_straight) {
            ++lines;
            CHECK(std::abs((*edge.middle)[0]) < 1e-9);
        } else {
            ++arcs;
            CHECK(edge.circle && std::abs(std::abs(edge.circle->center[0]) - 2) < 1e-9);
            CHECK(std::abs(std::abs((*edge.middle)[0]) - 3) < 1e-9);
        }
    }
    CHECK(lines == 2 && arcs == 2);
}

TEST(polygons_have_corners_and_other_curves_have_none) {
    std::vector<Vec3d> hexagon;
    for (int i = 0; i < 6; ++i) hexagon.push_back({std::cos(i * std::numbers::pi / 3), std::sin(i * std::numbers::pi / 3), 0});
    const auto sides = edges_between(hexagon, ring(6), tolerance);
    CHECK(sides.size() == 6);
    for (const ShapeEdge& side : sides) CHECK(side.is_straight && side.begins_at_corner && side.ends_at_corner);
    std::vector<Vec3d> parabola;
    std::vector<Link> links;
    for (std::uint32_t i = 0; i <= 40; ++i) {
        parabola.push_back({i / 40., i * i / 1600., 0});
        if (i > 0) links.emplace_back(i - 1, i);
    }
    const auto curve = edges_between(parabola, links, tolerance);
    CHECK(curve.size() == 1);
    CHECK(!curve[0].circle && !curve[0].is_straight && !curve[0].middle && curve[0].begins_at_corner && curve[0].ends_at_corner);
}

TEST(arcs_of_any_length_have_their_middle) {
    for (const double angle : {0.5, 3.0, std::numbers::pi, 5.0}) {
        std::vector<Vec3d> points;
        for (int i = 0; i <= 8; ++i) points.push_back({std::cos(angle * i / 8), std::sin(angle * i / 8), 1});
        const ShapeEdge edge = edge_through(points, {1e-9, 1e-9});
        CHECK(edge.circle.has_value() && edge.middle.has_value());
        const Vec3d middle{std::cos(angle / 2), std::sin(angle / 2), 1};
        CHECK(length(*edge.middle - middle) < 1e-9);
    }
}

}  // namespace
