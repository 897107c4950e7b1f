/// The core as a Python module: convert and call. Arguments are checked by the Python package, in better words; here
/// only what would read or write out of bounds.
#include <nanobind/stl/string_view.h>

#include <string>
#include <string_view>
#include <vector>

#include "bindings.h"
#include "completion/incremental.h"
#include "completion/known.h"
#include "completion/paper.h"
#include "completion/pyramid.h"
#include "isa.h"
#include "parallel.h"
#include "picture/order.h"

using namespace nb::literals;

namespace {

void pixel_order(std::string_view name, std::uint64_t seed, std::uint32_t height, std::uint32_t width,
                 std::uint32_t start, const Array<std::int32_t, -1, 2>& pixels) {
    expect(std::uint64_t{start} + pixels.shape(0) <= std::uint64_t{height} * width, "start: beyond the last pixel");
    const auto write = [&](const auto& order) {
        const std::span all(reinterpret_cast<bob::Pixel*>(pixels.data()), pixels.shape(0));
        interruptible([&](const auto& keep_going) {
            bob::parallel_for(all.size(), 8192, [&](std::size_t begin, std::size_t end) {
                order(start + static_cast<std::uint32_t>(begin), all.subspan(begin, end - begin));
            }, keep_going);
        });
    };
    if (name == "uniform") {
        write(bob::UniformOrder(seed, height, width));
    } else {
        const bob::Tile* tile = bob::find_tile(name);
        expect(tile, "order: unknown");
        write(bob::TiledOrder(*tile, seed, height, width));
    }
}

template <class Network>
void init_network(Network* self, const nb::dict& tensors) {
    bob::Weights weights;
    std::vector<nb::ndarray<const float, nb::c_contig, nb::device::cpu>> arrays;  // keeps converted values alive
    for (const auto& [key, value] : tensors) {
        arrays.push_back(nb::cast<nb::ndarray<const float, nb::c_contig, nb::device::cpu>>(value));
        const auto& array = arrays.back();
        bob::Tensor tensor{{}, {array.data(), array.size()}};
        for (std::size_t axis = 0; axis < array.ndim(); ++axis) {
            tensor.shape.push_back(static_cast<int>(array.shape(axis)));
        }
        weights.emplace(nb::cast<std::string_view>(key), std::move(tensor));
    }
    new (self) Network(weights);
}

template <class Network>
void run_network(Network& network, const Array<const float, 5, -1, -1>& gbuffer, const Image& gray) {
    expect(gray.shape(0) == gbuffer.shape(1) && gray.shape(1) == gbuffer.shape(2), "gray: expected the input's size");
    interruptible([&](const auto& keep_going) {
        network(gbuffer.data(), static_cast<int>(gray.shape(0)), static_cast<int>(gray.shape(1)), gray.data(), keep_going);
    });
}

void keep_known(const Array<const float, 5, -1, -1>& gbuffer, const Image& gray) {
    expect(gray.shape(0) == gbuffer.shape(1) && gray.shape(1) == gbuffer.shape(2), "gray: expected the input's size");
    const nb::gil_scoped_release release;
    bob::keep_known(gbuffer.data(), gray.size(), gray.data());
}

/// A network of the core, under its own name, and what completes changed pictures with it.
template <class Network>
void bind_network(nb::module_& m, const char* name) {
    using Incremental = bob::Incremental<Network>;
    nb::class_<Incremental>(m, (std::string("Incremental") + name).c_str())
        .def("__call__", &run_network<Incremental>, "gbuffer"_a.noconvert(), "gray"_a.noconvert());
    nb::class_<Network>(m, name)
        .def("__init__", &init_network<Network>, "tensors"_a)
        .def("__call__", &run_network<const Network>, "gbuffer"_a.noconvert(), "gray"_a.noconvert())
        .def("incremental", [](const Network& self) { return new Incremental(self); }, nb::rv_policy::take_ownership,
             nb::keep_alive<0, 1>());
}

bool set_isa(std::string_view name) {
    for (const bob::Isa isa : {bob::Isa::baseline, bob::Isa::avx2, bob::Isa::avx512}) {
        if (bob::name(isa) == name) return bob::set_isa(isa);
    }
    return false;
}

}  // namespace

NB_MODULE(_core, m) {
    m.doc() = "The C++ core of BobRossNet.";
    nb::set_leak_warnings(false);  // what a user's modules still hold when Python ends is no leak

    m.def("thread_count", &bob::thread_count);
    m.def("set_thread_count", &bob::set_thread_count, "count"_a);
    m.def("isa", [] { return bob::name(bob::isa()); });
    m.def("set_isa", &set_isa, "name"_a);

    bind_shapes(m);
    bind_scene(m);

    m.def("pixel_order", &pixel_order, "order"_a, "seed"_a, "height"_a, "width"_a, "start"_a, "pixels"_a.noconvert());

    bind_network<bob::Paper>(m, "Paper");
    bind_network<bob::Pyramid>(m, "Pyramid");
    m.def("keep_known", &keep_known, "gbuffer"_a.noconvert(), "gray"_a.noconvert());

    bind_formula(m);
    bind_modelling(m);
    bind_nurbs(m);
    bind_language(m);
}
