/// Networks in the WebAssembly module, and the memory that all its functions work in.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "completion/known.h"
#include "completion/paper.h"
#include "completion/pyramid.h"
#include "wasm.h"

namespace {

/// A network of the core under one type.
struct Network {
    virtual ~Network() = default;
    virtual void run(const float* gbuffer, int height, int width, float* gray) const = 0;
};

template <class N>
struct NetworkOf : Network {
    N network;

    explicit NetworkOf(const bob::Weights& weights) : network(weights) {}
    void run(const float* gbuffer, int height, int width, float* gray) const override {
        network(gbuffer, height, width, gray);
    }
};

}  // namespace

std::string& error_text() {
    static std::string text;
    return text;
}

EXPORT(error) const char* error() { return error_text().c_str(); }

EXPORT(allocate) void* allocate(std::size_t bytes) {
    return attempt([&] { return ::operator new(bytes, std::align_val_t{16}); });
}
EXPORT(release) void release(void* memory) { ::operator delete(memory, std::align_val_t{16}); }

// ---- Networks --------------------------------------------------------------------------------------------

EXPORT(make_weights) bob::Weights* make_weights() {
    return attempt([] { return new bob::Weights; });
}
EXPORT(free_weights) void free_weights(bob::Weights* weights) { delete weights; }

/// The values must stay until a network was made of them.
EXPORT(add_tensor)
bool add_tensor(bob::Weights* weights, const char* name, std::size_t name_size, const std::int32_t* shape,
                std::size_t axes, const float* values) {
    return attempt([&] {
        std::size_t size = 1;
        for (std::size_t axis = 0; axis < axes; ++axis) size *= static_cast<std::size_t>(shape[axis]);
        weights->insert_or_assign(std::string(name, name_size), bob::Tensor{{shape, shape + axes}, {values, size}});
        return true;
    });
}

EXPORT(make_network)
Network* make_network(const char* name, std::size_t name_size, const bob::Weights* weights) {
    return attempt([&]() -> Network* {
        const std::string_view network(name, name_size);
        if (network == "paper") return new NetworkOf<bob::Paper>(*weights);
        if (network == "pyramid") return new NetworkOf<bob::Pyramid>(*weights);
        throw std::invalid_argument("expected weights of one of the networks paper, pyramid, got '" +
                                    std::string(network) + "'");
    });
}
EXPORT(free_network) void free_network(Network* network) { delete network; }

/// gbuffer: (5, height, width); gray: (height, width).
EXPORT(run_network)
bool run_network(const Network* network, const float* gbuffer, std::int32_t height, std::int32_t width, float* gray) {
    return attempt([&] {
        network->run(gbuffer, height, width, gray);
        return true;
    });
}

/// Writes samples, (count, 4), to their pixels, (count, 2), of planes, (5, height, width); returns how many pixels are known.
EXPORT(add_samples)
std::size_t add_samples(const std::int32_t* pixels, const float* samples, std::size_t count, float* planes, std::int32_t height,
                        std::int32_t width) {
    return attempt([&] {
        const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        for (std::size_t i = 0; i < count; ++i) {
            const std::int32_t row = pixels[2 * i], column = pixels[2 * i + 1];
            expect(row >= 0 && row < height && column >= 0 && column < width, "pixels: outside the image");
            float* p = planes + static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + column;
            p[0] = 1;
            for (std::size_t channel = 0; channel < 4; ++channel) p[(channel + 1) * size] = samples[4 * i + channel];
        }
        return size - static_cast<std::size_t>(std::count(planes, planes + size, 0.f));
    });
}

EXPORT(keep_known) void keep_known(const float* gbuffer, std::size_t pixels, float* gray) {
    bob::keep_known(gbuffer, pixels, gray);
}
