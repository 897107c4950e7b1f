/// Pictures on surfaces.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/vec.h"

namespace bob {

/// Addressing outside the picture.
enum class Wrap : std::uint8_t { repeat, clamp, mirror };

/// A mip-mapped sRGB picture.
///
/// Level n + 1 has half the size of level n, rounded up; each of its texels is the mean of the texels it covers, in
/// linear light. Colours are always weighted by opacity, so that transparent texels do not bleed into their neighbours.
class Picture {
public:
    /// texels: (height, width, 3), at least one, top row first. alpha: (height, width), the opacity of each texel;
    /// empty if all are opaque. They are read during the picture's lifetime; `owner` keeps them alive, if necessary.
    Picture(std::span<const std::uint8_t> texels, int height, int width, std::span<const std::uint8_t> alpha = {},
            std::shared_ptr<const void> owner = nullptr);
    Picture(const Picture&) = delete;

    /// The minimum alpha of all texels, 0..1.
    [[nodiscard]] float least_alpha() const { return least_alpha_; }
    [[nodiscard]] int height() const { return levels_[0].height; }
    [[nodiscard]] int width() const { return levels_[0].width; }
    [[nodiscard]] std::size_t bytes() const;

private:
    friend class Texture;

    struct Level {
        int height, width;
        std::span<const std::uint8_t> texels;  // (height, width, 3)
        std::span<const std::uint8_t> alpha;   // (height, width), or empty

        [[nodiscard]] float opacity(std::size_t texel) const { return alpha.empty() ? 1 : static_cast<float>(alpha[texel]) / 255; }
    };

    std::shared_ptr<const void> owner_;
    std::vector<std::uint8_t> smaller_;  // all levels except the first
    std::vector<Level> levels_;
    float least_alpha_;
};

/// A picture on a surface; textures share pictures.
class Texture {
public:
    explicit Texture(std::shared_ptr<const Picture> picture, Wrap across = Wrap::repeat, Wrap down = Wrap::repeat)
        : picture_(std::move(picture)), across_(across), down_(down) {}

    /// Linear RGB, 0..1, at texture coordinates u and v. They are 0 at the left and top edges, and 1 at the right and
    /// bottom. Trilinear: bilinear in the two levels with texel sizes next to `width`, in texels of level 0, and linear
    /// between them.
    [[nodiscard]] Vec3 operator()(float u, float v, float width) const;

    /// The same in two steps, for several places: `look_up` prefetches the texels, which are rarely in the cache.
    struct Lookup;
    [[nodiscard]] Lookup look_up(float u, float v, float width) const;
    [[nodiscard]] Vec3 color(const Lookup& lookup) const;

    /// Opacity, 0..1: bilinear in level 0, so that cutouts do not depend on a picture's size.
    [[nodiscard]] float alpha(float u, float v) const;

    [[nodiscard]] const Picture& picture() const { return *picture_; }

private:
    using Level = Picture::Level;

    /// The four texels around a place, (row, column), and the fractional position between them.
    struct Around {
        std::size_t texel[2][2];
        float dx, dy;
    };

    [[nodiscard]] Around around(const Level& level, float u, float v) const;
    [[nodiscard]] static Vec3 bilinear(const Level& level, const Around& at);

    std::shared_ptr<const Picture> picture_;
    Wrap across_, down_;
};

struct Texture::Lookup {
    std::size_t level;
    Around fine;
    float u, v, share;  // the place, and the weight of the next level
};

}  // namespace bob
