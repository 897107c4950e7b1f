/// Distances from meshes against all triangles, and their signs against solid angles.
#include "formula/mesh_distance.h"

#include <numbers>
#include <string_view>

#include "formulas.h"
#include "meshes.h"
#include "shapes/implicit/bounds.h"

namespace {

using bob::MeshDistance;
using bob::Vec3;
using Point = MeshDistance::Point;
using Triangle = MeshDistance::Triangle;
using test::Random;
using test::TriangleMesh;

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point& a) { return std::sqrt(dot(a, a)); }

std::shared_ptr<const MeshDistance> made(const TriangleMesh& mesh) { return MeshDistance::of(mesh.vertices, mesh.triangles); }

void add(TriangleMesh& mesh, const TriangleMesh& other, Vec3 offset) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3 v : other.vertices) mesh.vertices.push_back(v + offset);
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
}

TriangleMesh inside_out(TriangleMesh mesh) {
    for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
    return mesh;
}

/// Of coordinates such as CAD has, so that much is parallel and in line.
TriangleMesh box(Vec3 low, Vec3 high) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) mesh.vertices.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// A sphere with spikes and dents: saddles, and edges of all angles.
TriangleMesh spiky(int levels, float roughness) {
    Random random(7);
    TriangleMesh mesh = test::sphere(levels, 0.55f);
    for (Vec3& v : mesh.vertices) v = (1 + random(-roughness, roughness)) * v;
    return mesh;
}

/// Closed meshes, each with a difficulty.
std::vector<std::pair<const char*, TriangleMesh>> meshes() {
    std::vector<std::pair<const char*, TriangleMesh>> result{
        {"octahedron", test::sphere(0, 1)}, {"sphere", test::sphere(3, 0.8f)},       {"box", box({-1, -0.5f, -0.25f}, {1, 0.5f, 0.75f})},
        {"spiky", spiky(3, 0.7f)},          {"inside out", inside_out(spiky(2, 0.3f))}, {"thin", box({-1, -1, 0}, {1, 1, 1e-4f})},
    };
    TriangleMesh overlapping = test::sphere(2, 0.5f);
    add(overlapping, test::sphere(2, 0.5f), {0.4f, 0.1f, 0});
    add(overlapping, box({-0.1f, -0.1f, -0.9f}, {0.1f, 0.1f, 0.9f}), {});
    result.emplace_back("overlapping", overlapping);
    TriangleMesh hollow = test::sphere(2, 0.9f);
    add(hollow, inside_out(test::sphere(2, 0.5f)), {0.1f, 0, 0});
    result.emplace_back("hollow", hollow);
    TriangleMesh along_edge = box({-1, -1, 0}, {0, 0, 1});
    add(along_edge, box({0, 0, 0}, {1, 1, 1}), {});
    result.emplace_back("along an edge", along_edge);
    TriangleMesh stacked = box({-1, -1, -1}, {1, 1, 0});
    add(stacked, box({-0.25f, -0.5f, 0}, {0.5f, 0.25f, 0.5f}), {});
    result.emplace_back("stacked", stacked);
    return result;
}

/// Where the three edges do not hold it back, the distance from the plane; else that from the nearest edge.
double distance_to(const std::array<Point, 3>& t, const Point& p) {
    const Point n = cross(t[1] - t[0], t[2] - t[0]);
    bool within = length(n) > 0;
    double nearest = test::infinity;
    for (std::size_t k = 0; k < 3; ++k) {
        const Point edge = t[(k + 1) % 3] - t[k], way = p - t[k];
        within = within && dot(cross(n, edge), way) >= 0;
        const double s = std::clamp(dot(way, edge) / dot(edge, edge), 0., 1.);
        nearest = std::min(nearest, length({way[0] - s * edge[0], way[1] - s * edge[1], way[2] - s * edge[2]}));
    }
    return within ? std::fabs(dot(p - t[0], n)) / length(n) : nearest;
}

/// The distance from all triangles; the sign by the sum of the angles that they fill, seen from p (van Oosterom and Strackee, 1983).
double distance_to_all(const MeshDistance& mesh, const Point& p) {
    double nearest = test::infinity, angles = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<Point, 3> t;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 v = mesh.vertices()[triangle[k]];
            t[k] = {v.x, v.y, v.z};
        }
        nearest = std::min(nearest, distance_to(t, p));
        const Point a = t[0] - p, b = t[1] - p, c = t[2] - p;
        const double la = length(a), lb = length(b), lc = length(c);
        angles += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return std::lround(angles / (4 * std::numbers::pi)) != 0 ? -nearest : nearest;
}

