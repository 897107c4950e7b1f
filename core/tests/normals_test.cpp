#include "shapes/mesh/normals.h"

#include "check.h"
#include "meshes.h"

namespace {

/// Two quads that share an edge and bend by `degrees` there, stored without shared vertices.
test::TriangleMesh bent(float degrees) {
    const float a = degrees * 3.14159265f / 180;
    const bob::Vec3 low{-1, 0, 0}, low2{-1, 1, 0}, edge{0, 0, 0}, edge2{0, 1, 0};
    const bob::Vec3 high{std::cos(a), 0, std::sin(a)}, high2{std::cos(a), 1, std::sin(a)};
    return {{low, edge, edge2, low, edge2, low2, edge, high, high2, edge, high2, edge2},
            {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}}};
}

std::vector<bob::CornerNormals> creased(const test::TriangleMesh& mesh) {
    return bob::crease_normals(mesh.vertices, mesh.triangles, bob::face_normals(mesh.vertices, mesh.triangles));
}

}  // namespace

TEST(edges_are_smooth_below_the_crease_angle_and_sharp_above) {
    for (const float degrees : {10.f, 39.f, 41.f, 90.f}) {
        const auto mesh = bent(degrees);
        const auto normals = creased(mesh);
        const bob::Vec3 at_edge = normals[0][1], flat{0, 0, 1};
        const float turned = std::acos(std::min(1.f, dot(at_edge, flat))) * 180 / 3.14159265f;
        if (degrees < bob::crease_angle_degrees) {
            CHECK_NEAR(turned, degrees / 2, 0.01f);
            CHECK_NEAR(length(at_edge - normals[2][0]), 0.f, 1e-5f);
        } else {
            CHECK_NEAR(turned, 0.f, 0.03f);
        }
        CHECK_NEAR(length(normals[0][0] - flat), 0.f, 1e-6f);
    }
}

TEST(a_coarse_sphere_is_smooth) {
    const auto mesh = test::sphere(3, 0.5f);
    const auto normals = creased(mesh);
    for (std::size_t i = 0; i < normals.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            CHECK_LT(length(normals[i][c] - normalized(mesh.vertices[mesh.triangles[i][c]])), 0.03f);
        }
    }
}

TEST(stored_normals_win_where_they_are_usable) {
    const auto mesh = bent(20);
    std::vector<bob::Vec3> stored(mesh.vertices.size(), {0, 0, 3});
    stored[1] = {0, 0, 0};
    stored[2] = {std::nanf(""), 0, 0};
    const auto normals = bob::stored_normals(mesh.vertices, mesh.triangles, bob::face_normals(mesh.vertices, mesh.triangles), stored);
    const auto computed = creased(mesh);
    CHECK_EQ(normals[2][1].z, 1.f);
    CHECK_EQ(length(normals[0][1] - computed[0][1]), 0.f);
    CHECK_EQ(length(normals[0][2] - computed[0][2]), 0.f);
}

TEST(faces_without_area_do_not_spoil_their_neighbours) {
    auto mesh = bent(0);
    mesh.triangles.push_back({0, 0, 1});
    const auto normals = creased(mesh);
    for (std::size_t i = 0; i < 4; ++i) CHECK_NEAR(normals[i][0].z, 1.f, 1e-6f);
}

TEST(corners_have_the_mean_of_the_faces_within_the_crease_angle) {
    auto mesh = test::sphere(4, 1);
    test::Random random(1);
    for (bob::Vec3& v : mesh.vertices) v = random(1, random() < 0.2f ? 1.15f : 1.01f) * v;  // smooth here, sharp there
    const auto normals = creased(mesh);
    const float limit = std::cos(bob::crease_angle_degrees * 3.14159265f / 180);
    std::vector<std::vector<std::pair<std::size_t, float>>> faces_at(mesh.vertices.size());  // with their angles there
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const auto& t = mesh.triangles[i];
            const bob::Vec3 p = mesh.vertices[t[c]];
            const bob::Vec3 a = normalized(mesh.vertices[t[(c + 1) % 3]] - p), b = normalized(mesh.vertices[t[(c + 2) % 3]] - p);
            faces_at[t[c]].emplace_back(i, std::acos(dot(a, b)));
        }
    }
    int sharp = 0, smooth = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const bob::Vec3 own = face_normal(mesh.vertices, mesh.triangles[i]);
        for (std::size_t c = 0; c < 3; ++c) {
            bob::Vec3 sum;
            std::size_t count = 0;
            for (const auto& [face, angle] : faces_at[mesh.triangles[i][c]]) {
                const bob::Vec3 normal = face_normal(mesh.vertices, mesh.triangles[face]);
                if (dot(normal, own) > limit) sum = sum + angle * normal, ++count;
            }
            ++(count < faces_at[mesh.triangles[i][c]].size() ? sharp : smooth);
            CHECK_LT(length(normals[i][c] - normalized(sum)), 1e-5f);
        }
    }
    CHECK_LT(100, sharp);
    CHECK_LT(100, smooth);
}
