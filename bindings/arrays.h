/// What the bindings share: arrays of fixed types, and work that Ctrl-C can stop.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <chrono>
#include <cstdint>
#include <span>

namespace nb = nanobind;
using namespace nb::literals;

template <class T, nb::ssize_t... Shape>
using Array = nb::ndarray<T, nb::numpy, nb::shape<Shape...>, nb::c_contig, nb::device::cpu>;
using Points = Array<const float, -1, 3>;
using Pixels = Array<const std::int32_t, -1, 2>;
using Image = Array<float, -1, -1>;

inline void expect(bool condition, const char* what) {
    if (!condition) throw nb::value_error(what);
}

template <class T, class A>
std::span<const T> items(const A& array) {
    return {reinterpret_cast<const T*>(array.data()), array.shape(0)};
}

/// Runs work(keep_going) without the GIL and lets Ctrl-C stop it: when asked, keep_going runs Python's signal handlers
/// now and then, on the main thread, with the GIL taken back. What a handler raised is raised here.
template <class Work>
void interruptible(Work work) {
    auto asked = std::chrono::steady_clock::now();
    bool raised = false;
    {
        const nb::gil_scoped_release release;
        work([&] {
            const auto now = std::chrono::steady_clock::now();
            if (now - asked < std::chrono::milliseconds(20)) return true;
            asked = now;
            const nb::gil_scoped_acquire gil;
            raised = PyErr_CheckSignals() != 0;
            return !raised;
        });
    }
    if (raised) throw nb::python_error();
}

/// Adds the shapes and scenes to the module.
void bind_scene(nb::module_& m);
