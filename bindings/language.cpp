/// Languages: shape scripts and .vm formulas, both from a file's bytes.
#include <optional>
#include <string_view>
#include <utility>

#include "bindings.h"
#include "formula/vm.h"
#include "modelling/script.h"

using namespace nb::literals;

namespace {

template <auto read>
auto from_bytes(const nb::bytes& text) {
    std::optional<decltype(read({}))> made;
    interruptible([&] { made.emplace(read({text.c_str(), text.size()})); });
    return std::move(*made);
}

}  // namespace

void bind_language(nb::module_& m) {
    m.def("run_script", &from_bytes<bob::run_script>, "source"_a, "The shape of a script; ValueError with line and column if it is none.");
    m.def("parse_vm", &from_bytes<bob::parse_vm>, "text"_a, "The formula of a .vm file; ValueError with its line if it is none.");
}
