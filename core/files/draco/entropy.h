/// Bits and symbols of Draco: plain bits, and two range coders of asymmetric numeral systems (rANS).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "files/binary.h"

namespace bob::files::draco {

/// Plain bits of bytes, the lowest first.
class Bits {
public:
    explicit Bits(Bytes bytes) : bytes_(bytes) {}

    std::uint32_t read(unsigned count);
    /// Bytes that were begun.
    [[nodiscard]] std::size_t used() const { return (at_ + 7) / 8; }

private:
    Bytes bytes_;
    std::size_t at_ = 0;
};

/// The state of a range coder, which reads its bytes from the end.
class Ans {
public:
    Ans(Bytes bytes, std::uint32_t base);

    /// Fills the state up to its base; it stays below at the end of the bytes.
    void fill() {
        while (state_ < base_ && !bytes_.empty()) {
            state_ = state_ << 8 | bytes_.back();
            bytes_ = bytes_.first(bytes_.size() - 1);
        }
    }
    std::uint32_t state() const { return state_; }
    void set(std::uint32_t state) { state_ = state; }

private:
    Bytes bytes_;
    std::uint32_t base_, state_ = 0;
};

/// Bits that are 0 with one probability.
class AnsBits {
public:
    explicit AnsBits(Stream& stream);

    bool read();

private:
    std::uint8_t zero_;
    Ans ans_;
};

/// Symbols in groups of `width`, which may share their number of bits.
[[nodiscard]] std::vector<std::uint32_t> symbols(Stream& stream, std::size_t count, std::size_t width, Budget& budget);

}  // namespace bob::files::draco
