#include "tracing/antialiasing.h"

#include <algorithm>
#include <cmath>

#include "picture/channels.h"
#include "tracing/trace.h"

namespace bob {
namespace {

/// Smaller differences, in the square root of linear light or in coverage, need no more rays.
constexpr float edge = 1 / 32.f;

constexpr std::size_t components = 5;  // of a sample or a mean

}  // namespace

std::vector<Pixel> pixels_at_edges(std::span<const LightPlane> light, const float* covered, int height, int width, int begin, int end) {
    const auto across = static_cast<std::size_t>(width), padded = across + 2, planes = light.size() + 1;
    std::vector<float> rows(3 * planes * padded);
    const auto row_of = [&](int y) { return rows.data() + static_cast<std::size_t>((y + 3) % 3) * planes * padded + 1; };
    const auto read = [&](int y) {
        const std::size_t at = static_cast<std::size_t>(std::clamp(y, 0, height - 1)) * across;
        float* to = row_of(y);
        for (std::size_t plane = 0; plane < planes; ++plane, to += padded) {
            for (std::size_t x = 0; x < across; ++x) {
                to[x] = plane == 0 ? (covered[at + x] > 0 ? 1.f : 0.f) : std::sqrt(light[plane - 1].values[(at + x) * light[plane - 1].step]);
            }
            to[-1] = to[0], to[across] = to[across - 1];
        }
    };
    read(begin - 1), read(begin);
    std::vector<Pixel> found;
    for (int y = begin; y < end; ++y) {
        read(y + 1);
        for (std::size_t x = 0; x < across; ++x) {
            float bent = 0;
            for (std::size_t i = x; i < planes * padded; i += padded) {
                const float *above = row_of(y - 1) + i, *here = row_of(y) + i, *below = row_of(y + 1) + i, twice = 2 * *here;
                for (const float sum : {here[-1] + here[1], *above + *below, above[-1] + below[1], above[1] + below[-1]}) {
                    bent = std::max(bent, std::abs(sum - twice));
                }
            }
            if (bent > edge) found.push_back({y, static_cast<int>(x)});
        }
    }
    return found;
}

void trace_means(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels, int side, float* means) {
    const Layout layout{channels::mask, channels::color, channels::alpha};
    std::vector<Pixel> rays;
    for (const Pixel pixel : pixels) {
        for (int down = 0; down < side; ++down) {
            for (int right = 0; right < side; ++right) rays.push_back({side * pixel.row + down, side * pixel.column + right});
        }
    }
    std::vector<float> samples(rays.size() * components);
    trace(scene, camera, side * height, side * width, rays, layout, samples.data());
    const std::size_t each = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    const float* seen = samples.data();
    for (std::size_t i = 0; i < pixels.size(); ++i, means += components, seen += each * components) {
        means[0] = 0;
        for (std::size_t c = 1; c < components; ++c) {
            float sum = 0, low = 1, high = 0;
            for (std::size_t k = 0; k < each; ++k) {
                const float value = seen[k * components + c], shown = c + 1 == components ? value : std::sqrt(value);
                sum += value, low = std::min(low, shown), high = std::max(high, shown);
            }
            means[c] = sum / static_cast<float>(each);
            if (high - low > edge) means[0] = 1;
        }
    }
}

}  // namespace bob
