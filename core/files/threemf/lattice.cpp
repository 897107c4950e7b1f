#include "files/threemf/lattice.h"

#include <algorithm>
#include <cmath>

#include "base/counts.h"
#include "base/interruption.h"
#include "base/vec3d.h"
#include "files/text.h"

namespace bob::files::threemf {
namespace {

constexpr double max_coordinate = 1e100;

double number(std::string_view text) { return number_of(trimmed(text)); }

/// A vertex; -1, which there is none of, for NaN.
double vertex_of(std::string_view text) {
    const double value = number(text);
    return std::isnan(value) ? -1 : value;
}

/// An attribute with or without its namespace.
std::string_view either(const XmlAttributes& get, std::string_view name, std::string_view otherwise) {
    for (const XmlAttributes::Attribute& attribute : get.all()) {
        if (attribute.name == name) return attribute.value;
    }
    return otherwise;
}

}  // namespace

void LeftOut::add(std::string_view name, std::size_t count) {
    if (count == 0) return;
    const auto found = std::ranges::find(counts_, name, [](const auto& known) -> std::string_view { return known.first; });
    if (found == counts_.end()) {
        counts_.emplace_back(name, count);
    } else {
        found->second += count;
    }
}

std::string LeftOut::names() const {
    std::string result;
    for (const auto& [name, count] : counts_) result += joined({result.empty() ? "" : ", ", name, " (", grouped(count), ")"});
    return result;
}

Lattice::Lattice(const XmlAttributes& get, std::string_view group, std::string_view number_of_color, Palette& palette)
    : palette_(palette), group_(get.get("pid", group)), mode_(either(get, "ballmode", "none")),
      swatch_(palette.swatch(group_, get.get("pindex", number_of_color))), radius_(number(get.get("radius", "nan"))),
      ball_radius_(number(either(get, "ballradius", get.get("radius", "nan")))), min_length_(number(get.get("minlength", "0"))),
      is_clipped_(get.get("clippingmode", "none") != "none"), is_butt_(get.get("cap", "sphere") == "butt") {}

void Lattice::add_beam(const XmlAttributes& get, std::string_view v1, std::string_view v2) {
    const auto r1 = get.find("r1"), r2 = get.find("r2");
    const double first = r1 ? number(*r1) : radius_;
    Beam& beam = beams_.emplace_back(Beam{{vertex_of(v1), vertex_of(v2)}, {first, r2 ? number(*r2) : first}, {}});
    for (const std::string_view name : {"cap1", "cap2"}) butts_ += get.find(name) ? get.get(name) == "butt" : is_butt_;
    if (const auto p1 = get.find("p1")) {
        const std::string_view group = get.get("pid", group_);
        beam.chosen = {palette_.swatch(group, *p1), palette_.swatch(group, get.get("p2", *p1))};
    }
}

void Lattice::add_ball(const XmlAttributes& get, std::string_view vertex) {
    const auto r = get.find("r");
    const double radius = r ? number(*r) : ball_radius_, at = vertex_of(vertex);
    const auto [found, is_new] = ball_of_.try_emplace(at, balls_.size());
    if (is_new) balls_.emplace_back();
    Beam& ball = balls_[found->second] = {{at, at}, {radius, radius}, {}};
    if (const auto p = get.find("p")) ball.chosen = {palette_.swatch(get.get("pid", group_), *p)};
}

std::vector<OtherShape> Lattice::shapes(const Numbers<double>& vertices, LeftOut& left) const {
    std::vector<Beam> all = beams_;
    if (mode_ != "none") all.insert(all.end(), balls_.begin(), balls_.end());
    if (mode_ == "all") {
        std::map<double, std::size_t> known = ball_of_;
        for (const Beam& beam : beams_) {
            for (const double vertex : beam.vertices) {
                if (known.try_emplace(vertex, 0).second) all.push_back({{vertex, vertex}, {ball_radius_, ball_radius_}, {}});
            }
        }
    }
    std::vector<OtherShape> shapes;
    std::map<Rgb, std::size_t> shape_of;
    std::size_t missing = 0;
    const auto count = static_cast<double>(vertices.size() / 3);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i % 4096 == 0) Interruption::check();
        const Beam& beam = all[i];
        Vec3d ends[2];
        bool is_there = true;
        for (std::size_t k = 0; k < 2; ++k) {
            const bool has_vertex = beam.vertices[k] >= 0 && beam.vertices[k] < count;
            for (std::size_t axis = 0; axis < 3; ++axis) ends[k][axis] = has_vertex ? vertices[3 * static_cast<std::size_t>(beam.vertices[k]) + axis] : nan;
            for (const double x : ends[k]) is_there = is_there && std::fabs(x) <= max_coordinate;
            is_there = is_there && beam.radii[k] > 0 && beam.radii[k] <= max_coordinate;
        }
        if (!is_there) {
            ++missing;
            continue;
        }
        const double size = length(ends[1] - ends[0]);
        if (i < beams_.size() && !(size >= min_length_ && size > 0)) continue;
        Swatches swatches;
        swatches.fill(swatch_);
        if (!beam.chosen.empty()) swatches = {beam.chosen.front(), beam.chosen.back(), beam.chosen.back()};
        const std::array<Rgb, 3> colors = palette_.of(swatches);
        Rgb color;
        for (std::size_t k = 0; k < 3; ++k) color[k] = (colors[0][k] + colors[1][k]) / 2;
        const auto [found, is_new] = shape_of.try_emplace(color, shapes.size());
        if (is_new) shapes.push_back({.name = {}, .color = color, .shape = Beams{}});
        Beams& beams = std::get<Beams>(shapes[found->second].shape);
        for (const Vec3d& end : ends) beams.ends.insert(beams.ends.end(), end.begin(), end.end());
        beams.radii.insert(beams.radii.end(), std::begin(beam.radii), std::end(beam.radii));
    }
    left.add("beams without a vertex or a radius", missing);
    left.add("flat ends of beams", butts_);
    left.add("clippings of beam lattices", is_clipped_);
    return shapes;
}

}  // namespace bob::files::threemf
