/// Zip files of stored parts.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "files/inflate.h"

namespace fuzz {

/// A zip file of these names and contents, not compressed.
inline std::string zipped(std::initializer_list<std::pair<std::string_view, std::string_view>> parts) {
    const auto number = [](std::size_t value, int bytes) {
        std::string result;
        for (; bytes > 0; --bytes, value >>= 8) result += static_cast<char>(value & 255);
        return result;
    };
    std::string result, directory;
    for (const auto& [name, content] : parts) {
        const std::uint32_t crc = bob::files::crc32({reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
        const std::string sizes = number(crc, 4) + number(content.size(), 4) + number(content.size(), 4) + number(name.size(), 2);
        directory += "PK\1\2" + number(20, 2) + number(20, 2) + number(0, 8) + sizes + number(0, 12) + number(result.size(), 4);
        directory += name;
        result += "PK\3\4" + number(20, 2) + number(0, 8) + sizes + number(0, 2);
        result.append(name).append(content);
    }
    const std::size_t start = result.size();
    const std::string count = number(parts.size(), 2);
    return result + directory + "PK\5\6" + number(0, 4) + count + count + number(directory.size(), 4) + number(start, 4) + number(0, 2);
}

}  // namespace fuzz
