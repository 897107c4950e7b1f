/// Reading of mesh files.
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "bindings.h"
#include "files/gltf_data.h"
#include "files/read.h"

using namespace nb::literals;

namespace {

bob::files::Bytes span_of(const nb::bytes& data) { return {static_cast<const std::uint8_t*>(data.data()), data.size()}; }

/// A reading, and the bytes that it reads.
struct Reading {
    Reading(std::string_view format, const nb::bytes& data) : data_(data), core_(format, span_of(data)) {}

    std::string go_on() {
        const InUse in_use(this);
        std::string wanted;
        interruptible([&] { wanted = core_.go_on(); });
        return wanted;
    }
    void give(const nb::bytes& data) { core_.give(span_of(data)); }
    void refuse(std::string_view why) { core_.refuse(why); }
    std::string description() { return bob::files::description(core_.contents()); }
    Array<double, -1, -1> numbers();
    bob::files::Part& part(std::size_t number) { return core_.contents().parts.at(number); }
    nb::bytes image(std::size_t number) {
        const auto& bytes = core_.contents().images.at(number).bytes;
        return nb::bytes(bytes.data(), bytes.size());
    }

private:
    nb::bytes data_;
    bob::files::Reading core_;
};

/// An array of Python's, (n, width), that owns the numbers from now on.
template <class T>
Array<T, -1, -1> handed_over(bob::files::Numbers<T>& numbers, std::size_t width) {
    auto own = std::make_unique<bob::files::Numbers<T>>(std::move(numbers));
    numbers.clear();
    const std::size_t shape[] = {own->size() / width, width};
    T* const data = own->data();
    const nb::capsule owner(own.release(), [](void* p) noexcept { delete static_cast<bob::files::Numbers<T>*>(p); });
    return Array<T, -1, -1>(data, 2, shape, owner);
}

Array<double, -1, -1> Reading::numbers() {
    auto numbers = bob::files::numbers(core_.contents());
    return handed_over(numbers, 1);
}

std::optional<Array<double, -1, -1>> field(Reading& reading, std::size_t part, std::size_t number) {
    auto& numbers = bob::files::field(reading.part(part), number);
    if (numbers.empty() && number > 0) return std::nullopt;
    return handed_over(numbers, number < 4 ? 3 : number == 4 ? 1 : 2);
}

}  // namespace

void bind_files(nb::module_& m) {
    m.attr("MAX_ITEMS") = bob::files::max_items;
    nb::class_<Reading>(m, "Reading",
        "Reads a mesh file, whose name ends in `format`, in as many steps as it takes to fetch other files that it names. ValueError, of "
        "one line, if it can't be read.")
        .def(nb::init<std::string_view, const nb::bytes&>(), "format"_a, "data"_a)
        .def("go_on", &Reading::go_on,
             "The name of a file that is needed first, which `give` or `refuse` has to answer; empty at the end.")
        .def("give", &Reading::give, "data"_a)
        .def("refuse", &Reading::refuse, "why"_a)
        .def("description", &Reading::description, "All but numbers and images, as JSON (core/files/read.h).")
        .def("numbers", &Reading::numbers, "The numbers of the description, (n, 1): 13 for each surface, then 16 for each placement.")
        .def("triangles", [](Reading& reading, std::size_t part) { return handed_over(reading.part(part).triangles, 3); }, "part"_a,
             "(T, 3), handed over: the next call has none.")
        .def("field", &field, "part"_a, "number"_a,
             "Vertices, normals, colors, face_colors, alphas, and from 5 on uv sets, (n, 3), (n, 2) or (n, 1), handed over; None if the "
             "file has none.")
        .def("image", &Reading::image, "number"_a, "The embedded file.");
}
