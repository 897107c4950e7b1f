/// Shared parts of the Python module: arrays, checks, and work without the GIL.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "threads.h"

namespace nb = nanobind;

template <class T, nb::ssize_t... Shape>
using Array = nb::ndarray<T, nb::numpy, nb::shape<Shape...>, nb::c_contig, nb::device::cpu>;

using Points = Array<const float, -1, 3>;
using Pixels = Array<const std::int32_t, -1, 2>;
using Samples = Array<float, -1, -1>;     // (n, C)
using Planes = Array<float, -1, -1, -1>;  // (C, height, width)
using Plane = Array<float, -1, -1>;
using ConstPlane = Array<const float, -1, -1>;
using ConstPlanes = Array<const float, -1, -1, -1>;

/// Python types with parameters, for the stub.
using AnyObject = nb::typed<nb::object, nb::any>;
using AnyTuple = nb::typed<nb::tuple, nb::any, nb::ellipsis>;
using Keywords = nb::typed<nb::dict, nb::str, nb::any>;

inline void expect(bool condition, const char* what) {
    if (!condition) throw nb::value_error(what);
}

template <class T, class A>
std::span<const T> items(const A& array) {
    return {reinterpret_cast<const T*>(array.data()), array.shape(0)};
}

/// Whether two planes, or stacks of planes, have the same height and width.
template <class A, class B>
bool same_size(const A& a, const B& b) {
    const std::size_t i = a.ndim(), j = b.ndim();
    return a.shape(i - 2) == b.shape(j - 2) && a.shape(i - 1) == b.shape(j - 1);
}

/// An affine map with last row (0, 0, 0, 1).
using Matrix = Array<const double, 4, 4>;

/// A new Python array, uninitialized.
template <class T, nb::ssize_t... Shape, class... Sizes>
Array<T, Shape...> make_array(Sizes... sizes) {
    const std::size_t shape[] = {static_cast<std::size_t>(sizes)...};
    auto values = std::make_unique_for_overwrite<T[]>((static_cast<std::size_t>(sizes) * ...));
    T* data = values.get();
    const nb::capsule owner(values.release(), [](void* p) noexcept { delete[] static_cast<T*>(p); });
    return Array<T, Shape...>(data, sizeof...(sizes), shape, owner);
}

/// A new Python array of pixels, (n, 2).
inline Array<std::int32_t, -1, 2> pixel_array(std::span<const bob::Pixel> pixels) {
    auto made = make_array<std::int32_t, -1, 2>(pixels.size(), 2);
    std::int32_t* to = made.data();
    for (const auto [row, column] : pixels) *to++ = row, *to++ = column;
    return made;
}

/// Raises ValueError unless the pixels lie inside the image.
void check_pixels(const Pixels& pixels, int height, int width);
/// Raises ValueError unless there are `count` samples of the layout's width.
void check_width(const bob::Layout& layout, std::size_t count, const Samples& samples);

void bind_completion(nb::module_& m);
void bind_drawing(nb::module_& m);
void bind_files(nb::module_& m);
void bind_formula(nb::module_& m);
void bind_language(nb::module_& m);
void bind_light(nb::module_& m);
void bind_modelling(nb::module_& m);
void bind_nurbs(nb::module_& m);
void bind_picture(nb::module_& m);
void bind_frame(nb::module_& m);
void bind_scene(nb::module_& m);
void bind_shapes(nb::module_& m);
