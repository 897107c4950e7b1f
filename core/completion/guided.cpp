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

/// Scatter around the fit is detail if it exceeds the noise by this factor, since noise has long tails.
constexpr float noise_explains = 2;

/// Doublings of the reach where samples on the same surface have less than the least weight.
constexpr int widenings = 4;
/// Maximum number of samples at any reach.
constexpr int enough = 4096;

/// Spacing of fitted places, as a share of the distance whose square is the offset: the fit varies over that distance. Five scenes in a
/// studio, 5 to 100 % of the pixels, against a fit of each pixel: the mean error changes by -3 to 2 % on surfaces and by -7 to 4 % on the
/// ground, in 0.4 to 0.8 of the time. At 1, by up to 4 % more on surfaces.
constexpr float place_spacing = 0.6f;
/// Pixels are fitted themselves where the places around them are less alike. At 0.02, textured surfaces have a tenth more error; at 0.6,
/// bunnies take a third longer.
constexpr float blended_likeness = 0.3f;
/// Maximum number of rows of places in an area of several tiles, whose places are fewer than those of its tiles together.
constexpr int max_rows = 7;

/// Size of tiles, the smallest rectangles that are fitted one at a time, and number of tiles along the sides of the largest.
constexpr int tile_width = GuidedSurfaces::row_multiple, tile_height = 8, tiles_of_block = 4;
constexpr int block_width = tiles_of_block * tile_width, block_height = tiles_of_block * tile_height;
constexpr int tiles_across(int width) { return (width + tile_width - 1) / tile_width; }
constexpr int tiles_down(int height) { return (height + tile_height - 1) / tile_height; }

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
                if (x % tile_width == 0) first_.push_back(static_cast<int>(samples.size()));
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

    /// The samples of a row that are in columns of tiles from `begin` to before `end`.
    [[nodiscard]] std::span<const GuidedSample> in_tiles(int y, int begin, int end) const {
        return std::span(samples).subspan(static_cast<std::size_t>(first(y, begin)), static_cast<std::size_t>(first(y, end) - first(y, begin)));
    }

    /// The samples of a row that are in columns from `left` to before `right`.
    [[nodiscard]] GuidedRange within(int y, int left, int right) const {
        const int tiles = stride_ - 1;
        int begin = first(y, std::clamp(left / tile_width, 0, tiles)), end = first(y, std::clamp(tiles_across(right), 0, tiles));
        const auto column = [&](int n) { return samples[static_cast<std::size_t>(n)].column; };
        while (begin < end && column(begin) < static_cast<float>(left)) ++begin;
        while (begin < end && column(end - 1) >= static_cast<float>(right)) --end;
        return {begin, end, static_cast<float>(y)};
    }

private:
    [[nodiscard]] int first(int y, int across) const { return first_[static_cast<std::size_t>(y * stride_ + across)]; }

    int stride_;
    std::vector<int> first_;  // first sample of each row from each column of tiles on, and the row's end
};

/// Sums of samples' values over rectangles of the picture, spread evenly over bins of several pixels.
class Table {
public:
    Table(int height, int width)
        : down_((height + bin - 1) / bin), across_((width + bin - 1) / bin), sums_(size(down_ + 1) * size(across_ + 1)) {}

