#include "base/color.h"

namespace bob {
namespace {

/// -1 for any other character.
int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

}  // namespace

SrgbBytes::SrgbBytes() {
    for (std::size_t byte = 1; byte < 256; ++byte) {
        const auto reaches = [&](float x) { return to_srgb(x) * 255 + 0.5f >= static_cast<float>(byte); };
        float x = from_srgb((static_cast<float>(byte) - 0.5f) / 255);
        while (reaches(x)) x = std::nextafter(x, 0.f);
        while (!reaches(x)) x = std::nextafter(x, 1.f);
        least_[byte] = x;
    }
    least_[256] = 2;
    std::uint8_t byte = 0;
    for (std::size_t i = 0; i < steps; ++i) {
        while (least_[byte + 1u] <= static_cast<float>(i) / steps) ++byte;
        byte_at_[i] = byte;
    }
}

std::optional<std::array<double, 3>> linear_color(std::string_view text) {
    if ((text.size() != 4 && text.size() != 7) || text[0] != '#') return std::nullopt;
    const std::size_t digits = (text.size() - 1) / 3;
    std::array<double, 3> rgb;
    for (std::size_t i = 0; i < 3; ++i) {
        const int high = digit(text[1 + digits * i]), low = digit(text[digits * (i + 1)]);
        if (high < 0 || low < 0) return std::nullopt;
        const double value = (16 * high + low) / 255.0;
        rgb[i] = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    }
    return rgb;
}

}  // namespace bob
