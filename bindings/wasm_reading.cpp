/// Reading of files in the WebAssembly modules.
#include "wasm_reading.h"

#include "base/units.h"
#include "shapes/mesh/lying.h"
#include "wasm.h"

/// Reads on; returns 0 if that fails. Afterwards `reading_text` is the name of a file that is needed first, which
/// `answer_reading` has to answer; empty at the end.
EXPORT(read_on) bool read_on(Reading* reading) {
    return attempt([&] {
        reading->text = reading->core.go_on();
        return true;
    });
}

/// Gives the file, or if `is_there` is 0, the reason why it can't be read.
EXPORT(answer_reading)
bool answer_reading(Reading* reading, const std::uint8_t* bytes, std::size_t size, bool is_there) {
    return attempt([&] {
        if (is_there) {
            reading->core.give({bytes, size});
        } else {
            reading->core.refuse({reinterpret_cast<const char*>(bytes), size});
        }
        return true;
    });
}

/// Writes the description of the file's contents to `reading_text`, and their numbers to `reading_numbers` (core/files/read.h).
EXPORT(describe_reading) bool describe_reading(Reading* reading) {
    return attempt([&] {
        reading->text = bob::files::description(reading->core.contents());
        reading->numbers = bob::files::numbers(reading->core.contents());
        return true;
    });
}

EXPORT(reading_text) const char* reading_text(const Reading* reading) { return reading->text.data(); }
EXPORT(reading_text_size) std::size_t reading_text_size(const Reading* reading) { return reading->text.size(); }

EXPORT(reading_numbers) const double* reading_numbers(const Reading* reading) { return reading->numbers.data(); }
EXPORT(reading_numbers_size) std::size_t reading_numbers_size(const Reading* reading) { return reading->numbers.size(); }

/// A part's triangles, (T, 3).
EXPORT(part_triangles) const std::int32_t* part_triangles(Reading* reading, std::size_t part) {
    return reading->core.contents().parts[part].triangles.data();
}
EXPORT(part_triangles_size) std::size_t part_triangles_size(Reading* reading, std::size_t part) {
    return reading->core.contents().parts[part].triangles.size();
}

/// A part's array by its number, as bob::files::field has it.
EXPORT(part_field) const double* part_field(Reading* reading, std::size_t part, std::size_t number) {
    return bob::files::field(reading->core.contents().parts[part], number).data();
}
EXPORT(part_field_size) std::size_t part_field_size(Reading* reading, std::size_t part, std::size_t number) {
    return bob::files::field(reading->core.contents().parts[part], number).size();
}

/// An embedded image file.
EXPORT(reading_image) const std::uint8_t* reading_image(Reading* reading, std::size_t number) {
    return reading->core.contents().images[number].bytes.data();
}
EXPORT(reading_image_size) std::size_t reading_image_size(Reading* reading, std::size_t number) {
    return reading->core.contents().images[number].bytes.size();
}

/// Metres in a unit of length.
EXPORT(unit_metres) double unit_metres(const char* name, std::size_t size) {
    return attempt([&] {
        std::string message = "unit: expected one of ";
        for (const bob::Unit& unit : bob::units) {
            if (unit.name == std::string_view(name, size)) return unit.metres;
            message.append(unit.name).append(&unit == &bob::units.back() ? ", got " : ", ");
        }
        throw std::invalid_argument(message.append(name, size));
    });
}

/// Whether y is more likely the up axis of a mesh than z.
EXPORT(seems_to_lie)
bool seems_to_lie(const bob::Vec3d* vertices, std::size_t count, const std::array<std::int32_t, 3>* triangles, std::size_t triangle_count) {
    return attempt([&] { return bob::seems_to_lie({vertices, count}, {triangles, triangle_count}); });
}

EXPORT(free_reading) void free_reading(Reading* reading) { delete reading; }
