#include "reprojection/history.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/parallel.h"
#include "base/thread_memory.h"

namespace bob {
namespace {

/// Maximum disc radius in pixels, and disc radius per distance between samples. From the squared radius `far_squared`
/// on, discs are splatted individually. The disc of five pixels replaces all smaller ones.
constexpr int max_radius = BorderedGrid::border;
constexpr float radius_per_distance = 1.3f;
constexpr std::uint32_t far_squared = 3;

/// Samples are counted in blocks of `block` x `block` pixels.
constexpr std::uint32_t block = 8;

/// The motion of the background is computed every `piece` pixels across and down, and interpolated linearly.
constexpr std::uint32_t piece = WasEmpty::piece;

/// Within this share of a point's screen motion around it, the background is no longer certain.
constexpr float overrun_share = 0.5f;

/// The camera has jumped if fewer of the points in the picture face it unoccluded: the history is discarded.
constexpr float min_still_seen = 0.75f;

/// Minimum share of the picture with a reprojected sample; below it, reprojection does not help.
constexpr float min_known = 1 / 16.f;

/// A pixel is inside a surface if the mean direction to the disc centres is shorter. The five directions of one half
/// average to .48.
constexpr float one_sided = 0.45f;

/// Points are compacted if more than this share of them is marked.
constexpr float max_marked = 0.3f;

/// Precomputed discs of all radii.
struct Discs {
    static constexpr int across = 2 * max_radius + 1;

    std::int32_t sides[across][2 * max_lanes]{};           // by row and column: the bit of the octant with the centre
    std::int32_t half_widths[max_radius * max_radius + 1][across]{};  // by the squared radius
    std::int32_t is_inside[256]{};                          // by the octants of centres, 0 or -1
    std::array<std::uint8_t, block * block + 1> squared{};  // squared radius by the number of known pixels in a block

    Discs() {
        for (int down = -max_radius; down <= max_radius; ++down) {
            for (int right = -max_radius; right <= max_radius; ++right) {
                const double turn = std::atan2(down, right) / (2 * std::numbers::pi);
                const int eighth = static_cast<int>(std::lround(8 * turn)) & 7;
                sides[down + max_radius][right + max_radius] = right != 0 || down != 0 ? 1 << eighth : 0;
            }
        }
        for (int square = 0; square <= max_radius * max_radius; ++square) {
            const int radius = root(square);
            for (int down = -radius; down <= radius; ++down) half_widths[square][down + radius] = root(square - down * down);
        }
        for (std::size_t all = 1; all < std::size(is_inside); ++all) {
            double right = 0, down = 0;
            for (int eighth = 0; eighth < 8; ++eighth) {
                if (!(all >> eighth & 1)) continue;
                const double angle = eighth * std::numbers::pi / 4;
                right += std::cos(angle), down += std::sin(angle);
            }
            is_inside[all] = std::hypot(right, down) < one_sided * std::popcount(all) ? -1 : 0;
        }
        for (std::size_t count = 1; count < squared.size(); ++count) {
            const float radius = std::min(radius_per_distance * block / std::sqrt(static_cast<float>(count)), float{max_radius});
            squared[count] = static_cast<std::uint8_t>(radius * radius);
        }
    }

    static int root(int square) { return static_cast<int>(std::sqrt(static_cast<double>(square))); }

    [[nodiscard]] DiscRows rows(std::uint32_t square) const { return {root(static_cast<int>(square)), half_widths[square], sides}; }

    static const Discs& all() {
        static const Discs discs;
        return discs;
    }
};

/// The columns of points.
namespace columns {
enum : std::size_t { x, y, z, normal_x, normal_y, normal_z, carried };
}

/// The planes that every history needs.
template <class Float>
struct Planes {
    Planes(const Layout& layout, Float* planes, std::size_t pixels)
        : mask(planes + at(layout, channels::mask) * pixels), depth(planes + at(layout, channels::depth) * pixels),
          normal_x(planes + at(layout, channels::normal) * pixels), normal_y(normal_x + pixels) {}

