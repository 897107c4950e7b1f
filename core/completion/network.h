/// Networks: what completes a picture of which some pixels were traced.
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

    /// planes: (inputs().width(), height, width), all 0 where not traced; output: (outputs().width(), height, width), the
    /// network's own values at every pixel. Any size; from several threads at once.
    void operator()(const float* planes, int height, int width, float* output) const {
        (*this)(planes, height, width, output, {0, height});
    }

    /// The same of a band alone, of all planes: those who share a picture each compute what the coarse levels say of it. Other rows may be
    /// written too.
    virtual void operator()(const float* planes, int height, int width, float* output, Band band) const = 0;

protected:
    /// Throws std::invalid_argument unless the weights have the layouts that the network is made for.
    Network(const Weights& weights, Layout inputs, Layout outputs);

private:
    Layout inputs_, outputs_;
};

/// The network of a name, "filling", "paper" or "pyramid". Throws std::invalid_argument if there is no such network, or a tensor is
/// missing or does not fit.
[[nodiscard]] std::unique_ptr<const Network> make_network(std::string_view name, const Weights& weights);

}  // namespace bob
