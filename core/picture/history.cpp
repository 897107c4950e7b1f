#include "picture/history.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "parallel.h"

namespace bob {
namespace {

/// Points whose depths differ by less belong to one surface, in sides of a pixel: so steep it may be.
constexpr float same_surface = 2;

/// Surfaces that are seen more nearly edge-on are taken to be as steep as this.
constexpr float least_normal_z = 0.3f;

/// Discs are at most so large, in pixels, and of so many sample distances.
constexpr int most_radius = 8;
constexpr float radius_per_distance = 1.3f;

/// Samples are counted in blocks of so many pixels a side.
constexpr std::uint32_t block = 8;

/// Where emptiness was is found for every so many pixels of a row, and lies on straight lines between. Of many, nothing is known.
constexpr std::uint32_t piece = 16;

/// A share of the way that a point moved: as far around it, nothing is known to be empty any more.
constexpr float overrun_share = 0.5f;

/// Where fewer of the points in the picture are not turned away or hidden, the camera has jumped: what it sees now is new.
constexpr float least_still_seen = 0.75f;

/// Nor does it help to expect a smaller share of the picture.
constexpr float least_known = 1 / 16.f;

/// The mean of the eighths in which centres of discs lie is shorter where a pixel is inside. Of all in one half it is .48.
constexpr float one_sided = 0.45f;

/// Where discs reach from their centres, the nearest pixels first.
struct Offset {
    float right, down;
    std::int32_t squared;
    std::uint8_t side;  // the bit of the eighth in which the centre lies
};
struct Disc {
    std::vector<Offset> offsets;
    std::array<std::uint8_t, 256> is_inside{};  // by the sides on which centres lie

