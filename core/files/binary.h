/// Numbers of binary files.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "files/part.h"
#include "files/text.h"

namespace bob::files {

/// A number at any address.
template <class T>
T load(const std::uint8_t* bytes, bool is_big) {
    std::array<std::uint8_t, sizeof(T)> own;
    std::memcpy(own.data(), bytes, sizeof(T));
    if (is_big != (std::endian::native == std::endian::big)) std::ranges::reverse(own);
    return std::bit_cast<T>(own);
}

/// The rest of a stream, read from its start. Throws std::invalid_argument at its end.
class Stream {
public:
    explicit Stream(Bytes bytes) : rest_(bytes) {}

    [[nodiscard]] std::size_t size() const { return rest_.size(); }
    [[nodiscard]] Bytes rest() const { return rest_; }

    Bytes take(std::uint64_t size) {
        if (size > rest_.size()) refuse({"expected more compressed data, got its end"});
        const Bytes result = rest_.first(static_cast<std::size_t>(size));
        rest_ = rest_.subspan(result.size());
        return result;
    }
    template <class T = std::uint8_t>
    T number() {
        return load<T>(take(sizeof(T)).data(), false);
    }
    /// An integer in groups of seven bits, the lowest first.
    std::uint32_t varint() {
        std::uint32_t result = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            const auto byte = number();
            result |= (byte & std::uint32_t{127}) << shift;
            if (byte < 128) return result;
        }
        refuse({"expected integers of 32 bits, got a longer one"});
    }

private:
    Bytes rest_;
};

/// Bytes that compressed data may still take in memory. Throws std::invalid_argument if they are spent.
class Budget {
public:
    explicit Budget(std::uint64_t left) : total_(left), left_(left) {}

    void take(std::uint64_t bytes) {
        if (bytes > left_) refuse({"expected at most ", grouped(total_), " bytes once decompressed, got more"});
        left_ -= bytes;
    }

private:
    std::uint64_t total_, left_;
};

/// The signed integer whose sign is in the lowest bit.
template <class T>
constexpr T unzigzagged(T value) {
    return static_cast<T>((value >> 1) ^ (0 - (value & 1)));
}

/// A column of float32 of low byte first, in rows of `stride` bytes, to one of (rows, width).
void read_floats(const std::uint8_t* from, std::size_t stride, std::size_t rows, double* to, std::size_t width);

/// Reads the leading rows that consist of a byte 3 and three indices of 32 bits, within the data. Returns their number. to: (rows, 3).
std::size_t read_triples(Bytes bytes, std::size_t rows, bool is_big, std::int32_t* to);

}  // namespace bob::files
