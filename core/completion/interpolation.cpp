#include "completion/interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "completion/interpolation_kernels.h"
#include "completion/planes.h"
#include "completion/spare.h"
#include "sampling/order.h"

namespace bob {
namespace {

/// Maximum contrast between two corners, as a share of the channel's range; above it they predict nothing between them.
constexpr float most_contrast = 0.15f;

/// Maximum distance over which two corners decide. Over longer ones a highlight may lie between them, and all four have
/// to agree.
constexpr int longest_pair = 4;

constexpr float unknown = std::numeric_limits<float>::infinity();

/// Lattices of at least this spacing are stored for the whole picture, finer ones for a band.
constexpr int coarse_step = 8;

/// Picture rows finished together, while their inputs are in the cache.
constexpr int band_rows = 32;

constexpr int coarsest_step = static_cast<int>(Tile::side);

/// Minimum and maximum; b if either is NaN, as in vector code.
float least(float a, float b) { return a < b ? a : b; }
float most(float a, float b) { return a > b ? a : b; }

/// The first row and column of the lattice with spacing `step`, and its number of nodes across `size` pixels.
constexpr int first_of(int step) { return lattice_first % step; }
constexpr int count_of(int size, int step) { return size > first_of(step) ? (size - first_of(step) - 1) / step + 1 : 0; }

/// Phase of the next coarser lattice in this one: its even rows and columns, or the odd ones.
constexpr int phase_of(int step) { return (first_of(2 * step) - first_of(step)) / step; }

/// Rows of the next coarser lattice that enclose the rows of a lattice.
Band coarser(Band rows, int step, int height) {
    const int phase = phase_of(step);
    return {std::max(0, (rows.begin - phase - 1 + 2) / 2 - 1), std::min(count_of(height, 2 * step), (rows.end - 1 - phase + 2) / 2 + 1)};
}

/// The range of coarser nodes, on the columns and between them, that nodes of a lattice depend on. Includes two
/// neighbours on either side.
Stretch made_for(Stretch some) { return aligned({std::max(0, some.begin / 2 - 2), some.end / 2 + 2}); }

ConstNodes row_of(const Planes& nodes, int y) { return {nodes.row(0, y), nodes.plane_stride()}; }

/// The memory of a thread. Nodes are planes of their contrast and their components.
struct Lattices {
    int height, width;
    Planes traced;              // traced pixels of a lattice row
    Planes made;                // between coarser nodes: two rows of square centres, two rows between their columns, and one other row
    std::vector<Planes> nodes;  // of spacings 2, 4, 8, ...; up to `coarse_step` only a band

    Lattices(int height, int width, int components)
        : height(height), width(width), traced(1 + components, 1, half(width)), made(1 + components, 5, half(width)) {
        for (int step = 2; step <= coarsest_step; step *= 2) {
            nodes.emplace_back(1 + components, count_of(height, step), count_of(width, step), step < coarse_step ? band_rows / step + 4 : height);
        }
    }
};

/// Lattices of one and of three components; enough for the threads of small machines.
std::array<Spare<Lattices>, 2> spare{Spare<Lattices>(8), Spare<Lattices>(8)};

/// Rows of a picture: its mask, the traced values of a channel, and the output.
struct Picture {
    const float *mask, *traced;
    float *output, *weights;  // weights may be null
    std::size_t plane;        // floats from component to component, of the traced values and of the output
    int height, width;
    std::span<const Stretch> lit;  // of each two rows; if given, the rest is black, and traced pixels are restored
};

/// A neighbouring row of nodes: node i lies next to `nodes` i + `shift`, if that row and column exist.
struct Corner {
    ConstNodes nodes;
    int shift, count;
};

/// Interpolates one component, or the three of a colour, which share their weights. Each lattice is refined from the
/// next coarser one: first the centres of its squares, then the nodes between two corners and two centres.
class Interpolation {
public:
    Interpolation(const Picture& picture, int components, float range)
        : picture_(picture), components_(components), weight_per_contrast_(1 / (most_contrast * range)),
          lattices_(kept().take(picture.height, picture.width, components)) {}
    ~Interpolation() { kept().give_back(std::move(lattices_)); }
    Interpolation(const Interpolation&) = delete;
    Interpolation& operator=(const Interpolation&) = delete;

