/// The core as a Python module: converts and calls. The Python package checks arguments, with better messages; only
/// out-of-bounds accesses are checked here.
#include <nanobind/stl/string_view.h>

#include <string_view>

#include "base/isa.h"
#include "base/parallel.h"
#include "bindings.h"

using namespace nb::literals;

namespace {

bool set_isa(std::string_view name) {
    for (const bob::Isa isa : {bob::Isa::baseline, bob::Isa::avx2, bob::Isa::avx512}) {
        if (bob::name(isa) == name) return bob::set_isa(isa);
    }
    return false;
}

}  // namespace

NB_MODULE(_core, m) {
    m.doc() = "The C++ core of BobRossNet.";
    nb::set_leak_warnings(false);  // objects that user modules still hold at exit are no leaks

    m.def("thread_count", &bob::thread_count);
    m.def("set_thread_count", &bob::set_thread_count, "count"_a);
    m.def("isa", [] { return bob::name(bob::isa()); });
    m.def("set_isa", &set_isa, "name"_a);

    bind_threads(m);
    bind_picture(m);
    bind_frame(m);
    bind_files(m);
    bind_shapes(m);
    bind_scene(m);
    bind_drawing(m);
    bind_light(m);
    bind_completion(m);

    bind_formula(m);
    bind_modelling(m);
    bind_nurbs(m);
    bind_language(m);
}
