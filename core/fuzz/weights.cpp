/// Weight files: tensors of any names and shapes make a network or are refused; a network completes a small picture, and the
/// known pixels stay.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "completion/error_predictor.h"
#include "completion/interpolation.h"
#include "completion/known.h"
#include "completion/network.h"
#include "fuzz/fuzz.h"
#include "picture/gbuffer.h"

namespace {

/// Weights of a network with some of it changed.
struct File {
    std::string network;
    bob::Weights weights;
    std::vector<std::vector<float>> values;  // of the tensors

    explicit File(fuzz::Source& source)
        : network(std::array{"paper", "pyramid", "filling"}[source.below(3)]),
          weights{layout(source, bob::gbuffer_layout().names()), layout(source, "gray"), {}} {
        values.reserve(64);
        const std::uint32_t changed = source.below(64);  // often no tensor
        if (network == "paper") {
            const int groups = std::array{1, 5, 10, 20}[source.below(4)], inputs = weights.inputs.width();
            add(source, "encode1", 20, inputs, 1, changed);
            add(source, "encode2", 80, 20, groups, changed);
            add(source, "encoded", 20, 80, groups, changed);
            add(source, "decode1", 5, 20, 1, changed);
            add(source, "decode2", 5, 25, 1, changed);
            add(source, "output", 1, 5 + inputs, 1, changed);
        } else if (network == "pyramid") {
            int handed = 0;
            for (int level = source.between(1, 4); level > 0; --level) {
                const std::string number = std::to_string(level);
                const int features = 4 * source.between(1, 3), finer = level > 1 ? 4 * source.between(1, 2) : 4;
                add(source, "features" + number, features, (level > 1 ? 8 : 11) + handed, 1, changed);
                add(source, "finer" + number, finer, features, 1, changed);
                handed = finer / 4;
            }
        }
    }

private:
    static bob::Layout layout(fuzz::Source& source, const std::string& usual) {
        constexpr const char* names[] = {"mask,gray", "gray", "mask,gray,depth,normal,normal", "normal,mask", "", ",", "alpha"};
        const std::uint8_t which = source.byte();
        return bob::Layout(std::string_view(which < std::size(names) ? names[which] : usual));
    }

    void add(fuzz::Source& source, const std::string& name, int out, int in, int groups, std::uint32_t changed) {
        const auto count = static_cast<std::uint32_t>(weights.tensors.size());
        tensor(source, name + ".weight", {out, in / groups, 3, 3}, changed == count);
        tensor(source, name + ".bias", {out}, changed == count + 1);
    }

    /// Writes a tensor of repeated values, in the number that its shape requires.
    void tensor(fuzz::Source& source, std::string name, std::vector<int> shape, bool changed) {
        if (changed && source.flag()) name += static_cast<char>(source.byte());
        if (changed && source.flag()) shape.resize(source.below(6), 1);
        if (changed && !shape.empty()) shape[source.below(static_cast<std::uint32_t>(shape.size()))] = source.between(0, 100);
        std::size_t size = 1;
        for (const int axis : shape) size *= static_cast<std::size_t>(axis);
        if (size > 1 << 16) return;
        auto& filled = values.emplace_back(size);
        std::array<float, 5> few;
        for (float& value : few) value = static_cast<float>(source.number()) / 8;
        for (std::size_t i = 0; i < size; ++i) filled[i] = few[i % few.size()] * static_cast<float>(i % 7);
        weights.tensors.insert_or_assign(std::move(name), bob::Tensor{std::move(shape), filled});
    }
};

std::vector<float> picture(fuzz::Source& source, std::size_t pixels) {
    std::vector<float> planes(static_cast<std::size_t>(bob::gbuffer_layout().width()) * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        const std::uint8_t kind = source.byte();
        planes[i] = kind % 4 == 0;
        for (std::size_t plane = 1; plane * pixels < planes.size() && kind % 4 == 0; ++plane) {
            planes[plane * pixels + i] = static_cast<float>(kind * plane % 61) / 60;
        }
    }
    return planes;
}

}  // namespace

FUZZ(weights) {
    try {
        const File file(source);
        const auto network = bob::make_network(file.network, file.weights);
        const int height = source.between(1, 20), width = source.between(1, 20);
        const auto pixels = static_cast<std::size_t>(height * width);
        const std::vector<float> planes = picture(source, pixels);
        std::vector<float> storage, output(pixels * static_cast<std::size_t>(network->outputs().width()));
        const float* const inputs = bob::select(bob::gbuffer_layout(), planes.data(), network->inputs(), pixels, storage);
        (*network)(inputs, height, width, output.data());
        std::vector<float> features(pixels * bob::error_features::count);
        bob::ErrorPredictor::features(bob::gbuffer_layout(), planes.data(), output.data(), height, width, features.data());
        fuzz::expect(std::ranges::all_of(features, [](float value) { return std::isfinite(value); }), "finite features");
        bob::interpolate_lattice(bob::gbuffer_layout(), planes.data(), network->outputs(), output.data(), height, width);
        bob::keep_known(bob::gbuffer_layout(), planes.data(), network->outputs(), output.data(), pixels);
        for (std::size_t i = 0; i < pixels; ++i) {
            fuzz::expect(planes[i] > 0 ? output[i] == planes[pixels + i] : output[i] >= 0 && output[i] <= 1, "known pixels, and a range");
        }
    } catch (const std::invalid_argument&) {  // refused
    }
}