    static std::size_t at(const Layout& layout, const Channel& channel) { return static_cast<std::size_t>(layout.place_of(channel)); }

    Float *mask, *depth, *normal_x, *normal_y;
};

}  // namespace

History::History(const Layout& layout, std::uint32_t height, std::uint32_t width)
    : layout_(layout), height_(height), width_(width), cells_{static_cast<std::int32_t>(height), static_cast<std::int32_t>(width)},
      chosen_(cells_.size(), no_choice), surface_depth_(cells_.size()), surface_right_(cells_.size()), surface_down_(cells_.size()),
      nearest_(cells_.size()), sides_(cells_.size()),
      expected_right_(cells_.size(), ExpectedRow::unknown), expected_down_(cells_.size(), ExpectedRow::unknown), overrun_(cells_.size()), empty_(std::size_t{height} * width + max_lanes),
      was_empty_(empty_.size()), counts_(width + max_lanes) {
    const bool is_shaded_anew = layout_.place(channels::instance) >= 0;
    std::size_t at = 0;
    for (const Channel& channel : layout_) {
        const bool is_derived = channel == channels::mask || channel == channels::depth || channel == channels::normal ||
                                (is_shaded_anew && (channel == channels::gray || channel == channels::color));
        for (int component = 0; component < channel.components; ++component, ++at) {
            if (!is_derived) carried_components_.push_back(at);
            if (channel == channels::gray || channel == channels::color) shade_components_.push_back(at);
        }
    }
    (void)Planes<float>(layout_, nullptr, 0);  // throws if one is missing
    const std::size_t max_points = std::size_t{height} * width + max_lanes;
    columns_.assign(columns::carried + carried_components_.size(), Column(max_points));
    for (Column* const column : {&sight_depth_, &sight_right_, &sight_down_, &off_center_, &right_, &down_, &screen_x_, &screen_y_}) column->resize(max_points);
    cell_.resize(max_points);
    shades_.assign(shade_components_.size(), Column(cells_.size()));
}

void History::clear() {
    count_ = kept_ = 0;
    std::ranges::fill(chosen_, no_choice);
    std::ranges::fill(empty_, std::uint8_t{0});
}

PointsIn<const float> History::points() const {
    return {columns_[columns::x].data(),        columns_[columns::y].data(),        columns_[columns::z].data(),
            columns_[columns::normal_x].data(), columns_[columns::normal_y].data(), columns_[columns::normal_z].data()};
}

Sights History::sights() {
    return {cell_.data(), sight_depth_.data(), sight_right_.data(), sight_down_.data(), off_center_.data(),
            right_.data(), down_.data(), screen_x_.data(), screen_y_.data()};
}

Surfaces History::surfaces() { return {surface_depth_.data(), surface_right_.data(), surface_down_.data()}; }

void History::add(const Camera& camera, const float* planes) {
    if (camera != camera_) clear();
    camera_ = camera;
    const Projection projection(camera, static_cast<int>(height_), static_cast<int>(width_));
    const std::size_t pixels = std::size_t{height_} * width_;
    const Planes<const float> traced(layout_, planes, pixels);

    traced_.clear();
    for (std::uint32_t begin = 0; begin < pixels; begin += piece) {
        const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(begin + piece, pixels));
        std::uint32_t any = 0;
        for (std::uint32_t i = begin; i < end; ++i) any |= std::bit_cast<std::uint32_t>(traced.mask[i]);
        for (std::uint32_t i = begin; any != 0 && i < end; ++i) {
            if (traced.mask[i] != 0) traced_.push_back(i);
        }
    }
    const auto cell_of = [&](std::uint32_t i) {
        return static_cast<std::size_t>(cells_.at(static_cast<std::int32_t>(i / width_), static_cast<std::int32_t>(i % width_)));
    };
    std::size_t more = 0;
    for (const std::uint32_t i : traced_) more += traced.depth[i] != 0 && chosen_[cell_of(i)] == no_choice;
    if (count_ + more > pixels || static_cast<float>(count_ - kept_) > max_marked * static_cast<float>(count_)) drop(pixels - more);
    kept_ += more;

