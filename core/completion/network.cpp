#include "completion/network.h"

#include <stdexcept>
#include <string>

#include "completion/filling.h"
#include "completion/paper.h"
#include "completion/pyramid.h"

namespace bob {
namespace {

template <class N>
std::unique_ptr<const Network> make(const Weights& weights) {
    return std::make_unique<const N>(weights);
}

struct Entry {
    std::string_view name;
    std::unique_ptr<const Network> (*make)(const Weights&);
};

constexpr Entry networks[] = {
    {"filling", make<Filling>},
    {"paper", make<Paper>},
    {"pyramid", make<Pyramid>},
};

void expect_layout(const char* what, const Layout& expected, const Layout& got) {
    if (got == expected) return;
    throw std::invalid_argument(std::string(what) + ": expected " + expected.names() + ", got " + got.names());
}

}  // namespace

Network::Network(const Weights& weights, Layout inputs, Layout outputs)
    : inputs_(std::move(inputs)), outputs_(std::move(outputs)) {
    expect_layout("inputs", inputs_, weights.inputs);
    expect_layout("outputs", outputs_, weights.outputs);
}

std::unique_ptr<const Network> make_network(std::string_view name, const Weights& weights) {
    std::string names;
    for (const Entry& entry : networks) {
        if (entry.name == name) return entry.make(weights);
        if (!names.empty()) names += ", ";
        names += entry.name;
    }
    throw std::invalid_argument("expected weights of one of the networks " + names + ", got '" + std::string(name) + "'");
}

}  // namespace bob
