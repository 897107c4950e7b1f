/// A placed shape, as a key of hashed containers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/affine.h"
#include "shapes/shape.h"

namespace bob {

struct PlaceKey {
    const Shape* shape;
    AffineMap map;

    bool operator==(const PlaceKey&) const = default;

    struct Hash {
        std::size_t operator()(const PlaceKey& key) const {
            auto hash = static_cast<std::uint64_t>(std::bit_cast<std::uintptr_t>(key.shape));
            for (const auto& row : key.map.row) {
                for (const double x : row) {  // 0 and -0 are equal
                    hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15;
                    hash ^= hash >> 32;
                }
            }
            return static_cast<std::size_t>(hash);
        }
    };
};

}  // namespace bob
