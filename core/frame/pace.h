/// How many pixels take how long, as measured.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace bob {

/// By which what was measured once is taken for faster with each frame that does not use it, as the first use of code is slow;
/// by half of this where it was measured twice, and so on.
constexpr double doubt_of_first = 0.2;

/// A call costs something, however few its pixels, and something for each pixel: a line through the last calls, fitted
/// with weights that fade. While it is uncertain, calls grow step by step and so differ enough for the fit.
class Pace {
public:
    void measured(double count, double seconds) {
        const std::array<double, 5> now = {1, count, seconds, count * count, count * seconds};
        for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] = fade_of_calls * sums_[i] + now[i];
        largest_ = std::max(largest_, count);
        ++calls_;
    }

    [[nodiscard]] bool is_known() const { return largest_ > 0; }

    /// How many pixels fit into a call of so many seconds; 0 if less than a call costs.
    [[nodiscard]] double pixels_in(double seconds) const {
        if (!is_known()) return first_call;
        const Costs costs = fitted();
        return std::max(0., std::min((seconds - costs.call) / costs.pixel, growth * largest_));
    }

    /// How many pixels take as long as the call around them: with fewer, most of the time is lost.
    [[nodiscard]] double worthwhile() const {
        if (!is_known()) return first_call;
        const Costs costs = fitted();
        return std::max(1., std::min(costs.call / costs.pixel, growth * largest_));
    }

    /// Pixels a second, of calls like those so far; 0 where nothing is known.
    [[nodiscard]] double rate() const { return is_known() ? sums_[1] / std::max(sums_[2], least_seconds) : 0; }

    /// Takes what was measured for faster, the more so the less was: what seemed slow at first is tried again soon.
    void doubt() {
        const double share = 1 - doubt_of_first / calls_;
        if (is_known()) sums_[2] *= share, sums_[4] *= share;
    }

private:
    /// Of the calls before, against the last one.
    static constexpr double fade_of_calls = 0.8;
    /// Pixels, while nothing is known: 1 ms of a tracer of 30,000 rays a second.
    static constexpr double first_call = 32;
    /// Times the pixels of the largest call: small calls say little about a large one.
    static constexpr double growth = 8;
    static constexpr double least_seconds = 1e-9;

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
    double largest_ = 0, calls_ = 0;
};

}  // namespace bob
