#include "shapes/implicit/implicit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/interruption.h"
#include "base/thread_memory.h"
#include "formula/jumps.h"
#include "formula/scratch.h"
#include "formula/sequenced.h"
#include "shapes/batches.h"
#include "shapes/implicit/visits.h"

namespace bob {
namespace {

/// Roots closer together than this are not separated, in the surface's own coordinates.
constexpr float finest = 1e-6f;

/// Segments per batch; work can be interrupted between batches.
constexpr std::size_t most_at_once = 256;

/// The sphere within the cube around a box.
Sphere sphere_in(const Bounds& box) {
    Sphere sphere{{}, 0};
    for (int axis = 0; axis < 3; ++axis) {
        sphere.center[axis] = (box.low[axis] + box.high[axis]) / 2;
        sphere.radius = std::max(sphere.radius, box.high[axis] - box.low[axis]);
    }
    sphere.radius *= 0.5;
    return sphere;
}

/// f at center + radius * (x, y, z), cut by the box if it extends beyond it.
Expression in_unit_sphere(const Expression& f, const Bounds& bounds, const Sphere& sphere) {
    const auto& [center, half_side] = sphere;
    Graph graph;
    const Value axes[3] = {graph.x(), graph.y(), graph.z()};
    Value p[3];
    for (int axis = 0; axis < 3; ++axis) p[axis] = axes[axis] * half_side + center[axis];
    Value value = graph.substitute(without_modulo(f), p[0], p[1], p[2]);
    for (int axis = 0; axis < 3; ++axis) {
        const double half = 0.5 * (bounds.high[axis] - bounds.low[axis]) / half_side;
        value = max(value, abs(axes[axis]) - half * (1 - 1e-6));
    }
    return graph.expression(value);
}

ColorTape in_unit_sphere(const ColorFormula& color, const Sphere& sphere) {
    Graph graph;
    const Value axes[3] = {graph.x(), graph.y(), graph.z()};
    Value p[3];
    for (int axis = 0; axis < 3; ++axis) p[axis] = axes[axis] * sphere.radius + sphere.center[axis];
    return ColorTape(graph.color_formula(graph.substitute(color, p[0], p[1], p[2])));
}

/// Bounds of the derivative along a direction, from bounds of the gradient.
struct Slopes {
    float least = 0, most = 0;

    Slopes(const Cells::Cell& cell, const float (&direction)[3]) {
        float size = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float a = cell.least_slope[axis] * direction[axis], b = cell.most_slope[axis] * direction[axis];
            least += std::min(a, b);
            most += std::max(a, b);
            size += std::fabs(a) + std::fabs(b);
        }
        least -= 1e-6f * size;
        most += 1e-6f * size;  // NaN propagates to both
    }
};

}  // namespace

Implicit::Implicit(const Expression& f, const Bounds& bounds, const ColorFormula* color)
    : Shape(sphere_in(bounds)), cells_(in_unit_sphere(f, bounds, sphere())) {
    if (color) painting_.emplace(in_unit_sphere(*color, sphere()), cells_);
}

void Implicit::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    void* const memory = scratch(cells_.max_registers());
    std::fill(hits.begin(), hits.end(), Hit{});
    struct Memory {
        std::vector<Walk> walks;
        std::array<Segment, most_at_once> segments;
        std::array<float, most_at_once> from;
    };
    auto& [walks, segments, from] = thread_memory<Memory>();
    const std::vector<Cells::Cell>& cells = cells_.cells();
    const auto find_roots = [&](std::uint32_t code, Rays some) {
        Interruption::check();
        for (std::size_t i = 0; i < some.size(); ++i) {
            const Walk& walk = walks[some[i]];
            // Segments overlap by the cells' margin, so no root falls between two.
            const float margin = 0.5f * Cells::margin / walk.length;
            from[i] = std::max(0.f, walk.enter - margin);
            const Slopes slopes(cells[walk.cell], walk.direction);
            Segment& segment = segments[i];
            for (int axis = 0; axis < 3; ++axis) {
                segment.origin[axis] = walk.origin[axis] + from[i] * walk.direction[axis];
                segment.direction[axis] = walk.direction[axis];
            }
            segment.t_end = walk.leave + margin - from[i];
            segment.finest = finest / walk.length;
            segment.least_slope = slopes.least;
            segment.most_slope = slopes.most;
        }
        formula_kernels_for(some.size()).first_roots(cells_.code(code), segments.data(), some.size(), memory);
        for (std::size_t i = 0; i < some.size(); ++i) {
            const Segment& segment = segments[i];
            Walk& walk = walks[some[i]];
            walk.unresolved |= segment.unresolved;
            if (!segment.found) continue;
            hits[some[i]] = {from[i] + segment.t, 0, 0, walk.cell};
            walk.cell = Walk::none;
        }
    };
    visit_cells(cells_, rays, walks, [&](std::uint32_t code, Rays some) {
        for (; some.size() > most_at_once; some = some.subspan(most_at_once)) find_roots(code, some.first(most_at_once));
        find_roots(code, some);
    });
    const auto unresolved = std::count_if(walks.begin(), walks.end(), [](const Walk& walk) { return walk.unresolved; });
    if (unresolved) unresolved_rays_ += static_cast<std::uint64_t>(unresolved);
}

void Implicit::normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const {
    void* const memory = scratch(cells_.max_registers());
    const std::vector<Cells::Cell>& cells = cells_.cells();
    const auto code_of = [&](std::uint32_t i) { return cells[hits[i].primitive].code; };
    const auto lanes = static_cast<std::size_t>(best_formula_kernels().lanes);
    for_each_batch(hits.size(), cells_.codes(), lanes, code_of, [&](std::uint32_t code, Items items) {
        const int count = static_cast<int>(items.size());
        float point[3][max_lanes], gradient[3][max_lanes], value[max_lanes];
        const float* const points[3] = {point[0], point[1], point[2]};
        float* const gradients[3] = {gradient[0], gradient[1], gradient[2]};
        std::uint32_t without = (1u << count) - 1;
        // A distance has no gradient at an exact zero, but has one just before the hit.
        for (const float before : {0.f, 1e-5f}) {
            for (int lane = 0; lane < count; ++lane) {
                const Ray& ray = rays[items[lane]];
                const Vec3 p = ray.origin + (hits[items[lane]].t - before / length(ray.direction)) * ray.direction;
                for (int axis = 0; axis < 3; ++axis) point[axis][lane] = p[axis];
            }
            formula_kernels_for(items.size()).gradients(cells_.code(code), points, count, true, value, gradients, memory);
            for (int lane = 0; lane < count; ++lane) {
                if (!(without >> lane & 1)) continue;
                const Vec3 direction = rays[items[lane]].direction;
                const Vec3 normal = normalized(Vec3{gradient[0][lane], gradient[1][lane], gradient[2][lane]});
                const bool none = dot(normal, normal) == 0;
                // Without a gradient there, too, the surface is assumed to face the ray.
                normals[items[lane]] = none ? -normalized(direction) : dot(normal, direction) > 0 ? -normal : normal;
                if (!none) without &= ~(1u << lane);
            }
            if (!without) break;
        }
    });
}

void Implicit::colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float>, std::span<Vec3> colors) const {
    for (std::size_t i = 0; i < hits.size(); ++i) colors[i] = rays[i].origin + hits[i].t * rays[i].direction;
    this->colors(colors.first(hits.size()), colors);
}

void Implicit::colors(std::span<const Vec3> points, std::span<Vec3> colors) const { (*painting_)(points, colors); }

}  // namespace bob
