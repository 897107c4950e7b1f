/// STL, text and binary. Its face normals equal the triangles' normals and are left out.
#include <stdexcept>

#include "base/interruption.h"
#include "files/binary.h"
#include "files/colors.h"
#include "files/read.h"
#include "files/text.h"
#include "files/welding.h"

namespace bob::files {
namespace {

constexpr std::size_t header = 84, facet = 50;  // bytes

/// The end of all facets, whose last two bytes say how many more bytes follow; 0 if they reach beyond the file.
std::size_t end_with_attributes(Bytes bytes, std::size_t count) {
    std::size_t at = header;
    for (std::size_t i = 0; i < count; ++i) {
        if (bytes.size() - at < facet) return 0;
        at += facet + (bytes[at + facet - 2] | bytes[at + facet - 1] << 8u);
        if (at > bytes.size()) return 0;
    }
    return at;
}

/// Linear RGB of facets, from the 5 bits of each component in their last two bytes; empty if none has a colour. Bit 15 marks facets
/// with a colour in VisCAM and SolidView, and those without in Magics, whose header has the colour of these behind COLOR=.
Numbers<double> colors_of(Bytes bytes, std::size_t count) {
    constexpr std::string_view mark = "COLOR=";
    const std::string_view head(reinterpret_cast<const char*>(bytes.data()), header - 4);
    const std::size_t at = head.find(mark);
    const bool is_magics = at < head.size() - mark.size() - 3;
    Numbers<double> colors(3 * count, nan);
    bool is_any_colored = is_magics;
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        const auto bits = load<std::uint16_t>(&bytes[header + facet * i + facet - 2], false);
        const bool is_marked = bits >> 15;
        for (std::size_t k = 0; k < 3; ++k) {
            if (is_marked != is_magics) {
                colors[3 * i + k] = bits >> 5 * (is_magics ? k : 2 - k) & 31;
            } else if (is_magics) {
                colors[3 * i + k] = bytes[at + mark.size() + k] * 31 / 255.;
            }
        }
        is_any_colored |= is_marked;
    }
    if (!is_any_colored) return {};
    make_linear(colors, 31);
    return colors;
}

Part read_binary(Bytes bytes, std::size_t count) {
    const bool has_attributes = bytes.size() != header + facet * count && end_with_attributes(bytes, count) == bytes.size();
    Welding welding(3 * count);
    welding.add_facets(bytes.subspan(header), count, has_attributes);
    Part part = std::move(welding).part();
    if (!has_attributes) part.face_colors = colors_of(bytes, count);
    return part;
}

[[noreturn]] void refuse_facet(std::string_view got) {
    refuse({"expected facets of three vertices, each of three numbers, got ", quoted(trimmed(got))});
}

/// Reads a text word by word: some writers put facets, or the whole file, on one line.
class TextSolid {
public:
    explicit TextSolid(std::string_view text) : lines_(text), welding_(3 * (text.size() / 256)) {}

    std::vector<Part> read() && {
        while (lines_.next()) {
            words_ = Words(lines_.line());
            for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) take(word);
        }
        if (corners_ > 0) refuse_facet("the end of the file");
        end_solid();
        return std::move(parts_);
    }

private:
    void take(std::string_view word) {
        const std::string_view line = lines_.line(), from_here = line.substr(static_cast<std::size_t>(word.data() - line.data()));
        if (is_word(word, "vertex")) {
            if (++corners_ < 1 || corners_ > 3) refuse_facet(from_here);
            add_vertex(from_here);
        } else if (is_word(word, "facet")) {
            if (corners_ >= 0) refuse_facet(from_here);
            corners_ = 0;
        } else if (is_word(word, "endfacet")) {
            if (corners_ != 3) refuse_facet(from_here);
            corners_ = -1;
        } else if (corners_ < 0) {
            if (is_word(word, "endsolid")) end_solid();
            skip_name();
        }
    }

    void add_vertex(std::string_view from_here) {
        double place[3];
        for (double& x : place) {
            std::string_view digits = words_.next();
            if (digits.empty()) digits = word_of_a_later_line();
            if (digits.empty()) refuse_facet(from_here);
            x = coordinate(digits, from_here);
        }
        Words ahead = words_;
        const std::string_view word = ahead.next();
        if (!word.empty() && !is_word(word, "vertex") && !is_word(word, "endloop") && !is_word(word, "endfacet")) refuse_facet(from_here);
        welding_.add(place[0], place[1], place[2]);
    }

    [[gnu::noinline]] std::string_view word_of_a_later_line() {
        std::string_view word;
        while (word.empty() && lines_.next()) {
            words_ = Words(lines_.line());
            word = words_.next();
        }
        return word;
    }

    static double coordinate(std::string_view word, std::string_view from_here) {
        try {
            return number_of(word);
        } catch (const std::invalid_argument&) {
            if (word.find(',') != std::string_view::npos) throw;
            refuse_facet(from_here);
        }
    }

    /// Skips the name of a solid: the rest of the line, or its words before "facet normal".
    void skip_name() {
        while (!trimmed(words_.rest()).empty()) {
            Words ahead = words_;
            const bool is_facet = is_word(ahead.next(), "facet");
            const Words after = ahead;
            if (is_facet && is_word(ahead.next(), "normal")) return;
            words_ = after;
        }
    }

    void end_solid() {
        if (Part part = std::move(welding_).part(); !part.triangles.empty()) parts_.push_back(std::move(part));
        welding_ = Welding(0);
    }

    Lines lines_;
    Words words_{{}};
    std::vector<Part> parts_;
    Welding welding_;
    int corners_ = -1;  // of the facet so far; -1 outside of one
};

}  // namespace

Contents read_stl(Bytes bytes, Beside&) {
    const std::size_t count = bytes.size() < header ? 0 : load<std::uint32_t>(&bytes[80], false);
    const bool is_exact = bytes.size() >= header && (bytes.size() - header) / facet == count && (bytes.size() - header) % facet == 0;
    const std::string_view text = is_exact ? std::string_view() : text_of(bytes), head = text.substr(0, header);
    const bool is_text = is_word(trimmed(head).substr(0, 5), "solid") && head.find('\0') == std::string_view::npos;
    Contents contents;
    if (!is_exact && is_text) {
        contents.parts = TextSolid(text).read();
    } else if (is_exact || (count > 0 && bytes.size() >= header && (bytes.size() - header) / facet >= count)) {
        contents.parts.push_back(read_binary(bytes, count));
    } else {
        refuse({"expected an STL of 84 + 50 n bytes for n triangles, got ", grouped(bytes.size()), " bytes"});
    }
    return contents;
}

}  // namespace bob::files
