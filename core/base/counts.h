/// Counts in messages, and the largest number of instances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace bob {

/// A number with commas between its thousands.
[[nodiscard]] inline std::string grouped(std::uint64_t number) {
    std::string digits = std::to_string(number);
    for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, 1, ',');
    return digits;
}

/// Instances of a scene, and nodes, primitives and placements of a file: files and pages hold them, and placing them takes seconds.
inline constexpr std::size_t max_instances = 100'000;

/// Throws std::invalid_argument if there are more of them.
inline void check_instances(std::string_view name, std::size_t count) {
    if (count <= max_instances) return;
    throw std::invalid_argument(std::string(name) + ": expected at most " + grouped(max_instances) + ", got " + grouped(count));
}

}  // namespace bob