    /// Refines from the coarsest squares to the finest.
    void operator()() {
        auto& nodes = lattices_->nodes;
        begin(nodes.back());
        std::size_t level = nodes.size() - 1;
        int step = coarsest_step;
        while (step > coarse_step) {
            step /= 2, --level;
            refine(step, nodes[level + 1], {0, nodes[level].height()}, {0, nodes[level].width()}, *lattices_, &nodes[level]);
        }
        const auto bands = static_cast<std::size_t>((picture_.height + band_rows - 1) / band_rows);
        parallel_for(bands, static_cast<std::size_t>(1 + 8192 / (band_rows * picture_.width)), [&](std::size_t first, std::size_t last) {
            auto lattices = kept().take(picture_.height, picture_.width, components_);
            Planes &twos = lattices->nodes[0], &fours = lattices->nodes[1];
            for (int i = static_cast<int>(first); i < static_cast<int>(last); ++i) {
                const Band rows{i * band_rows, std::min((i + 1) * band_rows, picture_.height)};
                const Band rows_of_twos = coarser(rows, 1, picture_.height), rows_of_fours = coarser(rows_of_twos, 2, picture_.height);
                const Stretch some = improved_in(rows);
                put_back_around(some, rows);
                if (some.is_empty()) continue;
                const Stretch some_twos = read_for(some), some_fours = read_for(some_twos);
                refine(4, nodes[2], rows_of_fours, some_fours, *lattices, &fours);
                refine(2, fours, rows_of_twos, some_twos, *lattices, &twos);
                refine(1, twos, rows, some, *lattices, nullptr);
            }
            kept().give_back(std::move(lattices));
        });
    }

private:
    [[nodiscard]] Spare<Lattices>& kept() const { return spare[components_ == 1 ? 0 : 1]; }

    [[nodiscard]] bool puts_back() const { return !picture_.lit.empty(); }

    /// Columns of pixels, in whole vectors of nodes of either parity.
    [[nodiscard]] Stretch improved_in(Band rows) const {
        if (!puts_back()) return {0, picture_.width};
        return within(aligned(joined(picture_.lit, rows.begin / 2, half(rows.end)), 2 * max_lanes), picture_.width);
    }

    /// The range of coarser nodes read for a range of nodes.
    static Stretch read_for(Stretch some) {
        const Stretch made = made_for(some);
        return {std::max(0, made.begin - 1), made.end + 1};
    }

    void put_back_around(Stretch some, Band rows) const {
        if (!puts_back()) return;
        for (int y = rows.begin; y < rows.end; ++y) {
            for (const Stretch& beside : {Stretch{0, some.begin}, Stretch{some.end, picture_.width}}) {
                const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) + static_cast<std::size_t>(beside.begin);
                best_interpolation_kernels().put_back({picture_.mask + first, picture_.traced + first, picture_.plane, beside.end - beside.begin},
                                                      components_, picture_.output + first, picture_.plane);
            }
        }
    }

    /// Loads the traced pixels of a lattice row, in some columns.
    TracedRow traced_row(int step, int y, Stretch some, Lattices& lattices) const {
        const std::size_t first = static_cast<std::size_t>(first_of(step) + step * y) * static_cast<std::size_t>(picture_.width);
        TracedRow row{picture_.mask + first, picture_.traced + first, picture_.plane, picture_.width};
        Planes& to = lattices.traced;
        for (int finer = 1; finer < step; finer *= 2) {
            const int times = step / (2 * finer);
            best_interpolation_kernels().halve(row, components_, phase_of(finer), to.row(0, 0), to.plane_stride(), {times * some.begin, times * some.end});
            row = {to.row(0, 0), to.row(1, 0), to.plane_stride(), count_of(picture_.width, 2 * finer)};
        }
        return row;
    }

