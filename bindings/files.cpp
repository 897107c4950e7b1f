/// Reading of mesh files.
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/units.h"
#include "bindings.h"
#include "files/placing.h"
#include "files/read.h"
#include "files/threemf/functions.h"

using namespace nb::literals;

namespace {

bob::files::Bytes span_of(const nb::bytes& data) { return {static_cast<const std::uint8_t*>(data.data()), data.size()}; }

/// A reading, and the bytes that it reads.
struct Reading {
    Reading(std::string_view format, const nb::bytes& data) : data_(data), core_(bob::files::reader_of(format), span_of(data)) {}

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
    bob::files::OtherShape& shape(std::size_t number) { return core_.contents().shapes.at(number); }
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

/// The arrays of a tube, or the formulas and the bounds of an implicit surface.
nb::typed<nb::tuple, nb::any, nb::ellipsis> shape(Reading& reading, std::size_t number) {
    auto& shape = reading.shape(number).shape;
    if (auto* const beams = std::get_if<bob::files::Beams>(&shape)) {
        return nb::make_tuple(handed_over(beams->ends, 3), handed_over(beams->radii, 2));
    }
    const auto& level_set = std::get<bob::files::LevelSet>(shape);
    auto bounds = make_array<double, 2, 3>(2, 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds.data()[axis] = level_set.bounds.low[axis];
        bounds.data()[3 + axis] = level_set.bounds.high[axis];
    }
    nb::object color = nb::none();
    if (level_set.color) color = nb::cast(*level_set.color);
    return nb::make_tuple(level_set.formula, std::move(bounds), color);
}

}  // namespace

void bind_files(nb::module_& m) {
    m.def("units", [] {
        std::vector<std::tuple<std::string_view, double>> all;
        for (const bob::Unit& unit : bob::units) all.emplace_back(unit.name, unit.metres);
        return all;
    }, "Units of length, and metres in each.");
    m.attr("MAX_FUNCTION_NODES") = bob::files::threemf::max_nodes;
    nb::class_<Reading>(m, "Reading",
        "Reads a mesh file, whose name ends in `format`, in as many steps as it takes to fetch other files that it names. ValueError, of "
        "one line, if it can't be read.")
        .def(nb::init<std::string_view, const nb::bytes&>(), "format"_a, "data"_a)
        .def("go_on", &Reading::go_on,
             "The name of a file that is needed first, which `give` or `refuse` has to answer; empty at the end.")
        .def("give", &Reading::give, "data"_a)
        .def("refuse", &Reading::refuse, "why"_a)
        .def("description", &Reading::description, "All but numbers and images, as JSON (core/files/read.h).")
        .def("numbers", &Reading::numbers, "The numbers of the description, (n, 1) (core/files/read.h).")
        .def("triangles", [](Reading& reading, std::size_t part) { return handed_over(reading.part(part).triangles, 3); }, "part"_a,
             "(T, 3), handed over: the next call has none.")
        .def("field", &field, "part"_a, "number"_a,
             "Vertices, normals, colors, face_colors, alphas, and from 5 on uv sets, (n, 3), (n, 2) or (n, 1), handed over; None if the "
             "file has none.")
        .def("shape", &shape, "number"_a,
             "A shape other than a mesh: the ends (2 n, 3) and radii (n, 2) of beams, handed over; or a formula, its bounds (2, 3) and its "
             "colour or None.")
        .def("image", &Reading::image, "number"_a, "The embedded file.");
}
