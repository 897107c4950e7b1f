#include "light/light_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/color.h"
#include "base/parallel.h"
#include "light/edges.h"
#include "light/sobol.h"

namespace bob {
namespace {

/// Two hits are on the same surface if the cosine between their normals exceeds the first number, and their depths differ by less than
/// the second, in pixels along the surface.
constexpr float same_normal = 0.9f, same_depth = 2, steepest = 0.1f;

/// Maximum change of a sample's luminance, as a share of itself plus a tenth.
constexpr float max_change = 0.05f, dark = 0.1f;

/// Decay of old paths per move, and their maximum number.
constexpr float kept_paths = 0.97f, max_paths = 256;

/// Side, in pixels, of blocks that should have a sample in motion; light is completed between samples.
constexpr int block = 4;

Vec3 divided(Vec3 color, Vec3 albedo) {
    for (int k = 0; k < 3; ++k) color[k] /= std::max(albedo[k], min_albedo);
    return color;
}
Vec3 multiplied(Vec3 light, Vec3 albedo) {
    for (int k = 0; k < 3; ++k) light[k] *= std::max(albedo[k], min_albedo);
    return light;
}
float divisor(Vec3 albedo) { return std::max(luminance(albedo), min_albedo); }

/// A first hit at a pixel.
struct FirstHit {
    bool is_surface, is_ground;
    float depth;
    Vec3 normal, albedo;  // the normal in screen space

    FirstHit(const SeenSurfaces& surfaces, std::size_t pixels, std::size_t i) {
        const auto value = [&](std::size_t plane) { return surfaces.planes[plane * pixels + i]; };
        is_surface = value(first_hit::mask) > 0, is_ground = !is_surface && surfaces.ground && surfaces.ground[i] > 0;
        depth = is_ground ? surfaces.ground[pixels + i] : value(first_hit::depth);
        normal = whole_normal(value(first_hit::normal_x), value(first_hit::normal_y));
        albedo = {value(first_hit::red), value(first_hit::green), value(first_hit::blue)};
    }
};

}  // namespace

LightHistory::LightHistory(int height, int width) : height_(height), width_(width), at_(pixels(), -1) {}

void LightHistory::merge(Sample& sample, const Sample& other) {
    const float sum = sample.paths + other.paths, own = sample.paths / sum, share = other.paths / sum;
    sample.light = own * sample.light + share * other.light;
    sample.shadow = own * sample.shadow + share * other.shadow;
    sample.variance = own * own * sample.variance + share * share * other.variance;
    sample.change = own * sample.change + share * other.change;
    if (other.age < sample.age) sample.toward = other.toward;
    sample.paths = sum, sample.age = std::min(sample.age, other.age);
}

LightHistory::Traced LightHistory::Traced::of(const float* means, float change, std::uint32_t paths) {
    return {{means[red], means[green], means[blue]}, means[LightHistory::shadow], means[LightHistory::variance], change, paths};
}

void LightHistory::age() {
    for (Sample& sample : samples_) sample.is_reprojected = true;
}

void LightHistory::move(const Camera& camera, int height, int width, const SeenSurfaces& surfaces) {
    camera_ = camera, height_ = height, width_ = width;
    const Projection projection(camera, height_, width_);
    parallel_for(samples_.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            Sample& sample = samples_[n];
            sample.pixel = -1;
            const Projection::Seen seen = projection.seen(sample.position);
            const float row = std::round(seen.row), column = std::round(seen.column);
            if (!(row >= 0 && row < static_cast<float>(height_) && column >= 0 && column < static_cast<float>(width_))) continue;
            const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
            const FirstHit hit(surfaces, pixels(), i);
            if (sample.on_ground ? !hit.is_ground : !hit.is_surface) continue;
            if (!sample.on_ground) {
                const float tolerance = same_depth * projection.pixel_side(hit.depth) / std::max(hit.normal.z, steepest);
                if (!(std::abs(seen.depth - hit.depth) < tolerance)) continue;
                if (!(dot(projection.in_scene(hit.normal, row, column), sample.normal) > same_normal)) continue;
                const Vec3 toward = projection.in_scene({0, 0, 1}, row, column);
                const float turned = length(toward - sample.toward), change = sample.change * turned;
                if (change > max_change * (luminance(sample.light) + dark)) continue;
            }
            sample.pixel = static_cast<std::int32_t>(i);
            sample.paths = std::min(kept_paths * sample.paths, max_paths), sample.age = static_cast<std::uint16_t>(std::min(sample.age + 1, 60000)), sample.is_reprojected = true;
        }
    });
    at_.assign(pixels(), -1);
    std::size_t kept = 0;
    for (std::size_t n = 0; n < samples_.size(); ++n) {
        if (samples_[n].pixel < 0) continue;
        std::int32_t& at = at_[static_cast<std::size_t>(samples_[n].pixel)];
        if (at >= 0) {
            merge(samples_[static_cast<std::size_t>(at)], samples_[n]);
            continue;
        }
        at = static_cast<std::int32_t>(kept);
        samples_[kept++] = samples_[n];
    }
    samples_.resize(kept);
}

