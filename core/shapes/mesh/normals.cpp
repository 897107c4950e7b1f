#include "shapes/mesh/normals.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/interruption.h"
#include "base/parallel.h"

namespace bob {
namespace {

// A corner shared by more faces stays flat: comparing all pairs would take too long. (The pole of a sphere of 1024
// meridians is below the limit.)
constexpr std::size_t max_faces_at_vertex = 1024;

constexpr float degree = 3.14159265f / 180;

std::array<float, 3> corner_angles(std::span<const Vec3> vertices, const Triangle& t) {
    Vec3 edge[3];  // from each corner to the next
    for (std::size_t c = 0; c < 3; ++c) edge[c] = normalized(vertices[t[(c + 1) % 3]] - vertices[t[c]]);
    std::array<float, 3> angles;
    for (std::size_t c = 0; c < 3; ++c) angles[c] = std::acos(std::clamp(-dot(edge[c], edge[(c + 2) % 3]), -1.f, 1.f));
    return angles;
}

std::uint64_t hash(Vec3 p) {
    // + 0.f: -0 and 0 are equal positions.
    std::uint64_t h = std::bit_cast<std::uint32_t>(p.x + 0.f);
    h = h * 0x9e3779b97f4a7c15 + std::bit_cast<std::uint32_t>(p.y + 0.f);
    h = (h ^ h >> 29) * 0x9e3779b97f4a7c15 + std::bit_cast<std::uint32_t>(p.z + 0.f);
    h = (h ^ h >> 32) * 0xd6e8feb86659fd93;
    return h ^ h >> 32;
}

}  // namespace

std::vector<std::uint32_t> merge_positions(std::span<const Vec3> vertices) {
    const std::size_t mask = std::bit_ceil(2 * vertices.size()) - 1;
    constexpr std::uint32_t empty = 0xffffffff;
    std::vector<std::uint32_t> table(mask + 1, empty), first(vertices.size());
    for (std::uint32_t i = 0; i < vertices.size(); ++i) {
        if (i % 32768 == 0) Interruption::check();
        const Vec3 p = vertices[i];
        std::size_t slot = hash(p) & mask;
        while (table[slot] != empty) {
            const Vec3 q = vertices[table[slot]];
            if (p.x == q.x && p.y == q.y && p.z == q.z) break;
            slot = (slot + 1) & mask;
        }
        if (table[slot] == empty) table[slot] = i;
        first[i] = table[slot];
    }
    return first;
}

namespace {

/// The sum of the normals of `corners` within an angle, given by its cosine, of `axis`; weighted by angle.
Vec3 sum_within(Vec3 axis, float cos_limit, std::span<const std::uint32_t> corners, std::span<const Vec3> face,
                std::span<const std::array<float, 3>> angle) {
    Vec3 sum;
    for (const std::uint32_t corner : corners) {
        const Vec3 normal = face[corner / 3];
        if (dot(normal, axis) > cos_limit) sum = sum + angle[corner / 3][corner % 3] * normal;
    }
    return sum;
}

/// A position: the mean of its faces' normals, weighted by angle, and the number of corners.
struct Meeting {
    Vec3 mean;
    std::uint32_t count = 0;

    [[nodiscard]] bool is_crowded() const { return count > max_faces_at_vertex; }
};

/// The means at all positions.
std::vector<Meeting> meetings(std::span<const std::uint32_t> position, std::span<const Triangle> triangles, std::span<const Vec3> face,
                              std::span<const std::array<float, 3>> angle) {
    std::vector<Meeting> result(position.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 32768 == 0) Interruption::check();
        for (std::size_t c = 0; c < 3; ++c) {
            auto& [sum, count] = result[position[triangles[i][c]]];
            sum = sum + angle[i][c] * face[i];
            ++count;
        }
    }
    for (Meeting& at : result) at.mean = normalized(at.mean);
    return result;
}

/// For each position, whether all corners share one normal. If all faces deviate from their mean by less than half the
/// crease angle, minus a margin for rounding, no two of them differ by more than it.
std::vector<std::uint8_t> are_round(std::span<const std::uint32_t> position, std::span<const Triangle> triangles, std::span<const Vec3> face,
                                    std::span<const Meeting> meeting) {
    static const float cos_half = std::cos(crease_angle_degrees / 2 * degree) + 1e-5f;
    std::vector<std::uint8_t> result(position.size(), 1);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 32768 == 0) Interruption::check();
        for (const auto vertex : triangles[i]) {
            const Meeting& at = meeting[position[vertex]];
            if (!(dot(face[i], at.mean) > cos_half) || at.is_crowded()) result[position[vertex]] = 0;
        }
    }
    return result;
}

