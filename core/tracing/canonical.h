/// The canonical order of instances, by SHA-256 of their contents. Pictures do not depend on the order given by users,
/// even where surfaces coincide.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/affine.h"
#include "base/sha256.h"
#include "tracing/material.h"

namespace bob {

/// An array of a shape, as in files.
struct ShapeTensor {
    std::string_view name;
    std::string_view dtype;  // in numpy's notation: <f8
    std::vector<std::size_t> shape;
    std::span<const std::byte> bytes;
};

/// The digest of a shape: of its kind, and of its tensors ordered by name.
class ShapeDigest {
public:
    explicit ShapeDigest(std::string_view kind) { hash_.update(kind); }

    void add(const ShapeTensor& tensor);

    /// Adds a text as a tensor.
    void add(std::string_view name, std::string_view text);

    [[nodiscard]] Digest digest() const { return hash_.digest(); }

private:
    Sha256 hash_;
};

/// The digest of an instance's appearance: the shape, its transform as a 4x4 matrix, and its material's numbers.
[[nodiscard]] Digest instance_digest(const Digest& shape, const AffineMap& transform, const Material& material);

/// Indices of the instances, sorted by digest; equal ones keep their order.
[[nodiscard]] std::vector<std::uint32_t> canonical_order(std::span<const Digest> digests);

}  // namespace bob