void LightHistory::add(std::span<const Pixel> traced_pixels, std::span<const Traced> traced, bool at_rest, const SeenSurfaces& surfaces) {
    const Projection projection(camera_, height_, width_);
    for (std::size_t k = 0; k < traced_pixels.size(); ++k) {
        const auto [row, column] = traced_pixels[k];
        const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
        const FirstHit hit(surfaces, pixels(), i);
        if (!hit.is_surface && !hit.is_ground) continue;
        const auto y = static_cast<float>(row), x = static_cast<float>(column);
        const float scale = hit.is_surface ? divisor(hit.albedo) : 1;
        const Sample fresh{projection.point(y, x, hit.depth), projection.in_scene(hit.normal, y, x), projection.in_scene({0, 0, 1}, y, x),
                           hit.is_surface ? divided(traced[k].color, hit.albedo) : Vec3{}, traced[k].shadow, traced[k].variance / (scale * scale),
                           traced[k].change / scale, static_cast<float>(traced[k].paths), static_cast<std::int32_t>(i), 0, hit.is_ground, false};
        if (at_[i] < 0) {
            at_[i] = static_cast<std::int32_t>(samples_.size()), samples_.push_back(fresh);
            continue;
        }
        Sample& sample = samples_[static_cast<std::size_t>(at_[i])];
        if (at_rest && sample.is_reprojected) sample = fresh;
        else merge(sample, fresh);
    }
}

std::vector<Pixel> LightHistory::next(std::size_t count, std::uint32_t seed, bool at_rest, const SeenSurfaces& surfaces) const {
    struct Wanted {
        float priority;
        std::int32_t pixel;
    };
    std::vector<Wanted> wanted;
    const auto random = [&](std::int32_t pixel) { return 0.5f + static_cast<float>(hashed(seed, static_cast<std::uint32_t>(pixel)) >> 8) * 0x1p-25f; };
    const auto noise = [](const Sample& sample) {
        const float size = sample.on_ground ? sample.shadow + 0.3f : luminance(sample.light) + dark;
        return std::sqrt(sample.variance) / size;
    };
    constexpr float unknown = 1e6f;
    if (at_rest) {
        for (std::size_t i = 0; i < pixels(); ++i) {
            const auto pixel = static_cast<std::int32_t>(i);
            if (at_[i] >= 0) {
                const Sample& sample = samples_[static_cast<std::size_t>(at_[i])];
                wanted.push_back({sample.is_reprojected ? unknown / 2 * random(pixel) : noise(sample), pixel});
            } else if (const FirstHit hit(surfaces, pixels(), i); hit.is_surface || hit.is_ground) {
                wanted.push_back({unknown * random(pixel), pixel});
            }
        }
    } else {
        for (const Sample& sample : samples_) {
            wanted.push_back({(noise(sample) + 0.002f * static_cast<float>(sample.age)) * random(sample.pixel), sample.pixel});
        }
        // One pixel of each block with a surface and without a sample.
        for (int top = 0; top < height_; top += block) {
            for (int left = 0; left < width_; left += block) {
                std::int32_t best = -1;
                bool is_known = false;
                for (int y = top; y < std::min(top + block, height_) && !is_known; ++y) {
                    for (int x = left; x < std::min(left + block, width_) && !is_known; ++x) {
                        const std::int32_t i = y * width_ + x;
                        is_known = at_[static_cast<std::size_t>(i)] >= 0;
                        const auto shown = [&] {
                            const FirstHit hit(surfaces, pixels(), static_cast<std::size_t>(i));
                            return hit.is_surface || hit.is_ground;
                        };
                        if (!is_known && (best < 0 || random(i) > random(best)) && shown()) best = i;
                    }
                }
                if (!is_known && best >= 0) wanted.push_back({unknown * random(best), best});
            }
        }
    }
    count = std::min(count, wanted.size());
    std::nth_element(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(count), wanted.end(),
                     [](Wanted a, Wanted b) { return a.priority != b.priority ? a.priority > b.priority : a.pixel < b.pixel; });
    wanted.resize(count);
    std::ranges::sort(wanted, {}, &Wanted::pixel);
    std::vector<Pixel> chosen;
    for (const Wanted& one : wanted) chosen.push_back({one.pixel / width_, one.pixel % width_});
    return chosen;
}

void LightHistory::write(const SeenSurfaces& surfaces, float* planes) const {
    const Projection projection(camera_, height_, width_);
    parallel_for(samples_.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const Sample& sample = samples_[n];
            const auto i = static_cast<std::size_t>(sample.pixel);
            const FirstHit hit(surfaces, pixels(), i);
            const auto put = [&](Plane plane, float value) { planes[plane * pixels() + i] = value; };
            put(mask, 1), put(shadow, sample.shadow);
            if (!hit.is_surface) {
                put(variance, sample.variance);
                continue;
            }
            const Vec3 color = multiplied(sample.light, hit.albedo);
            const float scale = divisor(hit.albedo);
            put(gray, luminance(color)), put(depth, hit.depth), put(normal_x, hit.normal.x), put(normal_y, hit.normal.y);
            put(red, color.x), put(green, color.y), put(blue, color.z);
            put(variance, sample.variance * scale * scale);
        }
    });
}

}  // namespace bob
