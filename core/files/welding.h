/// Vertices in the same place become one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "files/part.h"

namespace bob::files {

/// Joins the repeated vertices of STL, in order of first appearance.
class Welding {
public:
    /// corners: how many there will be, about.
    explicit Welding(std::size_t corners);

    /// A corner of a triangle.
    void add(double x, double y, double z);
    /// Facets of a binary STL, 50 bytes each, and if `has_attributes`, as many more as the last two say.
    void add_facets(Bytes bytes, std::size_t count, bool has_attributes);

    [[nodiscard]] Part part() && { return std::move(part_); }

private:
    [[nodiscard]] bool is_at(std::int32_t vertex, const double (&place)[3]) const;
    std::int32_t& find(const double (&place)[3]);
    void grow();

    std::vector<std::int32_t> slots_;  // vertices by their hashes; -1 if free
    Part part_;
};

}  // namespace bob::files
