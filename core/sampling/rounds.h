/// Pixel orders that depend on the pixels traced before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "picture/channels.h"
#include "picture/gbuffer.h"

namespace bob {

/// Chooses the pixels of a picture round by round.
///
/// The samples of a round do not affect that round. The sequence is therefore a function of the order's parameters and
/// of the traced samples, never of time, speed or threads. A tracer gets few calls with many pixels.
class RoundOrder {
public:
    RoundOrder(std::uint32_t height, std::uint32_t width) : height_(height), width_(width) {}
    virtual ~RoundOrder() = default;
    RoundOrder(const RoundOrder&) = delete;
    RoundOrder& operator=(const RoundOrder&) = delete;

    /// The next round: at least one pixel, or empty if all were chosen; valid until the next call. All pixels of
    /// earlier rounds have been traced, and their samples are in the planes, (C, height, width) of a layout.
    virtual std::span<const Pixel> next(const Layout& layout, const float* planes) = 0;

    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }

    /// Bytes in use.
    [[nodiscard]] virtual std::size_t bytes() const = 0;

protected:
    std::uint32_t height_, width_;
};

}  // namespace bob
