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

/// What lies beyond a picture's edge.
enum class Wrap : std::uint8_t { repeat, clamp, mirror };

/// An sRGB picture, and smaller and smaller ones of it: level n + 1 has half the size of level n, rounded up, and each of its texels is
/// the mean of those that it covers, in linear light. Colours count as far as they are opaque, wherever they are mixed: what is cut out
/// lends none to what is beside it.
class Picture {
public:
    /// texels: (height, width, 3), from the top row down; at least one. alpha: (height, width), how opaque each is; none if all are.
    /// They are read for as long as it lives: the owner keeps them, if nobody else does.
    Picture(std::span<const std::uint8_t> texels, int height, int width, std::span<const std::uint8_t> alpha = {},
            std::shared_ptr<const void> owner = nullptr);
    Picture(const Picture&) = delete;

    /// Of all texels, 0..1.
    [[nodiscard]] float least_alpha() const { return least_alpha_; }
    [[nodiscard]] int height() const { return levels_[0].height; }
    [[nodiscard]] int width() const { return levels_[0].width; }
    [[nodiscard]] std::size_t bytes() const;

private:
    friend class Texture;

    struct Level {
        int height, width;
        std::span<const std::uint8_t> texels;  // (height, width, 3)
        std::span<const std::uint8_t> alpha;   // (height, width), or none

        [[nodiscard]] float opacity(std::size_t texel) const { return alpha.empty() ? 1 : static_cast<float>(alpha[texel]) / 255; }
    };

    std::shared_ptr<const void> owner_;
    std::vector<std::uint8_t> smaller_;  // of all levels but the first
    std::vector<Level> levels_;
    float least_alpha_;
};

/// A picture on a surface. Textures share it.
class Texture {
public:
    explicit Texture(std::shared_ptr<const Picture> picture, Wrap across = Wrap::repeat, Wrap down = Wrap::repeat)
        : picture_(std::move(picture)), across_(across), down_(down) {}

    /// Linear RGB, 0..1, at u, 0 at the left edge to 1 at the right one, and v, 0 at the top edge to 1 at the bottom: bilinear in the two
    /// levels whose texels are next to `width`, in texels of level 0, and between these.
    [[nodiscard]] Vec3 operator()(float u, float v, float width) const;

    /// The same in two steps, for several places in turn: `look_up` fetches the texels, which are rarely in the cache, and does not wait.
    struct Lookup;
    [[nodiscard]] Lookup look_up(float u, float v, float width) const;
    [[nodiscard]] Vec3 color(const Lookup& lookup) const;

    /// How opaque it is there, 0..1: bilinear in level 0, so that what is cut out of a surface does not depend on a picture's size.
    [[nodiscard]] float alpha(float u, float v) const;

    [[nodiscard]] const Picture& picture() const { return *picture_; }

private:
    using Level = Picture::Level;

    /// Where the four texels around a place are, (row, column), and how far it is from the first to the last.
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
    float u, v, share;  // where it is, and how much the next level counts
};

}  // namespace bob
