#include "completion/guided_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/color.h"
#include "base/parallel.h"

namespace bob {
namespace {

/// Number of exact samples in a fit: with half of it, slopes are lost; with twice, light is blurred.
constexpr double samples_around = 18;

/// Further samples per unit of noise, times the cube root of (share of noise x density²): variance and bias then grow at the same rate.
/// Twice as many blur 5 % of the pixels; half as many leave noise at 100 %.
constexpr double samples_for_noise = 1100, most_samples = 600;

/// Offset of squared distances: in pixels² for exact samples, in shares of the squared reach for noisy ones, whose weights are then
/// nearly uniform. Samples are noisy from this variance on, relative to the squared light.
constexpr float sharp = 0.3f;
constexpr double blunt = 0.5, noisy = 0.02;

/// A noisy sample is at most this much of the mean around it; a twentieth of all light is lost at 1.5, fireflies stay at 3.
constexpr double brighter = 2;
/// Maximum darkening of a sample, in its standard deviations: lamps are bright without noise.
constexpr double darkened = 3;
constexpr int clamp_rounds = 3;
constexpr double samples_to_clamp = 64;

constexpr float min_reach = 2.5f;

/// Sums of samples' values over rectangles of the picture, spread evenly over bins of several pixels.
class Table {
public:
    Table(int height, int width)
        : down_((height + bin - 1) / bin), across_((width + bin - 1) / bin), sums_(size(down_ + 1) * size(across_ + 1)) {}

    /// `of(sample)` is the value of a sample.
    template <class Of>
    void fill(const GuidedSamples& traced, Of of) {
        std::fill(sums_.begin(), sums_.end(), 0.);
        for (const GuidedSample& sample : traced.samples) {
            sums_[place(static_cast<int>(sample.row) / bin + 1, static_cast<int>(sample.column) / bin + 1)] += of(sample);
        }
        for (int y = 1; y <= down_; ++y) {
            double* const above = sums_.data() + place(y - 1, 0);
            double* const here = sums_.data() + place(y, 0);
            double row = 0;
            for (int x = 1; x <= across_; ++x) row += here[x], here[x] = above[x] + row;
        }
    }
    /// The sum over the pixels up to `reach` rows and columns away.
    [[nodiscard]] double around(int y, int x, float reach) const {
        const auto [top, bottom] = ends(y, reach, down_);
        const auto [left, right] = ends(x, reach, across_);
        return before(bottom, right) - before(top, right) - before(bottom, left) + before(top, left);
    }

private:
    static constexpr int bin = 2;

    static std::size_t size(int n) { return static_cast<std::size_t>(n); }
    [[nodiscard]] std::size_t place(int y, int x) const { return size(y) * size(across_ + 1) + size(x); }

    /// A bin, and a share of it.
    struct End {
        int bin;
        float share;
    };
    static std::pair<End, End> ends(int middle, float reach, int bins) {
        const auto end = [&](float pixel) {
            const float at = std::clamp(pixel / bin, 0.f, static_cast<float>(bins));
            const int whole = std::min(static_cast<int>(at), bins - 1);
            return End{whole, at - static_cast<float>(whole)};
        };
        return {end(static_cast<float>(middle) - reach), end(static_cast<float>(middle + 1) + reach)};
    }
    [[nodiscard]] double before(End y, End x) const {
        const double* const above = sums_.data() + place(y.bin, x.bin);
        const double* const below = above + across_ + 1;
        const double upper = above[0] + x.share * (above[1] - above[0]), lower = below[0] + x.share * (below[1] - below[0]);
        return upper + y.share * (lower - upper);
    }

    int down_, across_;
    std::vector<double> sums_;
};

/// Calls `body` for each corner of tiles, on all threads, with its pixel and its number.
template <class Body>
void for_corners(std::size_t count, std::size_t across, Body body) {
    parallel_for(count, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            body(static_cast<int>(i / across) * guided_tiles::height, static_cast<int>(i % across) * guided_tiles::width, i);
        }
    });
}

