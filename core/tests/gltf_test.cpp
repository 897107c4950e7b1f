#include <cstring>
#include <stdexcept>
#include <string>

#include "check.h"
#include "files/gltf_data.h"
#include "files/read.h"

namespace {

using namespace bob::files;

Bytes bytes_of(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

/// A triangle whose corners are bytes: (0, 0, 0), (2, 0, 0) and (0, 2, 0). more: members of the root.
std::string triangle(const std::string& more, const std::string& accessor = "") {
    return R"({"asset":{"version":"2.0"},"buffers":[{"uri":"data:;base64,AAAAAgAAAAIA"}],"bufferViews":[{"buffer":0,"byteLength":9}],)"
           R"("accessors":[{"bufferView":0,"componentType":5121,"count":3,"type":"VEC3")" + accessor + R"(}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}])" + more + "}";
}

/// The error of a text, or nothing.
std::string error_of(const std::string& text) {
    try {
        Beside beside;
        (void)read_gltf(bytes_of(text), beside);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST(gltf_points_are_z_up) {
    Beside beside;
    const std::string text = triangle("");
    const Contents contents = read_gltf(bytes_of(text), beside);
    CHECK_EQ(contents.parts.size(), 1u);
    const Part& part = contents.parts.at(0);
    CHECK_EQ(part.vertices.size(), 9u);
    CHECK_EQ(part.vertices[3], 2);
    CHECK_EQ(part.vertices[8], 2);  // y of the file
    CHECK_EQ(part.triangles.size(), 3u);
}

TEST(gltf_extensions_of_the_whole_file_are_warned_of) {
    Beside beside;
    const std::string text = triangle(R"(,"extensions":{"CESIUM_RTC":{"center":[1,2,3]},"KHR_xmp_json_ld":{}})");
    CHECK(read_gltf(bytes_of(text), beside).warnings == std::vector<std::string>{"not shown: CESIUM_RTC"});
}

TEST(gltf_members_of_a_wrong_type_are_named_in_one_warning) {
    const auto warned = [](const std::string& materials, const std::string& number = "0") {
        Beside beside;
        std::string text = triangle(R"(,"materials":)" + materials);
        text.insert(text.find("}]}],\"nodes\""), R"(,"material":)" + number);
        const Contents contents = read_gltf(bytes_of(text), beside);
        CHECK(contents.warnings.size() < 2);
        return contents.warnings.empty() ? std::string() : contents.warnings[0];
    };
    CHECK(warned(R"([{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1],"metallicFactor":0}}])").empty());
    CHECK(warned(R"([{"pbrMetallicRoughness":[{"baseColorFactor":[1,0,0,1]}]}])") == "not shown: invalid pbrMetallicRoughness");
    CHECK(warned(R"([{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0],"metallicFactor":"0","roughnessFactor":null}}])") ==
          "not shown: invalid baseColorFactor, invalid metallicFactor, invalid roughnessFactor");
    CHECK(warned(R"([{"emissiveFactor":["1",0,0],"normalTexture":1,"alphaMode":"mask","extensions":[]}])") ==
          "not shown: invalid alphaMode, invalid emissiveFactor, invalid extensions, invalid normalTexture");
    CHECK(warned(R"([{"alphaMode":"MASK","alphaCutoff":1e999,"pbrMetallicRoughness":{"baseColorTexture":{}}}])") ==
          "not shown: invalid alphaCutoff, textures without an index");
    CHECK(warned(R"([{"extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":[1]},"KHR_materials_pbrSpecularGlossiness":1}}])") ==
          "not shown: invalid KHR_materials_pbrSpecularGlossiness, invalid clearcoatFactor");
    for (const std::string wrong : {"\"0\"", "1", "-1", "0.5", "null"}) CHECK(warned("[{}]", wrong) == "not shown: invalid materials");
    CHECK(warned("{}") == "not shown: invalid materials");
    CHECK(warned("[1]") == "not shown: invalid materials");
}

TEST(gltf_attributes_of_other_sizes_and_skins_without_joints_are_named) {
    Beside beside;
    std::string text = triangle("");
    text.insert(text.find(R"("POSITION":0)"), R"("NORMAL":1,"COLOR_0":1,)");
    text.insert(text.find(R"(],"meshes")"), R"(,{"bufferView":0,"componentType":5121,"count":2,"type":"VEC3"})");
    text.insert(text.find(R"(}]})", text.find("nodes")), R"(,"skin":0)");
    CHECK(read_gltf(bytes_of(text), beside).warnings == std::vector<std::string>{"not shown: invalid COLOR_0, invalid NORMAL, invalid skins"});
}

/// Worked values: from a base colour c and metallic m, Khronos' converter makes the specular colour 0.04 + m (c - 0.04), and the
/// diffuse colour 0.96 (1 - m) c / (1 - the largest specular component).
TEST(gltf_specular_glossiness_becomes_metallic_roughness) {
    const auto shading = [](const std::string& values) {
        Beside beside;
        std::string text = triangle(R"(,"materials":[{"extensions":{"KHR_materials_pbrSpecularGlossiness":{)" + values + "}}}]");
        text.insert(text.find("}]}],\"nodes\""), R"(,"material":0)");
        const Contents contents = read_gltf(bytes_of(text), beside);
        CHECK(contents.warnings.empty());
        return contents.surfaces.at(0).material;
    };
    const auto check = [](const bob::Material& material, double red, double green, double blue, double metallic, double roughness) {
        CHECK_NEAR(material.color[0], red, 1e-9);
        CHECK_NEAR(material.color[1], green, 1e-9);
        CHECK_NEAR(material.color[2], blue, 1e-9);
        CHECK_NEAR(material.metallic, metallic, 1e-9);
        CHECK_NEAR(material.roughness, roughness, 1e-9);
    };
    check(shading(R"("diffuseFactor":[0,0,0,1],"specularFactor":[1,0.766,0.336],"glossinessFactor":0.75)"), 1, 0.766, 0.336, 1, 0.25);  // gold
    check(shading(R"("diffuseFactor":[0.5,0.2,0.1,1],"specularFactor":[0.04,0.04,0.04],"glossinessFactor":0)"), 0.5, 0.2, 0.1, 0, 1);
    check(shading(R"("diffuseFactor":[0.96,0.96,0.96,1],"specularFactor":[0,0,0])"), 1, 1, 1, 0, 0);  // of 1 / 0.96, clamped
    check(shading(R"("diffuseFactor":[0.66206896551724,0.66206896551724,0.66206896551724,1],"specularFactor":[0.42,0.42,0.42])"), 0.8, 0.8, 0.8, 0.5, 0);
    check(shading(""), 1, 1, 1, 1, 0);  // a mirror: all light is reflected before it can be diffuse
}

TEST(gltf_errors_name_their_place) {
    CHECK(error_of(triangle("")) == "");
    CHECK(error_of(triangle("", R"(,"byteOffset":1)")) == "accessors[0]: expected 10 bytes in its view, got 9");
    CHECK(error_of(triangle("", R"(,"byteOffset":-1)")).starts_with("accessors[0]: byteOffset: expected an integer in 0.."));
    CHECK(error_of(triangle("", R"(,"byteOffset":1e999)")) == "accessors[0]: byteOffset: expected an integer, got 1e999");
    CHECK(error_of(triangle(R"(,"scene":1,"scenes":[{}])")) == "scene: expected an integer in 0..0, got 1");
    CHECK(error_of(triangle(R"(,"scenes":[])")) == "");
    CHECK(error_of("{") != "");
    CHECK(error_of(std::string(1 << 20, '[')) != "");  // nested as deeply as it is long
}

TEST(gltf_files_next_to_it_are_asked_for) {
    std::string text = triangle("");
    text.replace(text.find("data:;base64,AAAAAgAAAAIA"), 25, "a%20b.bin");
    Reading reading(read_gltf, bytes_of(text));
    CHECK(reading.go_on() == "a b.bin");
    const std::uint8_t points[9] = {0, 0, 0, 2, 0, 0, 0, 2, 0};
    reading.give(points);
    CHECK(reading.go_on().empty());
    CHECK_EQ(reading.contents().parts.size(), 1u);
}

TEST(gltf_data_in_uris) {
    const auto text = [](std::string_view uri) {
        const auto bytes = data_of_uri(uri);
        return bytes ? std::string(bytes->begin(), bytes->end()) : "none";
    };
    CHECK(text("data:text/plain;base64,YWI%3D") == "ab");
    CHECK(text("DATA:text/plain;BASE64,YWI=") == "ab");
    CHECK(text("data:,a%20b") == "a b");
    CHECK(text("data:;base64").empty());
    CHECK(text("a%20b.bin") == "none");
    CHECK(path_of_uri("a%20b%2.bin") == "a b%2.bin");
}

TEST(base64_ends_anywhere) {
    const auto text = [](std::string_view encoded) {
        const auto bytes = from_base64(encoded);
        return bytes ? std::string(bytes->begin(), bytes->end()) : "none";
    };
    CHECK(text("") == "");
    CHECK(text("YQ==") == "a");
    CHECK(text("YWI=") == "ab");
    CHECK(text("YWI") == "ab");
    CHECK(text("YWJj\nZA==") == "abcd");
    for (const char* const wrong : {"Y", "YQ=", "Y=Q=", "????", "YWJj="}) CHECK(text(wrong) == "none");
}

TEST(gltf_compressed_data_have_bounded_size) {
    const auto error = [](const std::string& compressed) {
        std::string text = triangle("");
        text.insert(text.find(R"("byteLength":9)"), R"("extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":9,)" + compressed + "}},");
        return error_of(text);
    };
    const std::string place = "bufferViews[0]: EXT_meshopt_compression: ";
    CHECK(error(R"("byteStride":256,"count":1048577,"mode":"ATTRIBUTES")") == place + "expected at most 268,435,456 bytes once decompressed, got more");
    CHECK(error(R"("byteStride":256,"count":2,"mode":"ATTRIBUTES")") == place + "expected compressed data of a known version, got another");
    CHECK(error(R"("byteStride":2,"count":2,"mode":"ATTRIBUTES")") == place + "byteStride: expected one that its mode and filter allow, got 2");
    CHECK(error(R"("byteStride":2,"count":2,"mode":"SPARSE")") == place + "mode: expected ATTRIBUTES, TRIANGLES or INDICES, got 'SPARSE'");
}
