/// Zip files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// A file in a zip file.
struct ZipEntry {
    std::string name;  // as it is stored
    std::uint64_t start, packed, size;  // start: of its local header; the sizes in bytes
    std::uint32_t crc;
    std::uint16_t method;
    bool is_encrypted;
};

/// The directory of a zip file, whose bytes have to live as long. Functions throw std::invalid_argument if the file is damaged.
class Zip {
public:
    explicit Zip(Bytes bytes);

    [[nodiscard]] const std::vector<ZipEntry>& entries() const { return entries_; }
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }
    [[nodiscard]] Numbers<std::uint8_t> unpacked(const ZipEntry& entry) const;

private:
    Bytes bytes_;
    std::vector<ZipEntry> entries_;
};

}  // namespace bob::files
