/// Register allocation for generated code.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "formula/expression.h"

namespace bob {

/// In place of the last use of a value.
constexpr std::uint32_t never_used = 0xffffffff;

/// Allocates and frees registers.
class Registers {
public:
    std::uint16_t take() {
        if (!free_.empty()) {
            const std::uint16_t r = free_.back();
            free_.pop_back();
            return r;
        }
        if (count_ > std::numeric_limits<std::uint16_t>::max()) throw TooLarge();
        return static_cast<std::uint16_t>(count_++);
    }
    void give_back(std::uint16_t r) { free_.push_back(r); }
    [[nodiscard]] int count() const { return count_; }

private:
    int count_ = 3;
    std::vector<std::uint16_t> free_;
};

}  // namespace bob
