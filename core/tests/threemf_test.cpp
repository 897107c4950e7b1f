#include <string>
#include <vector>

#include "check.h"
#include "files/inflate.h"
#include "files/read.h"
#include "files/xml.h"
#include "files/zip.h"
#include "fuzz/zipped.h"

namespace {

using namespace bob::files;

Bytes bytes_of(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

template <class F>
std::string error_of(F f) {
    try {
        f();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

std::string inflated_text(std::string_view data, std::size_t size) {
    const auto bytes = inflated(bytes_of(data), size);
    return {bytes.begin(), bytes.end()};
}

/// Names of elements, "+" where they start and "-" where they end, with namespaces and attributes.
std::string events(std::string_view text) {
    Xml xml(bytes_of(text));
    std::string result;
    for (auto event = xml.next(); event != Xml::Event::finish; event = xml.next()) {
        const bool is_start = event == Xml::Event::start;
        result += is_start ? "+" : "-";
        if (!xml.space().empty()) result.append(xml.space()).append("}");
        result += xml.name();
        for (const auto& [space, name, value] : xml.attributes().all()) {
            if (is_start) result.append(" ").append(space).append(space.empty() ? "" : "}").append(name).append("=").append(value);
        }
    }
    return result;
}

std::string xml_error(std::string_view text) {
    return error_of([&] { events(text); });
}

Contents read(std::string_view resources, std::string_view build = "<item objectid='1'/>", std::string_view attributes = "") {
    const std::string text = "<model xmlns='core' xmlns:m='http://schemas.microsoft.com/3dmanufacturing/material/2015/02' " + std::string(attributes) +
                             "><resources>" + std::string(resources) + "</resources><build>" + std::string(build) + "</build></model>";
    const std::string package = fuzz::zipped({{"3D/3dmodel.model", text}});
    Reading reading(read_3mf, bytes_of(package));
    CHECK(reading.go_on().empty());
    return std::move(reading.contents());
}

const std::string triangle =
    "<mesh><vertices><vertex x='0' y='0' z='0'/><vertex x='1' y='0' z='0'/><vertex x='0' y='1' z='0'/></vertices>"
    "<triangles><triangle v1='0' v2='1' v3='2'/></triangles></mesh>";

}  // namespace

// Compressed by zlib 1.3.
TEST(deflate_in_blocks_of_each_kind) {
    const std::string_view fixed("\x4b\x4c\x4a\x4e\x24\x84\x00", 7);
    CHECK(inflated_text(fixed, 36) == "abcabcabcabcabcabcabcabcabcabcabcabc");
    CHECK(inflated_text(std::string_view("\x01\x05\x00\xfa\xffhello", 10), 5) == "hello");
    std::string letters;
    for (int i = 0; i < 300; ++i) letters += static_cast<char>('a' + (i * i + i / 7) % 26);
    const std::string_view dynamic(
        "\xdd\xcc\x01\x12\x00\x11\x08\x00\xc0\xb7\x86\x8c\x10\x9a\x32\xe1\xf5\xf7\x8f\xdb\x07\x2c\x04\xac\xf2\xda\x1d\x78\x74\x4d"
        "\xb1\x9b\xe7\xe3\x68\x5c\x30\x21\x8d\x9d\x66\x10\x0a\x6e\x6a\x1e\xab\x26\xc9\x2e\x9d\x0a\x75\xb9\x45\xf3\xee\x08\xc7\x0f"
        "\x64\xf6\xb2\x2b\xd8\xe4\xce\x6b\x87\xe6\xf5\x2e\x4a\x00\x7f\xab\x3f", 77);
    CHECK(inflated_text(dynamic, 300) == letters);
    CHECK_EQ(crc32(bytes_of("123456789")), 0xcbf43926u);
}

TEST(damaged_deflate_is_refused) {
    const std::string_view fixed("\x4b\x4c\x4a\x4e\x24\x84\x00", 7);
    const auto refused = [](std::string_view data, std::size_t size) { return !error_of([&] { inflated_text(data, size); }).empty(); };
    CHECK(refused(fixed, 35));
    CHECK(refused(fixed, 37));
    CHECK(refused(fixed, std::size_t{1} << 40));
    for (std::size_t size = 0; size < fixed.size(); ++size) CHECK(refused(fixed.substr(0, size), 36));
    CHECK(refused("\x07", 1));                                 // a kind of block that does not exist
    CHECK(refused(std::string_view("\x4b\x04\x12\x00", 4), 9));  // a copy from before the start
}

TEST(zip_files_have_comments_and_bytes_before_them) {
    std::string file = fuzz::zipped({{"a", "one"}, {"b", "two"}});
    file[file.size() - 2] = 4;
    file = "#!/bin/sh\n" + file + "note";
    const Zip zip(bytes_of(file));
    CHECK_EQ(zip.entries().size(), 2u);
    const auto second = zip.unpacked(zip.entries().at(1));
    CHECK(std::string(second.begin(), second.end()) == "two");
    std::string damaged = file;
    damaged[damaged.find("two")] = 'T';
    const Zip other(bytes_of(damaged));
    CHECK(error_of([&] { static_cast<void>(other.unpacked(other.entries().at(1))); }) == "expected a zip file that can be unpacked, got another (a checksum differs)");
    for (std::size_t size = 0; size < file.size(); ++size) {
        const std::string_view part = std::string_view(file).substr(0, size);
        error_of([&] {
            const Zip cut(bytes_of(part));
            for (const ZipEntry& entry : cut.entries()) static_cast<void>(cut.unpacked(entry));
        });
    }
}

TEST(xml_elements_in_their_namespaces) {
    CHECK(events("<a/>") == "+a-a");
    CHECK(events("\xef\xbb\xbf<?xml version='1.0'?><!-- <b> --><a x = '1'\n y=\"2'\" >t<![CDATA[<c>]]><b></b ></a>\n") == "+a x=1 y=2'+b-b-a");
    CHECK(events("<a xmlns='u' xmlns:p='v' k='1' p:k='2'><p:b xmlns:p='w'/><p:c/><d xmlns=''/></a>") == "+u}a k=1 v}k=2+w}b-w}b+v}c-v}c+d-d-u}a");
    CHECK(events("<a x='&lt;&#65;&#x20AC;&amp;&quot;&apos;&gt;\n'/>") == "+a x=<A\xe2\x82\xac&\"'> -a");
    CHECK(events(std::string_view("\xff\xfe<\0a\0 \0x\0=\0'\0\x3d\xd8\x07\xdc\xac\x20'\0/\0>\0", 26)) == "+a x=\xf0\x9f\x90\x87\xe2\x82\xac-a");
    CHECK(events("<a x='\xe4'/>") == "+a x=\xef\xbf\xbd-a");
}

TEST(damaged_xml_is_refused_with_the_line) {
    for (const char* text : {"", "a", "<a>", "<a", "<a b", "<a b='", "<a b='1'c='2'/>", "<a b/>", "<a b=c/>", "</a>", "<a></b>", "<a/><b/>", "<a/>t", "<p:a/>", "<a p:b='1'/>",
                             "<a x='<'/>", "<a x='&b;'/>", "<a x='&#0;'/>", "<a x='&#xD800;'/>", "<a x='&#99999999999;'/>", "<a x='&lt'/>", "< a/>", "<a / >", "<!-->", "<a><![CDATA[</a>"}) {
        CHECK(xml_error(text).starts_with("expected XML, got something else ("));
    }
    CHECK(xml_error("<a>\n</b>") == "expected XML, got something else (a mismatched tag in line 2)");
    CHECK(xml_error("<!DOCTYPE a><a/>") == "expected XML without a document type and entities, got some");
}

TEST(hostile_xml_is_refused_at_once) {
    std::string nested, many, prefixes = "<a";
    for (int i = 0; i < 100'001; ++i) nested += "<a>";
    CHECK(xml_error(nested) == "expected XML of at most 100,000 levels, got more");
    for (int i = 0; i < 400'000; ++i) many += "<b/>";
    CHECK(xml_error("<a>" + many + "</a>") == "expected XML with at most 250,000 elements of a few bytes, got more");
    for (const char* start : {"<a b='", "<a ", "<!--", "<?"}) {
        CHECK(xml_error(start + std::string(1 << 21, ' ')) == "expected XML tags of at most 1,048,576 bytes, got a longer one");
    }
    for (int i = 0; i < 40'000; ++i) prefixes += " xmlns:p" + std::to_string(i) + "='u'";  // looked up 100,000 times
    many.clear();
    for (int i = 0; i < 100'000; ++i) many += "<p0:b/>";
    CHECK(!events(prefixes + ">" + many + "</a>").empty());
}

TEST(threemf_objects_are_placed_and_labelled) {
    const std::string components = "<object id='2' name='pair'><components><component objectid='1'/><component objectid='1' transform='-1 0 0 0 1 0 0 0 1 0 0 5'/></components></object>";
    const Contents contents = read("<object id='1' name='wedge'>" + triangle + "</object>" + components, "<item objectid='2' transform='2 0 0 0 2 0 0 0 2 1 1 1'/>", "unit='inch'");
    CHECK(contents.unit == "in");
    CHECK_EQ(contents.parts.size(), 1u);
    const Part& part = contents.parts.at(0);
    CHECK((part.vertices == Numbers<double>{1, 1, 1, 3, 1, 1, 1, 3, 1, 1, 1, 11, -1, 1, 11, 1, 3, 11}));
    CHECK((part.triangles == Numbers<std::int32_t>{0, 1, 2, 5, 4, 3}));  // the second is mirrored
    CHECK_EQ(contents.labels.size(), 3u);
    CHECK(contents.labels.at(2).name == "wedge 2");
    CHECK_EQ(contents.labels.at(2).parent, 0);
}

TEST(threemf_colors_blend_unless_they_are_of_materials) {
    const auto with = [](std::string_view group, std::string_view choice) {
        std::string mesh = triangle;
        mesh.replace(mesh.find("v3='2'"), 6, "v3='2' pid='5' " + std::string(choice));
        return read(std::string(group) + "<object id='1'>" + mesh + "</object>").parts.at(0);
    };
    const char* const materials = "<basematerials id='5'><base displaycolor='#FF0000'/><base displaycolor='#0000FF80'/></basematerials>";
    CHECK((with(materials, "p1='1' p2='0'").face_colors == Numbers<double>{0, 0, 1}));
    const char* const colors = "<m:colorgroup id='5'><m:color color='#FF0000'/><m:color color='#0000FF80'/></m:colorgroup>";
    CHECK((with(colors, "p1='1' p2='0' p3='7'").colors == Numbers<double>{0, 0, 1, 1, 0, 0, 1, 1, 1}));
    CHECK((with(colors, "p1='1'").face_colors == Numbers<double>{0, 0, 1}));
}

TEST(painted_triangles_of_a_threemf_are_named) {
    const auto warned = [](std::string_view attribute) {
        std::string mesh = triangle;
        mesh.replace(mesh.find("v3='2'"), 6, "v3='2' " + std::string(attribute));
        return read("<object id='1'>" + mesh + "</object>", "<item objectid='1'/>", "xmlns:slic3rpe='http://schemas.slic3r.org/3mf/2017/06'").warnings;
    };
    const std::vector<std::string> painted{"left out painted colours of slicers (1)"};
    CHECK(warned("paint_color='8'") == painted);
    CHECK(warned("slic3rpe:mmu_segmentation='8'") == painted);
    CHECK(warned("paint_supports='8'").empty());
}

TEST(components_of_a_threemf_that_never_end) {
    std::string many;
    for (int i = 0; i < 99'000; ++i) many += "<component objectid='1'/>";
    const std::string error = error_of([&] { read("<object id='1'><components>" + many + "</components></object>"); });
    CHECK(error == "expected finitely many components, got too many; does one hold itself?");
}