    for (const std::uint32_t i : traced_) {
        Choice& chosen = chosen_[cell_of(i)];
        empty_[i] = traced.depth[i] == 0;
        if (empty_[i]) {
            if (chosen != no_choice) mark(static_cast<std::size_t>(chosen_point(std::exchange(chosen, no_choice))));
            continue;
        }
        // A traced sample replaces the reprojected one.
        if (chosen == no_choice) chosen = choice(0, static_cast<std::uint32_t>(count_++));
        const auto row = static_cast<float>(i / width_), column = static_cast<float>(i % width_);
        const Vec3 position = projection.point(row, column, traced.depth[i]);
        const Vec3 normal = projection.in_scene(whole_normal(traced.normal_x[i], traced.normal_y[i]), row, column);
        const auto point = static_cast<std::size_t>(chosen_point(chosen));
        columns_[columns::x][point] = position.x, columns_[columns::y][point] = position.y, columns_[columns::z][point] = position.z;
        columns_[columns::normal_x][point] = normal.x, columns_[columns::normal_y][point] = normal.y, columns_[columns::normal_z][point] = normal.z;
        for (std::size_t k = 0; k < carried_components_.size(); ++k) columns_[columns::carried + k][point] = planes[carried_components_[k] * pixels + i];
    }
}

void History::mark(std::size_t point) {
    columns_[columns::x][point] = std::numeric_limits<float>::quiet_NaN();
    --kept_;
}

void History::drop(std::size_t max_points) {
    // `cell_` first marks the points in use, then holds their new positions.
    std::fill_n(cell_.begin(), count_, BorderedGrid::nowhere);
    std::size_t expected = 0;
    for (const Choice chosen : chosen_) {
        if (chosen != no_choice) cell_[static_cast<std::size_t>(chosen_point(chosen))] = 1, ++expected;
    }
    const Column& x = columns_[columns::x];
    std::size_t others = max_points - std::min(max_points, expected), to = 0;
    for (std::size_t k = 0; k < count_; ++k) {
        if (std::isnan(x[k])) continue;
        if (cell_[k] == BorderedGrid::nowhere && (others == 0 || others-- == 0)) continue;
        for (Column& column : columns_) column[to] = column[k];
        cell_[k] = static_cast<std::int32_t>(to++);
    }
    for (Choice& chosen : chosen_) {
        if (chosen != no_choice) chosen = choice(0, static_cast<std::uint32_t>(cell_[static_cast<std::size_t>(chosen_point(chosen))]));
    }
    count_ = kept_ = to;
}

