/// PLY, text and binary: vertices, their normals, polygons and triangle strips, their colours and textures.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>

#include "base/interruption.h"
#include "files/binary.h"
#include "files/colors.h"
#include "files/not_shown.h"
#include "files/polygons.h"
#include "files/read.h"
#include "files/split.h"
#include "files/text.h"

namespace bob::files {
namespace {

using Names = std::array<std::string_view, 3>;

constexpr Names srgb_names[] = {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}, {"r", "g", "b"}};
constexpr Names linear_names{"color_0", "color_1", "color_2"};  // as Mitsuba writes its attributes
constexpr std::array<std::string_view, 2> uv_names[] = {{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}};
constexpr std::size_t most_header = 1 << 20;  // bytes

enum class Type : std::uint8_t { i1, u1, i2, u2, i4, u4, i8, u8, f4, f8 };

struct TypeName {
    std::string_view name;
    Type type;
};
constexpr TypeName types[] = {
    {"char", Type::i1}, {"int8", Type::i1}, {"uchar", Type::u1}, {"uint8", Type::u1}, {"short", Type::i2}, {"int16", Type::i2},
    {"ushort", Type::u2}, {"uint16", Type::u2}, {"int", Type::i4}, {"int32", Type::i4}, {"uint", Type::u4}, {"uint32", Type::u4},
    {"int64", Type::i8}, {"uint64", Type::u8}, {"float", Type::f4}, {"float32", Type::f4}, {"double", Type::f8}, {"float64", Type::f8},
};

/// Calls f with a value of a type.
template <class F>
auto with(Type type, F f) {
    switch (type) {
        case Type::i1: return f(std::int8_t{});
        case Type::u1: return f(std::uint8_t{});
        case Type::i2: return f(std::int16_t{});
        case Type::u2: return f(std::uint16_t{});
        case Type::i4: return f(std::int32_t{});
        case Type::u4: return f(std::uint32_t{});
        case Type::i8: return f(std::int64_t{});
        case Type::u8: return f(std::uint64_t{});
        case Type::f4: return f(float{});
        default: return f(double{});
    }
}

std::size_t size_of(Type type) {
    constexpr std::uint8_t sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

/// The full value of a colour; 0 for types with several conventions.
double full_of(Type type) { return type == Type::i1 ? 127 : type == Type::u1 ? 255 : 0; }
/// The largest number of an integer type; 255 of other types.
double most_of(Type type) {
    const bool is_integer = type < Type::f4, is_signed = static_cast<int>(type) % 2 == 0;
    return is_integer ? std::ldexp(1, static_cast<int>(8 * size_of(type)) - is_signed) - 1 : 255;
}

struct Property {
    std::string_view name;
    Type type;
    std::optional<Type> length;  // the type of a list's length
};

struct Element {
    std::string_view name;
    std::uint64_t rows;
    std::vector<Property> properties;

    [[nodiscard]] const Property* scalar(std::string_view wanted) const { return find(wanted, false); }
    [[nodiscard]] const Property* list(std::string_view wanted) const { return find(wanted, true); }
    [[nodiscard]] bool has(std::span<const std::string_view> names) const {
        return std::ranges::all_of(names, [&](std::string_view own) { return scalar(own); });
    }

private:
    [[nodiscard]] const Property* find(std::string_view wanted, bool is_list) const {
        for (const Property& property : properties) {
            if (property.name == wanted && property.length.has_value() == is_list) return &property;
        }
        return nullptr;
    }
};

struct Header {
    std::vector<Element> elements;
    std::vector<std::string> textures;  // their files
    std::size_t end = 0;                // where the body begins
    bool is_text = false, is_big = false;
};

/// Thrown where the file is shorter than it says.
struct Ended {};

// ---- Header ----------------------------------------------------------------------------------------------

std::int64_t integer_of(std::string_view word) {
    std::string_view digits = word;
    if (digits.starts_with('+') || digits.starts_with('-')) digits.remove_prefix(1);
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    const bool is_whole = !digits.empty() && digits[0] != '-' && digits.size() <= 18 && error == std::errc() && end == digits.data() + digits.size();
    if (!is_whole) refuse({"expected a whole number, got ", quoted(word)});
    return word[0] == '-' ? -number : number;
}

Type type_of(std::string_view word) {
    for (const TypeName& own : types) {
        if (own.name == word) return own.type;
    }
    refuse({"expected a PLY type such as float or int, got ", utf8(word.substr(0, 40))});
}

/// The place of the line end_header, and the data behind it.
std::pair<std::size_t, std::size_t> end_of_header(std::string_view text) {
    constexpr std::string_view word = "end_header";
    const std::string_view head = text.substr(0, most_header);
    for (std::size_t at = head.find(word); at != std::string_view::npos; at = head.find(word, at + 1)) {
        std::size_t end = at + word.size();
        while (end < text.size() && (text[end] == ' ' || text[end] == '\t')) ++end;
        const bool is_line = at > 0 && (text[at - 1] == '\n' || text[at - 1] == '\r');
        if (!is_line || (end < text.size() && text[end] != '\n' && text[end] != '\r')) continue;
        if (end < text.size()) end += text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n' ? 2 : 1;
        return {at, end};
    }
    refuse({"expected a PLY header that ends in end_header, got none"});
}

/// A list takes at least its length, and a number of a text a digit and a space, except the last.
void check_size(const Header& header, std::size_t left) {
    double smallest = 0;
    std::string declared;
    for (const Element& element : header.elements) {
        std::size_t row = 0;
        for (const Property& own : element.properties) row += header.is_text ? 2 : size_of(own.length.value_or(own.type));
        smallest += static_cast<double>(element.rows) * static_cast<double>(row);
        declared += joined({declared.empty() ? "" : ", ", grouped(element.rows), " ", utf8(element.name.substr(0, 40))});
    }
    if (smallest > static_cast<double>(left) + header.is_text) {
        refuse({"expected ", declared, ", got only ", grouped(left), " bytes to hold them"});
    }
}

Header read_header(std::string_view text) {
    if (!text.starts_with("ply")) refuse({"expected a PLY, which starts with 'ply', got ", quoted(text.substr(0, 8))});
    const auto [stop, end] = end_of_header(text);
    Header header;
    header.end = end;
    std::string_view format;
    for (Lines lines(text.substr(0, stop)); lines.next();) {
        Words words(lines.line());
        const std::string_view word = words.next();
        std::array<std::string_view, 5> rest;
        if (word == "comment") {
            if (words.next() == "TextureFile") {
                if (const std::string_view name = trimmed(words.rest()); !name.empty()) header.textures.push_back(utf8(name));
            }
            continue;
        }
        std::size_t count = 0;
        for (std::string_view next = words.next(); !next.empty() && count < rest.size(); next = words.next()) rest[count++] = next;
        if (word == "format" && count > 0) {
            format = rest[0];
        } else if (word == "element" && count == 2) {
            const std::int64_t rows = integer_of(rest[1]);
            if (rows < 0) refuse({"expected a count of rows, got ", quoted(rest[1])});
            header.elements.push_back({rest[0], static_cast<std::uint64_t>(rows), {}});
        } else if (word == "property" && !header.elements.empty() && count == 4 && rest[0] == "list") {
            header.elements.back().properties.push_back({rest[3], type_of(rest[2]), type_of(rest[1])});
        } else if (word == "property" && !header.elements.empty() && count == 2) {
            header.elements.back().properties.push_back({rest[1], type_of(rest[0]), std::nullopt});
        }
    }
    header.is_text = format == "ascii", header.is_big = format == "binary_big_endian";
    if (!header.is_text && !header.is_big && format != "binary_little_endian") {
        refuse({"expected a PLY of format ascii or binary, got ", format.empty() ? "none" : utf8(format.substr(0, 40))});
    }
    std::erase_if(header.elements, [](const Element& element) { return element.properties.empty(); });
    check_size(header, text.size() - end);
    return header;
}

// ---- Rows ------------------------------------------------------------------------------------------------

/// Not inlined: the code for all types takes more room than time.
[[gnu::noinline]] double number_at(const std::uint8_t* bytes, Type type, bool is_big) {
    return with(type, [&](auto value) { return static_cast<double>(load<decltype(value)>(bytes, is_big)); });
}

/// The destination of a property of each row: a column of (rows, width), or a list's numbers.
struct Target {
    double* column = nullptr;
    std::size_t width = 1;
    Numbers<std::int32_t>* indices = nullptr;
    Numbers<double>* values = nullptr;
    Numbers<std::int32_t>* lengths = nullptr;  // of the list in each row
};

/// The numbers of a body, one after the other. All throw Ended where it ends too early.
class Source {
public:
    virtual ~Source() = default;
    virtual void begin_row() = 0;
    virtual double number(Type type) = 0;
    virtual double length(Type type) = 0;
    virtual void skip(Type type, double count) = 0;
    /// Reads leading rows of a common layout quickly; returns their number.
    virtual std::uint64_t read_quickly(const Element&, std::span<const Target>) { return 0; }
};

class Binary final : public Source {
public:
    Binary(Bytes bytes, bool is_big) : bytes_(bytes), is_big_(is_big) {}

    void begin_row() override {}
    double number(Type type) override { return number_at(take(size_of(type)), type, is_big_); }
    double length(Type type) override { return number(type); }
    void skip(Type type, double count) override {
        if (count * static_cast<double>(size_of(type)) > static_cast<double>(bytes_.size())) throw Ended();
        take(static_cast<std::size_t>(count) * size_of(type));
    }
    std::uint64_t read_quickly(const Element& element, std::span<const Target> targets) override {
        const auto is_list = [](const Property& property) { return property.length.has_value(); };
        return std::ranges::none_of(element.properties, is_list) ? read_columns(element, targets) : read_triangles(element, targets[0]);
    }

private:
    const std::uint8_t* take(std::size_t size) {
        if (size > bytes_.size()) throw Ended();
        const std::uint8_t* const at = bytes_.data();
        bytes_ = bytes_.subspan(size);
        return at;
    }

    /// Rows that are all of one size.
    std::uint64_t read_columns(const Element& element, std::span<const Target> targets) {
        std::size_t stride = 0;
        for (const Property& property : element.properties) stride += size_of(property.type);
        if (element.rows > bytes_.size() / stride) throw Ended();
        const auto rows = static_cast<std::size_t>(element.rows);
        const std::uint8_t* at = take(rows * stride);
        for (std::size_t i = 0; i < targets.size(); ++i) {
            const Type type = element.properties[i].type;
            if (double* to = targets[i].column; to && type == Type::f4 && !is_big_) {  // nearly all files'
                read_floats(at, stride, rows, to, targets[i].width);
            } else if (to) {
                const std::uint8_t* from = at;
                for (std::size_t row = 0; row < rows; ++row, from += stride, to += targets[i].width) {
                    if (row % 65536 == 0) Interruption::check();
                    *to = number_at(from, type, is_big_);
                }
            }
            at += size_of(type);
        }
        return element.rows;
    }

    /// Rows that have nothing but a list of three indices, in a fifth of the time.
    std::uint64_t read_triangles(const Element& element, const Target& target) {
        const Property& list = element.properties[0];
        const bool is_plain = element.properties.size() == 1 && target.indices && list.length && size_of(*list.length) == 1 &&
                              (list.type == Type::i4 || list.type == Type::u4);
        if (!is_plain) return 0;
        constexpr std::size_t size = 13;
        const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(element.rows, bytes_.size() / size));
        Numbers<std::int32_t>& indices = *target.indices;
        const std::size_t start = indices.size();
        indices.resize(start + 3 * most);
        const std::size_t rows = read_triples(bytes_, most, is_big_, indices.data() + start);
        take(size * rows);
        indices.resize(start + 3 * rows);
        if (rows < element.rows) target.lengths->assign(rows, 3);  // else none, as of triangles alone
        return rows;
    }

    Bytes bytes_;
    bool is_big_;
};

/// A text, which has a line for each row. A line may hold more; some writers do that.
class Text final : public Source {
public:
    explicit Text(std::string_view text) : lines_(text) {}

