/// How many pixels get paths in a frame of moving light.
#pragma once

#include <algorithm>
#include <cstddef>

namespace bob {

/// It has no clock: hosts report their measurements, in any unit of time.
class LightPace {
public:
    /// Share of the pixels that a frame traces at least.
    static constexpr double least = 0.005;

    /// The number of pixels to trace in a frame of `total` pixels with `left` time after its first hits.
    [[nodiscard]] std::size_t pixels(std::size_t total, double left) const {
        const double in_time = for_pixel() > 0 ? std::max(0., left - completing_) / for_pixel() : 0, all = static_cast<double>(total);
        return static_cast<std::size_t>(std::min(all, std::max(least * all, in_time)));
    }
    void traced(std::size_t pixels, double time) {
        pixels_ = (1 - newest) * pixels_ + static_cast<double>(pixels), time_ = (1 - newest) * time_ + time;
    }
    void completed(double time) { completing_ = completing_ == 0 ? time : completing_ + newest * (time - completing_); }

    /// The time for a pixel's paths; 0 before the first.
    [[nodiscard]] double for_pixel() const { return pixels_ > 0 ? time_ / pixels_ : 0; }
    [[nodiscard]] double for_completing() const { return completing_; }

private:
    static constexpr double newest = 0.3;  // weight of the last frame's times among those before

    double pixels_ = 0, time_ = 0;  // decaying sums: few pixels, whose call costs more than their paths, count little
    double completing_ = 0;
};

}  // namespace bob
