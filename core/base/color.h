/// Colours: linear RGB in x, y and z, and the sRGB curve.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/vec.h"

namespace bob {

/// Luminance by Rec. 709's weights; exactly 1 for white, unlike the sum in float.
inline float luminance(Vec3 rgb) { return static_cast<float>(0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z); }

/// Minimum divisor of demodulated light, and factor of light that is multiplied back. Dark surfaces reflect highlights too.
constexpr float min_albedo = 0.02f;

/// IEC 61966-2-1: sRGB to linear values, both 0..1, and back.
inline float from_srgb(float value) {
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}
inline float to_srgb(float value) {
    return value <= 0.0031308f ? value * 12.92f : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f;
}

/// Linear light, 0..1, to a byte of sRGB: 255 to_srgb, rounded. A table replaces the power, which would take several
/// times as long as the rest of halving a texture.
class SrgbBytes {
public:
    SrgbBytes();

    [[nodiscard]] std::uint8_t operator()(float linear) const {
        std::uint8_t byte = byte_at_[std::min(static_cast<std::size_t>(linear * steps), steps - 1)];
        while (least_[byte + 1u] <= linear) ++byte;
        return byte;
    }

private:
    static constexpr std::size_t steps = 4096;  // at most about one byte boundary per step, even where the curve is steepest

    std::array<float, 257> least_{};             // the lower end of each byte's range, then an upper bound of all values
    std::array<std::uint8_t, steps> byte_at_{};  // at the lower end of each step
};

/// The one table of the core.
inline const SrgbBytes& srgb_bytes() {
    static const SrgbBytes table;
    return table;
}

/// Linear RGB of "#rrggbb", "#rgb" or a CSS color name; empty for any other text.
[[nodiscard]] std::optional<std::array<double, 3>> linear_color(std::string_view text);

}  // namespace bob