/// Sets the normals of all corners at one position that is not round.
void smooth(std::span<const std::uint32_t> corners, std::span<const Vec3> face, std::span<const std::array<float, 3>> angle,
            std::span<CornerNormals> normals) {
    static const float cos_crease = std::cos(crease_angle_degrees * degree);
    for (const std::uint32_t corner : corners) {
        const Vec3 sum = sum_within(face[corner / 3], cos_crease, corners, face, angle);
        if (dot(sum, sum) > 0) normals[corner / 3][corner % 3] = normalized(sum);
    }
}

}  // namespace

Vec3 face_normal(std::span<const Vec3> vertices, const Triangle& t) {
    return normalized(cross(vertices[t[1]] - vertices[t[0]], vertices[t[2]] - vertices[t[0]]));
}

std::vector<Vec3> face_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
    std::vector<Vec3> face(triangles.size());
    parallel_for(triangles.size(), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) face[i] = face_normal(vertices, triangles[i]);
    });
    return face;
}

std::vector<CornerNormals> crease_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::span<const Vec3> face) {
    const std::vector<std::uint32_t> position = merge_positions(vertices);
    std::vector<std::array<float, 3>> angle(triangles.size());
    parallel_for(triangles.size(), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) angle[i] = corner_angles(vertices, triangles[i]);
    });
    const std::vector<Meeting> meeting = meetings(position, triangles, face, angle);
    const std::vector<std::uint8_t> is_round = are_round(position, triangles, face, meeting);

    std::vector<CornerNormals> normals(triangles.size());
    parallel_for(triangles.size(), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            for (std::size_t c = 0; c < 3; ++c) {
                const std::uint32_t at = position[triangles[i][c]];
                normals[i][c] = is_round[at] ? meeting[at].mean : face[i];
            }
        }
    });

    // The corners (3 * triangle + corner) at each of the other positions, in one array sorted by position.
    const auto is_left = [&](std::uint32_t at) { return !is_round[at] && !meeting[at].is_crowded(); };
    std::vector<std::uint32_t> begin(vertices.size() + 1, 0);
    for (std::uint32_t at = 0; at < vertices.size(); ++at) begin[at + 1] = begin[at] + (is_left(at) ? meeting[at].count : 0);
    std::vector<std::uint32_t> corners(begin.back());
    if (corners.empty()) return normals;
    {
        std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
        for (std::uint32_t i = 0; i < triangles.size(); ++i) {
            if (i % 32768 == 0) Interruption::check();
            for (std::uint32_t c = 0; c < 3; ++c) {
                const std::uint32_t at = position[triangles[i][c]];
                if (is_left(at)) corners[next[at]++] = 3 * i + c;
            }
        }
    }
    parallel_for(vertices.size(), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t at = first; at < last; ++at) {
            const std::size_t count = begin[at + 1] - begin[at];
            if (count > 64) Interruption::check();
            smooth(std::span(corners).subspan(begin[at], count), face, angle, normals);
        }
    });
    return normals;
}

std::vector<CornerNormals> stored_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                                          std::span<const Vec3> face, std::span<const Vec3> vertex_normals) {
    std::vector<CornerNormals> normals(triangles.size());
    bool complete = true;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 32768 == 0) Interruption::check();
        for (std::size_t c = 0; c < 3; ++c) {
            normals[i][c] = normalized(vertex_normals[triangles[i][c]]);
            complete = complete && dot(normals[i][c], normals[i][c]) > 0;
        }
    }
    if (complete) return normals;
    const std::vector<CornerNormals> computed = crease_normals(vertices, triangles, face);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            if (dot(normals[i][c], normals[i][c]) == 0) normals[i][c] = computed[i][c];
        }
    }
    return normals;
}

}  // namespace bob
