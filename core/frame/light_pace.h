/// How large a frame of moving light is, and how many of its pixels get paths.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "frame/pace.h"

namespace bob {

/// It has no clock: hosts report their measurements, in any unit of time.
class LightPace {
public:
    /// Minimum share of the pixels: with 0, a budget below the time for completing would trace none. SSIM of a first picture of 5
    /// scenes is .9156 with .0025, .9246 with .005 and .9408 with .01.
    static constexpr double min_share = 0.005;

    /// The number of pixels to trace in a frame of `total` pixels with `left` time after its first hits.
    [[nodiscard]] std::size_t pixels(std::size_t total, double left) const {
        const double in_time = for_pixel() > 0 ? std::max(0., left - completing_) / for_pixel() : 0, all = static_cast<double>(total);
        return static_cast<std::size_t>(std::min(all, std::max(min_share * all, in_time)));
    }
    /// The divisor of a moving frame's height and width, of `total` pixels at 1: first hits and completing take at most `surfaces` of the
    /// time. Before the first measurement, 1.
    double scale(std::size_t total, double time) {
        const auto fits = [&](double scale) {
            const double limit = (scale < scale_ ? growing : 1) * surfaces * time;
            return for_surface_ * static_cast<double>(total) <= limit * scale * scale;
        };
        const auto found = std::ranges::find_if(scales, fits);
        return scale_ = found == scales.end() ? scales.back() : *found;
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
    static constexpr double growing = 0.8;   // of that time, for a larger frame than the last: else two sizes would alternate
    static constexpr std::array scales{1., 1.25, 1.5, 2., 2.5, 3.};

    double pixels_ = 0, time_ = 0;  // decaying sums: few pixels, whose call costs more than their paths, count little
    double completing_ = 0;
    double for_surface_ = 0, scale_ = 1;
};

}  // namespace bob
