#include "files/inflate.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "base/interruption.h"
#include "files/binary.h"
#include "files/text.h"

namespace bob::files {
namespace {

constexpr int max_code_bits = 15;

[[noreturn]] void refuse_data() { refuse({"damaged data"}); }

/// The bits of the data, the lowest of each byte first; zeros after the end.
class DeflateBits {
public:
    explicit DeflateBits(Bytes bytes) : bytes_(bytes) {}

    /// Makes at least 56 bits available.
    void fill() {
        if (at_ + 8 <= bytes_.size()) {
            // Bits beyond `count_` are right, too: the next load sets them again.
            bits_ |= load<std::uint64_t>(&bytes_[at_], false) << count_;
            at_ += static_cast<std::size_t>(63 - count_) / 8;
            count_ |= 56;
            return;
        }
        for (; count_ <= 56; count_ += 8, ++at_) {
            if (at_ > bytes_.size() + 8) refuse_data();
            if (at_ < bytes_.size()) bits_ |= std::uint64_t{bytes_[at_]} << count_;
        }
    }
    [[nodiscard]] std::uint64_t ahead() const { return bits_; }
    void drop(int count) {
        bits_ >>= count;
        count_ -= count;
    }
    std::uint32_t take(int count) {
        const auto result = static_cast<std::uint32_t>(bits_ & ((std::uint64_t{1} << count) - 1));
        drop(count);
        return result;
    }
    /// The next whole bytes.
    Bytes take_bytes(std::size_t size) {
        at_ -= static_cast<std::size_t>(count_ / 8);
        bits_ = 0, count_ = 0;
        if (at_ > bytes_.size() || size > bytes_.size() - at_) refuse_data();
        at_ += size;
        return bytes_.subspan(at_ - size, size);
    }

private:
    Bytes bytes_;
    std::size_t at_ = 0;  // of the first byte beyond the bits
    std::uint64_t bits_ = 0;
    int count_ = 0;
};

/// A prefix code: the symbol that any next 15 bits begin with, or as many as the longest code has.
class PrefixCode {
public:
    /// lengths: bits of each symbol's code; 0 for symbols that do not occur.
    void build(std::span<const std::uint8_t> lengths) {
        std::array<std::uint32_t, max_code_bits + 2> counts{}, next{};
        for (const std::uint8_t length : lengths) ++counts[length];
        counts[0] = 0;
        bits_ = max_code_bits;
        while (bits_ > 1 && counts[static_cast<std::size_t>(bits_)] == 0) --bits_;
        for (std::size_t length = 1; length <= max_code_bits; ++length) {
            next[length + 1] = (next[length] + counts[length]) << 1;
            if (next[length] + counts[length] > std::uint32_t{1} << length) refuse_data();
        }
        entries_.assign(std::size_t{1} << bits_, 0);
        for (std::size_t symbol = 0; symbol < lengths.size(); ++symbol) {
            const std::size_t length = lengths[symbol];
            if (length == 0) continue;
            const std::uint32_t code = next[length]++;
            std::size_t reversed = 0;
            for (std::size_t bit = 0; bit < length; ++bit) reversed |= std::size_t{code >> bit & 1} << (length - 1 - bit);
            const auto entry = static_cast<std::uint16_t>(symbol << 4 | length);
            for (std::size_t at = reversed; at < entries_.size(); at += std::size_t{1} << length) entries_[at] = entry;
        }
    }
    /// Reads a symbol from bits that are available.
    std::uint32_t symbol(DeflateBits& bits) const {
        const std::uint16_t entry = entries_[static_cast<std::size_t>(bits.ahead()) & (entries_.size() - 1)];
        if (entry == 0) refuse_data();
        bits.drop(entry & 15);
        return entry >> 4;
    }

private:
    int bits_ = 0;
    std::vector<std::uint16_t> entries_;  // symbol << 4 | length
};

/// A length or distance: a base, and a number of further bits.
struct Extended {
    std::uint16_t base;
    std::uint8_t bits;
};

/// Each range begins where the last one ends; the further bits increase by one with every `step` ranges.
template <std::size_t count>
constexpr std::array<Extended, count> ranges(std::size_t first, std::size_t step) {
    std::array<Extended, count> result{};
    std::size_t base = first;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t bits = i < 2 * step ? 0 : i / step - 1;
        result[i] = {static_cast<std::uint16_t>(base), static_cast<std::uint8_t>(bits)};
        base += std::size_t{1} << bits;
    }
    return result;
}

constexpr auto lengths_of_copies = [] {
    auto result = ranges<29>(3, 4);
    result.back() = {258, 0};
    return result;
}();
constexpr auto distances_of_copies = ranges<30>(1, 2);

class Inflation {
public:
    Inflation(Bytes data, std::size_t size) : bits_(data), output_(size) {}

