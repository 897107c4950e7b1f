/// Four floats in one register of every machine (SSE2, NEON, simd128), for code compiled once. Code that profits from
/// wider registers is in *_kernels.cpp files and uses simd.h.
#pragma once

#include <cstring>

namespace bob {

using Float4 [[gnu::vector_size(16)]] = float;

[[nodiscard]] inline Float4 load4(const float* p) {
    Float4 v;
    std::memcpy(&v, p, sizeof v);
    return v;
}

[[nodiscard]] inline Float4 min(Float4 a, Float4 b) { return a < b ? a : b; }
[[nodiscard]] inline Float4 max(Float4 a, Float4 b) { return a > b ? a : b; }

}  // namespace bob
