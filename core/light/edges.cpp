#include "light/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/color.h"
#include "base/parallel.h"

namespace bob {
namespace {

/// Minimum differences between neighbours on both sides of an edge.
constexpr float unlike_depth = 0.02f, unlike_normal = 0.3f, unlike_albedo = 0.1f;

/// Squared pixels that a difference of 1 in depth, normal or albedo counts for, where light is taken from a neighbour.
constexpr float unlike = 30;

constexpr int around[] = {0, -1, 1};

}  // namespace

std::vector<Pixel> edges_between_surfaces(const float* planes, int height, int width) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    const auto differ = [=](std::size_t a, std::size_t b) {
        const auto value = [=](std::size_t plane, std::size_t i) { return planes[plane * pixels + i]; };
        const auto apart = [=](std::size_t plane) { return std::abs(value(plane, a) - value(plane, b)); };
        if (apart(first_hit::mask) != 0 || apart(first_hit::ground) != 0 || apart(first_hit::behind) != 0) return true;
        if (value(first_hit::mask, a) == 0) return false;
        return apart(first_hit::depth) > unlike_depth || apart(first_hit::normal_x) > unlike_normal || apart(first_hit::normal_y) > unlike_normal ||
               apart(first_hit::red) > unlike_albedo || apart(first_hit::green) > unlike_albedo || apart(first_hit::blue) > unlike_albedo;
    };
    std::vector<std::vector<Pixel>> of_rows(static_cast<std::size_t>(height));
    for_rows(0, height, width, [&](int row) {
        for (int column = 0; column < width; ++column) {
            const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
            const auto below = static_cast<std::size_t>(width);
            if ((column > 0 && differ(i, i - 1)) || (column + 1 < width && differ(i, i + 1)) || (row > 0 && differ(i, i - below)) ||
                (row + 1 < height && differ(i, i + below))) {
                of_rows[static_cast<std::size_t>(row)].push_back({row, column});
            }
        }
    });
    std::vector<Pixel> edges;
    for (const auto& row : of_rows) edges.insert(edges.end(), row.begin(), row.end());
    return edges;
}

void smooth_edges(std::span<const Pixel> edges, const float* hits, std::size_t per_pixel, const float* guides, const float* ground, int height,
                  int width, float* color, float* alpha) {
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    struct Whole {
        float color[3], alpha;
    };
    std::vector<Whole> whole(edges.size());
    parallel_for(edges.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            struct Neighbour {
                float depth, normal_x, normal_y, albedo[3], light[3], squared;
            };
            std::array<Neighbour, 9> neighbours;
            std::size_t count = 0;
            float lost = 0, nearest = std::numeric_limits<float>::infinity();
            for (const int down : around) {
                for (const int right : around) {
                    const int row = std::clamp(edges[n].row + down, 0, height - 1), column = std::clamp(edges[n].column + right, 0, width - 1);
                    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
                    const auto guide = [&](std::size_t plane) { return guides[plane * pixels + i]; };
                    const auto squared = static_cast<float>(down * down + right * right);
                    if (ground && ground[i] > 0 && squared < nearest) nearest = squared, lost = alpha[i];
                    if (guide(first_hit::mask) == 0) continue;
                    Neighbour& to = neighbours[count++];
                    to = {guide(first_hit::depth), guide(first_hit::normal_x), guide(first_hit::normal_y), {}, {}, squared};
                    for (std::size_t c = 0; c < 3; ++c) {
                        to.albedo[c] = std::max(guide(first_hit::red + c), min_albedo);
                        to.light[c] = color[c * pixels + i] / to.albedo[c];
                    }
                }
            }
            Whole sum{};
            for (std::size_t k = 0; k < per_pixel; ++k) {
                const float* const hit = hits + (n * per_pixel + k) * first_hit::count;
                if (hit[first_hit::ground] > 0) sum.alpha += lost;
                if (hit[first_hit::mask] == 0) continue;
                sum.alpha += 1;
                float albedo[3];
                for (std::size_t c = 0; c < 3; ++c) albedo[c] = std::max(hit[first_hit::red + c], min_albedo);
                float min_distance = std::numeric_limits<float>::infinity();
                const float* light = nullptr;
                for (std::size_t j = 0; j < count; ++j) {
                    const Neighbour& other = neighbours[j];
                    const float off_albedo = std::abs(albedo[0] - other.albedo[0]) + std::abs(albedo[1] - other.albedo[1]) + std::abs(albedo[2] - other.albedo[2]);
                    const float apart = unlike * (std::abs(hit[first_hit::depth] - other.depth) + std::abs(hit[first_hit::normal_x] - other.normal_x) +
                                                  std::abs(hit[first_hit::normal_y] - other.normal_y) + off_albedo) + other.squared;
                    if (apart < min_distance) min_distance = apart, light = other.light;
                }
                for (std::size_t c = 0; light && c < 3; ++c) sum.color[c] += light[c] * albedo[c];
            }
            const float share = 1 / static_cast<float>(per_pixel);
            whole[n] = {{share * sum.color[0], share * sum.color[1], share * sum.color[2]}, share * sum.alpha};
        }
    });
    for (std::size_t n = 0; n < edges.size(); ++n) {
        const std::size_t i = static_cast<std::size_t>(edges[n].row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(edges[n].column);
        for (std::size_t c = 0; c < 3; ++c) color[c * pixels + i] = whole[n].color[c];
        alpha[i] = whole[n].alpha;
    }
}

}  // namespace bob
