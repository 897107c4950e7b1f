/// OFF as text, of all kinds: points with normals, colours and places on textures, polygons with colours.

#include "files/colors.h"
#include "files/polygons.h"
#include "files/read.h"
#include "files/text.h"

namespace bob::files {
namespace {

/// Properties of vertices, from the header's first word.
struct Kind {
    bool has_texture_coordinates = false, has_colors = false, has_normals = false, is_homogeneous = false, has_dimension = false;
};

/// Reads the first word, letter by letter in fixed order, and removes it from the text. Some writers put a number right behind it.
Kind take_kind(std::string_view& text) {
    Kind kind;
    std::string_view rest = text;
    const auto take = [&](std::string_view letters) {
        const bool is_there = rest.starts_with(letters);
        if (is_there) rest.remove_prefix(letters.size());
        return is_there;
    };
    kind.has_texture_coordinates = take("ST");
    kind.has_colors = take("C");
    kind.has_normals = take("N");
    kind.is_homogeneous = take("4");
    kind.has_dimension = take("n");
    if (!take("OFF") || (!rest.empty() && !is_space(rest[0]) && rest[0] != '#' && !(rest[0] >= '0' && rest[0] <= '9'))) {
        refuse({"expected an OFF, which starts with 'OFF', got ", quoted(text.substr(0, 8))});
    }
    text = rest;
    return kind;
}

/// The numbers of a text; '#' ends the rest of a line.
class NumberReader {
public:
    explicit NumberReader(std::string_view text) : lines_(text) {}

    /// The next number, on this line or a later one; at the end of the file, an error names `what`.
    double next(const std::string& what) {
        std::string_view word;
        while ((word = words_.next()).empty()) {
            if (!lines_.next()) refuse({"expected ", what, ", but the file ends before them"});
            words_ = Words(lines_.line().substr(0, lines_.line().find('#')));
        }
        return number_of(word);
    }

    /// Whether this line has no more words.
    [[nodiscard]] bool is_at_line_end() const { return trimmed(words_.rest()).empty(); }

    /// Counts the lines after this one that have words.
    [[nodiscard]] std::size_t lines_left() const {
        std::size_t count = 0;
        for (Lines lines = lines_; lines.next();) count += !trimmed(lines.line().substr(0, lines.line().find('#'))).empty();
        return count;
    }

    /// The numbers that are left on this line.
    const std::vector<double>& rest() {
        rest_.clear();
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) rest_.push_back(number_of(word));
        return rest_;
    }

private:
    Lines lines_;
    Words words_{{}};
    std::vector<double> rest_;
};

/// Colours of rows, which have them or not.
class Colors {
public:
    explicit Colors(std::size_t rows) : rows_(rows) {}

    void set(std::size_t row, std::span<const double> values) {
        if (values.size() < 3) {
            numbered_ += values.size();
            return;
        }
        if (colors_.empty()) colors_.assign(3 * rows_, nan);
        for (std::size_t k = 0; k < 3; ++k) colors_[3 * row + k] = values[k];
    }
    [[nodiscard]] bool are_numbered() const { return numbered_ > 0; }
    [[nodiscard]] Numbers<double> linear() && {
        make_linear(colors_, 0);
        return std::move(colors_);
    }

private:
    std::size_t rows_, numbered_ = 0;
    Numbers<double> colors_;
};

}  // namespace

