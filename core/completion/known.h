/// What is known stays as it was traced.
#pragma once

#include <cstddef>

#include "parallel.h"

namespace bob {

/// Puts the traced pixels of a G-buffer of `pixels` pixels, (5, height, width), back into `gray`; the others are
/// clamped to 0..1, and NaN to 0.
inline void keep_known(const float* gbuffer, std::size_t pixels, float* gray) {
    const float* mask = gbuffer;
    const float* known = gbuffer + pixels;
    parallel_for(pixels, 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float clamped = gray[i] > 0 ? (gray[i] < 1 ? gray[i] : 1) : 0;
            gray[i] = mask[i] > 0 ? known[i] : clamped;
        }
    });
}

}  // namespace bob
