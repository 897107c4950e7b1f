/// All pixels of a picture in one round, in the order of the lattice: partial results cover the whole picture.
#pragma once

#include <vector>

#include "sampling/order.h"
#include "sampling/rounds.h"

namespace bob {

class WholeOrder final : public RoundOrder {
public:
    using RoundOrder::RoundOrder;

    std::span<const Pixel> next(const Layout&, const float*) override {
        if (!round_.empty()) return {};
        round_.resize(std::size_t{height_} * width_);
        TiledOrder(lattice_tile(), 0, height_, width_)(0, round_);
        return round_;
    }
    [[nodiscard]] std::size_t bytes() const override { return round_.capacity() * sizeof(Pixel); }

private:
    std::vector<Pixel> round_;
};

}  // namespace bob
