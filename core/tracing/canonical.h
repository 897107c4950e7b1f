/// The canonical order of instances, by SHA-256 of what they are: pictures don't depend on the order in which users give
/// them, not even where surfaces coincide.
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

/// An array that a shape is made of, as files hold it.
struct ShapeTensor {
    std::string_view name;
    std::string_view dtype;  // as numpy writes it: <f8
    std::vector<std::size_t> shape;
    std::span<const std::byte> bytes;
};

/// What a shape is: its kind, and its tensors in the order of their names.
class ShapeDigest {
public:
    explicit ShapeDigest(std::string_view kind) { hash_.update(kind); }

    void add(const ShapeTensor& tensor);

    /// A text in a tensor's place.
    void add(std::string_view name, std::string_view text);

    [[nodiscard]] Digest digest() const { return hash_.digest(); }

private:
    Sha256 hash_;
};

/// What can be seen of an instance: the shape, its transform, which counts as a 4x4 matrix, and its material's numbers.
[[nodiscard]] Digest instance_digest(const Digest& shape, const AffineMap& transform, const Material& material);

/// Which of the instances, by their digests, comes first, second, ..; equal ones stay in their order.
[[nodiscard]] std::vector<std::uint32_t> canonical_order(std::span<const Digest> digests);

}  // namespace bob
