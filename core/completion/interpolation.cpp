#include "completion/interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "completion/interpolation_kernels.h"
#include "completion/planes.h"
#include "completion/spare.h"
#include "parallel.h"
#include "picture/order.h"

namespace bob {
namespace {

/// Corners that differ by more of a channel's range say nothing about what lies between them.
constexpr float most_contrast = 0.15f;

/// Over longer ways two corners agree that have a highlight between them: there all four have to.
constexpr int longest_pair = 4;

constexpr float unknown = std::numeric_limits<float>::infinity();

/// Lattices whose pixels lie so far apart are kept of whole pictures, finer ones of a band at a time.
constexpr int coarse_step = 8;

/// Rows of the picture that are finished together, while what they need is in the cache.
constexpr int band_rows = 32;

constexpr int coarsest_step = static_cast<int>(Tile::side);

/// The smaller of two, and the larger; b where either is NaN, as in vectors.
float least(float a, float b) { return a < b ? a : b; }
float most(float a, float b) { return a > b ? a : b; }

/// The first row and column of the lattice whose pixels lie `step` apart, and how many there are in so many pixels.
constexpr int first_of(int step) { return lattice_first % step; }
constexpr int count_of(int size, int step) { return size > first_of(step) ? (size - first_of(step) - 1) / step + 1 : 0; }

/// Where the next coarser lattice lies in this one: at its even rows and columns, or at the odd ones.
constexpr int phase_of(int step) { return (first_of(2 * step) - first_of(step)) / step; }

/// Rows of a lattice between which those of the next finer one lie.
Band coarser(Band rows, int step, int height) {
    const int phase = phase_of(step);
    return {std::max(0, (rows.begin - phase - 1 + 2) / 2 - 1), std::min(count_of(height, 2 * step), (rows.end - 1 - phase + 2) / 2 + 1)};
}

/// Nodes of a lattice: planes of their contrast and their components.
Planes nodes_of(int components, int height, int width, int step, int window) {
    return {1 + components, count_of(height, step), count_of(width, step), window};
}
ConstNodes row_of(const Planes& nodes, int y) { return {nodes.row(0, y), nodes.plane_stride()}; }

/// What one thread needs for a row, and for a band.
struct Scratch {
    int height, width;
    Planes traced;  // of the lattice's pixels in a row
    Planes made;    // nodes between those of the coarser lattice: two rows of middles, two of those beside them, and one of others
    Planes fours, twos;

    Scratch(int height, int width, int components)
        : height(height), width(width), traced(1 + components, 1, half(width)), made(1 + components, 5, half(width)),
          fours(nodes_of(components, height, width, 4, band_rows / 4 + 4)), twos(nodes_of(components, height, width, 2, band_rows / 2 + 2)) {}
};

struct Images {
    int height, width;
    std::vector<Planes> coarse;  // from `coarse_step` on
    Spare<Scratch> scratch;

    Images(int height, int width, int components) : height(height), width(width), scratch(static_cast<std::size_t>(thread_count())) {
        for (int step = coarse_step; step <= coarsest_step; step *= 2) {
            coarse.push_back(nodes_of(components, height, width, step, height));
        }
    }
};

std::array<Spare<Images>, 2> spare;  // of one component, and of three

/// Rows of a picture: its mask, what a channel showed where it was traced, and what is made of it.
struct Picture {
    const float *mask, *traced;
    float *output, *weights;  // weights may be null
    std::size_t plane;        // floats from a component to the next, of what was traced and of the output
    int height, width;
};

/// One of those between which a row of nodes lies: node i beside `nodes` i + `shift`, if there is such a row and column.
struct Corner {
    ConstNodes nodes;
    int shift, count;
};

/// Of one component, or of a colour's three, which agree or differ together. What lies in a lattice is made of the next coarser one: first
/// the middles of its squares, and then what lies between two corners and two middles.
template <int Components>
class Interpolation {
public:
    Interpolation(const Picture& picture, float range)
        : picture_(picture), weight_per_contrast_(1 / (most_contrast * range)),
          images_(spare[Components / 2].take(picture.height, picture.width, Components)) {}
    ~Interpolation() { spare[Components / 2].give_back(std::move(images_)); }
    Interpolation(const Interpolation&) = delete;
    Interpolation& operator=(const Interpolation&) = delete;

