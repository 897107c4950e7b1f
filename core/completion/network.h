/// Networks that complete a sparsely traced picture.
#pragma once

#include <memory>
#include <string_view>
#include <utility>

#include "completion/rows.h"
#include "completion/weights.h"
#include "picture/channels.h"

namespace bob {

class Network {
public:
    virtual ~Network() = default;

    [[nodiscard]] const Layout& inputs() const { return inputs_; }
    [[nodiscard]] const Layout& outputs() const { return outputs_; }

    /// planes: (inputs().width(), height, width), all 0 where not traced; output: (outputs().width(), height, width),
    /// the network's own values at every pixel. Any size; safe to call from several threads.
    void operator()(const float* planes, int height, int width, float* output) const {
        (*this)(planes, height, width, output, {0, height});
    }

    /// Computes one band, given all planes: workers that share a picture each compute the coarse levels for themselves.
    /// May write other rows too.
    virtual void operator()(const float* planes, int height, int width, float* output, Band band) const = 0;

protected:
    /// Throws std::invalid_argument unless the weights have the layouts that the network needs.
    Network(const Weights& weights, Layout inputs, Layout outputs);

private:
    Layout inputs_, outputs_;
};

/// The network named "filling", "paper" or "pyramid". Throws std::invalid_argument for any other name, or if a tensor
/// is missing or does not fit.
[[nodiscard]] std::unique_ptr<const Network> make_network(std::string_view name, const Weights& weights);

}  // namespace bob
