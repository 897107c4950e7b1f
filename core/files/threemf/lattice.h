/// The beam lattices of a 3MF: a beam is a straight tube between two vertices, a ball a tube of length 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/threemf/palette.h"
#include "files/xml.h"

namespace bob::files::threemf {

/// Features of a file that are not shown, by their names in the warning, in order.
class LeftOut {
public:
    void add(std::string_view name, std::size_t count = 1);
    /// "displacements (1), properties in space (2)"; empty if nothing was left out.
    [[nodiscard]] std::string names() const;

private:
    std::vector<std::pair<std::string, std::size_t>> counts_;
};

/// The beams and balls of one object.
class Lattice {
public:
    /// The attributes of the lattice override the object's group and number of a colour.
    Lattice(const XmlAttributes& get, std::string_view group, std::string_view number, Palette& palette);

    void add_beam(const XmlAttributes& get, std::string_view v1, std::string_view v2);
    void add_ball(const XmlAttributes& get, std::string_view vertex);

    /// The shapes: one for each colour.
    [[nodiscard]] std::vector<OtherShape> shapes(const Numbers<double>& vertices, LeftOut& left) const;

private:
    struct Beam {
        double vertices[2], radii[2];
        std::vector<Swatch> chosen;  // of its ends, or of both; empty for the lattice's
    };

    Palette& palette_;
    std::string group_, mode_;
    Swatch swatch_;
    double radius_, ball_radius_, min_length_;
    bool is_clipped_, is_butt_;
    std::size_t butts_ = 0;
    std::vector<Beam> beams_, balls_;
    std::map<double, std::size_t> ball_of_;  // by vertices
};

}  // namespace bob::files::threemf
