#include "files/placing.h"

#include <algorithm>

#include "base/interruption.h"
#include "files/text.h"

namespace bob::files {
namespace {

/// Appends `width` numbers for each row after those for `before` rows; some of these may lack them.
void append(Numbers<double>& all, Numbers<double>&& more, std::size_t before, std::size_t width) {
    if (more.empty()) return;
    if (before == 0) {
        all = std::move(more);
        return;
    }
    all.resize(width * before, nan);
    all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

Rows product(const Rows& a, const Rows& b) {
    Rows result;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            result[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] + (j == 3 ? a[4 * i + 3] : 0);
        }
    }
    return result;
}

Vec3d moved(const Rows& m, const double* p, double shift) {
    Vec3d result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = m[4 * i] * p[0] + m[4 * i + 1] * p[1] + m[4 * i + 2] * p[2] + shift * m[4 * i + 3];
    return result;
}

std::pair<Rows, bool> of_normals(const Rows& m) {
    const Vec3d a = {m[0], m[4], m[8]}, b = {m[1], m[5], m[9]}, c = {m[2], m[6], m[10]};
    const Vec3d columns[] = {cross(b, c), cross(c, a), cross(a, b)};
    const bool is_mirrored = dot(a, columns[0]) < 0;
    Rows result{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) result[4 * i + j] = is_mirrored ? -columns[j][i] : columns[j][i];
    }
    return {result, is_mirrored};
}

void Placing::count(std::size_t items) {
    if (items > max_items - items_) {
        refuse({"expected at most ", grouped(max_items), " triangles and vertices in all its parts, got more"});
    }
    items_ += items;
}

int Placing::label(std::string name, int parent) {
    const std::string first = name;
    for (int& count = taken_[{parent, first}]; ++count > 1;) {
        name = first + " " + std::to_string(count);
        if (taken_.try_emplace({parent, name}, 1).second) break;
    }
    contents_.labels.push_back({std::move(name), parent});
    return static_cast<int>(contents_.labels.size()) - 1;
}

void Placing::add(Part part, const Rows& place, int label) {
    Interruption::check();
    const auto [normal_place, is_mirrored] = of_normals(place);
    for (std::size_t i = 0; i < part.vertices.size(); i += 3) std::ranges::copy(moved(place, &part.vertices[i]), &part.vertices[i]);
    for (std::size_t i = 0; i < part.normals.size(); i += 3) std::ranges::copy(moved(normal_place, &part.normals[i], 0), &part.normals[i]);

    const auto [at, is_new] = parts_.try_emplace(part.surface, contents_.parts.size());
    if (is_new) contents_.parts.emplace_back().surface = part.surface;
    Part& whole = contents_.parts[at->second];
    const std::size_t before = whole.vertices.size() / 3, triangles_before = whole.triangles.size() / 3;
    const auto first = static_cast<std::int32_t>(before), size = static_cast<std::int32_t>(part.vertices.size() / 3);
    for (std::size_t i = 0; i < part.triangles.size(); i += 3) {
        std::int32_t* const corners = &part.triangles[i];
        for (int k = 0; k < 3; ++k) corners[k] = corners[k] >= 0 && corners[k] < size ? corners[k] + first : -1;
        if (is_mirrored) std::swap(corners[0], corners[2]);  // the outside stays anticlockwise
    }
    if (!part.triangles.empty()) whole.add_run(label, part.triangles.size() / 3);
    append(whole.vertices, std::move(part.vertices), before, 3);
    append(whole.normals, std::move(part.normals), before, 3);
    append(whole.colors, std::move(part.colors), before, 3);
    append(whole.face_colors, std::move(part.face_colors), triangles_before, 3);
    append(whole.alphas, std::move(part.alphas), before, 1);
    whole.uv.resize(std::max(whole.uv.size(), part.uv.size()));
    for (std::size_t i = 0; i < part.uv.size(); ++i) append(whole.uv[i], std::move(part.uv[i]), before, 2);
    if (triangles_before == 0) {
        whole.triangles = std::move(part.triangles);
    } else {
        whole.triangles.insert(whole.triangles.end(), part.triangles.begin(), part.triangles.end());
    }
}

void Placing::finish() {
    for (Part& part : contents_.parts) {
        const std::size_t count = part.vertices.size() / 3;
        if (!part.normals.empty()) part.normals.resize(3 * count, nan);
        if (!part.colors.empty()) part.colors.resize(3 * count, nan);
        if (!part.face_colors.empty()) part.face_colors.resize(part.triangles.size(), nan);
        if (!part.alphas.empty()) part.alphas.resize(count, nan);
        for (Numbers<double>& uv : part.uv) uv.resize(2 * count, nan);
    }
}

}  // namespace bob::files
