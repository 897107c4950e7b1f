#include "files/colors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/interruption.h"

namespace bob::files {

double linear(double srgb) { return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4); }

void make_linear(Numbers<double>& values, double full, double most) {
    if (full == 0) {
        double largest = 0;
        for (const double value : values) largest = value > largest ? value : largest;  // NaN is not
        full = largest <= 1 ? 1 : largest <= 255 ? 255 : most;
    }
    std::array<double, 256> of_bytes;
    for (std::size_t i = 0; i < of_bytes.size(); ++i) of_bytes[i] = linear(static_cast<double>(i) / 255);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % 65536 == 0) Interruption::check();
        const double value = values[i];
        const bool is_byte = full == 255 && value >= 0 && value <= 255 && value == std::floor(value);
        values[i] = is_byte ? of_bytes[static_cast<std::size_t>(value)] : std::isnan(value) ? value : linear(std::clamp(value / full, 0., 1.));
    }
}

}  // namespace bob::files