    void begin_row() override {
        do {
            if (!lines_.next()) throw Ended();
            words_ = Words(lines_.line());
            word_ = words_.next();
        } while (word_.empty());
    }
    double number(Type) override { return number_of(take()); }
    double length(Type) override { return static_cast<double>(integer_of(take())); }
    void skip(Type, double count) override {
        for (double i = 0; i < count; ++i) static_cast<void>(number_of(take()));
    }

private:
    std::string_view take() {
        if (word_.empty()) throw Ended();
        const std::string_view word = word_;
        word_ = words_.next();
        return word;
    }

    Lines lines_;
    Words words_{{}};
    std::string_view word_;
};

void read_list(Source& source, const Property& property, const Target& target, std::size_t most) {
    const double length = source.length(*property.length);
    if (!(length >= 0 && length <= static_cast<double>(most) && length < 1u << 31)) {
        const std::string got = std::fabs(length) < 1e18 ? std::to_string(static_cast<std::int64_t>(length)) : "more";
        refuse({"expected a list no longer than the file, got one of ", got});
    }
    const double count = std::floor(length);
    if (target.lengths) target.lengths->push_back(static_cast<std::int32_t>(count));
    if (target.indices) {
        for (double i = 0; i < count; ++i) target.indices->push_back(index_of(source.number(property.type)));
    } else if (target.values) {
        for (double i = 0; i < count; ++i) target.values->push_back(source.number(property.type));
    } else {
        source.skip(property.type, count);
    }
}

void read_rows(Source& source, const Element& element, std::span<const Target> targets, std::size_t most, bool is_text) {
    std::uint64_t row = 0;
    try {
        for (row = source.read_quickly(element, targets); row < element.rows; ++row) {
            if (row % 4096 == 0) Interruption::check();
            source.begin_row();
            for (std::size_t i = 0; i < targets.size(); ++i) {
                const Property& property = element.properties[i];
                if (property.length) {
                    read_list(source, property, targets[i], most);
                } else if (const double number = source.number(property.type); targets[i].column) {
                    targets[i].column[row * targets[i].width] = number;
                }
            }
        }
    } catch (const Ended&) {
        const std::string why = is_text ? joined({"but row ", grouped(row + 1), " is missing or too short"}) : "but the file ends before them";
        refuse({"expected ", grouped(element.rows), " ", utf8(element.name.substr(0, 40)), ", ", why});
    }
}

// ---- Contents --------------------------------------------------------------------------------------------

/// A file's contents, before parts are made of it.
struct Tables {
    bool has_vertices = false;
    Numbers<double> vertices, normals, colors, face_colors, uv, corner_uv, numbers;  // numbers: of the textures of faces
    Polygons faces;
    Numbers<std::int32_t> strips, strip_sizes, corner_uv_sizes;
};

/// Triangle strips, which end with their list or at an index below 0 within it.
void add_strips(const Numbers<std::int32_t>& corners, const Numbers<std::int32_t>& sizes, Polygons& to) {
    std::size_t begin = 0;
    for (const std::int32_t size : sizes) {
        std::size_t start = begin;
        const std::size_t end = begin + static_cast<std::size_t>(size);
        for (std::size_t i = begin; i < end; ++i) {
            if (i % 65536 == 0) Interruption::check();
            if (corners[i] < 0) start = i + 1;
            if (i < start + 2) continue;
            const std::int32_t a = corners[i - 2], b = corners[i - 1], c = corners[i];
            if (a == b || b == c || c == a) continue;  // these steer a strip round a bend; they are not meant to be seen
            const bool is_odd = (i - start) % 2 == 1;  // every second triangle of a strip turns the other way
            to.add(std::array{is_odd ? b : a, is_odd ? a : b, c});
        }
        begin = end;
    }
}

/// The names of an element's colours, and whether they are in sRGB; empty without colours.
std::pair<const Names*, bool> color_names(const Element& element) {
    for (const Names& names : srgb_names) {
        if (element.has(names)) return {&names, true};
    }
    return {element.has(linear_names) ? &linear_names : nullptr, false};
}

class Rows {
public:
    explicit Rows(const Element& element) : element_(element), targets_(element.properties.size()) {}

