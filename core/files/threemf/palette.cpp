#include "files/threemf/palette.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/color.h"
#include "base/interruption.h"
#include "files/split.h"
#include "files/text.h"

namespace bob::files::threemf {
namespace {

constexpr Rgb white = {1, 1, 1};

/// The digits of an index; -1 for any other text.
std::int32_t index_of_digits(std::string_view text) {
    std::int32_t result = text.empty() || text.size() > 9 ? -1 : 0;
    for (const char c : text) {
        if (result < 0 || c < '0' || c > '9') return -1;
        result = 10 * result + (c - '0');
    }
    return result;
}

/// A part with one vertex for each corner; NaN for a missing vertex.
Part of_corners(const Mesh& mesh) {
    Part part;
    part.vertices = picked(mesh.vertices, 3, mesh.triangles);
    part.triangles.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < part.triangles.size(); ++i) part.triangles[i] = static_cast<std::int32_t>(i);
    return part;
}

}  // namespace

std::vector<double> numbers_of(std::string_view text) {
    std::vector<double> result;
    Words words(text);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) result.push_back(number_of(word));
    return result;
}

int Palette::group_number(std::string_view group) {
    if (const auto found = numbers_.find(group); found != numbers_.end()) return found->second;
    groups_.emplace_back();
    return numbers_.emplace(group, static_cast<int>(groups_.size()) - 1).first->second;
}

std::size_t Palette::texture_number(std::string_view texture) {
    if (const auto found = texture_numbers_.find(texture); found != texture_numbers_.end()) return found->second;
    textures_.emplace_back();
    return texture_numbers_.emplace(texture, textures_.size() - 1).first->second;
}

Swatch Palette::swatch(std::string_view group, std::string_view number) { return {group_number(group), index_of_digits(number)}; }

void Palette::start(std::string_view group, bool is_flat) {
    current_ = static_cast<std::size_t>(group_number(group));
    groups_[current_] = {.is_flat = is_flat, .texture = {}, .colors = {}, .places = {}};
    mixed_.clear();
}

void Palette::start_places(std::string_view group, std::string_view texture) {
    start(group);
    groups_[current_].texture = texture_number(texture);
    has_places_ = true;
}

void Palette::start_mixtures(std::string_view group, std::string_view of, std::string_view numbers) {
    start(group);
    Words words(numbers);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) mixed_.push_back(color(swatch(of, word)));
}

void Palette::add(std::string_view color) {
    groups_[current_].colors.push_back(linear_color(color.substr(0, 7)).value_or(white));
    has_colors_ = true;
}

void Palette::add_mixture(std::string_view shares) {
    const std::vector<double> weights = numbers_of(shares);
    double sum = 0;
    bool is_valid = weights.size() == mixed_.size();
    for (const double weight : weights) {
        is_valid = is_valid && weight >= 0;
        sum += weight;
    }
    Rgb result = white;
    if (is_valid && sum > 0 && std::isfinite(sum)) {
        result = {};
        for (std::size_t i = 0; i < weights.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) result[k] += weights[i] / sum * mixed_[i][k];
        }
    }
    groups_[current_].colors.push_back(result);
    has_colors_ = true;
}

void Palette::add_place(std::string_view u, std::string_view v) {
    groups_[current_].places.push_back({number_of(trimmed(u)), number_of(trimmed(v))});
}

Rgb Palette::color(Swatch swatch) const {
    const Group* const found = group(swatch);
    const auto number = static_cast<std::size_t>(swatch.number);
    return found && swatch.number >= 0 && number < found->colors.size() ? found->colors[number] : white;
}

std::array<Rgb, 3> Palette::of(Swatches swatches) const {
    const Group* const found = group(swatches[0]);
    if (found && found->is_flat) swatches.fill(swatches[0]);
    return {color(swatches[0]), color(swatches[1]), color(swatches[2])};
}

