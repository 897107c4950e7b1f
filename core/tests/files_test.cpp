#include "files/read.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "check.h"
#include "files/polygons.h"

namespace {

using bob::files::Contents;
using bob::files::Numbers;

Contents read(std::string_view format, std::string_view text, std::string_view beside = "") {
    const auto bytes = [](std::string_view own) { return bob::files::Bytes(reinterpret_cast<const std::uint8_t*>(own.data()), own.size()); };
    bob::files::Reading reading(bob::files::reader_of(format), bytes(text));
    while (!reading.go_on().empty()) {
        if (beside.empty()) {
            reading.refuse("none");
        } else {
            reading.give(bytes(beside));
        }
    }
    return std::move(reading.contents());
}

/// The message of a refused file; empty if it is read.
std::string refusal(std::string_view format, std::string_view text) {
    try {
        static_cast<void>(read(format, text));
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return {};
}

/// Of triangles in the plane z = 0, with the sign of their turns.
std::array<double, 2> areas(const Numbers<double>& vertices, const Numbers<std::int32_t>& triangles) {
    std::array<double, 2> areas{};
    for (std::size_t i = 0; i < triangles.size(); i += 3) {
        const double* corner[3];
        for (std::size_t k = 0; k < 3; ++k) corner[k] = &vertices[3 * static_cast<std::size_t>(triangles[i + k])];
        const auto [a, b, c] = std::array{corner[0], corner[1], corner[2]};
        const double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
        areas[0] += area, areas[1] += std::fabs(area);
    }
    return areas;
}

/// A polygon of random radii around the origin, turned so that it starts at any corner.
Numbers<double> star(int count, test::Random& random) {
    Numbers<double> vertices;
    const double start = 6 * random();
    for (int i = 0; i < count; ++i) {
        const double angle = start + 2 * std::numbers::pi * i / count, radius = 0.05 + random();
        vertices.insert(vertices.end(), {radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    return vertices;
}

double shoelace(const Numbers<double>& vertices) {
    double sum = 0;
    for (std::size_t i = 0; i < vertices.size(); i += 3) {
        const std::size_t j = (i + 3) % vertices.size();
        sum += vertices[i] * vertices[j + 1] - vertices[j] * vertices[i + 1];
    }
    return sum / 2;
}

}  // namespace

TEST(concave_polygons_become_triangles_of_their_area) {
    test::Random random(7);
    for (int count = 4; count < 120; ++count) {
        const Numbers<double> vertices = star(count, random);
        bob::files::Polygons polygons;
        std::vector<std::int32_t> corners(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) corners[static_cast<std::size_t>(i)] = i;
        polygons.add(corners);
        std::vector<std::string> warnings;
        const auto triangles = bob::files::triangulated(std::move(polygons), vertices, {}, warnings);
        CHECK(triangles.size() == 3 * static_cast<std::size_t>(count - 2));
        const auto [area, covered] = areas(vertices, triangles);
        CHECK_NEAR(area, shoelace(vertices), 1e-9);
        CHECK_NEAR(covered, shoelace(vertices), 1e-5);  // a fan may be turned over by `fold`
        CHECK(warnings.empty());
    }
}

TEST(spikes_of_polygons_have_no_area) {
    test::Random random(8);
    for (int count = 4; count < 60; ++count) {
        Numbers<double> vertices = star(count, random);
        const double area = shoelace(vertices);
        std::vector<std::int32_t> corners;
        for (std::int32_t i = 0; i < count; ++i) {
            corners.push_back(i);
            if (i % 3) continue;
            const auto middle = static_cast<std::int32_t>(vertices.size() / 3), tip = middle + 1;
            const double x = vertices[3 * static_cast<std::size_t>(i)], y = vertices[3 * static_cast<std::size_t>(i) + 1];
            vertices.insert(vertices.end(), {1.5 * x, 1.5 * y, 0, 2 * x, 2 * y, 0});
            corners.insert(corners.end(), {middle, tip, tip, middle, i});  // out and back
        }
        for (std::size_t start = 0; start < corners.size(); ++start) {
            std::ranges::rotate(corners, corners.begin() + 1);
            bob::files::Polygons polygons;
            polygons.add(corners);
            std::vector<std::string> warnings;
            const auto triangles = bob::files::triangulated(std::move(polygons), vertices, {}, warnings);
            CHECK(triangles.size() == 3 * (corners.size() - 2));
            CHECK_NEAR(areas(vertices, triangles)[1], area, 1e-5);  // as above
        }
    }
}

TEST(polygons_of_very_many_corners_take_bounded_time) {
    Numbers<double> vertices;  // a comb: half of its corners are concave
    constexpr int teeth = 60'000;
    for (int i = 0; i < teeth; ++i) vertices.insert(vertices.end(), {double(i), i % 2 ? 1. : 2., 0});
    for (int i = teeth; i-- > 0;) vertices.insert(vertices.end(), {double(i), i % 2 ? 0.9 : 1.9, 0});
    bob::files::Polygons polygons;
    std::vector<std::int32_t> corners(vertices.size() / 3);
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::int32_t>(i);
    polygons.add(corners);
    std::vector<std::string> warnings;
    CHECK(bob::files::triangulated(std::move(polygons), vertices, {}, warnings).size() == 3 * (corners.size() - 2));
    CHECK(warnings == std::vector<std::string>{"1 concave polygons were cut into fans: they have too many corners"});
}

TEST(off_has_numbers_of_every_kind) {
    const Contents contents = read("off", "STCN4nOFF 3\n# all of it\n3 1 0\n2 0 0 2  1 0 0  230 25 25  .5 .5\n0 2 0 2 1 0 0 0 0 0 0 0\n"
                                          "0 0 2 2 1 0 0 0 0 0 0 0\n3 0 1 2\n");
    const bob::files::Part& part = contents.parts.at(0);
    CHECK(part.vertices == (Numbers<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
    CHECK(part.normals == (Numbers<double>{1, 0, 0, 1, 0, 0, 1, 0, 0}));
    CHECK_NEAR(part.colors.at(0), 0.7913, 1e-4);
    CHECK(part.triangles == (Numbers<std::int32_t>{0, 1, 2}));
    const Contents faces = read("off", "OFF3 2\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0 0\n3 2 1 0\n");
    CHECK(faces.parts.at(0).face_colors.at(0) == 1);
    CHECK(std::isnan(faces.parts.at(0).face_colors.at(3)));
}

TEST(off_lines_may_have_several_vertices_or_faces) {
    const Numbers<double> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const auto check = [&](std::string_view text, std::size_t colors) {
        const bob::files::Part part = read("off", text).parts.at(0);
        CHECK(part.vertices == corners);
        CHECK(part.triangles == (Numbers<std::int32_t>{0, 1, 2, 1, 3, 2}));
        CHECK(part.face_colors.size() == colors);
        CHECK(part.colors.empty());
    };
    check("OFF 4 2 5 0 0 0 1 0 0 0 1 0 1 1 0 3 0 1 2 3 1 3 2", 0);
    check("OFF\n4 2 0\n0 0 0 1 0 0\n0 1 0  1 1 0 # two\n3 0 1 2 3 1 3 2\n", 0);
    check("OFF\n4 2 0\n0 0 0 1 0 0 0 1 0 1 1 0\n3 0 1 2 1 0 0\n3 1 3 2 0 1 0\n", 6);
    const bob::files::Part colored = read("off", "COFF 3 1 0\n0 0 0 1 0 0 1 1 0 0 0 1 0 1\n0 1 0 0 0 1 1 3 0 1 2").parts.at(0);
    CHECK(colored.colors == (Numbers<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
    // The colors of a file that was cut short are no vertices.
    CHECK(refusal("off", "OFF\n4 1 0\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n").starts_with("expected a line for each vertex"));
}

TEST(faces_without_a_triangle_are_counted) {
    using Warnings = std::vector<std::string>;
    CHECK((read("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf\nf 1 2\nf 1 2 3\n").warnings == Warnings{"left out 2 faces of fewer than three corners"}));
    CHECK((read("off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n").warnings == Warnings{"left out 1 face of fewer than three corners"}));
}

TEST(obj_features_that_are_not_shown_are_named) {
    const std::string square = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", library = "newmtl a\nmap_Ks k.png\nnorm n.png\nmap_Ka a.png\nnewmtl b\ndisp d.png\n";
    CHECK((read("obj", "mtllib a.mtl\n" + square + "usemtl a\nf 1 2 3\nl 1 2\np 1\n", library).warnings ==
           std::vector<std::string>{"not shown: lines, normal maps, points, specular maps"}));
    CHECK(refusal("obj", square + "l 1 2 3\n") == "expected triangles, got none; not shown: lines");
    CHECK((read("obj", square + "f 1 2 3\ncurv2 1 2\nbzp 1 2 3\ncall other.obj\n").warnings ==
           std::vector<std::string>{"not shown: curves, files that it calls, freeform surfaces"}));
    for (const char* const curve : {"curv", "curv2", "cdc"}) CHECK(refusal("obj", square + curve + " 1 2\n").ends_with("not shown: curves"));
    for (const char* const surface : {"surf", "bsp", "bzp", "cdp"}) {
        CHECK(refusal("obj", square + surface + " 1 2\n").ends_with("not shown: freeform surfaces"));
    }
}

TEST(obj_faces_of_old_versions_are_faces) { CHECK(read("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nfo 1 2 3\n").parts.at(0).triangles.size() == 3); }

TEST(obj_materials_have_no_light_of_a_map_that_is_not_shown) {
    const std::string triangle = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const auto made = [&](std::string_view mtl) { return read("obj", triangle, mtl); };
    CHECK(made("newmtl a\nKe 1 1 1\n").surfaces.at(0).material.emits());
    const Contents mapped = made("newmtl a\nKe 1 1 1\nmap_Ke a.png\n");
    CHECK(!mapped.surfaces.at(0).material.emits());
    CHECK(mapped.warnings == std::vector<std::string>{"not shown: emission maps"});
}

TEST(obj_materials_have_clear_coats_and_name_sheen) {
    const std::string triangle = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const Contents contents = read("obj", triangle, "newmtl a\nPr .5\nPc .75\nPcr .25\nPs 1\n");
    CHECK(contents.surfaces.at(0).material.clearcoat == 0.75);
    CHECK(contents.surfaces.at(0).material.clearcoat_roughness == 0.25);
    CHECK(contents.warnings == std::vector<std::string>{"not shown: sheen"});
    CHECK(read("obj", triangle, "newmtl a\nPr .5\nPs 0\n").warnings.empty());
}

TEST(stl_texts_may_be_one_line) {
    const auto facet = [](std::string_view x) {
        return "facet normal 0 0 1 outer loop vertex 0 0 0 vertex " + std::string(x) + " 0 0 vertex 0 1 0 endloop endfacet ";
    };
    const Contents contents = read("stl", "solid facet of glass " + facet("1") + facet("2") + "endsolid solid vertex " + facet("3") + "endsolid");
    CHECK(contents.parts.size() == 2);
    CHECK((contents.parts.at(0).triangles == Numbers<std::int32_t>{0, 1, 2, 0, 3, 2}));
    CHECK(contents.parts.at(1).vertices.at(3) == 3);
    CHECK(refusal("stl", "solid a " + facet("1 2 3") + "endsolid a").starts_with(
        "expected facets of three vertices, each of three numbers, got 'vertex 1 2 3 0 0 "));
}

TEST(stl_numbers_of_a_vertex_may_be_on_several_lines) {
    const auto facet = [](std::string_view first) {
        return "solid a\nfacet normal 0 0 1\nouter loop\n" + std::string(first) + "vertex 1 0 0\nvertex 0 1\n0\nendloop\nendfacet\nendsolid a\n";
    };
    CHECK((read("stl", facet("vertex\n\n0 0\r\n  .5\n")).parts.at(0).vertices == Numbers<double>{0, 0, .5, 1, 0, 0, 0, 1, 0}));
    CHECK(refusal("stl", facet("vertex 0 0\n")).ends_with("each of three numbers, got 'vertex 0 0'"));
    CHECK(refusal("stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n").ends_with("each of three numbers, got 'vertex 0 0'"));
}

TEST(ply_edges_and_materials_are_named) {
    const auto ply = [](std::string_view faces) {
        return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement material 1\n"
               "property uchar diffuse_red\nelement face " + std::string(faces) +
               "\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
               "0 0 0\n1 0 0\n0 1 0\n255\n";
    };
    CHECK(read("ply", ply("1") + "3 0 1 2\n0 1\n").warnings == std::vector<std::string>{"not shown: lines, materials"});
    CHECK(refusal("ply", ply("0") + "0 1\n") == "expected triangles, got none; not shown: lines, materials");
}

TEST(ply_colors_of_16_bits_and_of_bytes_in_wide_types) {
    const auto first_red = [](std::string_view type, std::string_view value) {
        std::string text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
        for (const char* name : {"red", "green", "blue"}) text += "property " + std::string(type) + " " + name + "\n";
        return read("ply", text + "end_header\n0 0 0 " + std::string(value) + " 0 0\n").parts.at(0).colors.at(0);
    };
    CHECK_NEAR(first_red("ushort", "65535"), 1, 1e-12);
    CHECK_NEAR(first_red("ushort", "255"), 1, 1e-12);
    CHECK_NEAR(first_red("int", "255"), 1, 1e-12);
    CHECK_NEAR(first_red("double", "1"), 1, 1e-12);
    CHECK_NEAR(first_red("float", "255"), 1, 1e-12);
    CHECK_NEAR(first_red("uchar", "1"), 1 / 255. / 12.92, 1e-12);
}

TEST(stl_facets_have_colors_of_viscam_or_magics) {
    const auto first = [](std::string_view head, std::uint16_t bits) {
        std::string stl(head);
        stl.resize(80);
        stl += std::string("\1\0\0\0", 4) + std::string(48, '\0') + static_cast<char>(bits & 255) + static_cast<char>(bits >> 8);
        const Contents contents = read("stl", stl);
        const Numbers<double>& colors = contents.parts.at(0).face_colors;
        return colors.empty() ? std::array<double, 3>{-1, -1, -1} : std::array{colors[0], colors[1], colors[2]};
    };
    using Rgb = std::array<double, 3>;
    CHECK((first("made by hand", 0x7c1f) == Rgb{-1, -1, -1}));
    CHECK((first("made by hand", 0xfc00) == Rgb{1, 0, 0}));
    CHECK((first("COLOR=\xff\xff", 0x001f) == Rgb{1, 0, 0}));
    CHECK((first("by Magics COLOR=\xff\xff", 0x801f) == Rgb{1, 1, 0}));
}

TEST(ply_may_begin_with_a_byte_order_mark) {
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string text = head + "end_header\n1 2 3\n";
    CHECK((read("ply", "\xef\xbb\xbf" + text).parts.at(0).vertices == Numbers<double>{1, 2, 3}));
}

TEST(obj_numbers_behind_points_are_colors_or_a_warning) {
    const auto read_point = [](std::string_view numbers) {
        return read("obj", "v 0 0 0 " + std::string(numbers) + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    };
    CHECK(read_point("1 0 0").parts.at(0).colors.at(0) == 1);
    CHECK(read_point("1 0 0").warnings.empty());
    CHECK(read_point("230 25 25").parts.at(0).colors.empty());
    const std::string warning = "numbers behind points were left out: expected colours in 0..1, got others";
    CHECK(read_point("230 25 25").warnings == std::vector<std::string>{warning});
}

TEST(obj_places_on_textures_have_v_0_if_omitted) {
    const char* const obj = "mtllib a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt .5\nusemtl m\nf 1/1 2/1 3/1\n";
    const Contents contents = read("obj", obj, "NEWMTL m\nmap_Kd a.png\n");
    CHECK(contents.parts.at(0).uv.at(0).at(0) == 0.5);
    CHECK(contents.parts.at(0).uv.at(0).at(1) == 1);
}

TEST(maps_of_mtl_have_options_and_any_names) {
    const char* const obj = "mtllib \"a b.mtl\"\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt .5 .25\nusemtl m\nf 1/1 2/1 3/1\n";
    const Contents contents = read("obj", obj, "\xef\xbb\xbfnewmtl m\rmap_Kd -clamp on -s 2 4 1 -o .1 -bm 3 \"my #1 wood.png\"\r");
    CHECK(contents.images.at(0).name == "my #1 wood.png");
    CHECK(contents.surfaces.at(0).color.across == bob::Wrap::clamp);
    CHECK_NEAR(contents.parts.at(0).uv.at(0).at(0), 1.1, 1e-12);
    CHECK_NEAR(contents.parts.at(0).uv.at(0).at(1), 0, 1e-12);  // 1 - (4 · 0.25 + 0)
    CHECK(read("obj", obj).warnings == std::vector<std::string>{"materials were left out: none"});
}

TEST(names_are_utf_8_whatever_they_were) {
    const Contents contents = read("obj", "mtllib a\nusemtl \xe4\xf0\x9f\x90\x87\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "newmtl \xe4\xf0\x9f\x90\x87\n");
    CHECK(bob::files::description(contents).find(R"("name":"\ufffd\ud83d\udc07")") != std::string::npos);
}