Point random_point(Random& random, float reach) { return {random(-reach, reach), random(-reach, reach), random(-reach, reach)}; }

/// Random points, points close to the surface, and points that share coordinates with vertices.
Point interesting_point(Random& random, const MeshDistance& mesh, int i) {
    if (i % 4 == 0) return random_point(random, i % 8 ? 1.5f : 20.f);
    const auto some_vertex = [&] { return mesh.vertices()[test::pick(random, mesh.vertices().size())]; };
    if (i % 4 == 1) return {some_vertex().x, some_vertex().y, some_vertex().z};
    const Triangle& t = mesh.triangles()[test::pick(random, mesh.triangles().size())];
    const float u = random(), v = (1 - u) * random(), aside = i % 4 == 2 ? 0.1f : 1e-4f;
    Point p;
    for (int axis = 0; axis < 3; ++axis) {
        const float a = mesh.vertices()[t[0]][axis], b = mesh.vertices()[t[1]][axis], c = mesh.vertices()[t[2]][axis];
        p[static_cast<std::size_t>(axis)] = a + u * (b - a) + v * (c - a) + random(-aside, aside);
    }
    return p;
}

std::string refusal(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
    try {
        (void)MeshDistance::of(vertices, triangles);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST(distances_from_meshes_match_all_triangles_and_solid_angles) {
    for (const auto& [name, triangles] : meshes()) {
        const auto mesh = made(triangles);
        Random random(1);
        MeshDistance::Known known;
        int wrong = 0;
        for (int i = 0; i < 2000; ++i) {
            const Point p = interesting_point(random, *mesh, i);
            const double want = distance_to_all(*mesh, p), got = (*mesh)(p, known), alone = (*mesh)(p);
            // On the surface itself both signs are right.
            const bool same_side = std::fabs(want) < 1e-7 || (want < 0) == (got < 0);
            wrong += !(same_side && std::fabs(std::fabs(want) - std::fabs(got)) <= 1e-10 * (1 + std::fabs(want)));
            wrong += std::fabs(alone - got) > 1e-10 * (1 + std::fabs(got));
        }
        if (wrong) test::fail(__FILE__, __LINE__, std::string(name) + ": " + std::to_string(wrong) + " distances are others");
    }
}

TEST(distances_from_meshes_grow_no_faster_than_the_way) {
    for (const auto& [name, triangles] : meshes()) {
        const auto mesh = made(triangles);
        Random random(2);
        int steeper = 0;
        for (int i = 0; i < 2000; ++i) {
            const Point p = interesting_point(random, *mesh, i), q = interesting_point(random, *mesh, i + 1);
            steeper += std::fabs((*mesh)(p) - (*mesh)(q)) > length(p - q) + 1e-9;
        }
        if (steeper) test::fail(__FILE__, __LINE__, std::string(name) + ": " + std::to_string(steeper) + " pairs are too far apart");
    }
}

TEST(gradients_of_mesh_distances_are_slopes_and_within_their_bounds) {
    int bounded = 0, all = 0;
    for (const auto& [name, triangles] : meshes()) {
        const auto mesh = made(triangles);
        Random random(3);
        int wrong = 0;
        for (int i = 0; i < 1000; ++i) {
            const Point center = interesting_point(random, *mesh, i);
            const double radius = std::exp2(random(-12, -1));
            Point low, high;
            const bool known = mesh->gradients(center, radius, (*mesh)(center), low, high);
            ++all, bounded += known;
            for (int sample = 0; sample < 20; ++sample) {
                const Point way = random_point(random, static_cast<float>(radius));
                if (length(way) > radius) continue;
                const Point p{center[0] + way[0], center[1] + way[1], center[2] + way[2]};
                MeshDistance::Known nothing;
                Point gradient;
                const double distance = (*mesh)(p, nothing, gradient);
                wrong += std::fabs(length(gradient) - 1) > 1e-6;
                // A step along the gradient is as long as it changes the distance, where it crosses no ridge.
                constexpr double step = 1e-6;
                const double there = (*mesh)({p[0] - step * gradient[0], p[1] - step * gradient[1], p[2] - step * gradient[2]});
                if (distance > 1e-5) wrong += std::fabs(distance - there - step) > 1e-9;
                for (std::size_t axis = 0; axis < 3 && known; ++axis) {
                    wrong += !(gradient[axis] >= low[axis] - 1e-6 && gradient[axis] <= high[axis] + 1e-6);
                }
            }
        }
        if (wrong) test::fail(__FILE__, __LINE__, std::string(name) + ": " + std::to_string(wrong) + " gradients are others");
    }
    CHECK_LT(all * 0.2, bounded);
}

TEST(meshes_are_known_by_their_content) {
    const TriangleMesh sphere = test::sphere(1, 1);
    TriangleMesh apart;  // as STL has it
    for (const auto& t : sphere.triangles) {
        for (const auto corner : t) apart.vertices.push_back(sphere.vertices[corner]);
        const auto n = static_cast<std::uint32_t>(apart.vertices.size());
        apart.triangles.push_back({n - 3, n - 2, n - 1});
    }
    apart.vertices.push_back({9, 9, 9});                               // that no triangle has
    apart.triangles.push_back({0, 0, 1});                              // that is none
    auto mesh = made(sphere);
    CHECK(made(apart) == mesh);
    CHECK_EQ(mesh->vertices().size(), sphere.vertices.size());
    CHECK(made(test::sphere(1, 0.5f)) != mesh);
    const double number = mesh->number();
    CHECK(MeshDistance::numbered(number) == mesh);

    // Only a formula and the formulas made from it keep the mesh alive.
    {
        std::optional<bob::Expression> f;
        {
            bob::Graph graph;
            const bob::Value value = graph.mesh_distance(mesh, graph.x(), graph.y(), graph.z()) - 0.25;
            f = graph.expression(min(value, graph.mesh_distance(mesh, graph.y(), graph.x(), graph.z())));
        }
        mesh.reset();
        CHECK_EQ(f->meshes().size(), 1u);
        const bob::Tape tape(*f);
        const std::vector<float> at_center = test::values(tape, {{0, 0, 0}});
        f.reset();
        CHECK(test::same(test::values(tape, {{0, 0, 0}})[0], at_center[0]));
        const std::vector<bob::Decision> nothing_decided(tape.decisions().size());
        CHECK(tape.specialised(nothing_decided, 0) == tape.expression());
    }
    CHECK(MeshDistance::numbered(number) == nullptr);
    CHECK(std::isnan(evaluate(bob::Op::mesh_distance, number, 0, 0, 0)));
}

TEST(meshes_that_are_not_closed_are_refused) {
    const TriangleMesh sphere = test::sphere(1, 1);
    const auto with = [&](auto change) {
        TriangleMesh mesh = sphere;
        change(mesh);
        return refusal(mesh.vertices, mesh.triangles);
    };
    CHECK(with([](TriangleMesh& mesh) { mesh.triangles.pop_back(); }) == "expected a closed mesh, got one with 3 edges where it is open");
    CHECK(with([](TriangleMesh& mesh) { std::swap(mesh.triangles[0][0], mesh.triangles[0][1]); }) ==
          "expected triangles that all wind the same way, got 3 edges between two that don't");
    CHECK(with([](TriangleMesh& mesh) { mesh.triangles.clear(); }) == "expected a closed mesh, got no triangles");
    CHECK(with([](TriangleMesh& mesh) { mesh.triangles[0][0] = 99; }) == "expected corners among the vertices, got another");
    for (const float off : {1.5f, test::infinity, test::not_a_number}) {
        CHECK(with([&](TriangleMesh& mesh) { mesh.vertices[0].x = off; }) == "expected vertices in -1..1, got another");
    }
}

TEST(meshes_of_any_size_and_place_have_distances_in_their_own_units) {
    const TriangleMesh sphere = test::sphere(4, 1);
    for (const double size : {1e-6, 1., 1e6}) {
        std::vector<Point> vertices;
        for (const Vec3 v : sphere.vertices) vertices.push_back({size * (v.x + 3), size * (v.y - 100), size * v.z});
        const bob::Expression f = bob::distance_to_mesh(vertices, sphere.triangles);
        CHECK_LT(std::fabs(f(3 * size, -100 * size, 0) / size + 1), 0.01);
        CHECK_LT(std::fabs(f(3 * size, -100 * size, 5 * size) / size - 4), 1e-6);
        const auto bounds = bob::find_bounds(f);
        CHECK(bounds.has_value());
        CHECK(bounds && bounds->low[0] <= 2 * size && bounds->low[0] > 1.7 * size && bounds->high[0] >= 4 * size && bounds->high[0] < 4.3 * size);
    }
}
