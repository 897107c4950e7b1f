/// Traces pictures: from an order of pixels to planes.
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

/// Traces the first pixels of an order: chooses a round, traces it and scatters its samples, round by round.
class PictureTracing {
public:
    /// Pixels per call without decisions between them: a few hundredths of a second of work.
    static constexpr std::size_t piece = std::size_t{1} << 17;

    /// `order`: a name of `make_order`, "adaptive", "squares", "priority", "default", or "tiles", the fastest for all
    /// pixels.
    PictureTracing(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout, std::string_view order,
                   std::uint64_t seed);

    /// Traces until `count` pixels are done; with tiles, up to a row of tiles more. Planes are (layout.width(), height,
    /// width), initially 0, and the same in each call.
    void trace(std::size_t count, float* planes);

    /// Pixels traced so far.
    [[nodiscard]] std::size_t done() const { return done_; }

    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] const Layout& layout() const { return layout_; }

private:
    /// Traces from the start, where tracing all pixels is faster; then clears the pixels beyond `count`.
    void trace_all(std::size_t count, float* planes);
    /// The next pixels: at most `count`.
    std::span<const Pixel> next(std::size_t count, const float* planes);
    /// Traces the next rows of tiles: at least one, and no more for at most `count` pixels.
    void trace_tiles(std::size_t count, float* planes);

    const Scene& scene_;
    Camera camera_;
    int height_, width_;
    Layout layout_;
    std::unique_ptr<RoundOrder> rounds_;  // for orders with rounds
    Order order_;                         // for orders known from the start
    std::span<const Pixel> round_;        // not traced yet
    std::vector<Pixel> pixels_;
    std::size_t done_ = 0;
};

}  // namespace bob
