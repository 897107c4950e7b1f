/// Environments: pictures of light from all directions, and directions drawn in proportion to it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/vec.h"

namespace bob {

/// An equirectangular picture. Rows go from straight up to straight down, columns clockwise seen from above; the middle lies along -x.
class Environment {
public:
    /// texels: (height, width), linear RGB of at least 0, finite. Throws std::invalid_argument if it is larger than `max_texels`.
    Environment(std::span<const Vec3> texels, int height, int width);

    /// The radiance from a direction of unit length, bilinear.
    [[nodiscard]] Vec3 radiance(Vec3 toward) const;

    /// A direction drawn by how bright texels are, and its density over the sphere; 0 of a black environment.
    struct Drawn {
        Vec3 toward;
        float density;
    };
    [[nodiscard]] Drawn draw(float u, float v) const;
    [[nodiscard]] float density(Vec3 toward) const;

    static constexpr std::size_t max_texels = std::size_t{1} << 25;  // 8192 x 4096

private:
    struct Place {
        float row, column;  // in texels, from the top left corner of the picture
    };
    [[nodiscard]] Place place(Vec3 toward) const;
    [[nodiscard]] const Vec3& texel(int row, int column) const { return texels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column)]; }

    int height_, width_;
    std::vector<Vec3> texels_;
    // A texel's weight is the mean luminance of 3 x 3 texels, since light is interpolated, times its solid angle. The sums reach to
    // the end of each row, and within each row.
    std::vector<float> weights_, rows_, columns_;
};

}  // namespace bob
