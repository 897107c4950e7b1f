/// DEFLATE, the compression of zip files.
#pragma once

#include <cstddef>
#include <cstdint>

#include "files/part.h"

namespace bob::files {

/// The `size` bytes of compressed data, after RFC 1951. Throws std::invalid_argument if the data are damaged or make another number of
/// bytes. Memory is proportional to the data, whatever the size. Checks Interruption.
[[nodiscard]] Numbers<std::uint8_t> inflated(Bytes data, std::uint64_t size);

/// CRC-32 as in zip files and PNG, of the polynomial 0xEDB88320.
[[nodiscard]] std::uint32_t crc32(Bytes bytes);

}  // namespace bob::files
