#include "picture/history.h"

#include <algorithm>
#include <array>
#include <cmath>
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

/// Where emptiness was is found for every so many pixels of a row, and lies on straight lines between.
constexpr std::uint32_t piece = 16;

/// A share of the way that a point moved: as far around it, nothing is known to be empty any more.
constexpr float overrun_share = 0.5f;

/// Where fewer of the points in the picture are not turned away or hidden, the camera has jumped: what it sees now is new.
constexpr float least_still_seen = 0.75f;

/// The mean direction of the centres of discs around a pixel is shorter where it is inside.
constexpr float one_sided = 0.6f;

/// Where discs reach from their centres, the nearest pixels first.
struct Offset {
    std::int32_t right, down;
    float squared, unit_right, unit_down;
};
const std::vector<Offset>& offsets() {
    static const std::vector<Offset> all = [] {
        std::vector<Offset> result;
        for (int down = -most_radius; down <= most_radius; ++down) {
            for (int right = -most_radius; right <= most_radius; ++right) {
                const auto squared = static_cast<float>(right * right + down * down);
                const float inverse = squared > 0 ? 1 / std::sqrt(squared) : 0;
                result.push_back({right, down, squared, static_cast<float>(right) * inverse, static_cast<float>(down) * inverse});
            }
        }
        std::ranges::stable_sort(result, {}, &Offset::squared);
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

bool History::Cover::is_inside() const {
    return count >= 2 && right * right + down * down < one_sided * one_sided * count * count;
}

History::History(const Layout& layout, std::uint32_t height, std::uint32_t width)
    : layout_(layout), height_(height), width_(width), at_(std::size_t{height} * width, none), off_center_(at_.size()),
      depth_(at_.size()), empty_(at_.size()), was_empty_(at_.size()) {
    std::size_t at = 0;
    for (const Channel& channel : layout_) {
        const bool is_derived = channel == channels::mask || channel == channels::depth || channel == channels::normal;
        for (int component = 0; component < channel.components; ++component, ++at) {
            if (!is_derived) carried_components_.push_back(at);
        }
    }
    (void)Planes<float>(layout_, nullptr, 0);  // throws where one is missing
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

    const std::uint32_t blocks = (width_ + block - 1) / block;
    std::vector<std::uint8_t> counts(std::size_t{blocks} * ((height_ + block - 1) / block));
    for (std::uint32_t row = 0, i = 0; row < height_; ++row) {
        std::uint8_t* const of_row = counts.data() + std::size_t{row / block} * blocks;
        for (std::uint32_t column = 0; column < width_; ++column, ++i) {
            of_row[column / block] += traced.mask[i] != 0 || at_[i] != none || empty_[i] != 0;
        }
    }
    std::array<float, block * block + 1> radii{};
    for (std::size_t count = 1; count < radii.size(); ++count) {
        radii[count] = std::clamp(radius_per_distance * block / std::sqrt(static_cast<float>(count)), 1.f, float{most_radius});
    }
    const auto radius_at = [&](std::uint32_t row, std::uint32_t column) {
        return radii[counts[std::size_t{row / block} * blocks + column / block]];
    };

    kept_points_.clear(), kept_carried_.clear();
    for (std::uint32_t row = 0, i = 0; row < height_; ++row) {
        for (std::uint32_t column = 0; column < width_; ++column, ++i) {
            const auto kept = static_cast<std::uint32_t>(kept_points_.size());
            if (traced.mask[i] != 0) {
                empty_[i] = traced.depth[i] == 0;
                at_[i] = empty_[i] ? none : kept;
                if (empty_[i]) continue;
                const Vec3 normal = whole_normal(traced.normal_x[i], traced.normal_y[i]);
                const auto at_row = static_cast<float>(row), at_column = static_cast<float>(column);
                kept_points_.push_back({projection.point(at_row, at_column, traced.depth[i]),
                                        projection.in_scene(normal, at_row, at_column), radius_at(row, column)});
                for (const std::size_t c : carried_components_) kept_carried_.push_back(planes[c * pixels + i]);
            } else if (at_[i] != none) {
                keep(at_[i], radius_at(row, column));
                at_[i] = kept;
            }
        }
    }
    // Several points of a pixel say more about an edge that passes there than one.
    for (const std::uint32_t point : beside_) {
        if (kept_points_.size() >= pixels) break;
        keep(point, points_[point].radius);
    }
    beside_.clear();
    points_.swap(kept_points_), carried_.swap(kept_carried_);
}

void History::keep(std::uint32_t point, float radius) {
    kept_points_.push_back(points_[point]);
    kept_points_.back().radius = radius;
    const auto values = carried_.begin() + static_cast<std::ptrdiff_t>(point * carried_components_.size());
    kept_carried_.insert(kept_carried_.end(), values, values + static_cast<std::ptrdiff_t>(carried_components_.size()));
}

std::size_t History::expect(const Camera& camera, float* planes, float* off_center) {
    const Projection projection(camera, static_cast<int>(height_), static_cast<int>(width_));
    expect_emptiness(projection);
    see(projection);
    cover();
    choose();
    camera_ = camera;
    const std::size_t pixels = at_.size();
    std::size_t surfaces = pixels - static_cast<std::size_t>(std::ranges::count(at_, none));
    if (static_cast<float>(surfaces + beside_.size()) < least_still_seen * static_cast<float>(in_picture_)) {
        clear();
        surfaces = 0;
    }

    const Planes<float> expected(layout_, planes, pixels);
    for_rows(0, static_cast<int>(height_), static_cast<int>(width_), [&](int row) {
        const std::size_t first = static_cast<std::size_t>(row) * width_;
        for (int plane = 0; plane < layout_.width(); ++plane) std::fill_n(planes + static_cast<std::size_t>(plane) * pixels + first, width_, 0.f);
        for (std::uint32_t column = 0; column < width_; ++column) {
            const std::size_t i = first + column;
            if (at_[i] == none) {
                expected.mask[i] = empty_[i];
                off_center[i] = empty_[i] ? 0.5f : 0.f;
                continue;
            }
            empty_[i] = 0;
            const Vec3 normal = projection.on_screen(points_[at_[i]].normal, static_cast<float>(row), static_cast<float>(column));
            expected.mask[i] = 1, expected.depth[i] = depth_[i];
            expected.normal_x[i] = normal.x, expected.normal_y[i] = normal.y;
            off_center[i] = std::sqrt(off_center_[i]);
            const float* const values = carried_.data() + at_[i] * carried_components_.size();
            for (std::size_t k = 0; k < carried_components_.size(); ++k) planes[carried_components_[k] * pixels + i] = values[k];
        }
    });
    return surfaces;
}

void History::expect_emptiness(const Projection& projection) {
    const Projection before(camera_, static_cast<int>(height_), static_cast<int>(width_));
    // Nothing says how far away emptiness is: it is taken to move as what lies at the middle of the scene.
    const auto was_at = [&](std::uint32_t row, std::uint32_t column) {
        return before.seen(projection.point(static_cast<float>(row), static_cast<float>(column), 0.5f));
    };
    was_empty_.swap(empty_);
    for_rows(0, static_cast<int>(height_), static_cast<int>(width_), [&](int y) {
        const auto row = static_cast<std::uint32_t>(y);
        for (std::uint32_t first = 0; first < width_; first += piece) {
            const auto from = was_at(row, first), to = was_at(row, first + piece);
            const float down = (to.row - from.row) / piece, right = (to.column - from.column) / piece;
            for (std::uint32_t k = 0; k < std::min(piece, width_ - first); ++k) {
                const std::uint32_t column = first + k;
                const std::uint32_t was = pixel_at({from.row + down * static_cast<float>(k), from.column + right * static_cast<float>(k), 0});
                Ray ray;  // none, where it passes the scene by
                empty_[std::size_t{row} * width_ + column] =
                    (was != none && was_empty_[was]) ||
                    !projection.ray({static_cast<std::int32_t>(row), static_cast<std::int32_t>(column)}, ray);
            }
        }
    });
}

std::uint32_t History::pixel_at(const Projection::Seen& seen) const {
    const float row = seen.row + 0.5f, column = seen.column + 0.5f;  // NaN behind the camera
    if (!(row >= 0 && row < static_cast<float>(height_) && column >= 0 && column < static_cast<float>(width_))) return none;
    return static_cast<std::uint32_t>(row) * width_ + static_cast<std::uint32_t>(column);
}

void History::see(const Projection& projection) {
    const Projection before(camera_, static_cast<int>(height_), static_cast<int>(width_));
    sights_.clear(), in_picture_ = 0;
    std::ranges::fill(at_, none);
    for (std::uint32_t k = 0; k < points_.size(); ++k) {
        const Point& point = points_[k];
        const Projection::Seen seen = projection.seen(point.position);
        const std::uint32_t i = pixel_at(seen);
        if (i == none) continue;
        const std::uint32_t row = i / width_, column = i % width_;
        ++in_picture_;
        const Vec3 normal = projection.on_screen(point.normal, seen.row, seen.column);
        if (normal.z <= 0) continue;  // turned away
        const Projection::Seen was = before.seen(point.position);
        const float down = seen.row - static_cast<float>(row), right = seen.column - static_cast<float>(column);
        const float down_since = seen.row - was.row, right_since = seen.column - was.column;
        const float side = projection.pixel_side(seen.depth), steep = side / std::max(normal.z, least_normal_z);
        sights_.push_back({k, static_cast<std::int32_t>(row), static_cast<std::int32_t>(column), seen.depth, -normal.x * steep,
                           normal.y * steep, down * down + right * right,
                           down_since * down_since + right_since * right_since, same_surface * side});
        if (at_[i] == none || seen.depth > sights_[at_[i]].depth) at_[i] = static_cast<std::uint32_t>(sights_.size() - 1);
    }
}

std::size_t History::covering(std::int32_t row, std::int32_t column) const {
    return static_cast<std::size_t>(row + most_radius) * (width_ + 2 * most_radius) + static_cast<std::size_t>(column + most_radius);
}

void History::cover() {
    covers_.assign(std::size_t{height_ + 2 * most_radius} * (width_ + 2 * most_radius), Cover{});
    const auto along = static_cast<std::ptrdiff_t>(width_ + 2 * most_radius);
    const std::span<const Offset> all = offsets();
    // Of each pixel, the disc of the nearest point alone: those of others there would say the same.
    const auto each = [&](auto use) {
        for (const std::uint32_t nearest : at_) {
            if (nearest == none) continue;
            const Sight& sight = sights_[nearest];
            Cover* const center = covers_.data() + covering(sight.row, sight.column);
            const float radius = points_[sight.point].radius, squared = radius * radius;
            for (const Offset& offset : all) {
                if (offset.squared > squared) break;
                const float depth = sight.depth + sight.deeper_right * static_cast<float>(offset.right) +
                                    sight.deeper_down * static_cast<float>(offset.down);
                use(sight, offset, depth, center[along * offset.down + offset.right]);
            }
        }
    };
    each([](const Sight&, const Offset&, float depth, Cover& cover) { cover.depth = std::max(cover.depth, depth); });
    each([](const Sight& sight, const Offset& offset, float depth, Cover& cover) {
        if (offset.squared == 0 || depth < cover.depth - sight.tolerance) return;
        cover.count += 1, cover.right += offset.unit_right, cover.down += offset.unit_down;
    });
}

void History::choose() {
    std::ranges::fill(at_, none);
    beside_.clear();
    for (const Sight& sight : sights_) {
        const Cover& cover = covers_[covering(sight.row, sight.column)];
        const std::size_t i = static_cast<std::size_t>(sight.row) * width_ + static_cast<std::size_t>(sight.column);
        if (!cover.is_inside()) {
            overrun(sight);
        } else if (sight.depth < cover.depth - sight.tolerance) {
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
    for (std::uint32_t row = 0, i = 0; row < height_; ++row) {
        const Cover* const of_row = covers_.data() + covering(static_cast<std::int32_t>(row), 0);
        for (std::uint32_t column = 0; column < width_; ++column, ++i) {
            if (of_row[column].is_inside()) empty_[i] = 0;
        }
    }
}

void History::overrun(const Sight& sight) {
    for (const Offset& offset : offsets()) {
        if (offset.squared > overrun_share * overrun_share * sight.moved) break;
        const std::int32_t row = sight.row + offset.down, column = sight.column + offset.right;
        const bool is_inside = row >= 0 && row < static_cast<std::int32_t>(height_) && column >= 0 && column < static_cast<std::int32_t>(width_);
        if (is_inside) empty_[static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column)] = 0;
    }
}

std::size_t History::bytes() const {
    return (points_.capacity() + kept_points_.capacity()) * sizeof(Point) +
           (carried_.capacity() + kept_carried_.capacity() + off_center_.capacity() + depth_.capacity()) * sizeof(float) +
           (at_.capacity() + beside_.capacity()) * sizeof(std::uint32_t) + empty_.capacity() + was_empty_.capacity() +
           sights_.capacity() * sizeof(Sight) + covers_.capacity() * sizeof(Cover);
}

}  // namespace bob
