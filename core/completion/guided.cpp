#include "completion/guided.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "base/color.h"
#include "base/parallel.h"
#include "completion/guided_kernels.h"
#include "completion/guided_surfaces.h"

namespace bob {
namespace {

/// Number of exact samples in a fit: with half of it, slopes are lost; with twice, light is blurred.
constexpr double samples_around = 16;

/// Further samples per unit of noise, times the cube root of (share of noise x density²): variance and bias then grow at the same rate.
/// Twice as many blur 5 % of the pixels; half as many leave noise at 100 %.
constexpr double samples_for_noise = 1000, most_samples = 600;

/// Offset of squared distances: in pixels² for exact samples, in shares of the squared reach for noisy ones, whose weights are then
/// nearly uniform. Samples are noisy from this variance on, relative to the squared light.
constexpr double sharp = 0.3, blunt = 0.5, noisy = 0.02;

/// A noisy sample is at most this much of the mean around it; a twentieth of all light is lost at 1.5, fireflies stay at 3.
constexpr double brighter = 2;
/// Maximum darkening of a sample, in its standard deviations: lamps are bright without noise.
constexpr double darkened = 3;
constexpr int clamp_rounds = 3;
constexpr double samples_to_clamp = 64;

/// Scatter around the fit is detail if it exceeds the noise by this factor, since noise has long tails.
constexpr float noise_explains = 5;

/// Minimum sum of the weights of samples on the same surface; below it, the reach doubles.
constexpr float least_weight = 1e-2f;
constexpr int widenings = 4;
/// Maximum number of samples at any reach.
constexpr int enough = 4096;

/// Spacing of fitted rows on planes, as a share of the reach. Rows between are interpolated, with an error of 1 % at a shadow's edge.
constexpr float reach_per_row = 8;

/// Size of the tiles that are fitted one at a time.
constexpr int fit_width = GuidedSurfaces::row_multiple, fit_height = 8;

/// Sums over rectangles of the picture.
class Table {
public:
    Table(int height, int width) : height_(height), width_(width), sums_(size(height + 1) * size(width + 1)) {}

    /// `of(i)` is the value of pixel i.
    template <class Of>
    void fill(Of of) {
        for (int y = 0; y < height_; ++y) {
            double row = 0;
            for (int x = 0; x < width_; ++x) {
                row += of(size(y) * size(width_) + size(x));
                sums_[place(y + 1, x + 1)] = sums_[place(y, x + 1)] + row;
            }
        }
    }
    /// The sum over the pixels up to `reach` rows and columns away.
    [[nodiscard]] double around(int y, int x, int reach) const {
        const int top = std::clamp(y - reach, 0, height_), bottom = std::clamp(y + reach + 1, 0, height_);
        const int left = std::clamp(x - reach, 0, width_), right = std::clamp(x + reach + 1, 0, width_);
        return sums_[place(bottom, right)] - sums_[place(top, right)] - sums_[place(bottom, left)] + sums_[place(top, left)];
    }

private:
    static std::size_t size(int n) { return static_cast<std::size_t>(n); }
    [[nodiscard]] std::size_t place(int y, int x) const { return size(y) * size(width_ + 1) + size(x); }

    int height_, width_;
    std::vector<double> sums_;
};

/// The pixels that are completed.
enum class Completed { all, surfaces, plane };

/// Traced samples in row order, of the pixels that are completed.
struct Traced {
    std::vector<GuidedSample> samples;
    std::vector<int> first;  // first sample of each row, and the end
    bool is_noisy = false;

