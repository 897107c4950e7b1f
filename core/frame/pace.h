/// Models of durations, fitted to measurements.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace bob {

/// Constants of the planner. Evidence: `bench/frame_constants.py`, in docs/frame.md.
struct FrameConstants {
    double min_tracing = 0.25;    ///< minimum time for tracing, over that for completing: every budget makes progress
    double margin = 1.25;         ///< spare time for a whole picture, as a factor: one that is cut off is worse than squares
    double untried = 2;           ///< assumed speed of an untried mode, over the speed of a first round
    double doubt = 0.2;           ///< loss of trust in a first measurement, per frame without a new one
    double floor = 0.1;           ///< minimum trust
    double fade = 0.8;            ///< weight of earlier calls, against 1 for the last one
    double growth = 8;            ///< limit of a call's pixels, over the largest call so far: small calls say little about large ones
};

/// Pixels of a first call: 1 ms of a tracer of 30,000 rays a second.
constexpr double first_call = 32;
/// Shorter times are rounding errors of clocks.
constexpr double min_seconds = 1e-9;

/// Trust in a measured time. It falls with each frame without a new measurement, so that a slow mode is tried again: soon the first
/// time, because code is slow when it runs first, and half as soon each further time.
class Trust {
public:
    void measured() {
        if (share_ < 1) tries_ = std::min(tries_ + 1, max_tries);
        share_ = 1;
    }
    void doubt(const FrameConstants& c) { share_ = std::max(share_ * (1 - c.doubt / (1 << tries_)), c.floor); }
    /// The trusted share of the measured time.
    [[nodiscard]] double share() const { return share_; }

private:
    static constexpr int max_tries = 6;  // then about once in two hundred frames
    double share_ = 1;
    int tries_ = 0;
};

/// The time of a call of the tracer: a constant, and a time per pixel. Both are fitted to the last calls, with weights
/// that fade. The first calls grow step by step, so that their sizes differ enough for the fit.
class Pace {
public:
    explicit Pace(const FrameConstants& constants = {}) : constants_(constants) {}

    void measured(double count, double seconds) {
        const std::array<double, 5> now = {1, count, seconds, count * count, count * seconds};
        for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] = constants_.fade * sums_[i] + now[i];
        largest_ = std::max(largest_, count);
        trust_.measured();
    }

    [[nodiscard]] bool is_known() const { return largest_ > 0; }

    /// The pixels of a call that takes `seconds`; 0 if the constant alone takes longer.
    [[nodiscard]] double pixels_in(double seconds) const {
        if (!is_known()) return first_call;
        const Costs costs = fitted();
        return std::max(0., std::min((seconds - costs.call) / costs.pixel, constants_.growth * largest_));
    }

    /// The number of pixels that takes as long as the constant: with fewer, the constant dominates.
    [[nodiscard]] double worthwhile() const {
        if (!is_known()) return first_call;
        const Costs costs = fitted();
        return std::max(1., std::min(costs.call / costs.pixel, constants_.growth * largest_));
    }

    /// Pixels per second of recent calls; 0 before the first measurement.
    [[nodiscard]] double rate() const { return is_known() ? sums_[1] / std::max(trust_.share() * sums_[2], min_seconds) : 0; }

    void doubt() { trust_.doubt(constants_); }

private:
    struct Costs {
        double call, pixel;  // seconds
    };
    [[nodiscard]] Costs fitted() const {
        const auto [weight, n, t, nn, nt] = sums_;
        const double spread = weight * nn - n * n;
        const double pixel = std::max(spread > 1e-6 * n * n ? (weight * nt - n * t) / spread : t / n, 1e-10);
        const double call = (t - pixel * n) / weight;
        return call >= 0 ? Costs{call, pixel} : Costs{0, std::max(t / n, 1e-10)};
    }

    std::array<double, 5> sums_{};  // of 1, n, t, n * n and n * t
    double largest_ = 0;
    FrameConstants constants_;
    Trust trust_;
};

/// The size of moving pictures, in any unit of time.
class MovingScale {
public:
    static constexpr std::array scales{1., 1.25, 1.5, 2., 2.5, 3., 4., 5., 6., 8.};

    explicit MovingScale(double max) : max_(max) {}

    /// The minimum divisor of the height and width such that `total` pixels at 1, for `time_per_pixel` each, take at most `time`; `max` if
    /// none does.
    double next(double total, double time_per_pixel, double time) {
        return next(total, time_per_pixel, time, [](double) { return 0.; });
    }
    /// Of these divisors, the one with the smallest error(divisor); the minimum one of several.
    template <class Error>
    double next(double total, double time_per_pixel, double time, Error error) {
        double chosen = max_, min_error = std::numeric_limits<double>::infinity();
        for (const double scale : scales) {
            if (scale > max_ || total * time_per_pixel > (scale < last_ ? steady : 1) * time * scale * scale) continue;
            const double expected = (scale == last_ ? kept : 1) * error(scale);
            if (expected < min_error) min_error = expected, chosen = scale;
        }
        return last_ = chosen;
    }

private:
    /// Share of the time for a larger picture than the last, and of the last size's error: otherwise two sizes would alternate.
    /// Sizes of six scenes in a page change 33 to 76 times in 150 pictures with 1 for the error, 0 to 7 times with .9. With .8, the
    /// CSG keeps a smaller size at 16 ms, and SSIM falls by .010.
    static constexpr double steady = 0.8, kept = 0.9;

    double last_ = 1, max_;
};

}  // namespace bob
