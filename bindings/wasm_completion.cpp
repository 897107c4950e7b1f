/// G-buffers and networks in the WebAssembly module, and the memory that all its functions share.
#include <cstddef>
#include <cstdint>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "completion/error_predictor.h"
#include "completion/interpolation.h"
#include "completion/known.h"
#include "completion/network.h"
#include "completion/ratio.h"
#include "picture/gbuffer.h"
#include "wasm.h"

std::string& error_text() {
    static std::string text;
    return text;
}

EXPORT(error) const char* error() { return error_text().c_str(); }

EXPORT(allocate) void* allocate(std::size_t bytes) {
    return attempt([&] { return ::operator new(bytes, std::align_val_t{16}); });
}
EXPORT(release) void release(void* memory) { ::operator delete(memory, std::align_val_t{16}); }

// ---- G-buffers -------------------------------------------------------------------------------------------

/// Scatters samples, (count, C) of the traced layout, to their pixels, (count, 2), in planes, (C, height, width). These
/// have the same layout or its displayed part. Writes to `added` the number of pixels not traced before.
EXPORT(add_samples)
bool add_samples(bool is_colored, bool is_shown, const std::int32_t* pixels, const float* samples, std::size_t count, float* planes,
                 std::int32_t height, std::int32_t width, std::uint32_t* added) {
    return attempt([&] {
        const std::span all(reinterpret_cast<const bob::Pixel*>(pixels), count);
        for (const bob::Pixel p : all) {
            expect(p.row >= 0 && p.row < height && p.column >= 0 && p.column < width, "pixels: outside the image");
        }
        const bob::Layout &traced = traced_layout(is_colored), &written = is_shown ? shown_layout(is_colored) : traced;
        *added = static_cast<std::uint32_t>(bob::scatter(written, all, samples, static_cast<std::size_t>(traced.width()), planes,
                                                         static_cast<std::size_t>(height), static_cast<std::size_t>(width)));
        return true;
    });
}

// ---- Networks --------------------------------------------------------------------------------------------

/// inputs, outputs: names of channels, separated by commas.
EXPORT(make_weights)
bob::Weights* make_weights(const char* inputs, std::size_t inputs_size, const char* outputs, std::size_t outputs_size) {
    return attempt([&] {
        return new bob::Weights{bob::Layout(std::string_view(inputs, inputs_size)),
                                bob::Layout(std::string_view(outputs, outputs_size)), {}};
    });
}
EXPORT(free_weights) void free_weights(bob::Weights* weights) { delete weights; }

/// The values must stay valid until a network is made from them.
EXPORT(add_tensor)
bool add_tensor(bob::Weights* weights, const char* name, std::size_t name_size, const std::int32_t* shape,
                std::size_t axes, const float* values) {
    return attempt([&] {
        std::size_t size = 1;
        for (std::size_t axis = 0; axis < axes; ++axis) size *= static_cast<std::size_t>(shape[axis]);
        weights->tensors.insert_or_assign(std::string(name, name_size), bob::Tensor{{shape, shape + axes}, {values, size}});
        return true;
    });
}

EXPORT(make_network)
const bob::Network* make_network(const char* name, std::size_t name_size, const bob::Weights* weights) {
    return attempt([&] { return bob::make_network({name, name_size}, *weights).release(); });
}
EXPORT(free_network) void free_network(const bob::Network* network) { delete network; }

/// planes: (C, height, width) of a G-buffer; output: (channels of the network's outputs, height, width), finished in
/// the rows `begin` to `end` - 1.
EXPORT(run_network)
bool run_network(const bob::Network* network, const float* planes, std::int32_t height, std::int32_t width, float* output,
                 std::int32_t begin, std::int32_t end) {
    return attempt([&] {
        std::vector<float> storage;
        const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        (*network)(bob::select(bob::gbuffer_layout(), planes, network->inputs(), pixels, storage), height, width, output, {begin, end});
        return true;
    });
}

/// Interpolates a network's output for a G-buffer where traced pixels of the lattice agree. Only the rows `begin` to
/// `end` - 1 are finished.
EXPORT(interpolate_lattice)
bool interpolate_lattice(const bob::Network* network, const float* planes, std::int32_t height, std::int32_t width, float* output,
                         std::int32_t begin, std::int32_t end) {
    return attempt([&] {
        bob::interpolate_lattice(bob::gbuffer_layout(), planes, network->outputs(), output, height, width, {begin, end});
        return true;
    });
}

/// Restores the traced pixels of a G-buffer in a network's output.
EXPORT(keep_known)
bool keep_known(const bob::Network* network, const float* planes, std::size_t pixels, float* output) {
    return attempt([&] {
        bob::keep_known(bob::gbuffer_layout(), planes, network->outputs(), output, pixels);
        return true;
    });
}

/// Completes the colours of a G-buffer of bob::colored_layout with completed gray; color: (3, height, width).
EXPORT(complete_color)
bool complete_color(const float* planes, const float* gray, std::int32_t height, std::int32_t width, float* color) {
    return attempt([&] {
        const bob::Layout& known = bob::colored_layout();
        const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        const float* const known_gray = planes + static_cast<std::size_t>(known.place_of(bob::channels::gray)) * pixels;
        bob::complete_along(known, planes, bob::channels::color, known_gray, gray, {}, height, width, color);
        return true;
    });
}

// ---- Uncertainty -----------------------------------------------------------------------------------------

EXPORT(make_predictor)
const bob::ErrorPredictor* make_predictor(const bob::Weights* weights) {
    return attempt([&] { return new bob::ErrorPredictor(*weights); });
}
EXPORT(free_predictor) void free_predictor(const bob::ErrorPredictor* predictor) { delete predictor; }

/// planes: (C, height, width) of a G-buffer; gray: a network's own output, and error: its predicted error, both
/// (height, width).
EXPORT(predict_error)
bool predict_error(const bob::ErrorPredictor* predictor, const float* planes, const float* gray, std::int32_t height,
                   std::int32_t width, float* error) {
    return attempt([&] {
        (*predictor)(bob::gbuffer_layout(), planes, gray, height, width, error);
        return true;
    });
}