    Traced(const Layout& known, const float* planes, const Channel& channel, const GuidedSurfaces& surfaces, Completed completed) {
        const int height = surfaces.height(), width = surfaces.width(), components = channel.components;
        const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        const auto plane = [&](int place) { return planes + static_cast<std::size_t>(place) * pixels; };
        const float *const mask = plane(known.place_of(channels::mask)), *const values = plane(known.place_of(channel));
        const float* const variance = known.place(channels::variance) < 0 ? nullptr : plane(known.place(channels::variance));
        for (int y = 0; y < height; ++y) {
            first.push_back(static_cast<int>(samples.size()));
            for (int x = 0; x < width; ++x) {
                const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                if (!(mask[i] > 0)) continue;
                const auto of = [&](GuidedSurfaces::Plane plane) { return surfaces.row(plane, y)[x]; };
                if (completed != Completed::all && !(of(GuidedSurfaces::coverage) > 0)) continue;
                GuidedSample sample{static_cast<float>(y), static_cast<float>(x), of(GuidedSurfaces::depth),
                                    {of(GuidedSurfaces::normal_x), of(GuidedSurfaces::normal_y), of(GuidedSurfaces::normal_z)},
                                    {of(GuidedSurfaces::red), of(GuidedSurfaces::green), of(GuidedSurfaces::blue)}, of(GuidedSurfaces::coverage), {}, 0, 0};
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
        }
        first.push_back(static_cast<int>(samples.size()));
    }

    [[nodiscard]] std::span<const GuidedSample> of_row(int y) const {
        const auto at = static_cast<std::size_t>(y);
        return {samples.data() + first[at], static_cast<std::size_t>(first[at + 1] - first[at])};
    }
};

/// Reach and offset of distances at the corners of tiles, linearly interpolated between them.
class Reaches {
public:
    struct Reach {
        float reach, sharpness;
    };

    Reaches(const GuidedSurfaces& surfaces, Traced& traced)
        : height_(surfaces.height()), width_(surfaces.width()), counts_(height_, width_),
          across_(static_cast<std::size_t>((width_ + fit_width - 1) / fit_width + 1)),
          corners_(across_ * static_cast<std::size_t>((height_ + fit_height - 1) / fit_height + 1)) {
        std::vector<float> plane(static_cast<std::size_t>(height_) * static_cast<std::size_t>(width_));
        const auto fill = [&](Table& table, auto of) {
            std::fill(plane.begin(), plane.end(), 0.f);
            for (const GuidedSample& sample : traced.samples) plane[index(sample)] = of(sample);
            table.fill([&](std::size_t i) { return plane[i]; });
        };
        fill(counts_, [](const GuidedSample&) { return 1.f; });
        for_corners([&](int y, int x, Reach& corner) { corner = {reach(y, x, samples_around), static_cast<float>(sharp)}; });
        if (!traced.is_noisy) return;

        Table shades(height_, width_), variances(height_, width_);
        std::vector<float> raw;
        for (const GuidedSample& sample : traced.samples) raw.push_back(sample.shade);
        std::vector<int> around(corners_.size());
        for_corners([&](int y, int x, Reach& corner) {
            around[static_cast<std::size_t>(&corner - corners_.data())] = static_cast<int>(reach(y, x, samples_to_clamp));
        });
        for (int round = 0; round < clamp_rounds; ++round) {
            fill(shades, [](const GuidedSample& sample) { return sample.shade; });
            for (std::size_t n = 0; n < raw.size(); ++n) {
                GuidedSample& sample = traced.samples[n];
                const int y = static_cast<int>(sample.row), x = static_cast<int>(sample.column);
                const int k = around[place((y + fit_height / 2) / fit_height, (x + fit_width / 2) / fit_width)];
                const double most = brighter * shades.around(y, x, k) / counts_.around(y, x, k);
                const double least = raw[n] - darkened * std::sqrt(sample.variance);
                sample.shade = static_cast<float>(std::min<double>(raw[n], std::max(most, least)));
            }
        }
        for (std::size_t n = 0; n < raw.size(); ++n) {
            GuidedSample& sample = traced.samples[n];
            const float scale = raw[n] > 0 ? sample.shade / raw[n] : 1;
            for (float& light : sample.light) light *= scale;
            sample.variance *= scale * scale;
        }
        fill(shades, [](const GuidedSample& sample) { return sample.shade; });
        fill(variances, [](const GuidedSample& sample) { return sample.variance; });
        for_corners([&](int y, int x, Reach& corner) {
            const int k = around[static_cast<std::size_t>(&corner - corners_.data())];
            const double count = std::max(1., counts_.around(y, x, k)), shade = shades.around(y, x, k) / count;
            const double noise = variances.around(y, x, k) / count / (shade * shade + 1e-12), side = 2 * k + 1;
            const double density = count / (side * side);
            const double wanted = samples_around + samples_for_noise * std::cbrt(noise * density * density);
            corner.reach = reach(y, x, std::min(most_samples, wanted));
            corner.sharpness += static_cast<float>(blunt * std::min(1., noise / noisy)) * corner.reach * corner.reach;
        });
    }

