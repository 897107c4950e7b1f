/// STL, text and binary. Its normals, one for each face, are those of the triangles, and are left out.
#include <bit>
#include <limits>
#include <stdexcept>

#include "base/interruption.h"
#include "files/read.h"
#include "files/text.h"

namespace bob::files {
namespace {

constexpr std::size_t header = 84, facet = 50, normal = 12;  // bytes

/// Joins vertices in the same place, which STL repeats for every triangle, in the order in which they come first.
template <class T>
class Welding {
public:
    explicit Welding(std::size_t corners) : slots_(std::bit_ceil(corners / 2 + 16), -1) { part_.triangles.reserve(corners); }

    void add(T x, T y, T z) {
        const T place[] = {x + 0, y + 0, z + 0};  // of -0 and 0, one
        if (4 * (part_.vertices.size() / 3 + 1) > 3 * slots_.size()) grow();
        std::int32_t& slot = find(place);
        if (slot < 0) {
            if (part_.vertices.size() / 3 >= std::numeric_limits<std::int32_t>::max()) throw std::bad_alloc();
            slot = static_cast<std::int32_t>(part_.vertices.size() / 3);
            part_.vertices.insert(part_.vertices.end(), {place[0], place[1], place[2]});
        }
        part_.triangles.push_back(slot);
    }

    [[nodiscard]] Part part() && { return std::move(part_); }

private:
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;

    static std::size_t hash(const T (&place)[3]) {
        std::uint64_t hash = 0;
        for (const T x : place) hash = (std::rotl(hash, 5) ^ std::bit_cast<Bits>(x)) * 0x9e3779b97f4a7c15;
        return static_cast<std::size_t>(hash >> 20);
    }

    bool is_at(std::int32_t vertex, const T (&place)[3]) const {
        const double* own = &part_.vertices[3 * static_cast<std::size_t>(vertex)];
        for (int axis = 0; axis < 3; ++axis) {
            if (std::bit_cast<Bits>(static_cast<T>(own[axis])) != std::bit_cast<Bits>(place[axis])) return false;
        }
        return true;
    }

    std::int32_t& find(const T (&place)[3]) {
        std::size_t at = hash(place) & (slots_.size() - 1);
        while (slots_[at] >= 0 && !is_at(slots_[at], place)) at = (at + 1) & (slots_.size() - 1);
        return slots_[at];
    }

    void grow() {
        Interruption::check();
        slots_.assign(2 * slots_.size(), -1);
        const double* own = part_.vertices.data();
        for (std::size_t vertex = 0; vertex < part_.vertices.size() / 3; ++vertex, own += 3) {
            const T place[] = {static_cast<T>(own[0]), static_cast<T>(own[1]), static_cast<T>(own[2])};
            find(place) = static_cast<std::int32_t>(vertex);
        }
    }

    std::vector<std::int32_t> slots_;  // vertices by their hashes; -1 where there is none
    Part part_;
};

float float_at(const std::uint8_t* bytes) {
    const std::uint32_t bits = bytes[0] | bytes[1] << 8u | bytes[2] << 16u | static_cast<std::uint32_t>(bytes[3]) << 24u;
    return std::bit_cast<float>(bits);
}

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

Part read_binary(Bytes bytes, std::size_t count) {
    const bool has_attributes = bytes.size() != header + facet * count && end_with_attributes(bytes, count) == bytes.size();
    Welding<float> welding(3 * count);
    std::size_t at = header;
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        const std::uint8_t* corner = &bytes[at + normal];
        for (int k = 0; k < 3; ++k, corner += 12) welding.add(float_at(corner), float_at(corner + 4), float_at(corner + 8));
        at += facet + (has_attributes ? corner[0] | corner[1] << 8u : 0);
    }
    return std::move(welding).part();
}

[[noreturn]] void refuse_line(std::string_view line) {
    refuse({"expected facets of three vertices, each of three numbers, got ", quoted(trimmed(line))});
}

double coordinate(std::string_view word, std::string_view line) {
    try {
        return number_of(word);
    } catch (const std::invalid_argument&) {
        if (word.find(',') != std::string_view::npos) throw;
        refuse_line(line);
    }
}

std::vector<Part> read_text(std::string_view text) {
    std::vector<Part> parts;
    Welding<double> welding(3 * (text.size() / 256));
    int corners = -1;  // of the facet so far; -1 outside of one
    const auto end_solid = [&] {
        if (Part part = std::move(welding).part(); !part.triangles.empty()) parts.push_back(std::move(part));
        welding = Welding<double>(0);
    };
    for (Lines lines(text); lines.next();) {
        Words words(lines.line());
        const std::string_view word = words.next();
        if (is_word(word, "vertex")) {
            if (++corners < 1 || corners > 3) refuse_line(lines.line());
            double place[3];
            for (double& x : place) {
                const std::string_view digits = words.next();
                if (digits.empty()) refuse_line(lines.line());
                x = coordinate(digits, lines.line());
            }
            if (!words.next().empty()) refuse_line(lines.line());
            welding.add(place[0], place[1], place[2]);
        } else if (is_word(word, "facet")) {
            if (corners >= 0) refuse_line(lines.line());
            corners = 0;
        } else if (is_word(word, "endfacet")) {
            if (corners != 3) refuse_line(lines.line());
            corners = -1;
        } else if (is_word(word, "endsolid")) {
            end_solid();
        }
    }
    if (corners > 0) refuse_line("the end of the file");
    end_solid();
    return parts;
}

}  // namespace

Contents read_stl(Bytes bytes, Beside&) {
    const std::string_view text = text_of(bytes), head = text.substr(0, header);
    const std::size_t count = bytes.size() < header ? 0 : std::bit_cast<std::uint32_t>(float_at(&bytes[80]));
    const bool is_exact = bytes.size() >= header && (bytes.size() - header) / facet == count && (bytes.size() - header) % facet == 0;
    const bool is_text = is_word(trimmed(head).substr(0, 5), "solid") && head.find('\0') == std::string_view::npos;
    Contents contents;
    if (!is_exact && is_text) {
        contents.parts = read_text(text);
    } else if (is_exact || (count > 0 && bytes.size() >= header && (bytes.size() - header) / facet >= count)) {
        contents.parts.push_back(read_binary(bytes, count));
    } else {
        refuse({"expected an STL of 84 + 50 n bytes for n triangles, got ", grouped(bytes.size()), " bytes"});
    }
    return contents;
}

}  // namespace bob::files