    /// `of(sample)` is the value of a sample.
    template <class Of>
    void fill(const Traced& traced, Of of) {
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
        if (!traced.is_noisy) {
            for_corners([&](int y, int x, std::size_t corner) { corners_[corner] = {reach(y, x, samples_around), sharp}; });
            return;
        }

        Table shades(height_, width_), variances(height_, width_);
        std::vector<float> raw;
        for (const GuidedSample& sample : traced.samples) raw.push_back(sample.shade);
        std::vector<float> around(corners_.size());
        for_corners([&](int y, int x, std::size_t corner) { around[corner] = reach(y, x, samples_to_clamp); });
        for (int round = 0; round < clamp_rounds; ++round) {
            shades.fill(traced, [](const GuidedSample& sample) { return sample.shade; });
            parallel_for(raw.size(), 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t n = begin; n < end; ++n) {
                    GuidedSample& sample = traced.samples[n];
                    const int y = static_cast<int>(sample.row), x = static_cast<int>(sample.column);
                    const float k = around[place((y + tile_height / 2) / tile_height, (x + tile_width / 2) / tile_width)];
                    const double most = brighter * shades.around(y, x, k) / counts_.around(y, x, k);
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
        shades.fill(traced, [](const GuidedSample& sample) { return sample.shade; });
        variances.fill(traced, [](const GuidedSample& sample) { return sample.variance; });
        for_corners([&](int y, int x, std::size_t corner) {
            const float k = around[corner];
            const double count = std::max(1., counts_.around(y, x, k)), shade = shades.around(y, x, k) / count;
            const double noise = variances.around(y, x, k) / count / (shade * shade + 1e-12), side = 2 * k + 1;
            const double density = count / (side * side);
            const double wanted = samples_around + samples_for_noise * std::cbrt(noise * density * density);
            const float wide = reach(y, x, std::min(most_samples, wanted));
            corners_[corner] = {wide, sharp + static_cast<float>(blunt * std::min(1., noise / noisy)) * wide * wide};
        });
    }

    /// At a pixel.
    [[nodiscard]] Reach at(int y, int x) const {
        const auto blend = [](const Reach& from, const Reach& to, float share) {
            return Reach{from.reach + share * (to.reach - from.reach), from.sharpness + share * (to.sharpness - from.sharpness)};
        };
        const std::size_t above = place(y / tile_height, x / tile_width), below = above + across_;
        const float down = static_cast<float>(y % tile_height) / tile_height, right = static_cast<float>(x % tile_width) / tile_width;
        return blend(blend(corners_[above], corners_[below], down), blend(corners_[above + 1], corners_[below + 1], down), right);
    }

    /// The largest reach and the smallest offset in a rectangle.
    [[nodiscard]] Reach extremes(int top, int left, int height, int width) const {
        Reach result{0, std::numeric_limits<float>::max()};
        for (int down = top / tile_height; down <= tiles_down(top + height); ++down) {
            for (int across = left / tile_width; across <= tiles_across(left + width); ++across) {
                const auto [reach, sharpness] = corners_[place(down, across)];
                result = {std::max(result.reach, reach), std::min(result.sharpness, sharpness)};
            }
        }
        return result;
    }

private:
    [[nodiscard]] std::size_t place(int down, int across) const {
        return static_cast<std::size_t>(down) * across_ + static_cast<std::size_t>(across);
    }

    template <class Body>
    void for_corners(Body body) {
        parallel_for(corners_.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                body(static_cast<int>(i / across_) * tile_height, static_cast<int>(i % across_) * tile_width, i);
            }
        });
    }

    /// The smallest reach with this number of samples, in rows and columns; at most the whole picture.
    [[nodiscard]] float reach(int y, int x, double samples) const {
        float low = least, high = static_cast<float>(height_ + width_);
        if (counts_.around(y, x, low) >= samples) return low;
        while (high - low > 0.5f) {
            const float middle = 0.5f * (low + high);
            (counts_.around(y, x, middle) >= samples ? high : low) = middle;
        }
        return high;
    }

    static constexpr float least = 2.5f;

    int height_, width_;
    Table counts_;
    std::size_t across_;
    std::vector<Reach> corners_;
};

/// The fit at the pixels of a block.
struct Fitted {
    static constexpr std::size_t size = block_width * block_height;
    std::array<float, size> light[3]{}, weight{}, detail{}, noise{};
};

/// Fits the light at pixels to the samples around them.
class Fit {
public:
    Fit(const GuidedSurfaces& surfaces, const Traced& traced, const Reaches& reaches, int components, Completed completed)
        : surfaces_(surfaces), traced_(traced), reaches_(reaches), components_(components), completed_(completed),
          kernels_(completed == Completed::plane ? best_guided_kernels().plane : components == 3 ? best_guided_kernels().color : best_guided_kernels().gray) {}

    /// Fits the pixels of a block; those that are not completed keep any value.
    void block(int top, int left, Fitted& fitted) {
        block_top_ = top, block_left_ = left;
        fit({top, left, block_height, block_width}, fitted);
    }

private:
    /// A rectangle of whole tiles; the picture may end in it.
    struct Area {
        int top, left, height, width;
    };

    [[nodiscard]] std::size_t in_block(int y, int x) const {
        return static_cast<std::size_t>((y - block_top_) * block_width + x - block_left_);
    }

    [[nodiscard]] bool is_wanted(int y, int x) const {
        return completed_ == Completed::all || surfaces_.row(GuidedSurfaces::coverage, y)[x] > 0;
    }

