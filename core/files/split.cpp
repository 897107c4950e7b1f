#include "files/split.h"

#include <algorithm>

#include "base/interruption.h"
#include "files/text.h"

namespace bob::files {

Numbers<double> picked(std::span<const double> rows, std::size_t width, std::span<const std::int32_t> numbers) {
    const std::size_t count = rows.size() / width;
    Numbers<double> result(width * numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (i % 65536 == 0) Interruption::check();
        const auto row = static_cast<std::size_t>(numbers[i]);
        const bool is_there = numbers[i] >= 0 && row < count;
        for (std::size_t k = 0; k < width; ++k) result[width * i + k] = is_there ? rows[width * row + k] : nan;
    }
    return result;
}

std::vector<Part> split(const Part& whole, std::span<const std::int32_t> groups, std::size_t count) {
    std::vector<std::size_t> starts(count + 1);
    const auto is_shown = [&](std::int32_t group) { return group >= 0 && static_cast<std::size_t>(group) < count; };
    for (const std::int32_t group : groups) {
        if (is_shown(group)) ++starts[static_cast<std::size_t>(group) + 1];
    }
    for (std::size_t i = 1; i <= count; ++i) starts[i] += starts[i - 1];
    std::vector<std::size_t> triangles(starts[count]), ends(starts.begin(), starts.end() - 1);
    for (std::size_t t = 0; t < groups.size(); ++t) {
        if (is_shown(groups[t])) triangles[ends[static_cast<std::size_t>(groups[t])]++] = t;
    }

    const std::size_t vertices = whole.vertices.size() / 3;
    std::vector<std::int32_t> places(vertices, -1), used;  // places: of vertices in the group at hand
    std::vector<Part> parts(count);
    for (std::size_t group = 0; group < count; ++group) {
        Interruption::check();
        Part& part = parts[group];
        const std::span<const std::size_t> own(triangles.data() + starts[group], starts[group + 1] - starts[group]);
        used.clear();
        const auto each_corner = [&](auto f) {
            for (const std::size_t t : own) {
                for (std::size_t k = 0; k < 3; ++k) f(whole.triangles[3 * t + k]);
            }
        };
        const auto is_there = [&](std::int32_t vertex) { return vertex >= 0 && static_cast<std::size_t>(vertex) < vertices; };
        each_corner([&](std::int32_t vertex) {
            if (!is_there(vertex) || places[static_cast<std::size_t>(vertex)] >= 0) return;
            places[static_cast<std::size_t>(vertex)] = 0;
            used.push_back(vertex);
        });
        std::ranges::sort(used);
        for (std::size_t i = 0; i < used.size(); ++i) places[static_cast<std::size_t>(used[i])] = static_cast<std::int32_t>(i);
        part.triangles.reserve(3 * own.size());
        each_corner([&](std::int32_t vertex) { part.triangles.push_back(is_there(vertex) ? places[static_cast<std::size_t>(vertex)] : -1); });
        for (const std::int32_t vertex : used) places[static_cast<std::size_t>(vertex)] = -1;
        part.vertices = picked(whole.vertices, 3, used);
        if (!whole.normals.empty()) part.normals = picked(whole.normals, 3, used);
        if (!whole.colors.empty()) part.colors = picked(whole.colors, 3, used);
        if (!whole.alphas.empty()) part.alphas = picked(whole.alphas, 1, used);
        for (const auto& uv : whole.uv) part.uv.push_back(picked(uv, 2, used));
        for (const std::size_t t : own) {
            for (std::size_t k = 0; k < 3 && !whole.face_colors.empty(); ++k) part.face_colors.push_back(whole.face_colors[3 * t + k]);
        }
    }
    return parts;
}

}  // namespace bob::files