    /// How many pixels a disc covers.
    [[nodiscard]] std::uint32_t reach(float radius) const {
        const auto squared = static_cast<std::int32_t>(radius * radius);
        return static_cast<std::uint32_t>(std::ranges::upper_bound(offsets, squared, {}, &Offset::squared) - offsets.begin());
    }
};
const Disc& disc() {
    static const Disc all = [] {
        Disc result;
        for (int down = -most_radius; down <= most_radius; ++down) {
            for (int right = -most_radius; right <= most_radius; ++right) {
                const int squared = right * right + down * down;
                if (squared > most_radius * most_radius) continue;
                const double turn = std::atan2(down, right) / (2 * std::numbers::pi);
                const int eighth = static_cast<int>(std::lround(8 * turn)) & 7;
                result.offsets.push_back({static_cast<float>(right), static_cast<float>(down), squared, static_cast<std::uint8_t>(squared > 0 ? 1 << eighth : 0)});
            }
        }
        std::ranges::stable_sort(result.offsets, {}, &Offset::squared);
        for (std::size_t sides = 1; sides < result.is_inside.size(); ++sides) {
            double right = 0, down = 0;
            for (int eighth = 0; eighth < 8; ++eighth) {
                if (!(sides >> eighth & 1)) continue;
                const double angle = eighth * std::numbers::pi / 4;
                right += std::cos(angle), down += std::sin(angle);
            }
            result.is_inside[sides] = std::hypot(right, down) < one_sided * std::popcount(sides);
        }
        return result;
    }();
    return all;
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
    : layout_(layout), height_(height), width_(width), at_(std::size_t{height} * width, none), off_center_(at_.size()),
      depth_(at_.size()), empty_(at_.size() + 1), was_empty_(at_.size() + 1), overrun_(at_.size()),
      counts_(std::size_t{(height + block - 1) / block} * ((width + block - 1) / block)),
      nearest_((std::size_t{height} + 2 * most_radius) * (width + 2 * most_radius)), sides_(nearest_.size()) {
    std::size_t at = 0;
    for (const Channel& channel : layout_) {
        const bool is_derived = channel == channels::mask || channel == channels::depth || channel == channels::normal;
        for (int component = 0; component < channel.components; ++component, ++at) {
            if (!is_derived) carried_components_.push_back(at);
        }
    }
    (void)Planes<float>(layout_, nullptr, 0);  // throws where one is missing
    for (const Offset& offset : disc().offsets) {
        steps_.push_back(static_cast<std::int32_t>(offset.down) * static_cast<std::int32_t>(width + 2 * most_radius) +
                         static_cast<std::int32_t>(offset.right));
    }
}

void History::clear() {
    points_.clear(), carried_.clear(), beside_.clear();
    std::ranges::fill(at_, none);
    std::ranges::fill(empty_, std::uint8_t{0});
}

void History::add(const Camera& camera, const float* planes) {
    if (camera != camera_) clear();
    camera_ = camera;
    const Projection projection(camera, static_cast<int>(height_), static_cast<int>(width_));
    const std::size_t pixels = at_.size();
    const Planes<const float> traced(layout_, planes, pixels);
    count(traced.mask);

    kept_points_.clear(), kept_carried_.clear();
    for (std::uint32_t row = 0; row < height_; ++row) {
        for (std::uint32_t begin = 0; begin < width_; begin += piece) {
            const std::uint32_t end = std::min(begin + piece, width_);
            if (is_nothing_known(traced.mask, std::size_t{row} * width_ + begin, end - begin)) continue;
            for (std::uint32_t column = begin; column < end; ++column) {
                const std::size_t i = std::size_t{row} * width_ + column;
                const auto kept = static_cast<std::uint32_t>(kept_points_.size());
                if (traced.mask[i] != 0) {
                    empty_[i] = traced.depth[i] == 0;
                    at_[i] = empty_[i] ? none : kept;
                    if (empty_[i]) continue;
                    const Vec3 normal = whole_normal(traced.normal_x[i], traced.normal_y[i]);
                    const auto at_row = static_cast<float>(row), at_column = static_cast<float>(column);
                    kept_points_.push_back({projection.point(at_row, at_column, traced.depth[i]),
                                            projection.in_scene(normal, at_row, at_column), reach_at(row, column)});
                    for (const std::size_t c : carried_components_) kept_carried_.push_back(planes[c * pixels + i]);
                } else if (at_[i] != none) {
                    keep(at_[i], reach_at(row, column));
                    at_[i] = kept;
                }
            }
        }
    }
    // Several points of a pixel say more about an edge that passes there than one.
    for (const std::uint32_t point : beside_) {
        if (kept_points_.size() >= pixels) break;
        keep(point, points_[point].reach);
    }
    beside_.clear();
    points_.swap(kept_points_), carried_.swap(kept_carried_);
}

bool History::is_nothing_known(const float* mask, std::size_t i, std::uint32_t count) const {
    std::uint32_t nothing = none, traced = 0;
    for (std::uint32_t k = 0; k < count; ++k) nothing &= at_[i + k], traced |= std::bit_cast<std::uint32_t>(mask[i + k]);
    return nothing == none && traced == 0;
}

void History::count(const float* mask) {
    std::ranges::fill(counts_, std::uint8_t{0});
    const std::uint32_t blocks = (width_ + block - 1) / block;
    for (std::uint32_t row = 0, i = 0; row < height_; ++row) {
        std::uint8_t* const of_row = counts_.data() + std::size_t{row / block} * blocks;
        for (std::uint32_t column = 0; column < width_; ++column, ++i) {
            of_row[column / block] += mask[i] != 0 || at_[i] != none || empty_[i] != 0;
        }
    }
}

std::uint32_t History::reach_at(std::uint32_t row, std::uint32_t column) const {
    static const std::array<std::uint32_t, block * block + 1> reaches = [] {
        std::array<std::uint32_t, block * block + 1> result{};
        for (std::size_t count = 1; count < result.size(); ++count) {
            const float radius = radius_per_distance * block / std::sqrt(static_cast<float>(count));
            result[count] = disc().reach(std::clamp(radius, 1.f, float{most_radius}));
        }
        return result;
    }();
    return reaches[counts_[std::size_t{row / block} * ((width_ + block - 1) / block) + column / block]];
}

void History::keep(std::uint32_t point, std::uint32_t reach) {
    kept_points_.push_back(points_[point]);
    kept_points_.back().reach = reach;
    const float* const values = carried_.data() + point * carried_components_.size();
    for (std::size_t k = 0; k < carried_components_.size(); ++k) kept_carried_.push_back(values[k]);
}

std::size_t History::expect(const Camera& camera, float* planes, float* off_center) {
    const Projection before(camera_, static_cast<int>(height_), static_cast<int>(width_));
    const Projection projection(camera, static_cast<int>(height_), static_cast<int>(width_));
    see(projection);
    cover();
    choose(before);
    camera_ = camera;
    const std::size_t pixels = at_.size(), surfaces = pixels - static_cast<std::size_t>(std::ranges::count(at_, none));
    const auto nothing = [&] {
        clear();
        std::fill_n(planes, static_cast<std::size_t>(layout_.width()) * pixels, 0.f), std::fill_n(off_center, pixels, 0.f);
        return std::size_t{0};
    };
    if (static_cast<float>(surfaces + beside_.size()) < least_still_seen * static_cast<float>(in_picture_)) return nothing();
    was_empty_.swap(empty_);

    const Planes<float> expected(layout_, planes, pixels);
    for_rows(0, static_cast<int>(height_), static_cast<int>(width_), [&](int y) {
        const auto row = static_cast<std::uint32_t>(y);
        const std::size_t first = std::size_t{row} * width_;
        for (int plane = 0; plane < layout_.width(); ++plane) std::fill_n(planes + static_cast<std::size_t>(plane) * pixels + first, width_, 0.f);
        expect_emptiness(before, projection, row);
        for (std::uint32_t column = 0; column < width_; ++column) {
            expected.mask[first + column] = empty_[first + column];
            off_center[first + column] = 0.5f * static_cast<float>(empty_[first + column]);
        }
        for (std::uint32_t column = 0; column < width_; ++column) {
            const std::size_t i = first + column;
            if (at_[i] == none) continue;
            const Vec3 normal = projection.on_screen(points_[at_[i]].normal, static_cast<float>(row), static_cast<float>(column));
            expected.mask[i] = 1, expected.depth[i] = depth_[i];
            expected.normal_x[i] = normal.x, expected.normal_y[i] = normal.y;
            off_center[i] = std::sqrt(off_center_[i]);
            const float* const values = carried_.data() + at_[i] * carried_components_.size();
            for (std::size_t k = 0; k < carried_components_.size(); ++k) planes[carried_components_[k] * pixels + i] = values[k];
        }
    });
    const std::size_t known = surfaces + static_cast<std::size_t>(std::count(empty_.begin(), empty_.end(), std::uint8_t{1}));
    return static_cast<float>(known) < least_known * static_cast<float>(pixels) ? nothing() : surfaces;
}

std::uint32_t History::pixel_at(const Projection::Seen& seen) const {
    const float row = seen.row + 0.5f, column = seen.column + 0.5f;  // NaN behind the camera
    if (!(row >= 0 && row < static_cast<float>(height_) && column >= 0 && column < static_cast<float>(width_))) return none;
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(row)) * width_ + static_cast<std::uint32_t>(static_cast<std::int32_t>(column));
}

void History::see(const Projection& projection) {
    sights_.clear(), in_picture_ = 0;
    std::ranges::fill(at_, none);
    for (std::uint32_t k = 0; k < points_.size(); ++k) {
        const Point& point = points_[k];
        const Projection::Seen seen = projection.seen(point.position);
        const std::uint32_t i = pixel_at(seen);
        if (i == none) continue;
        ++in_picture_;
        const Vec3 normal = projection.on_screen(point.normal, seen.row, seen.column);
        if (normal.z <= 0) continue;  // turned away
        const std::uint32_t row = i / width_, column = i - row * width_;
        const float down = seen.row - static_cast<float>(row), right = seen.column - static_cast<float>(column);
        const float side = projection.pixel_side(seen.depth), steep = side / std::max(normal.z, least_normal_z);
        sights_.push_back({k, i, static_cast<std::int32_t>(row), static_cast<std::int32_t>(column), seen.depth, -normal.x * steep,
                           normal.y * steep, down * down + right * right, same_surface * side});
        if (at_[i] == none || seen.depth > sights_[at_[i]].depth) at_[i] = static_cast<std::uint32_t>(sights_.size() - 1);
    }
}

std::size_t History::covered_at(std::int32_t row, std::int32_t column) const {
    return static_cast<std::size_t>(row + most_radius) * (width_ + 2 * most_radius) + static_cast<std::size_t>(column + most_radius);
}

void History::cover() {
    std::ranges::fill(nearest_, -1.f);
    std::ranges::fill(sides_, std::uint8_t{0});
    const Offset* const offsets = disc().offsets.data();
    // Of each pixel, the disc of the nearest point alone: those of others there would say the same.
    const auto each = [&](auto use) {
        for (std::size_t k = 0; k < sights_.size(); ++k) {
            const Sight& sight = sights_[k];
            if (at_[sight.pixel] == k) use(sight, covered_at(sight.row, sight.column), points_[sight.point].reach);
        }
    };
    each([&](const Sight& sight, std::size_t center, std::uint32_t reach) {
        float* const nearest = nearest_.data() + center;
        for (std::uint32_t k = 0; k < reach; ++k) {
            float& there = nearest[steps_[k]];
            there = std::max(there, sight.depth_at(offsets[k].right, offsets[k].down));
        }
    });
    each([&](const Sight& sight, std::size_t center, std::uint32_t reach) {
        const float* const nearest = nearest_.data() + center;
        std::uint8_t* const sides = sides_.data() + center;
        for (std::uint32_t k = 1; k < reach; ++k) {
            const bool is_same = sight.depth_at(offsets[k].right, offsets[k].down) >= nearest[steps_[k]] - sight.tolerance;
            sides[steps_[k]] |= is_same ? offsets[k].side : std::uint8_t{0};
        }
    });
}

bool History::is_inside(std::size_t covered) const { return disc().is_inside[sides_[covered]] != 0; }

void History::choose(const Projection& before) {
    std::ranges::fill(at_, none);
    std::ranges::fill(overrun_, std::uint8_t{0});
    beside_.clear();
    for (const Sight& sight : sights_) {
        const std::size_t covered = covered_at(sight.row, sight.column), i = sight.pixel;
        if (!is_inside(covered)) {
            overrun(sight, before);
        } else if (sight.depth < nearest_[covered] - sight.tolerance) {
            continue;  // hidden
        }
        const bool is_better = at_[i] == none || sight.depth > depth_[i] + sight.tolerance ||
                               (sight.depth > depth_[i] - sight.tolerance && sight.off_center < off_center_[i]);
        if (!is_better) {
            beside_.push_back(sight.point);
            continue;
        }
        if (at_[i] != none) beside_.push_back(at_[i]);
        at_[i] = sight.point, depth_[i] = sight.depth, off_center_[i] = sight.off_center;
    }
}

void History::overrun(const Sight& sight, const Projection& before) {
    const Projection::Seen was = before.seen(points_[sight.point].position);
    const float down = static_cast<float>(sight.row) - was.row, right = static_cast<float>(sight.column) - was.column;
    const float squared = overrun_share * overrun_share * (down * down + right * right);
    for (const Offset& offset : disc().offsets) {
        if (static_cast<float>(offset.squared) > squared) break;
        const std::int32_t row = sight.row + static_cast<std::int32_t>(offset.down), column = sight.column + static_cast<std::int32_t>(offset.right);
        const bool is_in_picture = row >= 0 && row < static_cast<std::int32_t>(height_) && column >= 0 && column < static_cast<std::int32_t>(width_);
        if (is_in_picture) overrun_[static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column)] = 1;
    }
}

void History::expect_emptiness(const Projection& before, const Projection& projection, std::uint32_t row) {
    const auto y = static_cast<std::int32_t>(row);
    const std::size_t first = std::size_t{row} * width_;
    // Nothing says how far away emptiness is: it is taken to move as what lies at the middle of the scene.
    const auto was_at = [&](std::uint32_t column) {
        return before.seen(projection.point(static_cast<float>(row), static_cast<float>(column), 0.5f));
    };
    const auto passes_by = [&](std::uint32_t column) {
        Ray ray;
        return !projection.ray({y, static_cast<std::int32_t>(column)}, ray);
    };
    const auto width = static_cast<std::int32_t>(width_), outside = static_cast<std::int32_t>(height_) * width;
    const auto rows = static_cast<float>(height_), columns = static_cast<float>(width_);
    const std::array<std::uint8_t, 256>& is_inside = disc().is_inside;
    const std::uint8_t* const sides = sides_.data() + covered_at(y, 0);
    Projection::Seen to = was_at(0);
    bool end_passes_by = passes_by(0);
    for (std::uint32_t begin = 0; begin < width_; begin += piece) {
        const Projection::Seen from = std::exchange(to, was_at(begin + piece));
        const bool begin_passes_by = std::exchange(end_passes_by, passes_by(begin + piece));
        const bool any_passes_by = begin_passes_by || end_passes_by;  // the sphere covers one part of a row
        const float down = (to.row - from.row) / piece, right = (to.column - from.column) / piece;
        // In which pixel the k-th of the piece was, or outside.
        const auto was = [&](std::uint32_t k) {
            const float at_row = from.row + down * static_cast<float>(k) + 0.5f, at_column = from.column + right * static_cast<float>(k) + 0.5f;
            const bool is_in_picture = (at_row >= 0) & (at_row < rows) & (at_column >= 0) & (at_column < columns);
            const auto i = static_cast<std::int32_t>(is_in_picture ? at_row : 0) * width + static_cast<std::int32_t>(is_in_picture ? at_column : 0);
            return is_in_picture ? i : outside;
        };
        const std::size_t i = first + begin;
        const std::uint32_t count = std::min(piece, width_ - begin);
        const std::int32_t was_first = was(0);
        const bool was_in_a_row = was_first != outside && was(count - 1) == was_first + static_cast<std::int32_t>(count) - 1;
        if (was_in_a_row && !any_passes_by && is_nothing_here(i, sides + begin, count)) {
            std::copy_n(was_empty_.data() + was_first, count, empty_.data() + i);
            continue;
        }
        for (std::uint32_t k = 0; k < count; ++k) {
            const bool may_be = at_[i + k] == none && overrun_[i + k] == 0 && !is_inside[sides[begin + k]];
            empty_[i + k] = may_be && (was_empty_[static_cast<std::size_t>(was(k))] || (any_passes_by && passes_by(begin + k)));
        }
    }
}

bool History::is_nothing_here(std::size_t i, const std::uint8_t* sides, std::uint32_t count) const {
    std::uint32_t nothing = none, marks = 0;
    for (std::uint32_t k = 0; k < count; ++k) nothing &= at_[i + k], marks |= std::uint32_t{overrun_[i + k]} | sides[k];
    return nothing == none && marks == 0;
}

std::size_t History::bytes() const {
    return (points_.capacity() + kept_points_.capacity()) * sizeof(Point) +
           (carried_.capacity() + kept_carried_.capacity() + off_center_.capacity() + depth_.capacity()) * sizeof(float) +
           (at_.capacity() + beside_.capacity()) * sizeof(std::uint32_t) + empty_.capacity() + was_empty_.capacity() +
           overrun_.capacity() + counts_.capacity() + sights_.capacity() * sizeof(Sight) + nearest_.capacity() * sizeof(float) +
           sides_.capacity() + steps_.capacity() * sizeof(std::int32_t);
}

}  // namespace bob
