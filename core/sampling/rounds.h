/// Pixel orders that depend on what the pixels before show.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "picture/channels.h"
#include "picture/gbuffer.h"

namespace bob {

/// Decides round by round which pixels of a picture come next. Nothing within a round depends on what its own pixels show: so the
/// sequence is a function of what the order was made of and of what was traced, never of time, pace or threads, and a tracer is
/// called a few times with many pixels.
class RoundOrder {
public:
    RoundOrder(std::uint32_t height, std::uint32_t width) : height_(height), width_(width) {}
    virtual ~RoundOrder() = default;
    RoundOrder(const RoundOrder&) = delete;
    RoundOrder& operator=(const RoundOrder&) = delete;

    /// The next round: at least one pixel, or none where all were decided; they stay until the next call. All pixels of the rounds
    /// before have been traced; what they show is taken from the planes, (C, height, width) of a layout.
    virtual std::span<const Pixel> next(const Layout& layout, const float* planes) = 0;

    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }

    /// Bytes in use.
    [[nodiscard]] virtual std::size_t bytes() const = 0;

protected:
    std::uint32_t height_, width_;
};

}  // namespace bob
