/// Batches of items whose cells have the same code, for evaluation together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/thread_memory.h"

namespace bob {

/// Stable sort of keys of the form group << 32 | item by group.
inline void sort_by_group(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& spare, std::uint32_t groups) {
    constexpr int digit_bits = 11;
    spare.resize(keys.size());
    for (int shift = 0; groups >> shift; shift += digit_bits) {
        std::array<std::uint32_t, 1 << digit_bits> start{};
        const auto digit = [shift](std::uint64_t key) { return key >> (32 + shift) & ((1 << digit_bits) - 1); };
        for (const std::uint64_t key : keys) ++start[digit(key)];
        std::uint32_t sum = 0;
        for (std::uint32_t& s : start) {
            const std::uint32_t count = s;
            s = sum;
            sum += count;
        }
        for (const std::uint64_t key : keys) spare[start[digit(key)]++] = key;
        keys.swap(spare);
    }
}

/// Some of the items 0..count.
using Items = std::span<const std::uint32_t>;

/// Calls body(code, items) for batches of at most `most` of the items 0..count, each batch with one code.
template <class CodeOf, class Body>
void for_each_batch(std::size_t count, std::uint32_t codes, std::size_t most, CodeOf code_of, Body body) {
    struct Memory {
        std::vector<std::uint64_t> keys, spare;
        std::vector<std::uint32_t> items;
    };
    auto& [keys, spare, items] = thread_memory<Memory>();
    keys.resize(count);
    items.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) keys[i] = std::uint64_t{code_of(i)} << 32 | i;
    sort_by_group(keys, spare, codes);
    for (std::uint32_t i = 0; i < count; ++i) items[i] = static_cast<std::uint32_t>(keys[i]);
    for (std::size_t begin = 0, end; begin < count; begin = end) {
        const std::uint64_t code = keys[begin] >> 32;
        for (end = begin + 1; end < count && end - begin < most && keys[end] >> 32 == code;) ++end;
        body(static_cast<std::uint32_t>(code), Items(items).subspan(begin, end - begin));
    }
}

}  // namespace bob
