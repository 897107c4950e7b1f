#include "files/decimal.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace bob::files {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr std::array<std::uint64_t, 20> powers_of_ten = [] {
    std::array<std::uint64_t, 20> powers{1};
    for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 10 * powers[i - 1];
    return powers;
}();
constexpr int most_digits = 800;  // 767 digits decide the rounding; any nonzero digits after them act as one more

/// (value + a little if more) 2^exponent, rounded to the nearest double, ties to even.
double rounded(Wide value, bool more, int exponent) {
    const auto high = static_cast<std::uint64_t>(value >> 64), low = static_cast<std::uint64_t>(value);
    const int bits = 128 - (high ? std::countl_zero(high) : 64 + std::countl_zero(low));
    const int shift = std::max(bits - 53, -1074 - exponent);
    if (shift <= 0) return std::ldexp(static_cast<double>(low), exponent);
    if (shift > 127) return 0;
    auto kept = static_cast<std::uint64_t>(value >> shift);
    const Wide rest = value - (Wide{kept} << shift), half = Wide{1} << (shift - 1);
    if (rest > half || (rest == half && (more || kept & 1))) ++kept;
    return std::ldexp(static_cast<double>(kept), exponent + shift);
}

/// A whole number of any size.
class Large {
public:
    void multiply_add(std::uint32_t factor, std::uint32_t summand) {
        std::uint64_t carry = summand;
        for (std::size_t i = 0; i < size_; ++i) {
            carry += std::uint64_t{limbs_[i]} * factor;
            limbs_[i] = static_cast<std::uint32_t>(carry);
            carry >>= 32;
        }
        if (carry) limbs_[size_++] = static_cast<std::uint32_t>(carry);
    }
    /// Shifts to the left by whole limbs, before anything else.
    void shift(std::size_t limbs) {
        std::uint32_t* const begin = limbs_.data();
        std::copy_backward(begin, begin + size_, begin + size_ + limbs);
        std::fill_n(begin, limbs, 0u);
        size_ += limbs;
    }
    /// Returns whether there is a remainder.
    bool divide(std::uint32_t divisor) {
        std::uint64_t rest = 0;
        for (std::size_t i = size_; i-- > 0;) {
            rest = rest << 32 | limbs_[i];
            limbs_[i] = static_cast<std::uint32_t>(rest / divisor);
            rest %= divisor;
        }
        while (size_ > 0 && limbs_[size_ - 1] == 0) --size_;
        return rest > 0;
    }
    [[nodiscard]] double nearest(bool more, int exponent) const {
        Wide top = 0;
        const std::size_t begin = size_ > 4 ? size_ - 4 : 0;
        for (std::size_t i = size_; i-- > begin;) top = top << 32 | limbs_[i];
        for (std::size_t i = 0; i < begin; ++i) more |= limbs_[i] != 0;
        return rounded(top, more, exponent + 32 * static_cast<int>(begin));
    }

private:
    // 801 digits, 84 limbs, times 10^310 or 2^(32 * 118)
    std::array<std::uint32_t, 240> limbs_{};
    std::size_t size_ = 0;
};

/// A decimal number's digits without leading zeros: 0.d1d2d3... 10^exponent.
struct Digits {
    std::array<std::uint8_t, most_digits> own;
    int count = 0;
    bool more = false;  // nonzero digits beyond
    std::int64_t exponent = 0;

    void push(std::uint8_t digit) {
        if (count < most_digits) {
            own[static_cast<std::size_t>(count++)] = digit;
        } else {
            more |= digit != 0;
        }
    }
};