    /// Calls `body` for each pixel that is completed, until it returns true.
    template <class Body>
    bool any_wanted(const Area& area, Body body) const {
        for (int y = area.top; y < area.top + area.height; ++y) {
            for (int x = area.left; x < area.left + area.width; ++x) {
                if (is_wanted(y, x) && body(y, x)) return true;
            }
        }
        return false;
    }

    /// Number of places along a side.
    static int places_along(int size, float spacing) {
        return std::clamp(static_cast<int>(std::ceil(static_cast<float>(size - 1) / spacing)) + 1, std::min(size, 2), size);
    }

    void fit(Area area, Fitted& fitted) {
        const Area whole = area;
        area.height = std::min(area.height, surfaces_.height() - area.top), area.width = std::min(area.width, surfaces_.width() - area.left);
        if (area.height <= 0 || area.width <= 0 || !any_wanted(area, [](int, int) { return true; })) return;
        const auto [reach, sharpness] = reaches_.extremes(area.top, area.left, area.height, area.width);
        const float spacing = place_spacing * std::sqrt(sharpness);
        if (whole.height > tile_height && places_along(whole.height, spacing) > max_rows) {
            const int height = whole.height / 2, width = whole.width / 2;
            for (const int top : {area.top, area.top + height}) {
                for (const int left : {area.left, area.left + width}) fit({top, left, height, width}, fitted);
            }
            return;
        }
        const bool is_sparse = spacing >= 1;
        if (is_sparse) blend(area, spacing, reach, fitted);
        places_.count = 0;
        any_wanted(area, [&](int y, int x) {
            if (is_sparse && fitted.weight[in_block(y, x)] >= blended_likeness) return false;
            add(y, x);
            if (places_.count == GuidedPlaces::capacity) fit_pixels(area, reach, fitted);
            return false;
        });
        fit_pixels(area, reach, fitted);
    }

    void add(int y, int x) {
        const auto set = [&, i = places_.count](int value, float to) { places_.of[value][i] = to; };
        const auto [reach, sharpness] = reaches_.at(y, x);
        set(GuidedPlaces::row, static_cast<float>(y)), set(GuidedPlaces::column, static_cast<float>(x));
        set(GuidedPlaces::reach, reach), set(GuidedPlaces::sharpness, sharpness);
        if (completed_ != Completed::plane) {
            for (int plane = 0; plane < GuidedSurfaces::count; ++plane) set(GuidedPlaces::guides + plane, surfaces_.row(plane, y)[x]);
        }
        ++places_.count;
    }

    /// Fits the places, which are pixels, and removes them.
    void fit_pixels(const Area& area, float reach, Fitted& fitted) {
        fit_places(area, reach);
        for (int i = 0; i < places_.count; ++i) {
            const auto of = [&](int value) { return places_.of[value][i]; };
            const std::size_t pixel = in_block(static_cast<int>(of(GuidedPlaces::row)), static_cast<int>(of(GuidedPlaces::column)));
            for (int c = 0; c < components_; ++c) fitted.light[c][pixel] = of(GuidedPlaces::light_of(c, 0));
            fitted.detail[pixel] = of(GuidedPlaces::detail), fitted.noise[pixel] = of(GuidedPlaces::noise);
        }
        places_.count = 0;
    }

    /// Fits places of a grid, and blends them at the pixels.
    void blend(const Area& area, float spacing, float reach, Fitted& fitted) {
        GuidedGrid grid;
        const auto spread = [&](int size, int* at) {
            const int count = places_along(size, spacing);
            for (int i = 0; i < count; ++i) at[i] = count > 1 ? (i * (size - 1) + (count - 1) / 2) / (count - 1) : 0;
            return count;
        };
        grid.rows = spread(area.height, grid.row), grid.columns = spread(area.width, grid.column);
        places_.count = 0;
        for (int row = 0; row < grid.rows; ++row) {
            for (int column = 0; column < grid.columns; ++column) {
                const int y = area.top + grid.row[row], x = area.left + grid.column[column];
                const bool is_fitted = completed_ == Completed::plane || is_wanted(y, x);
                grid.place[row][column] = is_fitted ? places_.count : -1;
                if (is_fitted) add(y, x);
            }
        }
        fit_places(area, reach);
        const std::size_t first = in_block(area.top, area.left);
        GuidedPixels pixels{area.top, area.left, area.height, area.width, {}, surfaces_.stride(), block_width,
                            {&fitted.light[0][first], &fitted.light[1][first], &fitted.light[2][first]},
                            &fitted.weight[first], &fitted.detail[first], &fitted.noise[first]};
        for (int plane = 0; plane < GuidedSurfaces::count; ++plane) pixels.guides[plane] = surfaces_.row(plane, area.top) + area.left;
        kernels_.blend(places_, grid, guided_likeness, pixels, traced_.is_noisy);
    }

