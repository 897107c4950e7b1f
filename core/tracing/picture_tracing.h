/// A picture, from an order of pixels to planes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "picture/camera.h"
#include "picture/channels.h"
#include "picture/gbuffer.h"
#include "sampling/order.h"
#include "sampling/rounds.h"
#include "tracing/scene.h"

namespace bob {

/// Traces the first pixels of an order: it decides on a round, traces it and scatters its samples, round after round.
class PictureTracing {
public:
    /// Pixels that are handed out at once where nothing is decided between them: a few hundredths of a second of work.
    static constexpr std::size_t piece = std::size_t{1} << 17;

    /// An order's name: those of `make_order`, "adaptive", "squares", "priority", and "tiles", which is fastest for all pixels.
    PictureTracing(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout, std::string_view order,
                   std::uint64_t seed);

    /// Goes on until `count` pixels are traced, of tiles up to a row of these more. Planes are (layout.width(), height, width), 0 at
    /// first, and the same in each call.
    void trace(std::size_t count, float* planes);

    /// Pixels traced so far.
    [[nodiscard]] std::size_t done() const { return done_; }

    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] const Layout& layout() const { return layout_; }

private:
    /// The same from none on, where that is faster: of all pixels, those that would not have been traced are cleared.
    void trace_all(std::size_t count, float* planes);
    /// The next pixels, at most so many, but of tiles.
    std::span<const Pixel> next(std::size_t count, const float* planes);
    void next_tiles(std::size_t count);

    const Scene& scene_;
    Camera camera_;
    int height_, width_;
    Layout layout_;
    std::unique_ptr<RoundOrder> rounds_;  // of an order that has them
    Order order_;                         // of one that is known from the start
    std::span<const Pixel> round_;        // the rest of it
    std::vector<Pixel> pixels_;
    std::size_t done_ = 0;
};

}  // namespace bob