std::vector<Part> Palette::parts(Mesh mesh, const std::function<int(const Texture*)>& surface) const {
    std::vector<Part> parts;
    std::vector<std::size_t> textures;                     // in the order of their first triangles
    std::vector<std::size_t> number_of(textures_.size());  // of each texture in that order, from 1 on; 0 for one without triangles
    std::vector<std::size_t> numbers;                      // of the textures of all triangles; 0 for colours
    for (std::size_t i = 0; has_places_ && i < mesh.chosen.size(); ++i) {
        const Group* const found = group(mesh.chosen[i][0]);
        if (!found || !found->texture) {
            numbers.push_back(0);
            continue;
        }
        std::size_t& number = number_of[*found->texture];
        if (number == 0) {
            textures.push_back(*found->texture);
            number = textures.size();
        }
        numbers.push_back(number);
    }
    if (textures.empty()) {
        parts.push_back(colored(std::move(mesh)));
        return parts;
    }
    std::vector<Mesh> meshes(textures.size() + 1);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        Mesh& own = meshes[numbers[i]];
        for (std::size_t k = 0; k < 3; ++k) own.triangles.push_back(mesh.triangles[3 * i + k]);
        own.chosen.push_back(mesh.chosen[i]);
    }
    for (std::size_t number = 0; number < meshes.size(); ++number) {
        Mesh& own = meshes[number];
        if (own.chosen.empty()) continue;
        if (number > 0) {
            own.vertices.swap(mesh.vertices);
            parts.push_back(laid(own, textures[number - 1], surface));
            own.vertices.swap(mesh.vertices);
        } else {
            own.vertices = mesh.vertices;
            parts.push_back(colored(std::move(own)));
        }
    }
    return parts;
}

/// A part with one colour for each triangle, or if the corners of one differ, for each corner.
Part Palette::colored(Mesh mesh) const {
    Part part;
    const std::size_t count = mesh.triangles.size() / 3;
    Numbers<double> colors;
    bool blends = false;
    for (std::size_t i = 0; has_colors_ && i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        const std::array<Rgb, 3> corners = of(mesh.chosen[i]);
        if (!blends && (corners[0] != corners[1] || corners[1] != corners[2])) {
            blends = true;
            Numbers<double> whole;
            for (std::size_t k = 0; k < colors.size(); k += 3) {
                for (int corner = 0; corner < 3; ++corner) whole.insert(whole.end(), &colors[k], &colors[k] + 3);
            }
            colors = std::move(whole);
        }
        for (std::size_t corner = 0; corner < (blends ? 3 : 1); ++corner) colors.insert(colors.end(), corners[corner].begin(), corners[corner].end());
    }
    if (blends) {
        part = of_corners(mesh);
        part.colors = std::move(colors);
    } else {
        part.vertices = std::move(mesh.vertices);
        part.triangles = std::move(mesh.triangles);
        part.face_colors = std::move(colors);
    }
    return part;
}

/// A part with a texture, and one vertex for each corner.
Part Palette::laid(const Mesh& mesh, std::size_t texture, const std::function<int(const Texture*)>& surface) const {
    const std::optional<Texture>& found = textures_[texture];
    Part part = of_corners(mesh);
    part.surface = surface(found ? &*found : nullptr);
    if (part.surface < 0) return part;
    Numbers<double>& uv = part.uv.emplace_back();
    for (const Swatches& swatches : mesh.chosen) {
        for (const Swatch& swatch : swatches) {
            const Group* const of = group(swatch);
            const auto number = static_cast<std::size_t>(swatch.number);
            const bool is_there = of && swatch.number >= 0 && number < of->places.size();
            const std::array<double, 2> place = is_there ? of->places[number] : std::array{nan, nan};
            uv.push_back(place[0]);
            uv.push_back(1 - place[1]);  // a 3MF counts from the bottom up
        }
    }
    return part;
}

}  // namespace bob::files::threemf
