#include "shapes/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "base/interruption.h"

namespace bob {
namespace {

/// How far beyond a hit the rest of a line begins.
constexpr float step = 4e-6f;

/// Lines with more crossings are ignored.
constexpr std::size_t most_crossings = 1024;

/// Calls met(number, side) at each crossing of each ray after its first hit, in order, until that returns false.
template <class Met>
void follow(const Shape& shape, const SidesOf& sides, std::vector<Ray> rays, std::vector<std::uint32_t> numbers, Met met) {
    std::vector<Hit> hits;
    std::vector<Side> at;
    for (std::size_t crossing = 0; !rays.empty() && crossing < most_crossings; ++crossing) {
        Interruption::check();
        hits.resize(rays.size());
        shape.closest_hits(rays, hits);
        std::size_t left = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (hits[i].primitive == no_primitive) continue;
            rays[left] = rays[i], hits[left] = hits[i], numbers[left] = numbers[i], ++left;
        }
        rays.resize(left), hits.resize(left), numbers.resize(left), at.resize(left);
        sides(rays, hits, at);
        std::size_t going_on = 0;
        for (std::size_t i = 0; i < left; ++i) {
            if (!met(numbers[i], at[i])) continue;
            const float t = hits[i].t + step / length(rays[i].direction);
            rays[going_on] = {rays[i].origin + t * rays[i].direction, rays[i].direction}, numbers[going_on] = numbers[i], ++going_on;
        }
        rays.resize(going_on), numbers.resize(going_on);
    }
}

std::vector<std::uint32_t> first_numbers(std::size_t count) {
    std::vector<std::uint32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0u);
    return numbers;
}

/// The mean of the colours in the fullest of the cells of a coarse grid.
Vec3 most_frequent(std::span<const Vec3> colors) {
    std::map<std::array<int, 3>, std::pair<std::size_t, Vec3>> cells;
    for (const Vec3 color : colors) {
        const auto cell = [](float x) { return static_cast<int>(std::lround(8 * x)); };
        auto& [count, sum] = cells[{cell(color.x), cell(color.y), cell(color.z)}];
        ++count, sum = sum + color;
    }
    const auto fullest = std::max_element(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
    if (fullest == cells.end()) return {1, 1, 1};
    const auto& [count, sum] = fullest->second;
    return (1 / static_cast<float>(count)) * sum;
}

Vec3 color_of(const Shape& shape, std::span<const Ray> lines) {
    if (!shape.is_colored()) return {1, 1, 1};
    std::vector<Ray> rays(lines.begin(), lines.end());
    std::vector<Hit> hits(rays.size());
    shape.closest_hits(rays, hits);
    std::size_t count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].primitive == no_primitive) continue;
        rays[count] = rays[i], hits[count] = hits[i], ++count;
    }
    const std::vector<float> widths(count, 0.02f);
    std::vector<Vec3> colors(count);
    shape.colors({rays.data(), count}, {hits.data(), count}, widths, colors);
    return most_frequent(colors);
}

}  // namespace

Solid find_solid(const Shape& shape, std::size_t parts, std::span<const Ray> lines, const SidesOf& sides) {
    std::vector<std::vector<Side>> crossings(lines.size());
    follow(shape, sides, {lines.begin(), lines.end()}, first_numbers(lines.size()), [&](std::uint32_t line, const Side& side) {
        crossings[line].push_back(side);
        return true;
    });
    std::size_t met = 0, odd = 0, overlapping = 0;
    std::vector<std::int32_t> agree(parts), differ(parts);
    for (const auto& line : crossings) {
        if (line.empty() || line.size() == most_crossings) continue;
        ++met, odd += line.size() % 2;
        if (line.size() % 2) continue;
        for (std::size_t i = 0; i < line.size(); ++i) ++(line[i].is_front == (i % 2 == 0) ? agree : differ)[line[i].part];
    }
    Solid solid;
    solid.is_closed = met > 0 && 100 * odd <= met;
    solid.turned.resize(parts);
    // Lines through overlapping parts count wrongly, so only a clear majority turns a part.
    for (std::size_t part = 0; part < parts; ++part) solid.turned[part] = differ[part] > 2 * agree[part];
    for (const auto& line : crossings) {
        int depth = 0;
        bool is_simple = true;
        for (const Side& side : line) depth += solid.is_entered(side) ? 1 : -1, is_simple = is_simple && depth >= 0 && depth <= 1;
        overlapping += line.size() % 2 == 0 && !is_simple;
    }
    solid.overlaps = 500 * overlapping > met;
    if (std::find(solid.turned.begin(), solid.turned.end(), 1) == solid.turned.end()) solid.turned.clear();
    solid.color = color_of(shape, lines);
    return solid;
}

bool SurfaceShape::prepare_inside() const {
    solid_.prepare([&] { return find_solid(); });
    return solid_.get()->is_closed;
}

void SurfaceShape::starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const {
    const Solid& solid = *solid_.get();
    std::vector<Side> first(rays.size());
    sides(rays, hits, first);
    for (std::size_t i = 0; i < rays.size(); ++i) inside[i] = !solid.is_entered(first[i]);
    if (!solid.overlaps) return;
    std::vector<int> left(rays.size());  // how many times more often a ray leaves than enters
    std::vector<Ray> open;
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        if (inside[i]) continue;
        left[i] = -1;
        const float t = hits[i].t + step / length(rays[i].direction);
        open.push_back({rays[i].origin + t * rays[i].direction, rays[i].direction}), numbers.push_back(i);
    }
    const auto sides_of = [&](std::span<const Ray> some, std::span<const Hit> met, std::span<Side> at) { sides(some, met, at); };
    follow(*this, sides_of, std::move(open), std::move(numbers), [&](std::uint32_t ray, const Side& side) {
        left[ray] += solid.is_entered(side) ? -1 : 1;
        return left[ray] <= 0;
    });
    for (std::size_t i = 0; i < rays.size(); ++i) inside[i] = inside[i] || left[i] > 0;
}

void SurfaceShape::colors_inside(std::span<const Vec3> points, std::span<Vec3> colors) const {
    std::fill_n(colors.begin(), points.size(), solid_.get()->color);
}

Ray line_through(Vec3 point, Vec3 normal, std::uint32_t number) {
    // Points of a spiral on the sphere, which no axis of a shape is aligned with.
    constexpr float golden = 2.39996323f;
    const auto turn = static_cast<float>(number);
    const float z = 2 * std::fmod(0.5f + 0.6180339887f * turn, 1.f) - 1, ring = std::sqrt(std::max(0.f, 1 - z * z));
    const Vec3 tilt{ring * std::cos(golden * turn), ring * std::sin(golden * turn), z};
    Vec3 direction = normalized(0.6f * tilt - normalized(normal));
    if (dot(direction, direction) == 0) direction = tilt;
    return {point - 2.5f * direction, direction};
}

}  // namespace bob