double slow(const Digits& digits) {
    if (digits.exponent > 310) return std::numeric_limits<double>::infinity();
    if (digits.exponent < -330) return 0;
    Large number;
    const int power = static_cast<int>(digits.exponent) - digits.count - digits.more;
    for (int i = 0; i < digits.count; ++i) number.multiply_add(10, digits.own[static_cast<std::size_t>(i)]);
    if (digits.more) number.multiply_add(10, 1);
    if (power >= 0) {
        for (int i = 0; i < power; ++i) number.multiply_add(10, 0);
        return number.nearest(false, 0);
    }
    // Quotients by 10^power keep at least 64 bits: 10 is below 2^(10/3).
    const int limbs = (-power * 10 / 3 + 96) / 32;
    number.shift(static_cast<std::size_t>(limbs));
    bool more = false;
    int left = -power;
    for (; left >= 9; left -= 9) more |= number.divide(1'000'000'000);
    if (left > 0) more |= number.divide(static_cast<std::uint32_t>(powers_of_ten[static_cast<std::size_t>(left)]));
    return number.nearest(more, -32 * limbs);
}

/// The nearest double if 128 bits are enough to find it.
std::optional<double> quick(std::uint64_t mantissa, std::int64_t power) {
    if (power < -19 || power > 19) return std::nullopt;
    const std::uint64_t ten = powers_of_ten[static_cast<std::size_t>(power < 0 ? -power : power)];
    if (mantissa < std::uint64_t{1} << 53 && ten < std::uint64_t{1} << 53) {  // both are doubles
        const auto number = static_cast<double>(mantissa), scale = static_cast<double>(ten);
        return power < 0 ? number / scale : number * scale;
    }
    if (power >= 0) return rounded(Wide{mantissa} * ten, false, 0);
    const int shift = 63 + std::countl_zero(mantissa);
    const Wide number = Wide{mantissa} << shift, quotient = number / ten;
    return rounded(quotient, quotient * ten != number, -shift);
}

bool is_any(std::string_view text, std::string_view word) {
    return std::ranges::equal(text, word, [](char a, char b) { return (a | 0x20) == b; });
}

}  // namespace

std::optional<double> decimal(std::string_view text) {
    const bool is_negative = text.starts_with('-');
    if (is_negative || text.starts_with('+')) text.remove_prefix(1);
    const auto with_sign = [&](double size) { return is_negative ? -size : size; };
    if (is_any(text, "inf") || is_any(text, "infinity")) return with_sign(std::numeric_limits<double>::infinity());
    if (is_any(text, "nan")) return with_sign(std::numeric_limits<double>::quiet_NaN());

    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    std::uint64_t mantissa = 0;
    std::size_t at = 0, first = text.size();
    std::int64_t digits = 0, before_point = -1;  // digits: from the first that is not 0 on
    bool is_number = false;
    std::int64_t zeros = 0;  // behind the point, before the first other digit
    for (; at < text.size() && (is_digit(text[at]) || (text[at] == '.' && before_point < 0)); ++at) {
        if (text[at] == '.') {
            before_point = digits;
            continue;
        }
        is_number = true;
        if (digits == 0 && text[at] == '0') {
            zeros += before_point >= 0;
            continue;
        }
        if (digits == 0) first = at;
        if (digits < 19) mantissa = 10 * mantissa + static_cast<std::uint64_t>(text[at] - '0');
        ++digits;
    }
    if (!is_number) return std::nullopt;
    const std::size_t end = at;
    std::int64_t exponent = 0;
    if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
        ++at;
        const bool is_below = at < text.size() && text[at] == '-';
        if (at < text.size() && (text[at] == '-' || text[at] == '+')) ++at;
        if (at == text.size()) return std::nullopt;
        for (; at < text.size() && is_digit(text[at]); ++at) exponent = std::min<std::int64_t>(10 * exponent + (text[at] - '0'), 1'000'000'000'000);
        if (is_below) exponent = -exponent;
    }
    if (at != text.size()) return std::nullopt;
    if (digits == 0) return with_sign(0);

    const std::int64_t whole = before_point < 0 ? digits : before_point;  // 0.d1d2d3... 10^(whole - zeros + exponent)
    if (digits <= 19) {
        if (const auto number = quick(mantissa, whole - zeros + exponent - digits)) return with_sign(*number);
    }
    Digits all;
    all.exponent = whole - zeros + exponent;
    for (std::size_t i = first; i < end; ++i) {
        if (text[i] != '.') all.push(static_cast<std::uint8_t>(text[i] - '0'));
    }
    return with_sign(slow(all));
}

}  // namespace bob::files