    /// Loads the traced pixels of the coarsest lattice.
    void begin(Planes& nodes) {
        for (int y = 0; y < nodes.height(); ++y) {
            const TracedRow row = traced_row(coarsest_step, y, {0, nodes.width()}, *lattices_);
            for (int x = 0; x < row.columns; ++x) {
                const bool is_traced = row.mask[x] > 0;
                bool is_black = is_traced;
                for (int c = 0; c < components_; ++c) {
                    const float value = is_traced ? row.value[static_cast<std::size_t>(c) * row.plane + x] : 0;
                    nodes.row(1 + c, y)[x] = value;
                    is_black = is_black && value == 0;
                }
                nodes.row(0, y)[x] = is_black ? black : is_traced ? 0 : unknown;
            }
        }
    }

    /// Refines rows of a lattice, in some columns, from the coarser one. Writes its nodes or, if `nodes` is null, the
    /// picture.
    void refine(int step, const Planes& coarse, Band rows, Stretch some, Lattices& lattices, Planes* nodes) {
        const Stretch made = made_for(some), traced_in{2 * made.begin, 2 * made.end};
        const int phase = phase_of(step), height = count_of(picture_.height, step), columns = count_of(picture_.width, step);
        const int corners = coarse.width(), middles = columns - corners, middle_rows = height - coarse.height();
        const auto corner_row = [&](int y, int shift) {
            return Corner{y < 0 || y >= coarse.height() ? ConstNodes{} : row_of(coarse, y), shift, corners};
        };
        const auto made_row = [&](int place) { return Nodes{lattices.made.row(0, place), lattices.made.plane_stride()}; };
        const auto read = [](const Nodes& nodes) { return ConstNodes{nodes.contrast, nodes.plane}; };
        int done = -1;  // the last row of centres computed
        /// Computes a row of centres and its nodes between a corner above and one below.
        const auto middle_row = [&](int i, int shift) {
            if (i < 0 || i >= middle_rows) return Corner{{}, shift, middles};
            const Nodes to = made_row(i % 2);
            if (i > done) {
                done = i;
                const TracedRow traced = traced_row(step, 2 * i + 1 - phase, traced_in, lattices);
                const int above = i - phase, below = above + 1;
                make(step, {corner_row(above, -phase), corner_row(below, 1 - phase), corner_row(above, 1 - phase), corner_row(below, -phase)},
                     traced, 1 - phase, to, made, middles);
                make(step, {corner_row(above, 0), corner_row(below, 0), Corner{read(to), phase - 1, middles}, Corner{read(to), phase, middles}},
                     traced, phase, made_row(2 + i % 2), made, corners);
            }
            return Corner{read(to), shift, middles};
        };
        for (int y = rows.begin; y < rows.end; ++y) {
            ConstNodes at[2];  // on the columns of the coarser lattice, and between them
            if (y % 2 == phase) {
                const int corner = y / 2;
                const Corner above = middle_row(corner + phase - 1, 0), below = middle_row(corner + phase, 0);
                const Nodes to = made_row(4);
                make(step, {above, below, corner_row(corner, -phase), corner_row(corner, 1 - phase)}, traced_row(step, y, traced_in, lattices),
                     1 - phase, to, made, middles);
                at[0] = row_of(coarse, corner), at[1] = read(to);
            } else {
                at[1] = middle_row(y / 2, 0).nodes;
                at[0] = read(made_row(2 + y / 2 % 2));
            }
            const ConstNodes &even = at[phase], &odd = at[1 - phase];
            const auto& kernels = best_interpolation_kernels();
            if (nodes) {
                for (int c = 0; c <= components_; ++c) {
                    const auto plane = static_cast<std::size_t>(c);
                    kernels.zip(even.contrast + plane * even.plane, odd.contrast + plane * odd.plane, nodes->row(c, y), within(made, half(columns)));
                }
            } else {
                const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns);
                kernels.improve({components_, {even, odd}, picture_.mask + first, weight_per_contrast_, picture_.output + first, picture_.plane,
                                 picture_.weights ? picture_.weights + first : nullptr, columns, puts_back()},
                                some);
            }
        }
    }

