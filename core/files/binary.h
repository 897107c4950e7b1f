/// Numbers of binary files.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "files/part.h"

namespace bob::files {

/// A number at any address.
template <class T>
T load(const std::uint8_t* bytes, bool is_big) {
    std::array<std::uint8_t, sizeof(T)> own;
    std::memcpy(own.data(), bytes, sizeof(T));
    if (is_big != (std::endian::native == std::endian::big)) std::ranges::reverse(own);
    return std::bit_cast<T>(own);
}

/// A column of float32 of low byte first, in rows of `stride` bytes, to one of (rows, width).
void read_floats(const std::uint8_t* from, std::size_t stride, std::size_t rows, double* to, std::size_t width);

/// Leading rows of a byte 3 and three indices of 32 bits, within the data. Returns how many. to: (rows, 3).
std::size_t read_triples(Bytes bytes, std::size_t rows, bool is_big, std::int32_t* to);

}  // namespace bob::files