std::size_t History::expect(const Camera& camera, float* planes, float* off_center, const std::function<void(int)>& finish) {
    const Projection before(camera_, static_cast<int>(height_), static_cast<int>(width_));
    const Projection projection(camera, static_cast<int>(height_), static_cast<int>(width_));
    const Eye eye = projection.eye();
    see(eye);
    cover(eye);
    choose(before);
    const std::size_t pixels = std::size_t{height_} * width_;
    camera_ = camera;
    const auto nothing = [&] {
        clear();
        std::fill_n(planes, static_cast<std::size_t>(layout_.width()) * pixels, 0.f), std::fill_n(off_center, pixels, 0.f);
        return std::size_t{0};
    };
    if (static_cast<float>(kept_) < min_still_seen * static_cast<float>(in_picture_)) return nothing();
    was_empty_.swap(empty_);
    see_back(before, projection);

    const HistoryKernels& kernels = best_history_kernels();
    const Planes<float> expected(layout_, planes, pixels);
    std::atomic<std::size_t> surfaces{0};
    for_rows(0, static_cast<int>(height_), static_cast<int>(width_), [&](int y) {
        const std::size_t first = static_cast<std::size_t>(y) * width_;
        const auto width = static_cast<std::int32_t>(width_);
        const Choice* const chosen = chosen_.data() + cells_.at(y, 0);
        expect_emptiness(projection, static_cast<std::uint32_t>(y));
        const std::int32_t found = kernels.expect(sights(), chosen, empty_.data() + first,
                       {expected.mask + first, expected.depth + first, expected.normal_x + first, expected.normal_y + first, off_center + first,
                                                   expected_right_.data() + cells_.at(y, 0), expected_down_.data() + cells_.at(y, 0)}, width);
        surfaces.fetch_add(static_cast<std::size_t>(found), std::memory_order_relaxed);
        for (std::size_t k = 0; k < carried_components_.size(); ++k) {
            kernels.carry(columns_[columns::carried + k].data(), chosen, planes + carried_components_[k] * pixels + first, width);
        }
        if (finish) finish(y);
        for (std::size_t k = 0; k < shades_.size(); ++k) {
            std::copy_n(planes + shade_components_[k] * pixels + first, width_, shades_[k].data() + cells_.at(y, 0));
        }
    });
    for_rows(0, cells_.height, cells_.width, [&](int y) {
        const std::int32_t cell = cells_.at(y, 0);
        for (std::size_t k = 0; k < shades_.size(); ++k) {
            kernels.smooth(shades_[k].data() + cell, expected_right_.data() + cell, expected_down_.data() + cell, cells_.stride,
                           planes + shade_components_[k] * pixels + static_cast<std::size_t>(y) * width_, cells_.width);
        }
    });
    const std::size_t known = surfaces.load() + static_cast<std::size_t>(std::count(empty_.begin(), empty_.end(), std::uint8_t{1}));
    return static_cast<float>(known) < min_known * static_cast<float>(pixels) ? nothing() : surfaces.load();
}

void History::see(const Eye& eye) {
    const HistoryKernels& kernels = best_history_kernels();
    std::atomic<std::size_t> in_picture{0};
    parallel_for(count_, std::size_t{1} << 14, [&](std::size_t begin, std::size_t end) {
        in_picture.fetch_add(kernels.see(eye, cells_, points(), sights(), begin, end), std::memory_order_relaxed);
    });
    in_picture_ = in_picture;
    std::ranges::fill(surface_depth_, Surfaces::none);
    const Sights sight = sights();
    const Surfaces surface = surfaces();
    for (std::size_t k = 0; k < count_; ++k) {
        const std::int32_t cell = sight.cell[k];
        if (cell == BorderedGrid::nowhere || !(sight.depth[k] > surface.depth[cell])) continue;
        surface.depth[cell] = sight.depth[k];
        surface.deeper_right[cell] = sight.deeper_right[k], surface.deeper_down[cell] = sight.deeper_down[k];
    }
}

void History::find_far_discs() {
    const HistoryKernels& kernels = best_history_kernels();
    far_discs_.clear();
    for (std::uint32_t top = 0; top < height_; top += block) {
        const std::uint32_t bottom = std::min(top + block, height_);
        std::ranges::fill(counts_, 0);
        for (std::uint32_t row = top; row < bottom; ++row) {
            kernels.count(surface_depth_.data() + cells_.at(static_cast<std::int32_t>(row), 0), empty_.data() + std::size_t{row} * width_,
                          counts_.data(), static_cast<std::int32_t>(width_));
        }
        for (std::uint32_t left = 0; left < width_; left += block) {
            const std::uint32_t right = std::min(left + block, width_);
            std::int32_t count = 0;
            for (std::uint32_t column = left; column < right; ++column) count += counts_[column];
            const std::uint32_t squared = Discs::all().squared[static_cast<std::size_t>(std::min(count, static_cast<std::int32_t>(block * block)))];
            if (squared < far_squared) continue;
            for (std::uint32_t row = top; row < bottom; ++row) {
                const std::int32_t first = cells_.at(static_cast<std::int32_t>(row), 0);
                for (std::uint32_t column = left; column < right; ++column) {
                    const std::int32_t cell = first + static_cast<std::int32_t>(column);
                    if (surface_depth_[static_cast<std::size_t>(cell)] > Surfaces::none) far_discs_.push_back({cell, squared});
                }
            }
        }
    }
}

