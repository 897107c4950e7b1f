/// Networks: made of a weight file's tensors, and run.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/unique_ptr.h>

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.h"
#include "completion/error_predictor.h"
#include "completion/guided.h"
#include "completion/interpolation.h"
#include "completion/known.h"
#include "completion/network.h"
#include "completion/ratio.h"
#include "picture/gbuffer.h"

using namespace nb::literals;

namespace {

using Tensor = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;
using Tensors = nb::typed<nb::dict, nb::str, Tensor>;

/// A network in a class for Python, whose objects are not const.
struct Network {
    std::unique_ptr<const bob::Network> core;
};

/// Calls `make` with the weights of a dict of arrays.
template <class Make>
void with_weights(const Tensors& tensors, const bob::Layout& inputs, const bob::Layout& outputs, Make make) {
    bob::Weights weights{inputs, outputs, {}};
    std::vector<Tensor> arrays;  // keeps converted values alive
    for (const auto& [key, value] : tensors) {
        const Tensor& array = arrays.emplace_back(nb::cast<Tensor>(value));
        bob::Tensor tensor{{}, {array.data(), array.size()}};
        for (std::size_t axis = 0; axis < array.ndim(); ++axis) tensor.shape.push_back(static_cast<int>(array.shape(axis)));
        weights.tensors.emplace(nb::cast<std::string_view>(key), std::move(tensor));
    }
    make(weights);
}

void init_network(Network* self, std::string_view name, const Tensors& tensors, const bob::Layout& inputs,
                  const bob::Layout& outputs) {
    with_weights(tensors, inputs, outputs, [&](const bob::Weights& weights) { new (self) Network{bob::make_network(name, weights)}; });
}

void init_predictor(bob::ErrorPredictor* self, const Tensors& tensors) {
    with_weights(tensors, bob::gbuffer_layout(), {bob::channels::gray},
                 [&](const bob::Weights& weights) { new (self) bob::ErrorPredictor(weights); });
}

template <class Output>
void check_planes(const bob::Layout& layout, const ConstPlanes& planes, const bob::Layout& completed, const Output& output) {
    expect(planes.shape(0) == static_cast<std::size_t>(layout.width()), "planes: expected the layout's width");
    expect(output.shape(0) == static_cast<std::size_t>(completed.width()), "output: expected the outputs' width");
    expect(same_size(output, planes), "output: expected the planes' size");
}

void complete(const bob::Network& network, const bob::Layout& layout, const ConstPlanes& planes, const Planes& output) {
    check_planes(layout, planes, network.outputs(), output);
    std::vector<float> storage;
    const float* const inputs = bob::select(layout, planes.data(), network.inputs(), planes.shape(1) * planes.shape(2), storage);
    interruptible([&] {
        network(inputs, static_cast<int>(planes.shape(1)), static_cast<int>(planes.shape(2)), output.data());
    });
}

void keep_known(const bob::Layout& known, const ConstPlanes& planes, const bob::Layout& completed, const Planes& output) {
    check_planes(known, planes, completed, output);
    without_gil([&] { bob::keep_known(known, planes.data(), completed, output.data(), planes.shape(1) * planes.shape(2)); });
}

void interpolate_lattice(const bob::Layout& known, const ConstPlanes& planes, const bob::Layout& completed, const Planes& output) {
    check_planes(known, planes, completed, output);
    interruptible([&] {
        bob::interpolate_lattice(known, planes.data(), completed, output.data(), static_cast<int>(planes.shape(1)),
                                 static_cast<int>(planes.shape(2)));
    });
}

void complete_along(const bob::Layout& known, const ConstPlanes& planes, const bob::Layout& completed, const ConstPlane& known_guide,
                    const ConstPlane& guide, std::optional<float> unit, const Planes& output) {
    check_planes(known, planes, completed, output);
    const std::size_t height = planes.shape(1), width = planes.shape(2);
    for (const ConstPlane& plane : {known_guide, guide}) {
        expect(plane.shape(0) == height && plane.shape(1) == width, "guide: expected one number for each pixel");
    }
    expect(height > 0 && width > 0, "planes: expected at least one pixel");
    interruptible([&] {
        bob::complete_along(known, planes.data(), *completed.begin(), known_guide.data(), guide.data(), unit, static_cast<int>(height),
                            static_cast<int>(width), output.data());
    });
}

void complete_guided(const bob::Layout& known, const ConstPlanes& planes, const bob::Layout& guides_layout, const ConstPlanes& guides,
                     const bob::Layout& completed, bool covered_only, const Planes& output) {
    check_planes(known, planes, completed, output);
    expect(guides.shape(0) == static_cast<std::size_t>(guides_layout.width()), "guides: expected the layout's width");
    expect(same_size(guides, planes), "guides: expected the planes' size");
    expect(planes.shape(1) > 0 && planes.shape(2) > 0, "planes: expected at least one pixel");
    interruptible([&] {
        bob::complete_guided(known, planes.data(), guides_layout, guides.data(), *completed.begin(), static_cast<int>(planes.shape(1)),
                             static_cast<int>(planes.shape(2)), covered_only, output.data());
    });
}

void complete_alpha(const bob::Layout& known, const ConstPlanes& planes, const ConstPlane& coverage, const ConstPlanes& ground,
                    const Plane& alpha) {
    expect(planes.shape(0) == static_cast<std::size_t>(known.width()) && ground.shape(0) >= 2, "planes: expected the layout's, and 2 of the ground");
    expect(same_size(planes, alpha) && same_size(coverage, alpha) && same_size(ground, alpha), "planes: expected alpha's size");
    interruptible([&] {
        bob::complete_alpha(known, planes.data(), coverage.data(), ground.data(), static_cast<int>(alpha.shape(0)), static_cast<int>(alpha.shape(1)),
                            alpha.data());
    });
}

void noise_shown(const bob::Layout& known, const ConstPlanes& planes, const bob::Layout& guides_layout, const ConstPlanes& guides,
                 const std::optional<ConstPlanes>& ground, const Plane& noise) {
    expect(planes.shape(0) == static_cast<std::size_t>(known.width()) && guides.shape(0) == static_cast<std::size_t>(guides_layout.width()) &&
               (!ground || ground->shape(0) >= 2), "planes: expected the layouts', and 2 of the ground");
    expect(same_size(planes, noise) && same_size(guides, noise) && (!ground || same_size(*ground, noise)), "planes: expected the noise's size");
    interruptible([&] {
        std::vector<float> color(3 * noise.size()), alpha(noise.size());
        bob::complete_light(known, planes.data(), guides_layout, guides.data(), ground ? ground->data() : nullptr, static_cast<int>(noise.shape(0)),
                            static_cast<int>(noise.shape(1)), color.data(), alpha.data(), noise.data());
    });
}

/// `predict` writes `output`, (channels, H, W), from a G-buffer and its completion by a network, (1, H, W).
template <class Predict>
void from_completed(const bob::Layout& layout, const ConstPlanes& planes, const ConstPlanes& gray, const Planes& output,
                    int channels, Predict predict) {
    check_planes(layout, planes, bob::Layout{bob::channels::gray}, gray);
    expect(output.shape(0) == static_cast<std::size_t>(channels), "output: expected as many planes as are written");
    expect(same_size(output, planes), "output: expected the planes' size");
    interruptible([&] {
        predict(layout, planes.data(), gray.data(), static_cast<int>(planes.shape(1)), static_cast<int>(planes.shape(2)),
                output.data());
    });
}

}  // namespace