    /// From the coarsest squares to the finest.
    void operator()() {
        auto& coarse = images_->coarse;
        begin(coarse.back());
        int step = coarsest_step;
        for (std::size_t i = coarse.size() - 1; i-- > 0;) {
            step /= 2;
            Planes& to = coarse[i];
            in_bands(to.height(), picture_.width, [&](Band rows, Scratch& scratch) { refine(step, coarse[i + 1], rows, scratch, &to); });
        }
        in_bands(picture_.height, picture_.width, [&](Band rows, Scratch& scratch) {
            const Band twos = coarser(rows, 1, picture_.height), fours = coarser(twos, 2, picture_.height);
            refine(4, coarse[0], fours, scratch, &scratch.fours);
            refine(2, scratch.fours, twos, scratch, &scratch.twos);
            refine(1, scratch.twos, rows, scratch, nullptr);
        });
    }

private:
    template <class Body>
    void in_bands(int height, int width, Body body) {
        const int bands = (height + band_rows - 1) / band_rows;
        parallel_for(static_cast<std::size_t>(bands), static_cast<std::size_t>(1 + 8192 / (band_rows * width)), [&](std::size_t first, std::size_t last) {
            auto scratch = images_->scratch.take(picture_.height, picture_.width, Components);
            for (int i = static_cast<int>(first); i < static_cast<int>(last); ++i) {
                body(Band{i * band_rows, std::min((i + 1) * band_rows, height)}, *scratch);
            }
            images_->scratch.give_back(std::move(scratch));
        });
    }

    /// What was traced of a lattice's row.
    TracedRow traced_row(int step, int y, Scratch& scratch) const {
        const std::size_t first = static_cast<std::size_t>(first_of(step) + step * y) * static_cast<std::size_t>(picture_.width);
        TracedRow row{picture_.mask + first, picture_.traced + first, picture_.plane, picture_.width};
        Planes& to = scratch.traced;
        for (int finer = 1; finer < step; finer *= 2) {
            best_interpolation_kernels().halve(row, Components, phase_of(finer), to.row(0, 0), to.plane_stride());
            row = {to.row(0, 0), to.row(1, 0), to.plane_stride(), count_of(picture_.width, 2 * finer)};
        }
        return row;
    }

    /// Of the coarsest lattice what was traced.
    void begin(Planes& nodes) {
        auto scratch = images_->scratch.take(picture_.height, picture_.width, Components);
        for (int y = 0; y < nodes.height(); ++y) {
            const TracedRow row = traced_row(coarsest_step, y, *scratch);
            for (int x = 0; x < row.columns; ++x) {
                const bool is_traced = row.mask[x] > 0;
                nodes.row(0, y)[x] = is_traced ? 0 : unknown;
                for (int c = 0; c < Components; ++c) nodes.row(1 + c, y)[x] = is_traced ? row.value[static_cast<std::size_t>(c) * row.plane + x] : 0;
            }
        }
        images_->scratch.give_back(std::move(scratch));
    }

    /// Rows of a lattice, from the coarser one: to its nodes, or to the picture where these are null.
    void refine(int step, const Planes& coarse, Band rows, Scratch& scratch, Planes* nodes) {
        const int phase = phase_of(step), height = count_of(picture_.height, step), columns = count_of(picture_.width, step);
        const int corners = coarse.width(), middles = columns - corners, middle_rows = height - coarse.height();
        const auto corner_row = [&](int y, int shift) {
            return Corner{y < 0 || y >= coarse.height() ? ConstNodes{} : row_of(coarse, y), shift, corners};
        };
        const auto made_row = [&](int place) { return Nodes{scratch.made.row(0, place), scratch.made.plane_stride()}; };
        const auto read = [](const Nodes& nodes) { return ConstNodes{nodes.contrast, nodes.plane}; };
        int done = -1;  // the last row of middles that was made
        /// Makes a row of middles, and what lies in it between a corner above and one below.
        const auto middle_row = [&](int i, int shift) {
            if (i < 0 || i >= middle_rows) return Corner{{}, shift, middles};
            const Nodes to = made_row(i % 2);
            if (i > done) {
                done = i;
                const TracedRow traced = traced_row(step, 2 * i + 1 - phase, scratch);
                const int above = i - phase, below = above + 1;
                make(step, {corner_row(above, -phase), corner_row(below, 1 - phase), corner_row(above, 1 - phase), corner_row(below, -phase)},
                     traced, 1 - phase, to, middles);
                make(step, {corner_row(above, 0), corner_row(below, 0), Corner{read(to), phase - 1, middles}, Corner{read(to), phase, middles}},
                     traced, phase, made_row(2 + i % 2), corners);
            }
            return Corner{read(to), shift, middles};
        };
        for (int y = rows.begin; y < rows.end; ++y) {
            ConstNodes at[2];  // in the coarser lattice's columns, and between them
            if (y % 2 == phase) {
                const int corner = y / 2;
                const Corner above = middle_row(corner + phase - 1, 0), below = middle_row(corner + phase, 0);
                const Nodes to = made_row(4);
                make(step, {above, below, corner_row(corner, -phase), corner_row(corner, 1 - phase)}, traced_row(step, y, scratch), 1 - phase, to,
                     middles);
                at[0] = row_of(coarse, corner), at[1] = read(to);
            } else {
                at[1] = middle_row(y / 2, 0).nodes;
                at[0] = read(made_row(2 + y / 2 % 2));
            }
            const ConstNodes &even = at[phase], &odd = at[1 - phase];
            const auto& kernels = best_interpolation_kernels();
            if (nodes) {
                for (int c = 0; c <= Components; ++c) {
                    const auto plane = static_cast<std::size_t>(c);
                    kernels.zip(even.contrast + plane * even.plane, odd.contrast + plane * odd.plane, nodes->row(c, y), half(columns));
                }
            } else {
                const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns);
                kernels.improve({Components, {even, odd}, picture_.mask + first, weight_per_contrast_, picture_.output + first, picture_.plane,
                                 picture_.weights ? picture_.weights + first : nullptr, columns});
            }
        }
    }

