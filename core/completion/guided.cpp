#include "completion/guided.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
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
constexpr float noise_explains = 2;

/// Minimum sum of the weights of samples on the same surface; below it, the reach doubles.
constexpr float least_weight = 1e-2f;
constexpr int widenings = 4;
/// Maximum number of samples at any reach.
constexpr int enough = 4096;

/// Spacing of fitted rows on planes, as a share of the reach. Rows between are interpolated, with an error of 1 % at a shadow's edge.
constexpr float reach_per_row = 8;
/// Spacing of fitted places on the ground, as a share of the distance whose square is the offset: the fit varies over that distance. Shadows
/// of two scenes, 8 to 100 % of the pixels: at .35, the mean error grows by 0.5 to 1.5 %; at .5, by 2 to 3.5 %, in 5 to 20 % less time.
constexpr float place_spacing = 0.35f;

/// Size of the tiles that are fitted one at a time.
constexpr int fit_width = GuidedSurfaces::row_multiple, fit_height = 8;
constexpr int tiles_across(int width) { return (width + fit_width - 1) / fit_width; }
constexpr int tiles_down(int height) { return (height + fit_height - 1) / fit_height; }

/// The pixels that are completed.
enum class Completed { all, surfaces, plane };

/// Traced samples in row order, of the pixels that are completed.
class Traced {
public:
    std::vector<GuidedSample> samples;
    bool is_noisy = false;