void History::cover(const Eye& eye) {
    const HistoryKernels& kernels = best_history_kernels();
    const Discs& discs = Discs::all();
    const Surfaces surfaces = this->surfaces();
    const Covers covers{nearest_.data(), sides_.data()};
    find_far_discs();
    if (!far_discs_.empty()) std::ranges::fill(nearest_, -1.f);
    for (const auto [cell, squared] : far_discs_) kernels.cover_far(discs.rows(squared), surfaces, covers, cell, cells_.stride);
    for_rows(0, cells_.height, cells_.width, [&](int row) {
        kernels.cover(eye, discs.rows(0), discs.is_inside, surfaces, covers, cells_.at(row, 0), cells_.stride, cells_.width, far_discs_.empty());
    });
    if (far_discs_.empty()) return;
    for (const auto [cell, squared] : far_discs_) kernels.look_far(eye, discs.rows(squared), surfaces, covers, cell, cells_.stride);
    for_rows(0, cells_.height, cells_.width, [&](int row) {
        kernels.end_cover(eye, discs.is_inside, surfaces, covers, cells_.at(row, 0), cells_.width);
    });
}

void History::choose(const Projection& before) {
    std::ranges::fill(chosen_, no_choice);
    std::ranges::fill(overrun_, std::uint8_t{0});
    float* const x = columns_[columns::x].data();
    std::int32_t* const sides = sides_.data();
    Choice* const chosen = chosen_.data();
    const float* const nearest = nearest_.data();
    const Sights sight = sights();
    kept_ = 0;
    for (std::size_t k = 0; k < count_; ++k) {
        const std::int32_t cell = sight.cell[k];
        if (cell == BorderedGrid::nowhere) {
            x[k] = std::numeric_limits<float>::quiet_NaN();
            continue;
        }
        const bool is_seen = sight.depth[k] >= nearest[cell];
        if (sides[cell] == 0) {
            overrun(k, before);
            sides[cell] = 1;  // once
        } else if (!is_seen && sides[cell] == -1) {
            x[k] = std::numeric_limits<float>::quiet_NaN();  // hidden
            continue;
        }
        ++kept_;
        const Choice own = is_seen ? choice(sight.off_center[k], static_cast<std::uint32_t>(k)) : no_choice;
        chosen[cell] = std::min(chosen[cell], own);
    }
}

void History::overrun(std::size_t point, const Projection& before) {
    const Projection::Seen was = before.seen({columns_[columns::x][point], columns_[columns::y][point], columns_[columns::z][point]});
    const std::int32_t cell = cell_[point];
    const float down = static_cast<float>(cells_.row_of(cell)) - was.row, right = static_cast<float>(cells_.column_of(cell)) - was.column;
    const float squared = std::min(overrun_share * overrun_share * (down * down + right * right), float{max_radius * max_radius});
    if (!(squared >= 0)) return;  // it was behind the camera
    const DiscRows disc = Discs::all().rows(static_cast<std::uint32_t>(squared));
    for (std::int32_t row = -disc.radius; row <= disc.radius; ++row) {
        const std::int32_t half = disc.half_widths[row + disc.radius];
        std::uint8_t* const middle = overrun_.data() + cell + row * cells_.stride;
        std::fill_n(middle - half, 2 * half + 1, std::uint8_t{1});
    }
}

void History::see_back(const Projection& before, const Projection& projection) {
    // The depth of the background is unknown: it is reprojected at the depth of the scene's centre.
    was_row_.clear(), was_column_.clear();
    for (std::uint32_t row = 0; row < height_ + piece; row += piece) {
        for (std::uint32_t column = 0; column < width_ + piece; column += piece) {
            const Projection::Seen was = before.seen(projection.point(static_cast<float>(row), static_cast<float>(column), 0.5f));
            was_row_.push_back(was.row), was_column_.push_back(was.column);
        }
    }
}

