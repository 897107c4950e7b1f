/// Data compressed by meshoptimizer, as EXT_meshopt_compression and KHR_meshopt_compression specify it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// Decodes `count` elements of `stride` bytes. Throws std::invalid_argument unless the bytes are exactly these.
///
/// mode, filter: by the extension's names. The caller bounds `count * stride`.
[[nodiscard]] std::vector<std::uint8_t> meshopt_decoded(Bytes from, std::size_t count, std::size_t stride, std::string_view mode,
                                                        std::string_view filter);

}  // namespace bob::files