    /// Computes a row of nodes between corners, given as two opposite pairs.
    void make(int step, const Corner (&corners)[4], const TracedRow& traced, int phase, const Nodes& to, Stretch some, int count) const {
        some = within(some, count);
        const bool inside = std::all_of(std::begin(corners), std::end(corners), [](const Corner& c) { return c.nodes.contrast != nullptr; });
        if (inside) {
            NodesBetween row{components_, phase, step <= longest_pair, {}, traced, weight_per_contrast_, to};
            for (std::size_t i = 0; i < 4; ++i) row.corners[i] = {corners[i].nodes.contrast + corners[i].shift, corners[i].nodes.plane};
            best_interpolation_kernels().between(row, some);
        }
        const int last = some.end - 1;
        for (int i = some.begin; i < some.end; i = inside && i < last ? last : i + 1) {
            if (!inside || 2 * i + phase == 0 || 2 * i + phase == traced.columns - 1) make_of_all(corners, traced, phase, to, i);
        }
    }

    /// Computes node i from all corners inside the picture.
    void make_of_all(const Corner (&corners)[4], const TracedRow& traced, int phase, const Nodes& to, int i) const {
        const auto value_of = [&](int c) -> float& { return to.value(c)[i]; };
        if (const int column = 2 * i + phase; traced.mask[column] > 0) {
            to.contrast[i] = black;
            for (int c = 0; c < components_; ++c) {
                value_of(c) = traced.value[static_cast<std::size_t>(c) * traced.plane + column];
                if (value_of(c) != 0) to.contrast[i] = 0;
            }
            return;
        }
        const float* inside[4];
        std::size_t planes[4], count = 0;
        float contrast = black;
        for (const Corner& corner : corners) {
            const int column = i + corner.shift;
            if (!corner.nodes.contrast || column < 0 || column >= corner.count) continue;
            inside[count] = corner.nodes.contrast + column, planes[count] = corner.nodes.plane;
            contrast = most(contrast, *inside[count++]);
        }
        if (count == 0) contrast = unknown;
        const bool known = contrast < unknown, is_black = contrast < 0;
        for (int c = 0; c < components_; ++c) {
            float sum = 0, low = unknown, high = -unknown;
            for (std::size_t k = 0; known && k < count; ++k) {
                const float value = inside[k][static_cast<std::size_t>(c + 1) * planes[k]];
                sum += value, low = least(low, value), high = most(high, value);
            }
            value_of(c) = sum / static_cast<float>(std::max(count, std::size_t{1}));
            if (known) contrast = most(contrast, high - low);
        }
        to.contrast[i] = is_black ? black : 1 - contrast * weight_per_contrast_ > 0 ? contrast : unknown;
    }

    Picture picture_;
    int components_;
    float weight_per_contrast_;
    std::unique_ptr<Lattices> lattices_;
};

/// Interpolates one channel, reading and writing either all rows or the rows around a band.
void interpolate(const Layout& known, const float* planes, const Channel& channel, float unit, float* output, float* weights,
                 int height, int width, Band rows, std::span<const Stretch> lit = {}) {
    const std::size_t line = static_cast<std::size_t>(width), pixels = static_cast<std::size_t>(height) * line;
    const std::size_t first = static_cast<std::size_t>(rows.begin) * line;
    Picture picture{planes + first, planes + static_cast<std::size_t>(known.place_of(channel)) * pixels + first, output + first,
                    weights ? weights + first : nullptr, pixels, rows.end - rows.begin, width, lit};
    const float range = (channel.high - channel.low) * unit;
    if (channel.components == 3) return Interpolation(picture, 3, range)();
    for (int component = 0; component < channel.components; ++component) {
        Interpolation(picture, 1, range)();
        picture.traced += pixels, picture.output += pixels;
    }
}

}  // namespace

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width) {
    interpolate_lattice(known, planes, completed, output, height, width, {0, height});
}

void interpolate_lattice(const Layout& known, const float* planes, const Layout& completed, float* output, int height, int width, Band band) {
    // A pixel depends on two steps of each lattice above and below, less than two tiles; tiles keep their places.
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

void interpolate_lattice(const Layout& known, const float* planes, const Channel& channel, float unit, std::span<const Stretch> lit,
                         float* output, int height, int width) {
    interpolate(known, planes, channel, unit, output, nullptr, height, width, {0, height}, lit);
}

}  // namespace bob
