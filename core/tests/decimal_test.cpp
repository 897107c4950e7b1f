#include "files/decimal.h"

#include <bit>
#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <limits>
#include <string>

#include "check.h"

namespace {

/// By the standard library, where it knows the number's size.
void check_nearest(const std::string& text) {
    double expected = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), expected);
    if (error != std::errc()) return;
    const double found = bob::files::decimal(text).value_or(std::numeric_limits<double>::quiet_NaN());
    if (std::bit_cast<std::uint64_t>(found) != std::bit_cast<std::uint64_t>(expected)) test::fail(__FILE__, __LINE__, text);
}

}  // namespace

TEST(decimals_are_rounded_to_the_nearest_double) {
    test::Random random(1);
    char text[1100];
    for (int i = 0; i < 200'000; ++i) {
        const auto bits = static_cast<std::uint64_t>(random() * 0x1p32) << 32 | static_cast<std::uint64_t>(random() * 0x1p32);
        const auto number = std::bit_cast<double>(bits);
        if (!std::isfinite(number)) continue;
        std::snprintf(text, sizeof text, "%.*g", i % 20, number);
        check_nearest(text);
        std::snprintf(text, sizeof text, "%.*f", i % 18, (random() - 0.5) * 1e3);
        check_nearest(text);
        std::snprintf(text, sizeof text, "%" PRIu64 "e%d", bits >> (i % 64), i % 60 - 30);
        check_nearest(text);
    }
    // Halfway between doubles, and slightly beyond, with all digits.
    for (const double number : {1., 0x1.fffffffffffffp0, 0x1p-1074, 0x1p-1022, 3e-320, 1e22, 1e-5, 0x1.fffffffffffffp1023}) {
        const double next = std::nextafter(number, 1e300);
        std::snprintf(text, sizeof text, "%.1074f", number);
        check_nearest(text);
        const int exponent = std::ilogb(std::min(number, next)) - 53;
        if (exponent < -1074 || number > 1e300) continue;
        std::snprintf(text, sizeof text, "%.1060f", number + std::ldexp(1, exponent));
        check_nearest(text);
        check_nearest(std::string(text) + "1");
    }
    for (const char* own : {"0", "-0", "0.0e9", ".5", "5.", "0.000001e6", "00012.500", "9007199254740993", "9007199254740992.999999999999999999",
                            "2.2250738585072011e-308", "1.7976931348623158e308", "4.9406564584124654e-324", "123456789012345678901234567890"}) {
        check_nearest(own);
    }
}

TEST(decimals_know_no_other_texts) {
    using bob::files::decimal;
    CHECK(decimal("+1.5e+3") == 1500);
    CHECK(decimal("1e999") == std::numeric_limits<double>::infinity());
    CHECK(decimal("-1e99999999999999999999") == -std::numeric_limits<double>::infinity());
    CHECK(decimal("1e-999") == 0);
    CHECK(decimal("-INF") == -std::numeric_limits<double>::infinity());
    CHECK(std::isnan(*decimal("nan")));
    for (const char* text : {"", "+", ".", "e5", "1e", "1e+", "1,5", "0x10", "1_0", "--1", "+-1", "1.5.2", "1 ", "infinite", "nan(1)"}) {
        if (decimal(text)) test::fail(__FILE__, __LINE__, text);
    }
    CHECK(decimal(std::string(100'000, '0') + "1") == 1);
    CHECK(decimal("0." + std::string(100'000, '0') + "1e100001") == 1);
}
