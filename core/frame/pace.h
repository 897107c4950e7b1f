/// How many pixels take how long, as measured.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace bob {

/// What `bench/frame_constants.py` shows to be worth having: docs/frame.md has each one's evidence.
struct FrameConstants {
    double margin = 1.25;         ///< times the pixels of a whole picture there has to be time for: one that is cut off is worse than squares
    double untried = 2;           ///< by which a mode that was never tried is taken for faster than a first round
    double doubt = 0.2;           ///< by which what was measured once is taken for faster with each frame that does not use it
    double floor = 0.1;           ///< of the time that was measured, at which doubt ends
    double fade = 0.8;            ///< weight of the calls before, against the last one
    double growth = 8;            ///< times the pixels of the largest call: small calls say little about a large one
};

/// How far a measurement is still believed. With each frame that does not use what was measured, it is taken for faster, so that
/// what was slow is tried again: soon the first time, since the first use of code is slow, and then half as soon each time.
class Trust {
public:
    void measured() {
        if (share_ < 1) tries_ = std::min(tries_ + 1, most_tries);
        share_ = 1;
    }
    void doubt(const FrameConstants& c) { share_ = std::max(share_ * (1 - c.doubt / (1 << tries_)), c.floor); }
    /// Of the time that was measured.
    [[nodiscard]] double share() const { return share_; }

private:
    static constexpr int most_tries = 6;  // then about once in two hundred frames
    double share_ = 1;
    int tries_ = 0;
};

/// A call costs something, however few its pixels, and something for each pixel: a line through the last calls, fitted
/// with weights that fade. While it is uncertain, calls grow step by step and so differ enough for the fit.
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

    /// How many pixels fit into a call of so many seconds; 0 if less than a call costs.
    [[nodiscard]] double pixels_in(double seconds) const {
        if (!is_known()) return first_call;
        const Costs costs = fitted();
        return std::max(0., std::min((seconds - costs.call) / costs.pixel, constants_.growth * largest_));
    }

    /// How many pixels take as long as the call around them: with fewer, most of the time is lost.
    [[nodiscard]] double worthwhile() const {
        if (!is_known()) return first_call;
        const Costs costs = fitted();
        return std::max(1., std::min(costs.call / costs.pixel, constants_.growth * largest_));
    }

    /// Pixels a second, of calls like those so far; 0 where nothing is known.
    [[nodiscard]] double rate() const { return is_known() ? sums_[1] / std::max(trust_.share() * sums_[2], least_seconds) : 0; }

    void doubt() { trust_.doubt(constants_); }

private:
    /// Pixels, while nothing is known: 1 ms of a tracer of 30,000 rays a second.
    static constexpr double first_call = 32;
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
    double largest_ = 0;
    FrameConstants constants_;
    Trust trust_;
};

}  // namespace bob