    Numbers<std::uint8_t> result() && {
        for (bool is_last = false; !is_last;) {
            Interruption::check();
            bits_.fill();
            is_last = bits_.take(1);
            switch (bits_.take(2)) {
                case 0: copy_stored(); break;
                case 1: read_fixed_codes(), decode(); break;
                case 2: read_codes(), decode(); break;
                default: refuse_data();
            }
        }
        if (end_ != output_.size()) refuse_data();
        static_cast<void>(bits_.take_bytes(0));  // refuses data that end too soon
        return std::move(output_);
    }

private:
    void copy_stored() {
        const Bytes sizes = bits_.take_bytes(4);
        const auto size = load<std::uint16_t>(&sizes[0], false), inverse = load<std::uint16_t>(&sizes[2], false);
        if ((size ^ inverse) != 0xffff || size > output_.size() - end_) refuse_data();
        const Bytes stored = bits_.take_bytes(size);
        std::copy(stored.begin(), stored.end(), output_.begin() + static_cast<std::ptrdiff_t>(end_));
        end_ += size;
    }
    void read_fixed_codes() {
        std::array<std::uint8_t, 288> lengths;
        for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
        literals_.build(lengths);
        std::array<std::uint8_t, 30> distances;
        distances.fill(5);
        distances_.build(distances);
    }
    void read_codes() {
        constexpr std::array<std::uint8_t, 19> order = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
        const std::size_t literals = bits_.take(5) + 257, distances = bits_.take(5) + 1, count = bits_.take(4) + 4;
        std::array<std::uint8_t, 19> own{};
        for (std::size_t i = 0; i < count; ++i) {
            bits_.fill();
            own[order[i]] = static_cast<std::uint8_t>(bits_.take(3));
        }
        PrefixCode& code = literals_;
        code.build(own);
        std::array<std::uint8_t, 288 + 32> lengths{};
        for (std::size_t i = 0; i < literals + distances;) {
            bits_.fill();
            const std::uint32_t symbol = code.symbol(bits_);
            if (symbol < 16) {
                lengths[i++] = static_cast<std::uint8_t>(symbol);
                continue;
            }
            const std::size_t repeats = symbol == 16 ? 3 + bits_.take(2) : symbol == 17 ? 3 + bits_.take(3) : 11 + bits_.take(7);
            if ((symbol == 16 && i == 0) || repeats > literals + distances - i) refuse_data();
            std::fill_n(&lengths[i], repeats, symbol == 16 ? lengths[i - 1] : std::uint8_t{0});
            i += repeats;
        }
        literals_.build(std::span(lengths).first(literals));
        distances_.build(std::span(lengths).subspan(literals, distances));
    }
    void decode() {
        constexpr std::size_t between_checks = 1 << 20;
        std::uint8_t* const output = output_.data();
        const std::size_t size = output_.size();
        std::size_t end = end_, check = end + between_checks;
        while (true) {
            bits_.fill();  // a code, a length, another code and a distance have 48 bits
            const std::uint32_t symbol = literals_.symbol(bits_);
            if (symbol < 256) {
                if (end == size) refuse_data();
                output[end++] = static_cast<std::uint8_t>(symbol);
                continue;
            }
            if (symbol == 256) break;
            if (symbol - 257 >= lengths_of_copies.size()) refuse_data();
            const Extended& of_length = lengths_of_copies[symbol - 257];
            const std::size_t length = of_length.base + bits_.take(of_length.bits);
            const std::uint32_t second = distances_.symbol(bits_);
            if (second >= distances_of_copies.size()) refuse_data();
            const Extended& of_distance = distances_of_copies[second];
            const std::size_t distance = of_distance.base + bits_.take(of_distance.bits);
            if (distance > end || length > size - end) refuse_data();
            std::uint8_t* const to = output + end;
            if (distance >= length) {
                std::memcpy(to, to - distance, length);
            } else {
                for (std::size_t i = 0; i < length; ++i) to[i] = to[static_cast<std::ptrdiff_t>(i) - static_cast<std::ptrdiff_t>(distance)];
            }
            end += length;
            if (end > check) {
                Interruption::check();
                check = end + between_checks;
            }
        }
        end_ = end;
    }

    DeflateBits bits_;
    Numbers<std::uint8_t> output_;
    std::size_t end_ = 0;  // of the output so far
    PrefixCode literals_, distances_;
};

}  // namespace

Numbers<std::uint8_t> inflated(Bytes data, std::uint64_t size) {
    constexpr std::uint64_t highest_ratio = 1032;  // a copy of 258 bytes takes at least two bits
    if (size / highest_ratio > data.size()) refuse_data();
    return Inflation(data, static_cast<std::size_t>(size)).result();
}

std::uint32_t crc32(Bytes bytes) {
    using Table = std::array<std::uint32_t, 256>;
    static const auto tables = [] {  // of a byte that 0 to 3 others follow
        std::array<Table, 4> made;
        for (std::uint32_t i = 0; i < 256; ++i) {
            std::uint32_t value = i;
            for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ (value & 1 ? 0xedb88320u : 0);
            made[0][i] = value;
        }
        for (std::size_t k = 1; k < made.size(); ++k) {
            for (std::size_t i = 0; i < 256; ++i) made[k][i] = (made[k - 1][i] >> 8) ^ made[0][made[k - 1][i] & 255];
        }
        return made;
    }();
    std::uint32_t crc = 0xffffffff;
    for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
        crc ^= load<std::uint32_t>(bytes.data(), false);
        crc = tables[3][crc & 255] ^ tables[2][crc >> 8 & 255] ^ tables[1][crc >> 16 & 255] ^ tables[0][crc >> 24];
    }
    for (const std::uint8_t byte : bytes) crc = (crc >> 8) ^ tables[0][(crc ^ byte) & 255];
    return ~crc;
}

}  // namespace bob::files
