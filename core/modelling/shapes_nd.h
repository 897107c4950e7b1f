/// Shapes common to two and three dimensions: balls, boxes, and slabs between planes.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "modelling/words.h"

namespace bob {

template <std::size_t n>
Object ball(const Arguments& a) {
    Graph graph;
    return sdf<n>(graph, length(point<n>(graph) - a.vector<n>("center")) - a.number("radius"));
}

template <std::size_t n>
Object slab(const Arguments& a) {
    constexpr std::array<std::string_view, 6> names{"x0", "x1", "y0", "y1", "z0", "z1"};
    Graph graph;
    const Point<n> p = point<n>(graph);
    std::optional<Value> result;
    for (std::size_t i = 0; i < 2 * n; ++i) {
        if (!a.has(names[i])) continue;
        const Value side = (p[i / 2] - a.number(names[i])) * (i % 2 ? 1.0 : -1.0);
        result = result ? smooth_max(*result, side, smoothness(a)) : side;
    }
    if (!result) a.reject(n == 2 ? "expected at least one of x0, y0, x1, y1, got none"
                                 : "expected at least one of x0, y0, z0, x1, y1, z1, got none");
    return sdf<n>(graph, *result);
}

template <std::size_t n>
Object box(const Arguments& a) {
    Vector<n> size = a.size<n>("size"), center = a.vector<n>("center");
    if (a.has("a") != a.has("b")) a.reject(a.has("a") ? "b" : "a", "a corner, as the other is given");
    if (a.has("a")) {
        size = a.vector<n>("b") - a.vector<n>("a");
        center = a.vector<n>("a") - size * -0.5;
    }
    Graph graph;
    return sdf<n>(graph, corner(abs(point<n>(graph) - center) - size * 0.5));
}

}  // namespace bob
