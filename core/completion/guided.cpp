#include "completion/guided.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/color.h"
#include "base/parallel.h"
#include "completion/guided_fit.h"
#include "completion/guided_samples.h"
#include "completion/guided_surfaces.h"

namespace bob {
namespace {

/// Scatter around the fit is detail if it exceeds the noise by this factor, since noise has long tails.
constexpr float noise_explains = 2;

void complete(const Layout& known, const float* planes, const GuidedSurfaces& surfaces, const Channel& channel, GuidedExtent extent, bool keeps_samples,
              float* output, float* noise) {
    const int height = surfaces.height(), width = surfaces.width(), components = channel.components;
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    GuidedSamples traced(known, planes, channel, surfaces, extent);
    if (noise) std::fill_n(noise, pixels, 0.f);
    if (traced.samples.empty()) {
        std::fill_n(output, pixels * static_cast<std::size_t>(components), 0.f);
        return;
    }
    const GuidedReaches reaches(surfaces, traced);
    const float* const values = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    const int in_row = (width + GuidedBlock::width - 1) / GuidedBlock::width, in_column = (height + GuidedBlock::height - 1) / GuidedBlock::height;
    parallel_for(static_cast<std::size_t>(in_row) * static_cast<std::size_t>(in_column), 2, [&](std::size_t begin, std::size_t end) {
        GuidedFit fit(surfaces, traced, reaches, components, extent);
        GuidedBlock fitted;
        for (std::size_t block = begin; block < end; ++block) {
            const int down = static_cast<int>(block) / in_row, across = static_cast<int>(block) % in_row;
            const int top = down * GuidedBlock::height, left = across * GuidedBlock::width, right = std::min(left + GuidedBlock::width, width);
            fit.block(top, left, fitted);
            for (int y = top; y < std::min(top + GuidedBlock::height, height); ++y) {
                const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
                const auto in_block = [&](int x) { return static_cast<std::size_t>((y - top) * GuidedBlock::width + x - left); };
                const float* const coverage = surfaces.row(GuidedSurfaces::coverage, y);
                for (int c = 0; c < components; ++c) {
                    float* const to = output + static_cast<std::size_t>(c) * pixels + row;
                    for (int x = left; x < right; ++x) {
                        const float light = std::max(0.f, fitted.light[c][in_block(x)] * surfaces.divisor(components, c, y, x));
                        to[x] = extent == GuidedExtent::all || coverage[x] > 0 ? light : 0;
                    }
                }
                if (!keeps_samples) continue;
                for (const GuidedSample& sample : traced.in_tiles(y, left / guided_tiles::width, guided_tiles::across(right))) {
                    const int x = static_cast<int>(sample.column);
                    const std::size_t k = in_block(x), i = row + static_cast<std::size_t>(x);
                    const float around = fitted.noise[k], detail = std::max(0.f, fitted.detail[k] - noise_explains * around);
                    const float weight = sample.variance > 0 ? detail / (detail + std::max(around, sample.variance)) : 1;
                    for (int c = 0; c < components; ++c) {
                        const std::size_t place = static_cast<std::size_t>(c) * pixels + i;
                        const float light = fitted.light[c][k], divisor = surfaces.divisor(components, c, y, x);
                        output[place] = weight == 1 ? values[place] : std::max(0.f, (light + weight * (sample.light[c] - light)) * divisor);
                        if (noise) noise[i] = std::max(noise[i], weight * std::sqrt(sample.variance) * divisor);
                    }
                }
            }
        }
    });
}

}  // namespace

void complete_guided(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const Channel& channel,
                     int height, int width, bool covered_only, float* output, float* noise) {
    const GuidedSurfaces surfaces(guides_layout, guides, height, width);
    complete(known, planes, surfaces, channel, covered_only ? GuidedExtent::surfaces : GuidedExtent::all, true, output, noise);
}

void complete_alpha(const Layout& known, const float* planes, const float* coverage, const float* ground, int height, int width, float* alpha,
                    float* noise, bool keeps_samples) {
    const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    if (std::any_of(ground, ground + size, [](float share) { return share > 0; })) {
        complete(known, planes, GuidedSurfaces(ground, height, width), channels::shadow, GuidedExtent::plane, keeps_samples, alpha, noise);
    } else {
        std::fill_n(alpha, size, 0.f);
        if (noise) std::fill_n(noise, size, 0.f);
    }
    for (std::size_t i = 0; i < size; ++i) alpha[i] = std::min(coverage[i] + alpha[i], 1.f);
}

void complete_light(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const float* ground,
                    int height, int width, float* color, float* alpha, float* noise, bool keeps_samples) {
    const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const float* const coverage = guides + static_cast<std::size_t>(guides_layout.place_of(channels::mask)) * size;
    std::vector<float> in_shadow(noise ? size : 0);
    complete(known, planes, GuidedSurfaces(guides_layout, guides, height, width), channels::color, GuidedExtent::surfaces, keeps_samples, color, noise);
    if (ground) complete_alpha(known, planes, coverage, ground, height, width, alpha, noise ? in_shadow.data() : nullptr, keeps_samples);
    else std::copy_n(coverage, size, alpha);
    if (!noise) return;
    const auto shown = [](float light) { return to_srgb(std::clamp(light, 0.f, 1.f)); };
    for (std::size_t i = 0; i < size; ++i) {
        const float brightest = std::max({color[i], color[size + i], color[2 * size + i]});
        noise[i] = (shown(brightest + noise[i]) - shown(brightest - noise[i])) / 2 + in_shadow[i];
    }
}

}  // namespace bob
