#include "shapes/implicit/vm_solid.h"

#include <stdexcept>

#include "formula/sequenced.h"

namespace bob {
namespace {

constexpr Bounds cube{{-1, -1, -1}, {1, 1, 1}};

constexpr double height = 0.1;

// Higher than the extrusion, so that its ends are the solid's and not the box's.
constexpr Bounds flat_box{{-1, -1, -height}, {1, 1, height}};

/// max(f(x, y), |z| - height / 2)
Expression extruded(const Expression& f) {
    Graph graph;
    const Value z = graph.z(), x = graph.x(), y = graph.y();  // in one order, so that files of it are equal
    const Value sides = graph.substitute(f, x, y, z);
    return graph.expression(max(sides, abs(z) - height / 2));
}

}  // namespace

VmSolid vm_solid(const Expression& f) {
    if (!f.uses(Op::z)) return {extruded(f), flat_box, true};
    try {
        return {f, find_bounds(f), false};
    } catch (const std::invalid_argument&) {
        return {f, cube, true};
    }
}

}  // namespace bob