    /// A row of nodes between corners, two opposite ones and then the other two.
    void make(int step, const Corner (&corners)[4], const TracedRow& traced, int phase, const Nodes& to, int count) const {
        const auto& kernels = best_interpolation_kernels();
        const bool inside = std::all_of(std::begin(corners), std::end(corners), [](const Corner& c) { return c.nodes.contrast != nullptr; });
        if (inside) {
            NodesBetween row{Components, phase, {}, traced, weight_per_contrast_, to};
            for (std::size_t i = 0; i < 4; ++i) row.corners[i] = {corners[i].nodes.contrast + corners[i].shift, corners[i].nodes.plane};
            (step <= longest_pair ? kernels.between : kernels.amid)(row, count);
        }
        const int last = count - 1;
        for (int i = 0; i < count; i = inside && i < last ? last : i + 1) {
            if (!inside || 2 * i + phase == 0 || 2 * i + phase == traced.columns - 1) make_at_edge(corners, traced, phase, to, i);
        }
    }

    /// Of a node at the picture's edge: the mean of all corners that are not beyond it.
    void make_at_edge(const Corner (&corners)[4], const TracedRow& traced, int phase, const Nodes& to, int i) const {
        const auto value_of = [&](int c) -> float& { return to.value(c)[i]; };
        if (const int column = 2 * i + phase; traced.mask[column] > 0) {
            to.contrast[i] = 0;
            for (int c = 0; c < Components; ++c) value_of(c) = traced.value[static_cast<std::size_t>(c) * traced.plane + column];
            return;
        }
        const float* inside[4];
        std::size_t planes[4], count = 0;
        float contrast = 0;
        for (const Corner& corner : corners) {
            const int column = i + corner.shift;
            if (!corner.nodes.contrast || column < 0 || column >= corner.count) continue;
            inside[count] = corner.nodes.contrast + column, planes[count] = corner.nodes.plane;
            contrast = most(contrast, *inside[count++]);
        }
        if (count == 0) contrast = unknown;
        const bool known = contrast < unknown;
        for (int c = 0; c < Components; ++c) {
            float sum = 0, low = unknown, high = -unknown;
            for (std::size_t k = 0; known && k < count; ++k) {
                const float value = inside[k][static_cast<std::size_t>(c + 1) * planes[k]];
                sum += value, low = least(low, value), high = most(high, value);
            }
            value_of(c) = sum / static_cast<float>(std::max(count, std::size_t{1}));
            if (known) contrast = most(contrast, high - low);
        }
        to.contrast[i] = 1 - contrast * weight_per_contrast_ > 0 ? contrast : unknown;
    }

    Picture picture_;
    float weight_per_contrast_;
    std::unique_ptr<Images> images_;
};

/// Of one channel, some rows of which are looked at and written: all of a picture, or those around a band.
void interpolate(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                 int height, int width, Band rows) {
    const std::size_t line = static_cast<std::size_t>(width), pixels = static_cast<std::size_t>(height) * line;
    const std::size_t first = static_cast<std::size_t>(rows.begin) * line;
    Picture picture{planes + first, planes + static_cast<std::size_t>(known.place_of(channel)) * pixels + first, output + first,
                    weights ? weights + first : nullptr, pixels, rows.end - rows.begin, width};
    const float range = (channel.high - channel.low) * unit;
    if (channel.components == 3) return Interpolation<3>(picture, range)();
    for (int component = 0; component < channel.components; ++component) {
        Interpolation<1>(picture, range)();
        picture.traced += pixels, picture.output += pixels;
    }
}

}  // namespace

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width) {
    interpolate_lattice(known, planes, completed, output, height, width, {0, height});
}

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band) {
    // A pixel sees two steps of each lattice above and below, less than two tiles; tiles keep their places.
    constexpr int side = static_cast<int>(Tile::side);
    const Band rows{std::max(0, band.begin / side - 2) * side, std::min(height, band.end + 2 * side)};
    for (const Channel& channel : completed) {
        interpolate(known, planes, channel, 1, output, nullptr, height, width, rows);
        output += static_cast<std::size_t>(channel.components * height) * static_cast<std::size_t>(width);
    }
}

void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                         int height, int width) {
    if (weights) std::fill_n(weights, static_cast<std::size_t>(height) * static_cast<std::size_t>(width), 0.f);
    interpolate(known, planes, channel, unit, output, weights, height, width, {0, height});
}

}  // namespace bob
