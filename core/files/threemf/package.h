/// The packages of 3MF: zip files of parts and relationships, by the Open Packaging Conventions (ISO/IEC 29500-2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "files/zip.h"

namespace bob::files::threemf {

/// The parts of a package by their names: in any case, and with or without percent-encoding.
class Package {
public:
    explicit Package(Bytes bytes);

    /// The number of the part at a path from the package's root.
    [[nodiscard]] std::optional<std::size_t> part(std::string_view path) const;

    /// The first model: the target of the package's relationship, or else the part of the usual name, or else any.
    [[nodiscard]] std::optional<std::size_t> root();

    /// The bytes of a part. Throws std::invalid_argument if all parts with this content unpack to far more than the file's size.
    [[nodiscard]] Numbers<std::uint8_t> unpacked(std::string_view content, std::size_t part);

private:
    Zip zip_;
    std::map<std::string, std::size_t, std::less<>> parts_;          // by their plain names
    std::map<std::string, std::uint64_t, std::less<>> unpacked_;  // bytes so far, by their content
};

}  // namespace bob::files::threemf