    /// Has scalars read to the columns of (rows, names), which is made for them.
    void columns(std::span<const std::string_view> names, Numbers<double>& to) {
        to.resize(names.size() * static_cast<std::size_t>(element_.rows));
        if (to.empty()) return;
        for (std::size_t k = 0; k < names.size(); ++k) {
            Target& target = targets_[static_cast<std::size_t>(element_.scalar(names[k]) - element_.properties.data())];
            target.column = to.data() + k, target.width = names.size();
        }
    }
    Target& list(const Property& property) { return targets_[static_cast<std::size_t>(&property - element_.properties.data())]; }
    [[nodiscard]] std::span<const Target> targets() const { return targets_; }

private:
    const Element& element_;
    std::vector<Target> targets_;
};

Tables read_tables(const Header& header, Source& source, std::size_t most) {
    Tables tables;
    for (const Element& element : header.elements) {
        Rows rows(element);
        const Names* colors = nullptr;
        bool are_srgb = false;
        Numbers<double>* colored = nullptr;
        const Property* corners = element.list("vertex_indices");
        if (!corners) corners = element.list("vertex_index");
        if (element.name == "vertex" && element.has(Names{"x", "y", "z"})) {
            tables.has_vertices = true;
            for (Numbers<double>* own : {&tables.normals, &tables.colors, &tables.uv}) own->clear();  // of an element of the same name
            rows.columns(Names{"x", "y", "z"}, tables.vertices);
            if (element.has(Names{"nx", "ny", "nz"})) rows.columns(Names{"nx", "ny", "nz"}, tables.normals);
            for (const auto& names : uv_names) {
                if (tables.uv.empty() && !header.textures.empty() && element.has(names)) rows.columns(names, tables.uv);
            }
            std::tie(colors, are_srgb) = color_names(element);
            colored = &tables.colors;
        } else if (element.name == "face" && corners) {
            tables.faces = {};
            for (Numbers<double>* own : {&tables.face_colors, &tables.corner_uv, &tables.numbers}) own->clear();
            tables.corner_uv_sizes.clear();
            rows.list(*corners).indices = &tables.faces.corners, rows.list(*corners).lengths = &tables.faces.sizes;
            if (const Property* places = element.list("texcoord"); places && !header.textures.empty()) {
                rows.list(*places).values = &tables.corner_uv, rows.list(*places).lengths = &tables.corner_uv_sizes;
            }
            if (header.textures.size() > 1 && element.scalar("texnumber")) rows.columns(std::array{std::string_view("texnumber")}, tables.numbers);
            std::tie(colors, are_srgb) = color_names(element);
            colored = &tables.face_colors;
        } else if (element.name == "tristrips" && corners) {
            tables.strips.clear(), tables.strip_sizes.clear();
            rows.list(*corners).indices = &tables.strips, rows.list(*corners).lengths = &tables.strip_sizes;
        }
        if (colors) rows.columns(*colors, *colored);
        read_rows(source, element, rows.targets(), most, header.is_text);
        if (colors && are_srgb) {
            const Type type = element.scalar((*colors)[0])->type;
            make_linear(*colored, full_of(type), most_of(type));
        }
    }
    return tables;
}

/// Gives each corner its own vertex, with texture coordinates.
void spread(Part& part, Polygons& faces, Numbers<double>&& corner_uv) {
    part.vertices = picked(part.vertices, 3, faces.corners);
    if (!part.normals.empty()) part.normals = picked(part.normals, 3, faces.corners);
    if (!part.colors.empty()) part.colors = picked(part.colors, 3, faces.corners);
    part.uv.push_back(std::move(corner_uv));
    for (std::size_t i = 0; i < faces.corners.size(); ++i) faces.corners[i] = static_cast<std::int32_t>(i);
}

bool fit(const Numbers<std::int32_t>& corner_uv_sizes, const Polygons& faces) {
    return !corner_uv_sizes.empty() && std::ranges::equal(corner_uv_sizes, faces.sizes, [](std::int32_t places, std::int32_t size) {
        return places == 2 * static_cast<std::int64_t>(size);
    });
}

}  // namespace