    Traced(const Layout& known, const float* planes, const Channel& channel, const GuidedSurfaces& surfaces, Completed completed)
        : stride_(tiles_across(surfaces.width()) + 1) {
        const int height = surfaces.height(), width = surfaces.width(), components = channel.components;
        const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        const auto plane = [&](int place) { return planes + static_cast<std::size_t>(place) * pixels; };
        const float *const mask = plane(known.place_of(channels::mask)), *const values = plane(known.place_of(channel));
        const float* const variance = known.place(channels::variance) < 0 ? nullptr : plane(known.place(channels::variance));
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                if (x % fit_width == 0) first_.push_back(static_cast<int>(samples.size()));
                const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                if (!(mask[i] > 0)) continue;
                const auto of = [&](GuidedSurfaces::Plane plane) { return surfaces.row(plane, y)[x]; };
                if (completed != Completed::all && !(of(GuidedSurfaces::coverage) > 0)) continue;
                GuidedSample sample{};
                sample.row = static_cast<float>(y), sample.column = static_cast<float>(x);
                if (completed != Completed::plane) {
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

    /// The samples of a row that are in a column of tiles.
    [[nodiscard]] std::span<const GuidedSample> in_tile(int y, int across) const { return between(first(y, across), first(y, across + 1)); }
    [[nodiscard]] std::span<const GuidedSample> of_row(int y) const { return between(first(y, 0), first(y, stride_ - 1)); }

    /// The samples of a row that are in columns from `left` to before `right`.
    [[nodiscard]] GuidedRange within(int y, int left, int right) const {
        const int tiles = stride_ - 1;
        int begin = first(y, std::clamp(left / fit_width, 0, tiles)), end = first(y, std::clamp(tiles_across(right), 0, tiles));
        const auto column = [&](int n) { return samples[static_cast<std::size_t>(n)].column; };
        while (begin < end && column(begin) < static_cast<float>(left)) ++begin;
        while (begin < end && column(end - 1) >= static_cast<float>(right)) --end;
        return {begin, end, static_cast<float>(y)};
    }

private:
    [[nodiscard]] int first(int y, int across) const { return first_[static_cast<std::size_t>(y * stride_ + across)]; }
    [[nodiscard]] std::span<const GuidedSample> between(int begin, int end) const {
        return {samples.data() + begin, static_cast<std::size_t>(end - begin)};
    }

    int stride_;
    std::vector<int> first_;  // first sample of each row from each column of tiles on, and the row's end
};

/// Sums of samples' values over rectangles of the picture.
class Table {
public:
    Table(int height, int width) : height_(height), width_(width), sums_(size(height + 1) * size(width + 1)) {}

    /// `of(sample)` is the value of a sample.
    template <class Of>
    void fill(const Traced& traced, Of of) {
        for (int y = 0; y < height_; ++y) {
            const double* const above = sums_.data() + place(y, 1);
            double* const here = sums_.data() + place(y + 1, 1);
            double row = 0;
            int x = 0;
            for (const GuidedSample& sample : traced.of_row(y)) {
                for (const int end = static_cast<int>(sample.column); x < end; ++x) here[x] = above[x] + row;
                row += of(sample);
            }
            for (; x < width_; ++x) here[x] = above[x] + row;
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

/// Reach and offset of distances at the corners of tiles, linearly interpolated between them.
class Reaches {
public:
    struct Reach {
        float reach, sharpness;
    };

    Reaches(const GuidedSurfaces& surfaces, Traced& traced)
        : height_(surfaces.height()), width_(surfaces.width()), counts_(height_, width_),
          across_(static_cast<std::size_t>(tiles_across(width_) + 1)), corners_(across_ * static_cast<std::size_t>(tiles_down(height_) + 1)) {
        counts_.fill(traced, [](const GuidedSample&) { return 1.f; });
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
            shades.fill(traced, [](const GuidedSample& sample) { return sample.shade; });
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
        shades.fill(traced, [](const GuidedSample& sample) { return sample.shade; });
        variances.fill(traced, [](const GuidedSample& sample) { return sample.variance; });
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

    /// At the left and the right of a tile, this share of its height down.
    [[nodiscard]] std::pair<Reach, Reach> across(int down, int across, float share) const {
        const auto blend = [&](std::size_t above) {
            const Reach &from = corners_[above], &to = corners_[above + across_];
            return Reach{from.reach + share * (to.reach - from.reach), from.sharpness + share * (to.sharpness - from.sharpness)};
        };
        const std::size_t corner = place(down, across);
        return {blend(corner), blend(corner + 1)};
    }

    /// Extremes in a tile.
    [[nodiscard]] float widest(int down, int across) const { return of_corners(down, across, &Reach::reach).second; }
    [[nodiscard]] float narrowest(int down, int across) const { return of_corners(down, across, &Reach::reach).first; }
    [[nodiscard]] float sharpest(int down, int across) const { return of_corners(down, across, &Reach::sharpness).first; }

private:
    [[nodiscard]] std::size_t place(int down, int across) const {
        return static_cast<std::size_t>(down) * across_ + static_cast<std::size_t>(across);
    }

    [[nodiscard]] std::pair<float, float> of_corners(int down, int across, float Reach::*of) const {
        const std::size_t i = place(down, across), below = i + across_;
        return std::minmax({corners_[i].*of, corners_[i + 1].*of, corners_[below].*of, corners_[below + 1].*of});
    }

    template <class Body>
    void for_corners(Body body) {
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            body(static_cast<int>(i / across_) * fit_height, static_cast<int>(i % across_) * fit_width, corners_[i]);
        }
    }

    /// The smallest reach with this number of samples, in rows and columns; at most the whole picture.
    [[nodiscard]] float reach(int y, int x, double samples) const {
        float low = least, high = static_cast<float>(height_ + width_);
        if (counts_.around(y, x, static_cast<int>(low)) >= samples) return low;
        while (high - low > 0.5f) {
            const float middle = 0.5f * (low + high);
            (counts_.around(y, x, static_cast<int>(middle)) >= samples ? high : low) = middle;
        }
        return high;
    }

    static constexpr float least = 2.5f;

    int height_, width_;
    Table counts_;
    std::size_t across_;
    std::vector<Reach> corners_;
};

/// The fit at the pixels of a tile, or at places between which it is interpolated.
struct Fitted {
    static constexpr std::size_t size = fit_width * fit_height;
    std::array<float, size> light[3]{}, weight{}, detail{}, noise{};
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

/// Fits the light at pixels to the samples around them.
class Fit {
public:
    Fit(const GuidedSurfaces& surfaces, const Traced& traced, const Reaches& reaches, int components, Completed completed)
        : surfaces_(surfaces), traced_(traced), reaches_(reaches), components_(components), completed_(completed) {}

    /// Fits a tile; pixels that are not completed keep any value.
    void tile(int down, int across, Fitted& fitted) {
        const Tile tile{down, across, down * fit_height, std::min((down + 1) * fit_height, surfaces_.height()), across * fit_width,
                        std::min((across + 1) * fit_width, surfaces_.width())};
        if (completed_ == Completed::plane) {
            if (is_any_wanted(tile.top, tile.bottom, tile)) on_plane(tile, fitted);
        } else {
            on_surfaces(tile, fitted);
        }
    }

private:
    using Kernel = decltype(GuidedKernels::fit_gray);

    struct Tile {
        int down, across, top, bottom, left, right;
    };

    [[nodiscard]] bool is_wanted(int y, int x) const {
        return completed_ == Completed::all || surfaces_.row(GuidedSurfaces::coverage, y)[x] > 0;
    }
    [[nodiscard]] bool is_any_wanted(int begin, int end, const Tile& tile) const {
        for (int y = begin; y < end; ++y) {
            for (int x = tile.left; x < tile.right; ++x) {
                if (is_wanted(y, x)) return true;
            }
        }
        return false;
    }

    /// Finds the samples within `reach` of a tile; returns the step between them.
    int find_samples(const Tile& tile, float reach) {
        const int rows = static_cast<int>(reach) + 1;
        int found = 0;
        ranges_.clear();
        for (int y = std::max(0, tile.top - rows); y < std::min(surfaces_.height(), tile.bottom + rows); ++y) {
            const auto away = static_cast<float>(std::max({0, tile.top - y, y - tile.bottom + 1}));
            const int columns = static_cast<int>(std::sqrt(std::max(0.f, reach * reach - away * away))) + 1;
            const GuidedRange range = traced_.within(y, tile.left - columns, tile.left + fit_width + columns);
            if (range.begin < range.end) ranges_.push_back(range), found += range.end - range.begin;
        }
        return 1 + found / enough;
    }

    /// A row of places; its fit begins at `first` of the output.
    struct Row {
        float y;
        std::size_t first;
    };

    void fit_row(Kernel fit, const Tile& tile, const Row& row, float column_step, int count, float scale, int step, Fitted& fitted) {
        const auto [y, first] = row;
        const auto [left, right] = reaches_.across(tile.down, tile.across, (y - static_cast<float>(tile.top)) / fit_height);
        const float share = column_step / fit_width;
        const auto guide = [&, pixels = static_cast<int>(y)](GuidedSurfaces::Plane plane) { return surfaces_.row(plane, pixels) + tile.left; };
        const GuidedRow wanted{y, static_cast<float>(tile.left), column_step, guide(GuidedSurfaces::depth), guide(GuidedSurfaces::depth_right),
                               guide(GuidedSurfaces::depth_down), {guide(GuidedSurfaces::normal_x), guide(GuidedSurfaces::normal_y), guide(GuidedSurfaces::normal_z)},
                               {guide(GuidedSurfaces::red), guide(GuidedSurfaces::green), guide(GuidedSurfaces::blue)}, guide(GuidedSurfaces::coverage),
                               scale * left.reach, scale * (right.reach - left.reach) * share,
                               left.sharpness, (right.sharpness - left.sharpness) * share,
                               {&fitted.light[0][first], &fitted.light[1][first], &fitted.light[2][first]}, &fitted.weight[first],
                               &fitted.detail[first], &fitted.noise[first]};
        fit(traced_.samples.data(), ranges_.data(), ranges_.size(), step, guided_likeness, wanted, count, traced_.is_noisy);
    }

    /// Fits `rows_`, of `count` places, with a larger reach where no sample is on the same surface.
    void fit_rows(Kernel fit, const Tile& tile, float column_step, int count, Fitted& fitted) {
        for (int widening = 0; widening < widenings && !rows_.empty(); ++widening) {
            const float scale = static_cast<float>(1 << widening);
            const int step = find_samples(tile, scale * reaches_.widest(tile.down, tile.across));
            for (const Row& row : rows_) {
                fit_row(fit, tile, row, column_step, count, scale, step, widening > 0 ? wider_ : fitted);
                if (widening > 0) take_wider(row.first, count, fitted);
            }
            std::erase_if(rows_, [&](const Row& row) {
                for (int place = 0; place < count; ++place) {
                    if (fitted.weight[row.first + static_cast<std::size_t>(place)] < least_weight && is_wanted(tile, row, place)) return false;
                }
                return true;
            });
        }
    }
    /// On planes, pixels between places need all of them.
    [[nodiscard]] bool is_wanted(const Tile& tile, const Row& row, int place) const {
        if (completed_ == Completed::plane) return true;
        return tile.left + place < tile.right && is_wanted(static_cast<int>(row.y), tile.left + place);
    }

    /// Fits each pixel.
    void on_surfaces(const Tile& tile, Fitted& fitted) {
        int row_step = std::clamp(static_cast<int>(reaches_.narrowest(tile.down, tile.across) / reach_per_row), 1, fit_height - 1);
        if (row_step > 1 && !is_plane(surfaces_, tile.top, tile.bottom, tile.left, tile.right)) row_step = 1;
        const auto is_fitted = [&](int y) { return (y - tile.top) % row_step == 0 || y == tile.bottom - 1; };
        rows_.clear();
        for (int y = tile.top; y < tile.bottom; ++y) {
            if (is_fitted(y) && is_any_wanted(y, y + 1, tile)) rows_.push_back({static_cast<float>(y), static_cast<std::size_t>((y - tile.top) * fit_width)});
        }
        if (rows_.empty()) return;
        const auto fit = components_ == 3 ? best_guided_kernels().fit_color : best_guided_kernels().fit_gray;
        fit_rows(fit, tile, 1, fit_width, fitted);
        for (int y = tile.top, before = tile.top; y < tile.bottom; ++y) {
            if (is_fitted(y)) before = y;
            if (is_fitted(y)) continue;
            const int after = std::min(before + row_step, tile.bottom - 1);
            const float share = static_cast<float>(y - before) / static_cast<float>(after - before);
            const auto place = [&](int row) { return static_cast<std::size_t>((row - tile.top) * fit_width); };
            const auto interpolate = [&](std::array<float, Fitted::size>& values) {
                for (std::size_t x = 0; x < fit_width; ++x) {
                    const float from = values[place(before) + x], to = values[place(after) + x];
                    values[place(y) + x] = from + share * (to - from);
                }
            };
            for (int c = 0; c < components_; ++c) interpolate(fitted.light[c]);
            interpolate(fitted.detail), interpolate(fitted.noise);
        }
    }

    /// Fits places of a grid, between which the fit is interpolated.
    void on_plane(const Tile& tile, Fitted& fitted) {
        const float spacing = place_spacing * std::sqrt(reaches_.sharpest(tile.down, tile.across));
        const auto places = [&](int size) {
            return std::clamp(static_cast<int>(std::ceil(static_cast<float>(size - 1) / spacing)) + 1, std::min(size, 2), size);
        };
        const int height = tile.bottom - tile.top, rows = places(height), columns = places(fit_width);
        const float row_step = rows > 1 ? static_cast<float>(height - 1) / static_cast<float>(rows - 1) : 1;
        const float column_step = (fit_width - 1.f) / static_cast<float>(columns - 1);
        rows_.clear();
        for (int row = 0; row < rows; ++row) {
            rows_.push_back({static_cast<float>(tile.top) + row_step * static_cast<float>(row), static_cast<std::size_t>(row * fit_width)});
        }
        fit_rows(best_guided_kernels().fit_plane, tile, column_step, columns, places_);
        for (int y = 0; y < height; ++y) {
            const auto [row, down] = place_of(y, row_step, rows);
            for (int x = 0; x < fit_width; ++x) {
                const auto [column, along] = place_of(x, column_step, columns);
                const auto i = static_cast<std::size_t>(row * fit_width + column);
                const std::size_t right = i + (columns > 1), below = rows > 1 ? fit_width : 0;
                const auto interpolate = [&, along = along, down = down](const std::array<float, Fitted::size>& of, std::array<float, Fitted::size>& to) {
                    const float upper = of[i] + along * (of[right] - of[i]), lower = of[below + i] + along * (of[below + right] - of[below + i]);
                    to[static_cast<std::size_t>(y * fit_width + x)] = upper + down * (lower - upper);
                };
                interpolate(places_.light[0], fitted.light[0]);
                if (traced_.is_noisy) interpolate(places_.detail, fitted.detail), interpolate(places_.noise, fitted.noise);
            }
        }
    }

    /// The place before a pixel, and the pixel's distance to it as a share of the step.
    static std::pair<int, float> place_of(int pixel, float step, int count) {
        const float at = static_cast<float>(pixel) / step;
        const int before = std::clamp(static_cast<int>(at), 0, std::max(count - 2, 0));
        return {before, at - static_cast<float>(before)};
    }

    /// Takes the wider fit where the narrower one has too few samples.
    void take_wider(std::size_t first, int count, Fitted& fitted) const {
        for (std::size_t i = first; i < first + static_cast<std::size_t>(count); ++i) {
            if (fitted.weight[i] >= least_weight) continue;
            for (int c = 0; c < components_; ++c) fitted.light[c][i] = wider_.light[c][i];
            fitted.weight[i] = wider_.weight[i], fitted.detail[i] = wider_.detail[i], fitted.noise[i] = wider_.noise[i];
        }
    }

    const GuidedSurfaces& surfaces_;
    const Traced& traced_;
    const Reaches& reaches_;
    int components_;
    Completed completed_;
    std::vector<GuidedRange> ranges_;
    std::vector<Row> rows_;  // that still have to be fitted
    Fitted wider_, places_;
};

void complete(const Layout& known, const float* planes, const GuidedSurfaces& surfaces, const Channel& channel, Completed completed, float* output,
              float* noise) {
    const int height = surfaces.height(), width = surfaces.width(), components = channel.components;
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    Traced traced(known, planes, channel, surfaces, completed);
    if (noise) std::fill_n(noise, pixels, 0.f);
    if (traced.samples.empty()) {
        std::fill_n(output, pixels * static_cast<std::size_t>(components), 0.f);
        return;
    }
    const Reaches reaches(surfaces, traced);
    const float* const values = planes + static_cast<std::size_t>(known.place_of(channel)) * pixels;
    const int in_row = tiles_across(width);
    parallel_for(static_cast<std::size_t>(in_row) * static_cast<std::size_t>(tiles_down(height)), 8, [&](std::size_t begin, std::size_t end) {
        Fit fit(surfaces, traced, reaches, components, completed);
        Fitted fitted;
        for (std::size_t tile = begin; tile < end; ++tile) {
            const int down = static_cast<int>(tile) / in_row, across = static_cast<int>(tile) % in_row;
            fit.tile(down, across, fitted);
            const int top = down * fit_height, left = across * fit_width, right = std::min(left + fit_width, width);
            for (int y = top; y < std::min(top + fit_height, height); ++y) {
                const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
                const auto in_tile = [&](int x) { return static_cast<std::size_t>((y - top) * fit_width + x - left); };
                const float* const coverage = surfaces.row(GuidedSurfaces::coverage, y);
                for (int c = 0; c < components; ++c) {
                    float* const to = output + static_cast<std::size_t>(c) * pixels + row;
                    for (int x = left; x < right; ++x) {
                        const float light = std::max(0.f, fitted.light[c][in_tile(x)] * surfaces.divisor(components, c, y, x));
                        to[x] = completed == Completed::all || coverage[x] > 0 ? light : 0;
                    }
                }
                for (const GuidedSample& sample : traced.in_tile(y, across)) {
                    const int x = static_cast<int>(sample.column);
                    const std::size_t k = in_tile(x), i = row + static_cast<std::size_t>(x);
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
    complete(known, planes, surfaces, channel, covered_only ? Completed::surfaces : Completed::all, output, noise);
}

void complete_alpha(const Layout& known, const float* planes, const float* coverage, const float* ground, int height, int width, float* alpha,
                    float* noise) {
    const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    if (std::any_of(ground, ground + size, [](float share) { return share > 0; })) {
        complete(known, planes, GuidedSurfaces(ground, height, width), channels::shadow, Completed::plane, alpha, noise);
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
