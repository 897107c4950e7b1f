#include "base/sha256.h"

#include <algorithm>
#include <bit>

namespace bob {
namespace {

constexpr std::uint32_t k[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

std::uint32_t big_endian(const std::byte* p) {
    return std::to_integer<std::uint32_t>(p[0]) << 24 | std::to_integer<std::uint32_t>(p[1]) << 16 |
           std::to_integer<std::uint32_t>(p[2]) << 8 | std::to_integer<std::uint32_t>(p[3]);
}

}  // namespace

Sha256& Sha256::update(std::span<const std::byte> bytes) {
    const std::size_t filled = size_ % 64;
    size_ += bytes.size();
    if (filled > 0) {
        const std::size_t taken = std::min(64 - filled, bytes.size());
        std::copy_n(bytes.begin(), taken, block_ + filled);
        if (filled + taken < 64) return *this;
        mix(block_);
        bytes = bytes.subspan(taken);
    }
    for (; bytes.size() >= 64; bytes = bytes.subspan(64)) mix(bytes.data());
    std::copy(bytes.begin(), bytes.end(), block_);
    return *this;
}

Digest Sha256::digest() const {
    Sha256 padded = *this;
    std::byte end[128]{std::byte{0x80}};
    const std::size_t filled = size_ % 64, count = (filled < 56 ? 64 : 128) - filled;
    for (std::size_t i = 0; i < 8; ++i) end[count - 1 - i] = static_cast<std::byte>(8 * size_ >> 8 * i);
    padded.update({end, count});
    Digest result;
    for (std::size_t i = 0; i < 32; ++i) result[i] = static_cast<std::uint8_t>(padded.state_[i / 4] >> (24 - 8 * (i % 4)));
    return result;
}

void Sha256::mix(const std::byte* block) {
    std::uint32_t w[16];
    for (int i = 0; i < 16; ++i) w[i] = big_endian(block + 4 * i);
    auto [a, b, c, d, e, f, g, h] = state_;
    // Words rotate from round to round; eight rounds restore their places.
    const auto round = [&w](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t& d, std::uint32_t e,
                            std::uint32_t f, std::uint32_t g, std::uint32_t& h, int i) {
        std::uint32_t& word = w[i % 16];
        if (i >= 16) {
            const std::uint32_t x = w[(i + 1) % 16], y = w[(i + 14) % 16];
            word += (std::rotr(x, 7) ^ std::rotr(x, 18) ^ x >> 3) + w[(i + 9) % 16] +
                    (std::rotr(y, 17) ^ std::rotr(y, 19) ^ y >> 10);
        }
        h += (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) + (g ^ (e & (f ^ g))) + k[i] + word;
        d += h;
        h += (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) | (c & (a | b)));
    };
    for (int i = 0; i < 64; i += 8) {
        round(a, b, c, d, e, f, g, h, i);
        round(h, a, b, c, d, e, f, g, i + 1);
        round(g, h, a, b, c, d, e, f, i + 2);
        round(f, g, h, a, b, c, d, e, i + 3);
        round(e, f, g, h, a, b, c, d, i + 4);
        round(d, e, f, g, h, a, b, c, i + 5);
        round(c, d, e, f, g, h, a, b, i + 6);
        round(b, c, d, e, f, g, h, a, i + 7);
    }
    const std::uint32_t sums[8] = {a, b, c, d, e, f, g, h};
    for (int i = 0; i < 8; ++i) state_[i] += sums[i];
}

}  // namespace bob