/// Darkens samples that are much brighter than those around them. around: how far, by the sample's row and column.
template <class Around>
void darken(GuidedSamples& traced, const Table& counts, Table& shades, Around around) {
    std::vector<float> raw;
    for (const GuidedSample& sample : traced.samples) raw.push_back(sample.shade);
    for (int round = 0; round < clamp_rounds; ++round) {
        shades.fill(traced, [](const GuidedSample& sample) { return sample.shade; });
        parallel_for(raw.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                GuidedSample& sample = traced.samples[n];
                const int y = static_cast<int>(sample.row), x = static_cast<int>(sample.column);
                const float k = around(y, x);
                const double most = brighter * shades.around(y, x, k) / counts.around(y, x, k);
                const double least = raw[n] - darkened * std::sqrt(sample.variance);
                sample.shade = static_cast<float>(std::min<double>(raw[n], std::max(most, least)));
            }
        });
    }
    for (std::size_t n = 0; n < raw.size(); ++n) {
        GuidedSample& sample = traced.samples[n];
        const float scale = raw[n] > 0 ? sample.shade / raw[n] : 1;
        for (float& light : sample.light) light *= scale;
        sample.variance *= scale * scale;
    }
}

}  // namespace

GuidedSamples::GuidedSamples(const Layout& known, const float* planes, const Channel& channel, const GuidedSurfaces& surfaces, GuidedExtent extent)
    : stride_(guided_tiles::across(surfaces.width()) + 1) {
    const int height = surfaces.height(), width = surfaces.width(), components = channel.components;
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const auto plane = [&](int place) { return planes + static_cast<std::size_t>(place) * pixels; };
    const float *const mask = plane(known.place_of(channels::mask)), *const values = plane(known.place_of(channel));
    const float* const variance = known.place(channels::variance) < 0 ? nullptr : plane(known.place(channels::variance));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            if (x % guided_tiles::width == 0) first_.push_back(static_cast<int>(samples.size()));
            const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
            if (!(mask[i] > 0)) continue;
            const auto of = [&](GuidedSurfaces::Plane plane) { return surfaces.row(plane, y)[x]; };
            if (extent != GuidedExtent::all && !(of(GuidedSurfaces::coverage) > 0)) continue;
            GuidedSample sample{};
            sample.row = static_cast<float>(y), sample.column = static_cast<float>(x);
            if (extent != GuidedExtent::plane) {
                sample.depth = of(GuidedSurfaces::depth), sample.coverage = of(GuidedSurfaces::coverage);
                for (int k = 0; k < 3; ++k) {
                    sample.normal[k] = surfaces.row(GuidedSurfaces::normal_x + k, y)[x];
                    sample.albedo[k] = surfaces.row(GuidedSurfaces::red + k, y)[x];
                }
            }
            for (int c = 0; c < components; ++c) {
                sample.light[c] = values[static_cast<std::size_t>(c) * pixels + i] / surfaces.divisor(components, c, y, x);
            }
            sample.shade = components == 3 ? luminance({sample.light[0], sample.light[1], sample.light[2]}) : sample.light[0];
            if (variance && variance[i] > 0) {
                const float divisor = surfaces.divisor(1, 0, y, x);
                sample.variance = variance[i] / (divisor * divisor), is_noisy = true;
            }
            samples.push_back(sample);
        }
        first_.push_back(static_cast<int>(samples.size()));
    }
}

GuidedRange GuidedSamples::within(int y, int left, int right) const {
    const int tiles = stride_ - 1;
    int begin = first(y, std::clamp(left / guided_tiles::width, 0, tiles)), end = first(y, std::clamp(guided_tiles::across(right), 0, tiles));
    const auto column = [&](int n) { return samples[static_cast<std::size_t>(n)].column; };
    while (begin < end && column(begin) < static_cast<float>(left)) ++begin;
    while (begin < end && column(end - 1) >= static_cast<float>(right)) --end;
    return {begin, end, static_cast<float>(y)};
}

