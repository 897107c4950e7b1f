/// How large a frame of moving light is, and how many of its pixels get paths.
#pragma once

#include <algorithm>
#include <cstddef>

#include "frame/pace.h"

namespace bob {

/// It has no clock: hosts report their measurements, in any unit of time.
class LightPace {
public:
    /// first: assumed time for a pixel's first hit and its completing, before the first measurement. With 0, the first frame has scale 1.
    explicit LightPace(double first = 0, double max_scale = 3) : first_(first), scale_(max_scale) {}

    /// Minimum share of the pixels: with 0, a budget below the time for completing would trace none. SSIM of a first picture of 5
    /// scenes is .9156 with .0025, .9246 with .005 and .9408 with .01.
    static constexpr double min_share = 0.005;

    /// The number of pixels to trace in a frame of `total` pixels with `left` time after its first hits.
    [[nodiscard]] std::size_t pixels(std::size_t total, double left) const {
        const double in_time = for_pixel() > 0 ? std::max(0., left - completing_) / for_pixel() : 0, all = static_cast<double>(total);
        return static_cast<std::size_t>(std::min(all, std::max(min_share * all, in_time)));
    }
    /// The divisor of a moving frame's height and width, of `total` pixels at 1: first hits and completing take at most `surfaces` of the
    /// time.
    double scale(std::size_t total, double time) {
        return scale_.next(static_cast<double>(total), for_surface_ > 0 ? for_surface_ : first_, surfaces * time);
    }
    /// The time for first hits and completing of a frame of `pixels`.
    void shown(std::size_t pixels, double time) {
        const double newest = time / static_cast<double>(pixels);
        for_surface_ = for_surface_ == 0 ? newest : fade * for_surface_ + (1 - fade) * newest;
    }
    void traced(std::size_t pixels, double time) {
        pixels_ = fade * pixels_ + static_cast<double>(pixels), time_ = fade * time_ + time;
    }
    void completed(double time) { completing_ = completing_ == 0 ? time : fade * completing_ + (1 - fade) * time; }

    /// The time for a pixel's paths; 0 before the first.
    [[nodiscard]] double for_pixel() const { return pixels_ > 0 ? time_ / pixels_ : 0; }
    [[nodiscard]] double for_completing() const { return completing_; }

private:
    /// In a simulation with 15 % noise and costs that drift by 5 % a frame, 21 % of the frames are a tenth late, and 28 % if
    /// only the last frame counts.
    static constexpr double fade = FrameConstants{}.fade;
    static constexpr double surfaces = 0.7;  // share of a frame's time; the rest is for paths

    double pixels_ = 0, time_ = 0;  // decaying sums: few pixels, whose call costs more than their paths, count little
    double completing_ = 0;
    double first_, for_surface_ = 0;
    MovingScale scale_;
};

}  // namespace bob
