/// Triangles of Draco: edgebreaker (Rossignac, 1999), decoded backwards, and seams of attributes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "files/binary.h"

namespace bob::files::draco {

/// Triangles as corners: corner c is one of triangle c / 3. A missing corner or vertex is -1.
struct Corners {
    std::vector<std::int32_t> opposite;  // the corner across the edge opposite to each
    std::vector<std::int32_t> vertex;    // of each corner
    std::vector<std::int32_t> leftmost;  // a corner of each vertex: the leftmost, if the vertex is on a boundary

    static constexpr std::int32_t next(std::int32_t c) { return c < 0 ? c : c % 3 == 2 ? c - 2 : c + 1; }
    static constexpr std::int32_t previous(std::int32_t c) { return c < 0 ? c : c % 3 == 0 ? c + 2 : c - 1; }

    [[nodiscard]] std::int32_t across(std::int32_t c) const { return c < 0 ? c : opposite[static_cast<std::size_t>(c)]; }
    [[nodiscard]] std::int32_t vertex_of(std::int32_t c) const { return vertex[static_cast<std::size_t>(c)]; }
    /// The corners of the same vertex in the triangles to the left and right.
    [[nodiscard]] std::int32_t left(std::int32_t c) const { return next(across(next(c))); }
    [[nodiscard]] std::int32_t right(std::int32_t c) const { return previous(across(previous(c))); }

    [[nodiscard]] bool is_on_boundary(std::int32_t v) const { return left(leftmost[static_cast<std::size_t>(v)]) < 0; }

    /// Calls f with every corner around the vertex of c, c first, until f returns false.
    template <class F>
    void around(std::int32_t c, F f) const {
        for (std::int32_t at = c; f(at);) {
            at = left(at);
            if (at == c) return;
            if (at >= 0) continue;
            for (at = right(c); at >= 0 && f(at);) at = right(at);
            return;
        }
    }
};

/// The triangles of a mesh, and of attributes that are cut along seams.
struct Connectivity {
    Corners corners;
    std::vector<Corners> cut;
    std::vector<std::int32_t> points;  // of each corner
    std::size_t point_count = 0;
};

[[nodiscard]] Connectivity edgebreaker(Stream& stream, std::size_t max_triangles, Budget& budget);

}  // namespace bob::files::draco