    /// At a corner of tiles.
    [[nodiscard]] Reach operator()(int down, int across) const { return corners_[place(down, across)]; }

private:
    [[nodiscard]] std::size_t place(int down, int across) const {
        return static_cast<std::size_t>(down) * across_ + static_cast<std::size_t>(across);
    }
    [[nodiscard]] std::size_t index(const GuidedSample& sample) const {
        return static_cast<std::size_t>(sample.row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(sample.column);
    }

    template <class Body>
    void for_corners(Body body) {
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            body(static_cast<int>(i / across_) * fit_height, static_cast<int>(i % across_) * fit_width, corners_[i]);
        }
    }

    /// The smallest reach with this number of samples, in rows and columns; at most the whole picture.
    [[nodiscard]] float reach(int y, int x, double samples) const {
        float low = narrowest, high = static_cast<float>(height_ + width_);
        if (counts_.around(y, x, static_cast<int>(low)) >= samples) return low;
        while (high - low > 0.5f) {
            const float middle = 0.5f * (low + high);
            (counts_.around(y, x, static_cast<int>(middle)) >= samples ? high : low) = middle;
        }
        return high;
    }

    static constexpr float narrowest = 2.5f;

    int height_, width_;
    Table counts_;
    std::size_t across_;
    std::vector<Reach> corners_;
};

/// Output of the kernels for the pixels of a tile.
struct Fitted {
    static constexpr std::size_t size = fit_width * fit_height;
    std::array<float, size> light[3], weight{}, detail{}, noise{};
};

/// Whether a tile shows one plane, so that the fit varies smoothly from row to row.
bool is_plane(const GuidedSurfaces& surfaces, int top, int bottom, int left, int right) {
    const auto at = [&](GuidedSurfaces::Plane plane, int y, int x) { return surfaces.row(plane, y)[x]; };
    const int y0 = (top + bottom) / 2, x0 = (left + right) / 2;
    const float down = at(GuidedSurfaces::depth_down, y0, x0), along = at(GuidedSurfaces::depth_right, y0, x0);
    const float most = depth_tolerance(guided_likeness, std::abs(along), std::abs(down));
    constexpr GuidedSurfaces::Plane same[] = {GuidedSurfaces::coverage, GuidedSurfaces::normal_x, GuidedSurfaces::normal_y,
                                              GuidedSurfaces::red, GuidedSurfaces::green, GuidedSurfaces::blue};
    for (int y = top; y < bottom; ++y) {
        for (const GuidedSurfaces::Plane plane : same) {
            const float* const row = surfaces.row(plane, y);
            const float value = at(plane, y0, x0);
            for (int x = left; x < right; ++x) {
                if (std::abs(row[x] - value) > 1e-3f) return false;
            }
        }
        const float* const depth = surfaces.row(GuidedSurfaces::depth, y);
        const float middle = at(GuidedSurfaces::depth, y0, x0) + down * static_cast<float>(y - y0);
        for (int x = left; x < right; ++x) {
            if (std::abs(depth[x] - middle - along * static_cast<float>(x - x0)) > most) return false;
        }
    }
    return true;
}

/// Fits one tile, with a larger reach where no sample is on the same surface.
void fit_tile(const GuidedSurfaces& surfaces, const Traced& traced, const Reaches& reaches, int components, int down, int across, Completed completed, Fitted& fitted) {
    const auto& kernels = best_guided_kernels();
    const auto fit = completed == Completed::plane ? kernels.fit_plane : components == 3 ? kernels.fit_color : kernels.fit_gray;
    const int top = down * fit_height, left = across * fit_width, bottom = std::min(top + fit_height, surfaces.height());
    const Reaches::Reach corners[] = {reaches(down, across), reaches(down, across + 1), reaches(down + 1, across),
                                      reaches(down + 1, across + 1)};
    float widest = 0, narrowest = corners[0].reach;
    for (const auto& corner : corners) widest = std::max(widest, corner.reach), narrowest = std::min(narrowest, corner.reach);
    std::array<bool, Fitted::size> is_wanted;
    std::array<bool, fit_height> is_done{};
    bool is_any = false;
    for (int y = top; y < bottom; ++y) {
        const float* const coverage = surfaces.row(GuidedSurfaces::coverage, y) + left;
        const auto first = is_wanted.begin() + (y - top) * fit_width;
        for (int x = 0; x < fit_width; ++x) first[x] = left + x < surfaces.width() && (completed == Completed::all || coverage[x] > 0);
        is_any = is_any || !(is_done[static_cast<std::size_t>(y - top)] = std::find(first, first + fit_width, true) == first + fit_width);
    }
    if (!is_any) return;
    int row_step = std::clamp(static_cast<int>(narrowest / reach_per_row), 1, fit_height - 1);
    const auto is_flat = [&] { return completed == Completed::plane || is_plane(surfaces, top, bottom, left, std::min(left + fit_width, surfaces.width())); };
    if (row_step > 1 && !is_flat()) row_step = 1;
    const auto is_fitted = [=](int y) { return (y - top) % row_step == 0 || y == bottom - 1; };
    for (int y = top; y < bottom; ++y) is_done[static_cast<std::size_t>(y - top)] |= !is_fitted(y);
    for (int widening = 0; widening < widenings; ++widening) {
        const float scale = static_cast<float>(1 << widening);
        const int reach = static_cast<int>(widest * scale) + 1;
        std::vector<GuidedRange> ranges;
        int found = 0;
        for (int y = std::max(0, top - reach); y < std::min(surfaces.height(), top + fit_height + reach); ++y) {
            const auto row = traced.of_row(y);
            const auto before = [](const GuidedSample& sample, int column) { return sample.column < static_cast<float>(column); };
            const auto begin = std::lower_bound(row.begin(), row.end(), left - reach, before);
            const auto end = std::lower_bound(begin, row.end(), left + fit_width + reach, before);
            const int from = traced.first[static_cast<std::size_t>(y)] + static_cast<int>(begin - row.begin());
            const int count = static_cast<int>(end - begin);
            if (count > 0) ranges.push_back({from, from + count, static_cast<float>(y)}), found += count;
        }
        const int step = 1 + found / enough;
        bool is_last = true;
        for (int y = top; y < bottom; ++y) {
            const auto in_tile = static_cast<std::size_t>(y - top);
            if (is_done[in_tile]) continue;
            const float t = static_cast<float>(y - top) / fit_height;
            const auto blend = [&](auto of) { return std::array{of(corners[0]) + t * (of(corners[2]) - of(corners[0])), of(corners[1]) + t * (of(corners[3]) - of(corners[1]))}; };
            const auto far = blend([&](const Reaches::Reach& corner) { return scale * corner.reach; });
            const auto sharpness = blend([](const Reaches::Reach& corner) { return corner.sharpness; });
            Fitted fresh;
            const auto row = [&](GuidedSurfaces::Plane plane) { return surfaces.row(plane, y) + left; };
            const GuidedRow wanted{static_cast<float>(y), static_cast<float>(left), row(GuidedSurfaces::depth), row(GuidedSurfaces::depth_right),
                                   row(GuidedSurfaces::depth_down), {row(GuidedSurfaces::normal_x), row(GuidedSurfaces::normal_y), row(GuidedSurfaces::normal_z)},
                                   {row(GuidedSurfaces::red), row(GuidedSurfaces::green), row(GuidedSurfaces::blue)}, row(GuidedSurfaces::coverage),
                                   far[0], (far[1] - far[0]) / fit_width, sharpness[0], (sharpness[1] - sharpness[0]) / fit_width,
                                   {fresh.light[0].data(), fresh.light[1].data(), fresh.light[2].data()}, fresh.weight.data(),
                                   fresh.detail.data(), fresh.noise.data()};
            fit(traced.samples.data(), ranges.data(), ranges.size(), step, guided_likeness, wanted, fit_width, traced.is_noisy);
            bool is_whole = true;
            for (std::size_t x = 0; x < fit_width; ++x) {
                const std::size_t i = in_tile * fit_width + x;
                if (widening > 0 && fitted.weight[i] >= least_weight) continue;
                for (int c = 0; c < components; ++c) fitted.light[c][i] = fresh.light[c][x];
                fitted.weight[i] = fresh.weight[x], fitted.detail[i] = fresh.detail[x], fitted.noise[i] = fresh.noise[x];
                is_whole = is_whole && (fresh.weight[x] >= least_weight || !is_wanted[i]);
            }
            is_done[in_tile] = is_whole;
            is_last = is_last && is_whole;
        }
        if (is_last) break;
    }
    for (int y = top, before = top; y < bottom; ++y) {
        if (is_fitted(y)) before = y;
        if (is_fitted(y)) continue;
        const int after = std::min(before + row_step, bottom - 1);
        const float share = static_cast<float>(y - before) / static_cast<float>(after - before);
        const auto place = [=](int row) { return static_cast<std::size_t>((row - top) * fit_width); };
        const auto interpolate = [&](std::array<float, Fitted::size>& values) {
            for (std::size_t x = 0; x < fit_width; ++x) {
                const float from = values[place(before) + x], to = values[place(after) + x];
                values[place(y) + x] = from + share * (to - from);
            }
        };
        for (int c = 0; c < components; ++c) interpolate(fitted.light[c]);
        interpolate(fitted.detail), interpolate(fitted.noise);
    }
}

void complete(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const Channel& channel,
              int height, int width, Completed completed, float* output, float* noise) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const GuidedSurfaces surfaces(guides_layout, guides, height, width);
    Traced traced(known, planes, channel, surfaces, completed);
    const int components = channel.components;
    if (noise) std::fill_n(noise, pixels, 0.f);
    if (traced.samples.empty()) {
        std::fill_n(output, pixels * static_cast<std::size_t>(components), 0.f);
        return;
    }
    const Reaches reaches(surfaces, traced);
    const float* const values = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    const int tiles_across = (width + fit_width - 1) / fit_width, tiles_down = (height + fit_height - 1) / fit_height;
    parallel_for(static_cast<std::size_t>(tiles_across) * static_cast<std::size_t>(tiles_down), 8, [&](std::size_t begin, std::size_t end) {
        Fitted fitted;
        for (std::size_t tile = begin; tile < end; ++tile) {
            const int down = static_cast<int>(tile) / tiles_across, across = static_cast<int>(tile) % tiles_across;
            fit_tile(surfaces, traced, reaches, components, down, across, completed, fitted);
            const int left = across * fit_width;
            for (int y = down * fit_height; y < std::min((down + 1) * fit_height, height); ++y) {
                const auto row = traced.of_row(y);
                auto own = std::lower_bound(row.begin(), row.end(), left, [](const GuidedSample& s, int x) { return s.column < static_cast<float>(x); });
                for (int x = left; x < std::min(left + fit_width, width); ++x) {
                    const auto in_tile = static_cast<std::size_t>((y - down * fit_height) * fit_width + x - left);
                    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                    const bool is_traced = own != row.end() && own->column == static_cast<float>(x);
                    const bool is_empty = completed != Completed::all && !(surfaces.row(GuidedSurfaces::coverage, y)[x] > 0);
                    for (int c = 0; c < components; ++c) {
                        float& to = output[static_cast<std::size_t>(c) * pixels + i];
                        if (is_empty) {
                            to = 0;
                            continue;
                        }
                        if (is_traced && own->variance == 0) {
                            to = values[static_cast<std::size_t>(c) * pixels + i];
                            continue;
                        }
                        float light = fitted.light[c][in_tile];
                        const float divisor = surfaces.divisor(components, c, y, x);
                        if (is_traced) {
                            const float around = fitted.noise[in_tile], detail = std::max(0.f, fitted.detail[in_tile] - noise_explains * around);
                            const float weight = detail / (detail + std::max(around, own->variance));
                            light += weight * (own->light[c] - light);
                            if (noise) noise[i] = std::max(noise[i], weight * std::sqrt(own->variance) * divisor);
                        }
                        to = std::max(0.f, light * divisor);
                    }
                    if (is_traced) ++own;
                }
            }
        }
    });
}

}  // namespace

void complete_guided(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const Channel& channel,
                     int height, int width, bool covered_only, float* output, float* noise) {
    complete(known, planes, guides_layout, guides, channel, height, width, covered_only ? Completed::surfaces : Completed::all, output, noise);
}

void complete_alpha(const Layout& known, const float* planes, const float* coverage, const float* ground, int height, int width, float* alpha,
                    float* noise) {
    static const Layout guides_layout{channels::mask, channels::depth, channels::normal, channels::albedo};
    static const Layout shadows_layout{channels::mask, channels::gray, channels::variance};
    const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    if (std::any_of(ground, ground + size, [](float share) { return share > 0; })) {
        std::vector<float> shadows(3 * size);  // in gray's place
        std::size_t k = 0;
        for (const Channel& channel : {channels::mask, channels::shadow, channels::variance}) {
            std::copy_n(planes + static_cast<std::size_t>(known.place_of(channel)) * size, size, shadows.data() + k++ * size);
        }
        std::vector<float> guides(7 * size);  // the ground is flat, and white
        std::copy_n(ground, 2 * size, guides.data());
        for (std::size_t c = 4; c < 7; ++c) std::copy_n(ground, size, guides.data() + c * size);
        complete(shadows_layout, shadows.data(), guides_layout, guides.data(), channels::gray, height, width, Completed::plane, alpha, noise);
    } else {
        std::fill_n(alpha, size, 0.f);
        if (noise) std::fill_n(noise, size, 0.f);
    }
    for (std::size_t i = 0; i < size; ++i) alpha[i] = std::min(coverage[i] + alpha[i], 1.f);
}

void complete_light(const Layout& known, const float* planes, const Layout& guides_layout, const float* guides, const float* ground,
                    int height, int width, float* color, float* alpha, float* noise) {
    const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const float* const coverage = guides + static_cast<std::size_t>(guides_layout.place_of(channels::mask)) * size;
    std::vector<float> in_shadow(noise ? size : 0);
    complete_guided(known, planes, guides_layout, guides, channels::color, height, width, true, color, noise);
    if (ground) complete_alpha(known, planes, coverage, ground, height, width, alpha, noise ? in_shadow.data() : nullptr);
    else std::copy_n(coverage, size, alpha);
    if (!noise) return;
    const auto shown = [](float light) { return to_srgb(std::clamp(light, 0.f, 1.f)); };
    for (std::size_t i = 0; i < size; ++i) {
        const float brightest = std::max({color[i], color[size + i], color[2 * size + i]});
        noise[i] = (shown(brightest + noise[i]) - shown(brightest - noise[i])) / 2 + in_shadow[i];
    }
}

}  // namespace bob