void bind_completion(nb::module_& m) {
    nb::class_<Network>(m, "Network",
        "`tensors` by name; ValueError if they or the layouts do not fit the network.")
        .def("__init__", &init_network, "name"_a, "tensors"_a, "inputs"_a, "outputs"_a)
        .def("__call__", [](const Network& self, const bob::Layout& layout, const ConstPlanes& planes, const Planes& output) {
            complete(*self.core, layout, planes, output);
        }, "layout"_a, "planes"_a.noconvert(), "output"_a.noconvert(),
             "From a G-buffer's planes (C, H, W) of a layout to the outputs' (width, H, W). ValueError if the layout lacks one of the "
             "inputs.")
        .def_prop_ro("inputs", [](const Network& self) { return self.core->inputs(); })
        .def_prop_ro("outputs", [](const Network& self) { return self.core->outputs(); });
    nb::class_<bob::ErrorPredictor>(m, "ErrorPredictor", "`tensors` by name; ValueError if they do not fit the predictor.")
        .def("__init__", &init_predictor, "tensors"_a)
        .def("__call__", [](const bob::ErrorPredictor& self, const bob::Layout& layout, const ConstPlanes& planes,
                            const ConstPlanes& gray, const Planes& error) {
            from_completed(layout, planes, gray, error, 1, self);
        }, "layout"_a, "planes"_a.noconvert(), "gray"_a.noconvert(), "error"_a.noconvert(),
             "From a G-buffer's planes (C, H, W) and a network's own output (1, H, W) to the expected absolute error of the completed "
             "gray (1, H, W).");
    m.def("error_features", [](const bob::Layout& layout, const ConstPlanes& planes, const ConstPlanes& gray,
                               const Planes& features) {
        from_completed(layout, planes, gray, features, bob::error_features::count, bob::ErrorPredictor::features);
    }, "layout"_a, "planes"_a.noconvert(), "gray"_a.noconvert(), "features"_a.noconvert(),
          "The inputs of an error predictor, (14, H, W).");
    m.def("interpolate_lattice", &interpolate_lattice, "known"_a, "planes"_a.noconvert(), "completed"_a,
          "output"_a.noconvert(), "Improves completed channels where traced pixels of the lattice agree.");
    m.def("complete_along", &complete_along, "known"_a, "planes"_a.noconvert(), "completed"_a, "known_guide"_a.noconvert(),
          "guide"_a.noconvert(), "unit"_a.none(), "output"_a.noconvert(),
          "Completes the channel `completed` by its ratio to a guide known at all pixels; where traced pixels of the lattice agree, "
          "interpolates it. Values may have any range: `unit` counts as 1.");
    m.def("complete_guided", &complete_guided, "known"_a, "planes"_a.noconvert(), "guides_layout"_a, "guides"_a.noconvert(),
          "completed"_a, "covered_only"_a, "output"_a.noconvert(),
          "Completes gray or color, named by `completed`, along the mask, depth, normal and albedo of all pixels; `covered_only` leaves "
          "pixels without coverage at 0.");
    m.def("complete_alpha", &complete_alpha, "known"_a, "planes"_a.noconvert(), "coverage"_a.noconvert(), "ground"_a.noconvert(), "alpha"_a.noconvert(),
          "Completes the alpha of a picture of light: coverage, plus the shadow on the ground, whose mask and depth come first in `ground`.");
    m.def("noise_shown", &noise_shown, "known"_a, "planes"_a.noconvert(), "guides_layout"_a, "guides"_a.noconvert(), "ground"_a.noconvert().none(),
          "noise"_a.noconvert(), "Writes the standard deviation that noise leaves in the completed picture of light, (H, W), in sRGB 0..1.");
    m.def("keep_known", &keep_known, "known"_a, "planes"_a.noconvert(), "completed"_a, "output"_a.noconvert(),
          "Puts the traced pixels of planes back into completed channels; clamps the others to the channels' ranges.");
}
