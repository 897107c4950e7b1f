/// Samples on their way into planes, cameras and pixel orders, for pictures of odd sizes.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "fuzz/fuzz.h"
#include "picture/camera.h"
#include "picture/gbuffer.h"
#include "sampling/adaptive.h"
#include "sampling/order.h"
#include "sampling/squares.h"

namespace {

/// Marks pixels of the picture; each may come once.
class Seen {
public:
    Seen(std::uint32_t height, std::uint32_t width) : height_(height), width_(width), seen_(height * width) {}

    void add(bob::Pixel pixel) {
        const bool inside = pixel.row >= 0 && pixel.row < static_cast<int>(height_) && pixel.column >= 0 && pixel.column < static_cast<int>(width_);
        fuzz::expect(inside, "pixels of the picture");
        const std::size_t i = static_cast<std::size_t>(pixel.row) * width_ + static_cast<std::size_t>(pixel.column);
        fuzz::expect(!seen_[i], "each pixel once");
        seen_[i] = true;
        ++count_;
    }
    [[nodiscard]] bool all() const { return count_ == seen_.size(); }

private:
    std::uint32_t height_, width_;
    std::vector<bool> seen_;
    std::size_t count_ = 0;
};

std::vector<bob::Pixel> some_of(fuzz::Source& source, std::uint32_t height, std::uint32_t width) {
    constexpr std::string_view names[] = {"uniform", "lattice"};
    const std::string_view name = names[source.below(2)];
    const bob::Order order = bob::make_order(name, source.raw<std::uint64_t>(), height, width);
    std::vector<bob::Pixel> all(height * width);
    order(0, all);
    Seen seen(height, width);
    for (const bob::Pixel pixel : all) seen.add(pixel);
    const std::uint32_t start = source.raw<std::uint32_t>() % static_cast<std::uint32_t>(all.size() + 1);
    std::vector<bob::Pixel> rest(std::min<std::size_t>(all.size() - start, source.byte()));
    order(start, rest);
    for (std::size_t i = 0; i < rest.size(); ++i) {
        fuzz::expect(rest[i].row == all[start + i].row && rest[i].column == all[start + i].column, "the same pixels from any start");
    }
    return rest;
}

/// Checks an order on a picture of any values, traced round by round.
void in_rounds(fuzz::Source& source, bob::RoundOrder& order) {
    const std::uint32_t height = order.height(), width = order.width();
    const bob::Layout& layout = bob::gbuffer_layout();
    std::vector<float> planes(static_cast<std::size_t>(layout.width()) * height * width);
    Seen seen(height, width);
    for (auto round = order.next(layout, planes.data()); !round.empty(); round = order.next(layout, planes.data())) {
        for (const bob::Pixel pixel : round) {
            seen.add(pixel);
            std::vector<float> sample(static_cast<std::size_t>(layout.width()));
            for (float& value : sample) value = static_cast<float>(source.number());
            bob::scatter(layout, {&pixel, 1}, sample.data(), sample.size(), planes.data(), height, width);
        }
    }
    fuzz::expect(seen.all(), "all pixels in the end");
}

void scatter(fuzz::Source& source, const std::vector<bob::Pixel>& pixels, std::size_t height, std::size_t width) {
    constexpr std::string_view names[] = {"mask,gray,depth,normal", "mask", "mask,normal,gray", "mask,depth"};
    const bob::Layout layout(names[source.below(2)]);
    const auto components = static_cast<std::size_t>(layout.width());
    std::vector<float> samples(pixels.size() * components), planes(components * height * width);
    for (float& value : samples) value = static_cast<float>(source.number());
    const std::size_t added = bob::scatter(layout, pixels, samples.data(), components, planes.data(), height, width);
    fuzz::expect(added == pixels.size(), "all pixels counted");
    fuzz::expect(bob::scatter(layout, pixels, samples.data(), components, planes.data(), height, width) == 0, "no pixel counted twice");
    const bob::Layout wanted(names[source.below(2)]);
    std::vector<float> storage;
    try {
        const float* const selected = bob::select(layout, planes.data(), wanted, height * width, storage);
        fuzz::expect(std::equal(selected, selected + height * width, planes.begin()), "the mask first");
    } catch (const std::invalid_argument&) {  // a channel that is not there
    }
}

void cameras(fuzz::Source& source, const std::vector<bob::Pixel>& pixels, int height, int width) {
    const auto number = [&](double low, double high) { return static_cast<float>(std::clamp(source.number(), low, high)); };
    bob::Camera camera{number(-1e6, 1e6), number(-90, 90), number(-1e6, 1e6), number(1e-3, 1e6), number(-1e3, 1e3), number(-1e3, 1e3)};
    float sum = camera.azimuth_degrees + camera.elevation_degrees + camera.roll_degrees + camera.zoom + camera.pan_x + camera.pan_y;
    if (source.flag()) {
        sum += camera.fov_degrees = number(0.1, 175);
        if (source.flag()) {  // it looks along an axis at most half across
            const double at[3] = {number(-1e6, 1e6), number(-1e6, 1e6), number(-1e6, 1e6)};
            camera.standpoint = {{at[0], at[1], at[2]}, {at[0] + 1, at[1] + number(-1, 1), at[2] + number(-1, 1)}, {0, 0, 1}};
            for (const double x : camera.standpoint->target) sum += static_cast<float>(x);
        }
    }
    if (std::isnan(sum)) return;
    const bob::Projection projection(camera, height, width);
    for (const bob::Pixel pixel : pixels) {
        bob::Ray ray;
        if (!projection.ray(pixel, ray)) continue;
        fuzz::expect(std::fabs(length(ray.direction) - 1) < 1e-5f && length(ray.origin) < 1.01f, "a ray from the unit sphere");
        const bob::Projection::Seen seen = projection.seen(ray.origin);
        fuzz::expect(seen.depth >= 0 && seen.depth <= 1, "a depth within 0..1");
        const bob::Vec3 point = projection.point(static_cast<float>(pixel.row), static_cast<float>(pixel.column), source.byte() / 255.f);
        fuzz::expect(std::isfinite(dot(point, point)), "a point");
    }
}

}  // namespace

FUZZ(picture) {
    const std::uint32_t height = 1 + source.raw<std::uint16_t>() % 200, width = 1 + source.raw<std::uint16_t>() % (800 / height + 1);
    const std::vector<bob::Pixel> pixels = some_of(source, height, width);
    scatter(source, pixels, height, width);
    cameras(source, pixels, static_cast<int>(height), static_cast<int>(width));
    bob::AdaptiveOrder adaptive(source.raw<std::uint64_t>(), height, width);
    in_rounds(source, adaptive);
    bob::SquaresOrder squares(height, width);
    in_rounds(source, squares);
}