    /// Fits the places, with a larger reach where no sample is on the same surface.
    void fit_places(const Area& area, float reach) {
        fit_places(area, reach, places_);
        for (int widening = 1; widening < widenings; ++widening) {
            const auto scale = static_cast<float>(1 << widening);
            std::array<int, GuidedPlaces::capacity> wide;
            wider_.count = 0;
            for (int i = 0; i < places_.count; ++i) {
                if (places_.of[GuidedPlaces::weight][i] >= least_weight) continue;
                for (int value = 0; value < GuidedPlaces::light; ++value) wider_.of[value][wider_.count] = places_.of[value][i];
                wider_.of[GuidedPlaces::reach][wider_.count] *= scale;
                wide[static_cast<std::size_t>(wider_.count++)] = i;
            }
            if (wider_.count == 0) return;
            fit_places(area, scale * reach, wider_);
            for (int k = 0; k < wider_.count; ++k) {
                for (int value = GuidedPlaces::light; value < GuidedPlaces::values; ++value) {
                    places_.of[value][wide[static_cast<std::size_t>(k)]] = wider_.of[value][k];
                }
            }
        }
    }
    void fit_places(const Area& area, float reach, GuidedPlaces& places) {
        if (places.count == 0) return;
        for (int i = places.count; i % GuidedSurfaces::row_multiple != 0; ++i) {
            for (int value = 0; value < GuidedPlaces::light; ++value) places.of[value][i] = places.of[value][places.count - 1];
        }
        const int step = find_samples(area, reach);
        kernels_.fit(traced_.samples.data(), ranges_.data(), ranges_.size(), step, guided_likeness, places, traced_.is_noisy);
    }

    /// Finds the samples within `reach` of an area; returns the step between them.
    int find_samples(const Area& area, float reach) {
        const int rows = static_cast<int>(reach) + 1, bottom = area.top + area.height;
        int found = 0;
        ranges_.clear();
        for (int y = std::max(0, area.top - rows); y < std::min(surfaces_.height(), bottom + rows); ++y) {
            const auto away = static_cast<float>(std::max({0, area.top - y, y - bottom + 1}));
            const int columns = static_cast<int>(std::sqrt(std::max(0.f, reach * reach - away * away))) + 1;
            const GuidedRange range = traced_.within(y, area.left - columns, area.left + area.width + columns);
            if (range.begin < range.end) ranges_.push_back(range), found += range.end - range.begin;
        }
        return 1 + found / enough;
    }

    const GuidedSurfaces& surfaces_;
    const Traced& traced_;
    const Reaches& reaches_;
    int components_;
    Completed completed_;
    const GuidedKernels::Kernels& kernels_;
    int block_top_ = 0, block_left_ = 0;
    std::vector<GuidedRange> ranges_;
    GuidedPlaces places_, wider_;
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
    const int in_row = (width + block_width - 1) / block_width, in_column = (height + block_height - 1) / block_height;
    parallel_for(static_cast<std::size_t>(in_row) * static_cast<std::size_t>(in_column), 2, [&](std::size_t begin, std::size_t end) {
        Fit fit(surfaces, traced, reaches, components, completed);
        Fitted fitted;
        for (std::size_t block = begin; block < end; ++block) {
            const int down = static_cast<int>(block) / in_row, across = static_cast<int>(block) % in_row;
            const int top = down * block_height, left = across * block_width, right = std::min(left + block_width, width);
            fit.block(top, left, fitted);
            for (int y = top; y < std::min(top + block_height, height); ++y) {
                const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
                const auto in_block = [&](int x) { return static_cast<std::size_t>((y - top) * block_width + x - left); };
                const float* const coverage = surfaces.row(GuidedSurfaces::coverage, y);
                for (int c = 0; c < components; ++c) {
                    float* const to = output + static_cast<std::size_t>(c) * pixels + row;
                    for (int x = left; x < right; ++x) {
                        const float light = std::max(0.f, fitted.light[c][in_block(x)] * surfaces.divisor(components, c, y, x));
                        to[x] = completed == Completed::all || coverage[x] > 0 ? light : 0;
                    }
                }
                for (const GuidedSample& sample : traced.in_tiles(y, left / tile_width, tiles_across(right))) {
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