Contents read_off(Bytes bytes, Beside&) {
    std::string_view text = trimmed(text_of(bytes));
    while (text.starts_with('#')) {
        const std::size_t end = text.find_first_of("\r\n");
        text = end == std::string_view::npos ? std::string_view() : trimmed(text.substr(end));
    }
    const Kind kind = take_kind(text);
    if (is_word(trimmed(text).substr(0, 6), "binary")) refuse({"expected an OFF as text, got a binary one"});
    NumberReader rows(text);
    const std::string of_counts = "counts of vertices and faces";
    if (kind.has_dimension) {
        if (rows.next(of_counts) != 3) {
            refuse({"expected points of 3 dimensions, got others"});
        }
    }
    const double vertices = rows.next(of_counts), faces = rows.next(of_counts);
    NumberReader ahead = rows;
    bool are_rows = ahead.rest().size() <= 1;  // the number of edges
    if (are_rows) {
        rows = std::move(ahead);
    } else {
        static_cast<void>(rows.next(of_counts));
    }
    // A number takes at least a digit and a space.
    if (!(vertices >= 0 && faces >= 0 && 2 * (3 * vertices + faces) <= static_cast<double>(bytes.size()) + 1)) {
        const auto shown = [](double count) { return count >= 0 && count < 1e18 ? grouped(static_cast<std::uint64_t>(count)) : "others"; };
        refuse({"expected counts of vertices and faces that the file can hold, got ", shown(vertices), " and ", shown(faces)});
    }
    const auto vertex_count = static_cast<std::size_t>(vertices), face_count = static_cast<std::size_t>(faces);

    // A line has one vertex or face, with its color. Some writers put several on a line, where no color ends them.
    are_rows = are_rows && rows.lines_left() >= vertex_count + face_count;
    const bool are_vertex_rows = are_rows;

    Contents contents;
    Part& part = contents.parts.emplace_back();
    part.vertices.resize(3 * vertex_count);
    if (kind.has_normals) part.normals.resize(3 * vertex_count);
    Colors colors(vertex_count), face_colors(face_count);
    const std::string of_vertices = grouped(vertex_count) + " vertices", of_faces = grouped(face_count) + " faces";
    for (std::size_t i = 0; i < vertex_count; ++i) {
        double* const place = &part.vertices[3 * i];
        for (int k = 0; k < 3; ++k) place[k] = rows.next(of_vertices);
        if (kind.is_homogeneous) {
            const double w = rows.next(of_vertices);
            for (int k = 0; k < 3; ++k) place[k] /= w;
        }
        for (int k = 0; kind.has_normals && k < 3; ++k) part.normals[3 * i + static_cast<std::size_t>(k)] = rows.next(of_vertices);
        if (!are_vertex_rows) {
            double rgba[4];
            for (int k = 0; kind.has_colors && k < 4; ++k) rgba[k] = rows.next(of_vertices);
            for (int k = 0; kind.has_texture_coordinates && k < 2; ++k) static_cast<void>(rows.next(of_vertices));
            if (kind.has_colors) colors.set(i, rgba);
            continue;
        }
        std::span<const double> rest = rows.rest();
        if (kind.has_texture_coordinates) rest = rest.first(rest.size() - std::min<std::size_t>(rest.size(), 2));
        if (!rest.empty()) colors.set(i, rest);
    }
    Polygons polygons;
    std::vector<std::int32_t> polygon;
    const auto check_shared_lines = [&](bool is_good) {
        if (!is_good) refuse({"expected a line for each vertex and each face, or several on a line without colors, got others"});
    };
    are_rows |= rows.is_at_line_end() && rows.lines_left() >= face_count;
    for (std::size_t i = 0; i < face_count; ++i) {
        const double size = rows.next(of_faces);
        if (!(size >= 0 && size <= static_cast<double>(bytes.size()))) {
            refuse({"face ", grouped(i + 1), ": expected a count of corners that the file can hold"});
        }
        check_shared_lines(are_vertex_rows || size >= 3);
        polygon.clear();
        for (double corner = 0; corner < size; ++corner) polygon.push_back(index_of(rows.next(of_faces)));
        polygons.add(polygon);
        if (are_rows) face_colors.set(i, rows.rest());
    }
    check_shared_lines(are_vertex_rows || (rows.is_at_line_end() && rows.lines_left() == 0));
    if (colors.are_numbered() || face_colors.are_numbered()) {
        contents.warnings.emplace_back("colors were left out: they are numbers in a list of colors, which is not in the file");
    }
    part.colors = std::move(colors).linear();
    if (part.colors.empty()) part.face_colors = of_triangles(std::move(face_colors).linear(), 3, polygons);
    part.triangles = triangulated(std::move(polygons), part.vertices, {}, contents.warnings);
    return contents;
}

}  // namespace bob::files
