/// Decimal numbers without a locale.
#pragma once

#include <optional>
#include <string_view>

namespace bob::files {

/// The double nearest to a decimal number such as -1.5e3, ties to even; infinity or NaN for "inf", "infinity" and "nan" in any case;
/// empty for any other text. Replaces std::from_chars, which takes 30 kB in WebAssembly, and also accepts a plus sign.
[[nodiscard]] std::optional<double> decimal(std::string_view text);

}  // namespace bob::files
