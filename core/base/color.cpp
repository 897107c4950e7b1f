#include "base/color.h"

#include <algorithm>
#include <iterator>

#include "base/color_names.h"

namespace bob {
namespace {

/// -1 for any other character.
int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/// 0xrrggbb from three or six digits.
std::optional<std::uint32_t> hexadecimal(std::string_view text) {
    if (text.size() != 3 && text.size() != 6) return std::nullopt;
    std::uint32_t rgb = 0;
    for (std::size_t i = 0; i < 6; ++i) {
        const int next = digit(text[i * text.size() / 6]);
        if (next < 0) return std::nullopt;
        rgb = 16 * rgb + static_cast<std::uint32_t>(next);
    }
    return rgb;
}

/// 0xrrggbb of a CSS color name in lower or upper case.
std::optional<std::uint32_t> named(std::string_view text) {
    std::string name(text);
    std::ranges::transform(name, name.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    const auto found = std::ranges::lower_bound(named_colors, std::string_view(name), {}, &NamedColor::name);
    if (found == std::end(named_colors) || found->name != name) return std::nullopt;
    return found->rgb;
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
    const auto rgb = text.starts_with('#') ? hexadecimal(text.substr(1)) : named(text);
    if (!rgb) return std::nullopt;
    std::array<double, 3> linear;
    for (std::size_t i = 0; i < 3; ++i) {
        const double value = (*rgb >> (16 - 8 * i) & 255) / 255.0;
        linear[i] = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    }
    return linear;
}

}  // namespace bob