void History::find_outside(const Projection& projection, std::uint32_t row, std::vector<std::uint8_t>& outside) {
    // The sphere covers one interval of a row. Two equal samples bound a uniform stretch, unless the whole interval
    // lies between them.
    const auto passes_by = [&](std::size_t column) {
        Ray ray;
        return static_cast<std::uint8_t>(!projection.ray({static_cast<std::int32_t>(row), static_cast<std::int32_t>(column)}, ray));
    };
    constexpr std::size_t step = 4 * std::size_t{piece};
    bool is_met = false;
    std::uint8_t begins = passes_by(0);
    for (std::size_t begin = 0; begin < outside.size(); begin += step) {
        const std::size_t end = std::min(begin + step, outside.size());
        const std::uint8_t ends = passes_by(end);
        std::size_t changes = end;  // the first place that equals the end
        for (std::size_t alike = begin; begins != ends && alike + 1 < changes;) {
            const std::size_t middle = (alike + changes) / 2;
            (passes_by(middle) == begins ? alike : changes) = middle;
        }
        std::fill(outside.begin() + static_cast<std::ptrdiff_t>(begin), outside.begin() + static_cast<std::ptrdiff_t>(changes), begins);
        std::fill(outside.begin() + static_cast<std::ptrdiff_t>(changes), outside.begin() + static_cast<std::ptrdiff_t>(end), ends);
        is_met |= begins == 0 || ends == 0;
        begins = ends;
    }
    for (std::size_t column = 0; !is_met && column < outside.size(); ++column) outside[column] = passes_by(column);
}

void History::expect_emptiness(const Projection& projection, std::uint32_t row) {
    const std::size_t ends = was_row_.size() / ((height_ + 2 * piece - 1) / piece);  // of pieces
    struct Memory {
        std::vector<std::uint8_t> outside;
        Column was_row, was_column;
    };
    auto& [outside, was_row, was_column] = thread_memory<Memory>();
    outside.resize(ends * piece), was_row.resize(ends), was_column.resize(ends);
    const float down = static_cast<float>(row % piece) / piece;
    for (std::size_t k = 0; k < ends; ++k) {
        const std::size_t above = row / piece * ends + k, below = above + ends;
        was_row[k] = was_row_[above] + down * (was_row_[below] - was_row_[above]);
        was_column[k] = was_column_[above] + down * (was_column_[below] - was_column_[above]);
    }
    find_outside(projection, row, outside);
    const std::size_t first = std::size_t{row} * width_;
    const auto cell = static_cast<std::size_t>(cells_.at(static_cast<std::int32_t>(row), 0));
    best_history_kernels().empty({was_row.data(), was_column.data(), was_empty_.data(), cells_.height, cells_.width}, outside.data(), chosen_.data() + cell,
                                 sides_.data() + cell, overrun_.data() + cell, empty_.data() + first, cells_.width);
}

std::size_t History::bytes() const {
    std::size_t floats = sight_depth_.capacity() + sight_right_.capacity() + sight_down_.capacity() + off_center_.capacity() +
                         screen_x_.capacity() + screen_y_.capacity() +
                         surface_depth_.capacity() + surface_right_.capacity() + surface_down_.capacity() + nearest_.capacity() +
                         was_row_.capacity() + was_column_.capacity();
    floats += right_.capacity() + down_.capacity() + expected_right_.capacity() + expected_down_.capacity();
    for (const Column& column : columns_) floats += column.capacity();
    for (const Column& column : shades_) floats += column.capacity();
    return floats * sizeof(float) + (cell_.capacity() + sides_.capacity() + counts_.capacity() + traced_.capacity()) * sizeof(std::int32_t) +
           chosen_.capacity() * sizeof(Choice) + overrun_.capacity() + empty_.capacity() + was_empty_.capacity() + far_discs_.capacity() * sizeof(Disc);
}

}  // namespace bob
