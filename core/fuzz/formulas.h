/// Checks of a formula from any source.
#pragma once

#include <cmath>
#include <optional>
#include <stdexcept>

#include "base/interruption.h"
#include "formula/expression.h"
#include "formula/scratch.h"
#include "formula/tape.h"
#include "fuzz/fuzz.h"
#include "fuzz/rays.h"
#include "shapes/implicit/bounds.h"
#include "shapes/implicit/implicit.h"

namespace fuzz {

/// Budget of boxes and cells for building: some milliseconds, enough for most formulas.
constexpr int patience = 1000;

/// The bounds of a formula; empty if it is unbounded or the budget is spent.
inline std::optional<bob::Bounds> bounds_of(const bob::Expression& f) {
    const bob::Interruption impatience(Patience{patience});
    try {
        return bob::find_bounds(f);
    } catch (const std::invalid_argument&) {  // unbounded
    } catch (const bob::Stopped&) {
    }
    return std::nullopt;
}

/// Checks that a colour is in range and equals its components evaluated alone.
inline void colors(const bob::ColorFormula& color) {
    const bob::FormulaKernels& kernels = bob::best_formula_kernels();
    float point[3][bob::max_lanes], rgb[3][bob::max_lanes], alone[bob::max_lanes];
    for (int i = 0; i < kernels.lanes; ++i) {
        const auto at = static_cast<float>(i);
        point[0][i] = 0.25f * at - 1, point[1][i] = 1 - 0.125f * at, point[2][i] = 0.1f * at;
    }
    const float* const axes[3] = {point[0], point[1], point[2]};
    float* const components[3] = {rgb[0], rgb[1], rgb[2]};
    const bob::ColorTape tape(color);
    kernels.colors(tape.code(), tape.results().data(), axes, kernels.lanes, components, bob::scratch(tape.code().registers));
    for (std::size_t k = 0; k < 3; ++k) {
        const auto end = color.nodes().begin() + color.roots()[k] + 1;
        const bob::Tape component(bob::Expression({color.nodes().begin(), end}));
        kernels.values(component.code(), axes, kernels.lanes, alone, bob::scratch(component.code().registers));
        for (int i = 0; i < kernels.lanes; ++i) {
            expect(rgb[k][i] == alone[i] || (std::isnan(rgb[k][i]) && std::isnan(alone[i])), "components as they are alone");
        }
        const double shown = color(point[0][1], point[1][1], point[2][1])[k];
        expect(shown >= 0 && shown <= 1, "a colour in range");
    }
}

/// Builds the surface of a formula within a box, and meets it with some rays.
inline void trace(const bob::Expression& f, const bob::Bounds& box, Source& source) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(in_range(box.low[axis]) && in_range(box.high[axis]) && box.low[axis] < box.high[axis])) return;
    }
    const bob::Interruption impatience(Patience{patience});
    try {
        const bob::Implicit shape(f, box);
        if (!shape.cells().cells().empty()) meet(shape, box, source, 8);
    } catch (const bob::Stopped&) {
    } catch (const bob::TooLarge&) {
    }
}

}  // namespace fuzz