Contents read_ply(Bytes bytes, Beside&) {
    const std::string_view text = text_of(bytes);
    bytes = bytes.last(text.size());
    Header header = read_header(text);
    NotShown not_shown;
    for (const Element& element : header.elements) {
        if (element.name == "edge" && element.rows) not_shown.add("lines");
        if (element.name == "material" && element.rows) not_shown.add("materials");
    }
    // Whatever comes after the last of these is of no use here.
    while (!header.elements.empty() && header.elements.back().name != "vertex" && header.elements.back().name != "face" &&
           header.elements.back().name != "tristrips") {
        header.elements.pop_back();
    }
    Text lines(header.is_text ? text.substr(header.end) : std::string_view());
    Binary binary(bytes.subspan(header.end), header.is_big);
    Tables tables = read_tables(header, header.is_text ? static_cast<Source&>(lines) : binary, bytes.size());
    if (!tables.has_vertices) refuse({"expected a PLY with vertices x, y, z, got none"});

    Contents contents;
    Part part;
    part.vertices = std::move(tables.vertices), part.normals = std::move(tables.normals), part.colors = std::move(tables.colors);
    Polygons& faces = tables.faces;
    const bool has_strips = !tables.strips.empty();
    if (!tables.uv.empty()) {
        part.uv.push_back(std::move(tables.uv));
    } else if (fit(tables.corner_uv_sizes, faces) && !has_strips) {
        spread(part, faces, std::move(tables.corner_uv));
    } else if (!tables.corner_uv.empty()) {
        contents.warnings.push_back(joined({"texture ", header.textures[0], " was left out: expected two numbers in texcoord for each corner"}));
    }
    for (auto& uv : part.uv) {
        for (std::size_t i = 1; i < uv.size(); i += 2) uv[i] = 1 - uv[i];  // places are counted from the bottom up
    }
    // Vertex colours take precedence over face colours.
    if (part.colors.empty() && !tables.face_colors.empty()) part.face_colors = of_triangles(std::move(tables.face_colors), 3, faces);
    Numbers<double> numbers = tables.numbers.empty() ? Numbers<double>() : of_triangles(std::move(tables.numbers), 1, faces);
    if (std::ranges::all_of(faces.sizes, [](std::int32_t size) { return size == 3; })) faces.sizes.clear();
    part.triangles = triangulated(std::move(faces), part.vertices, {}, contents.warnings);
    if (has_strips) {
        Polygons strips;
        add_strips(tables.strips, tables.strip_sizes, strips);
        if (!part.face_colors.empty()) part.face_colors.resize(part.triangles.size() + strips.corners.size(), 1);
        part.triangles.insert(part.triangles.end(), strips.corners.begin(), strips.corners.end());
    }
    not_shown.report(contents, !part.triangles.empty());
    if (part.uv.empty()) {
        contents.parts.push_back(std::move(part));
        return contents;
    }

    for (std::string& name : header.textures) {
        Surface& surface = contents.surfaces.emplace_back();
        surface.color.image = static_cast<int>(contents.images.size());
        surface.replaces_color = true;
        contents.images.push_back({std::move(name)});
    }
    if (numbers.empty()) {
        part.surface = 0;
        contents.parts.push_back(std::move(part));
        if (const std::size_t others = contents.images.size() - 1) {
            const std::string further = others > 1 ? joined({" and ", grouped(others - 1), " more were"}) : " was";
            contents.warnings.push_back(
                joined({"texture ", contents.images[1].name, further, " left out: expected texnumber of faces, got none"}));
        }
        contents.images.resize(1), contents.surfaces.resize(1);
        return contents;
    }
    numbers.resize(part.triangles.size() / 3, -1);
    const std::size_t count = header.textures.size();
    std::vector<std::int32_t> groups(numbers.size());
    for (std::size_t i = 0; i < groups.size(); ++i) {
        const std::int32_t number = index_of(numbers[i]);
        groups[i] = number >= 0 && static_cast<std::size_t>(number) < count ? number : static_cast<std::int32_t>(count);
    }
    contents.parts = split(part, groups, count + 1);  // the last is without a texture
    for (std::size_t i = 0; i < count; ++i) contents.parts[i].surface = static_cast<int>(i);
    contents.parts.back().uv.clear();
    std::erase_if(contents.parts, [](const Part& own) { return own.triangles.empty(); });
    return contents;
}

}  // namespace bob::files
