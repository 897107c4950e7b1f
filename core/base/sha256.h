/// SHA-256 (FIPS 180-4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace bob {

using Digest = std::array<std::uint8_t, 32>;

class Sha256 {
public:
    /// Appends bytes.
    Sha256& update(std::span<const std::byte> bytes);
    Sha256& update(std::string_view text) { return update(std::as_bytes(std::span(text))); }

    /// The digest of all bytes so far; more may follow.
    [[nodiscard]] Digest digest() const;

private:
    void mix(const std::byte* block);

    std::uint32_t state_[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                               0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::byte block_[64];
    std::uint64_t size_ = 0;
};

}  // namespace bob
