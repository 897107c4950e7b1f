/// Formulas as nodes of scene files, checked like files. Bounds of boxes contain the values of their points, and the sign changes at
/// each root.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "formula/mesh_distance.h"
#include "formula/scratch.h"
#include "formula/tape.h"
#include "formula/text.h"
#include "fuzz/formulas.h"

namespace {

using Point = std::array<float, 3>;

/// A tetrahedron.
const bob::MeshDistance& mesh() {
    static const auto made = [] {
        const std::vector<bob::Vec3> vertices{{-0.5f, -0.5f, -0.5f}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        const std::vector<bob::MeshDistance::Triangle> triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
        return bob::MeshDistance::of(vertices, triangles);
    }();
    return *made;
}

bob::Expression formula(fuzz::Source& source) {
    std::vector<bob::Node> nodes{{.op = bob::Op::x}, {.op = bob::Op::y}, {.op = bob::Op::z}};
    const int steps = source.between(1, 24);
    for (int i = 0; i < steps; ++i) {
        bob::Node node{.op = static_cast<bob::Op>(source.below(bob::op_count + 1))};  // one value is invalid
        const auto count = static_cast<std::uint32_t>(nodes.size());
        for (std::uint32_t& operand : node.operand) {
            const std::uint8_t back = source.byte();
            operand = back < 250 ? count - 1 - back % count : back;  // some come later, or never
        }
        if (node.op == bob::Op::constant) node.value = source.number();
        if (node.op == bob::Op::mesh_distance) node.value = mesh().number();
        if (node.op == bob::Op::power) node.value = source.byte() < 250 ? source.between(-5, 8) : source.number();
        nodes.push_back(node);
    }
    return bob::Expression(std::move(nodes));
}

/// The expression as a graph stores it.
bob::Expression simplified(const bob::Expression& f) {
    bob::Graph graph;
    return graph.expression(graph.copy(f));
}

std::vector<float> values(const bob::Tape& tape, const std::vector<Point>& points) {
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    const auto lanes = static_cast<std::size_t>(kernels.lanes);
    std::vector<float> result(points.size());
    for (std::size_t first = 0; first < points.size(); first += lanes) {
        const std::size_t count = std::min(points.size() - first, lanes);
        float p[3][bob::max_lanes];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t i = 0; i < count; ++i) p[axis][i] = points[first + i][axis];
        }
        const float* const axes[3] = {p[0], p[1], p[2]};
        kernels.values(tape.code(), axes, static_cast<int>(count), &result[first], bob::scratch(tape.code().registers));
    }
    return result;
}

/// A point of a box: a corner, or between.
float within(fuzz::Source& source, float low, float high) {
    const std::uint8_t at = source.byte();
    return at < 32 ? low : at < 64 ? high : std::clamp(low + (high - low) * static_cast<float>(at - 64) / 191, low, high);
}

void bounds_hold_values(const bob::Tape& tape, fuzz::Source& source) {
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    bob::BoxBatch boxes{};
    const float size = std::array{0.f, 1e-6f, 1e-2f, 1.f, 1e4f, 1e9f}[source.below(6)];
    for (int lane = 0; lane < kernels.lanes; ++lane) {
        for (int axis = 0; axis < 3; ++axis) {
            const float corner = static_cast<float>(source.within(-2, 2));
            boxes.low[axis][lane] = corner;
            boxes.high[axis][lane] = corner + size * static_cast<float>(source.byte()) / 255;
        }
        if (source.empty()) break;  // the others are the origin
    }
    std::vector<bob::Decision> decisions(tape.decisions().size());
    kernels.bounds(tape.code(), boxes, decisions.data(), bob::scratch(tape.code().registers));
    for (int lane = 0; lane < kernels.lanes; ++lane) {
        std::vector<Point> points(8);
        for (Point& p : points) {
            for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = within(source, boxes.low[axis][lane], boxes.high[axis][lane]);
        }
        const bool partly = boxes.partly >> lane & 1, nowhere = boxes.nowhere >> lane & 1;
        for (const float value : values(tape, points)) {
            const bool outside = value < boxes.least[lane] || value > boxes.most[lane];  // false where a bound is NaN
            fuzz::expect(std::isnan(value) ? partly || nowhere : !nowhere && !outside, "bounds that hold every value");
        }
    }
    kernels.narrow(tape.code(), boxes, bob::scratch(tape.code().registers));
}

void roots_are_sign_changes(const bob::Tape& tape, fuzz::Source& source) {
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    std::vector<bob::Segment> segments;
    do {
        bob::Segment& segment = segments.emplace_back();
        for (int axis = 0; axis < 3; ++axis) {
            segment.origin[axis] = static_cast<float>(source.within(-1, 1));
            segment.direction[axis] = static_cast<float>(source.within(-1, 1));
        }
        segment.t_end = static_cast<float>(source.within(0.01, 3));
        segment.finest = source.flag() ? 1e-4f : 1e-6f;
        segment.least_slope = -std::numeric_limits<float>::infinity();
        segment.most_slope = std::numeric_limits<float>::infinity();
    } while (!source.empty() && segments.size() < 2 * static_cast<std::size_t>(kernels.lanes));
    kernels.first_roots(tape.code(), segments.data(), segments.size(), bob::scratch(tape.code().registers));
    for (const bob::Segment& segment : segments) {
        if (!segment.found) continue;
        fuzz::expect(segment.t >= 0 && segment.t <= segment.t_end, "a root on the ray");
        std::vector<Point> around;
        for (double off = 0; off < 1.1e-4; off = std::clamp(2 * off, 1e-7, off + 2e-6)) {
            for (const double t : {std::max(0., segment.t - off), std::min<double>(segment.t_end, segment.t + off)}) {
                Point& p = around.emplace_back();
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    p[axis] = segment.origin[axis] + static_cast<float>(t) * segment.direction[axis];
                }
            }
        }
        const std::vector<float> near = values(tape, around);
        const auto below = std::count_if(near.begin(), near.end(), [](float f) { return f < 0; });
        // Where f jumps to a zero that it leaves again to the side it came from, as -x mod 1 does, the zero is one point.
        const bool zero = std::any_of(near.begin(), near.end(), [](float f) { return std::fabs(f) < 1e-4f; });
        fuzz::expect(zero || (below > 0 && below < std::ssize(near)), "a root where the sign changes");
    }
}

}  // namespace

FUZZ(expression) {
    std::optional<bob::Expression> f;
    const bool plain = source.flag();
    const std::uint32_t part = source.below(16);
    try {
        f = formula(source);
    } catch (const std::invalid_argument&) {
        return;
    }
    const auto last = static_cast<std::uint32_t>(f->nodes().size() - 1);
    fuzz::colors(bob::ColorFormula(f->nodes(), {last, last / 2, 0}));
    if (!plain) f = simplified(*f);
    fuzz::expect(bob::to_text(*f, 60).size() <= 60, "a text of the length asked for");
    if (part < 15) {
        const bob::Tape tape(*f);
        if (part % 3 != 0) bounds_hold_values(tape, source);
        if (part % 3 != 1) roots_are_sign_changes(tape, source);
    } else if (source.flag()) {
        if (const auto box = fuzz::bounds_of(*f)) fuzz::trace(*f, *box, source);
    } else {
        bob::Bounds box;
        for (int axis = 0; axis < 3; ++axis) box.low[axis] = source.number(), box.high[axis] = source.number();
        fuzz::trace(*f, box, source);
    }
}