GuidedReaches::GuidedReaches(const GuidedSurfaces& surfaces, GuidedSamples& traced)
    : across_(static_cast<std::size_t>(guided_tiles::across(surfaces.width()) + 1)),
      corners_(across_ * static_cast<std::size_t>(guided_tiles::down(surfaces.height()) + 1)) {
    const int height = surfaces.height(), width = surfaces.width();
    Table counts(height, width);
    counts.fill(traced, [](const GuidedSample&) { return 1.f; });
    // The smallest reach with this number of samples, in rows and columns; at most the whole picture.
    const auto reach = [&](int y, int x, double samples) {
        float low = min_reach, high = static_cast<float>(height + width);
        if (counts.around(y, x, low) >= samples) return low;
        while (high - low > 0.5f) {
            const float middle = 0.5f * (low + high);
            (counts.around(y, x, middle) >= samples ? high : low) = middle;
        }
        return high;
    };
    if (!traced.is_noisy) {
        for_corners(corners_.size(), across_, [&](int y, int x, std::size_t corner) { corners_[corner] = {reach(y, x, samples_around), sharp}; });
        return;
    }

    std::vector<float> around(corners_.size());
    for_corners(corners_.size(), across_, [&](int y, int x, std::size_t corner) { around[corner] = reach(y, x, samples_to_clamp); });
    Table shades(height, width), variances(height, width);
    darken(traced, counts, shades, [&](int y, int x) {
        return around[place((y + guided_tiles::height / 2) / guided_tiles::height, (x + guided_tiles::width / 2) / guided_tiles::width)];
    });
    shades.fill(traced, [](const GuidedSample& sample) { return sample.shade; });
    variances.fill(traced, [](const GuidedSample& sample) { return sample.variance; });
    for_corners(corners_.size(), across_, [&](int y, int x, std::size_t corner) {
        const float k = around[corner];
        const double count = std::max(1., counts.around(y, x, k)), shade = shades.around(y, x, k) / count;
        const double noise = variances.around(y, x, k) / count / (shade * shade + 1e-12), side = 2 * k + 1;
        const double density = count / (side * side);
        const double wanted = samples_around + samples_for_noise * std::cbrt(noise * density * density);
        const float wide = reach(y, x, std::min(most_samples, wanted));
        corners_[corner] = {wide, sharp + static_cast<float>(blunt * std::min(1., noise / noisy)) * wide * wide};
    });
}

GuidedReaches::Reach GuidedReaches::at(int y, int x) const {
    const auto blend = [](const Reach& from, const Reach& to, float share) {
        return Reach{from.reach + share * (to.reach - from.reach), from.sharpness + share * (to.sharpness - from.sharpness)};
    };
    const std::size_t above = place(y / guided_tiles::height, x / guided_tiles::width), below = above + across_;
    const float down = static_cast<float>(y % guided_tiles::height) / guided_tiles::height;
    const float right = static_cast<float>(x % guided_tiles::width) / guided_tiles::width;
    return blend(blend(corners_[above], corners_[below], down), blend(corners_[above + 1], corners_[below + 1], down), right);
}

GuidedReaches::Reach GuidedReaches::extremes(int top, int left, int height, int width) const {
    Reach result{0, std::numeric_limits<float>::max()};
    for (int down = top / guided_tiles::height; down <= guided_tiles::down(top + height); ++down) {
        for (int across = left / guided_tiles::width; across <= guided_tiles::across(left + width); ++across) {
            const auto [reach, sharpness] = corners_[place(down, across)];
            result = {std::max(result.reach, reach), std::min(result.sharpness, sharpness)};
        }
    }
    return result;
}

}  // namespace bob
