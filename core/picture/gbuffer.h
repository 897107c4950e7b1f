/// The G-buffer: what is known of the first visible surface at the traced pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace bob {

struct Pixel {
    std::int32_t row, column;
};

/// What one ray tells. All zero where it missed.
struct Sample {
    float gray = 0;          // 0..1
    float depth = 0;         // 0..1, 1 at the point of the unit sphere nearest the camera
    float normal[2] = {};    // screen space, x right and y up
    bool hit = false;
};

/// Arrays of n samples, field by field.
struct Samples {
    float* gray;
    float* depth;
    float* normal;  // n pairs
    bool* hit;

    void set(std::size_t i, const Sample& sample) const {
        gray[i] = sample.gray;
        depth[i] = sample.depth;
        normal[2 * i] = sample.normal[0];
        normal[2 * i + 1] = sample.normal[1];
        hit[i] = sample.hit;
    }
};

/// Writes samples to their pixels in `planes`, (5, height, width): mask, gray, depth, normal x, normal y. The mask becomes
/// 1, the rest 0 where the ray missed.
inline void scatter(std::span<const Pixel> pixels, const Samples& samples, float* planes, std::size_t height,
                    std::size_t width) {
    const std::size_t plane = height * width;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        float* p = planes + static_cast<std::size_t>(pixels[i].row) * width + static_cast<std::size_t>(pixels[i].column);
        const bool hit = samples.hit[i];
        p[0] = 1;
        p[plane] = hit ? samples.gray[i] : 0;
        p[2 * plane] = hit ? samples.depth[i] : 0;
        p[3 * plane] = hit ? samples.normal[2 * i] : 0;
        p[4 * plane] = hit ? samples.normal[2 * i + 1] : 0;
    }
}

}  // namespace bob
