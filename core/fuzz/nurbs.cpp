/// Breps: faces with weights, knots and trims as readers let them pass.
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/interruption.h"
#include "fuzz/rays.h"
#include "fuzz/splines.h"
#include "shapes/brep/brep.h"

namespace {

std::optional<bob::Face> face(fuzz::Source& source) {
    const int most = source.below(8) ? 3 : 4, n = source.between(2, most), m = source.between(2, most);
    const int p = source.between(1, n - 1), q = source.between(1, m - 1);
    bob::Face face;
    face.surface = {p, q, fuzz::knots(source, n, p), fuzz::knots(source, m, q), fuzz::points<3>(source, static_cast<std::size_t>(n * m))};
    if (!fuzz::are_knots(face.surface.knots_u, n, p) || !fuzz::are_knots(face.surface.knots_v, m, q) ||
        !fuzz::are_points<3>(face.surface.control_points)) {
        return std::nullopt;
    }
    for (std::uint32_t loops = source.below(3); loops > 0; --loops) {
        bob::TrimLoop& loop = face.loops.emplace_back();
        for (std::uint32_t curves = source.below(4); curves > 0; --curves) {
            loop.push_back(fuzz::curve<2>(source, 4));
            if (loop.back().control_points.empty()) return std::nullopt;
        }
    }
    return face;
}

}  // namespace

FUZZ(nurbs) {
    const double tolerance = source.flag() ? 0 : source.number();
    if (!(tolerance >= 0 && std::isfinite(tolerance))) return;
    std::vector<bob::Face> faces;
    for (int count = source.below(8) ? 1 : 2; count > 0; --count) {
        auto made = face(source);
        if (!made) return;
        faces.push_back(std::move(*made));
    }
    if (source.empty()) return;  // points that are zeros for want of bytes take long, and are all the same
    // Half of the faces are cut into few pieces; a few of the others may take longer.
    const bob::Interruption impatience(fuzz::Patience{source.rest().size() % 64 ? 500 : 20'000});
    try {
        const bob::Brep brep = bob::Brep::of_weighted_points(std::move(faces), tolerance);
        fuzz::meet(brep, source, 6, 1e-2);  // a ray in a face meets it no more precisely than its pieces are long
    } catch (const std::invalid_argument&) {  // the trims leave nothing
    } catch (const bob::Stopped&) {
    }
}
