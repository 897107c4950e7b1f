/// Pixel orders: sequences in which the pixels of an image are traced.
#pragma once

#include <cstddef>
#include <cstdint>

namespace bob {

/// A seeded random permutation of 0..size-1 whose every element is computed on its own, so that the first pixels of an
/// order cost nothing but themselves.
///
/// A Feistel network over a grid of about sqrt(size) x sqrt(size); an index that falls outside 0..size-1 is sent through
/// again until it falls inside (Black and Rogaway, "Ciphers with Arbitrary Finite Domains", 2002).
class UniformOrder {
public:
    UniformOrder(std::uint64_t seed, std::uint32_t size);

    /// The pixel, row by row from the top left, that is traced as the index-th.
    [[nodiscard]] std::uint32_t operator()(std::uint32_t index) const;

private:
    static constexpr int rounds = 6;

    std::uint32_t size_, columns_, rows_;
    std::uint32_t keys_[rounds];
};

}  // namespace bob
