#include "trace/order.h"

#include <cmath>

namespace bob {
namespace {

/// A bijective mix in which each bit of the input moves every bit of the output (Wellons, "Prospecting for Hash
/// Functions", 2018: the two-round function of lowest bias).
std::uint32_t mix(std::uint32_t x) {
    x = (x ^ x >> 16) * 0x21f0aaad;
    x = (x ^ x >> 15) * 0xd35a2d97;
    return x ^ x >> 15;
}

/// A number in 0..size-1 from 32 random bits (Lemire, "Fast Random Integer Generation in an Interval", 2019).
std::uint32_t scale(std::uint32_t bits, std::uint32_t size) {
    return static_cast<std::uint32_t>(std::uint64_t{bits} * size >> 32);
}

std::uint32_t rotate(std::uint32_t value, std::uint32_t by, std::uint32_t size) {
    const std::uint32_t sum = value + by;
    return sum >= size ? sum - size : sum;
}

}  // namespace

UniformOrder::UniformOrder(std::uint64_t seed, std::uint32_t size) : size_(size) {
    columns_ = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(size))));
    columns_ = columns_ ? columns_ : 1;
    rows_ = (size + columns_ - 1) / columns_;
    std::uint32_t state = mix(static_cast<std::uint32_t>(seed)) ^ static_cast<std::uint32_t>(seed >> 32);
    for (auto& key : keys_) key = state = mix(state + 0x9e3779b9);
}

std::uint32_t UniformOrder::operator()(std::uint32_t index) const {
    do {
        std::uint32_t row = index / columns_, column = index % columns_;
        for (int round = 0; round < rounds; round += 2) {
            row = rotate(row, scale(mix(column ^ keys_[round]), rows_), rows_);
            column = rotate(column, scale(mix(row ^ keys_[round + 1]), columns_), columns_);
        }
        index = row * columns_ + column;
    } while (index >= size_);
    return index;
}

}  // namespace bob
