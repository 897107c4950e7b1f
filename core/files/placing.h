/// Parts of a file in their places, by surface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "base/vec3d.h"
#include "files/part.h"

namespace bob::files {

/// Triangles and vertices in all parts of a file: this many take a few GB, and half as many fit into a page.
constexpr std::uint64_t max_items = sizeof(void*) > 4 ? 100'000'000 : 50'000'000;

constexpr Rows identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// The map that does b first, then a.
[[nodiscard]] Rows product(const Rows& a, const Rows& b);

/// A point where the map takes it, or a direction without the shift.
[[nodiscard]] Vec3d moved(const Rows& m, const double* p, double shift = 1);

/// The map of normals: cofactors, which are det times the inverse transpose, and exist where a part is pressed flat. Second,
/// whether the map mirrors.
[[nodiscard]] std::pair<Rows, bool> of_normals(const Rows& m);

/// Adds parts to the contents of a file: one part for each surface, and labels in a tree.
class Placing {
public:
    explicit Placing(Contents& contents) : contents_(contents) {}

    /// Counts triangles and vertices, before there are any. Throws std::invalid_argument if there are too many.
    void count(std::size_t items);

    /// A new label below a parent, or -1. A second one of a name becomes "name 2".
    [[nodiscard]] int label(std::string name, int parent);

    /// Adds a part, moved, to the part of its surface. Its runs do not matter: its triangles have this label.
    void add(Part part, const Rows& place, int label);

    /// Completes the fields that only some parts of a surface have; after the last part.
    void finish();

private:
    Contents& contents_;
    std::uint64_t items_ = 0;
    std::map<std::pair<int, std::string>, int> taken_;  // how many labels of a parent have a name
    std::map<int, std::size_t> parts_;                  // by surface
};

}  // namespace bob::files
