/// The throughput of a tracer with several calls in flight.
#pragma once

#include <algorithm>
#include <map>

#include "frame/pace.h"

namespace bob {

/// The rate of all calls together, measured as they return.
///
/// The duration of one call is no measure of throughput, since calls also wait for each other. With c calls in flight, a call of n pixels
/// returns after c n / rate seconds (Little, 1961).
class Turnover {
public:
    explicit Turnover(const FrameConstants& constants = {}) : constants_(constants) {}

    /// A call began while no other was in flight.
    void resumed(double at) { since_ = at; }

    /// A call returned at time `at`, `seconds` after it began.
    void returned(int pixels, double seconds, double at, int in_flight) {
        const double fade = 1 - 1. / (turns * in_flight);
        pixels_ = fade * pixels_ + pixels;
        seconds_ = fade * seconds_ + at - since_;
        since_ = at;
        ++count_;
        const auto [call, is_new] = fastest_.try_emplace(pixels, seconds);
        if (!is_new) call->second = std::min(call->second, seconds);
    }

    /// The pixels of a call that takes `seconds`, at least `worthwhile`.
    [[nodiscard]] int pixels_in(double seconds, int in_flight) const {
        if (count_ < in_flight) return static_cast<int>(first_call);
        const double count = seconds * pixels_ / std::max(seconds_, min_seconds) / in_flight;
        const double max = constants_.growth * fastest_.rbegin()->first;
        return std::max(1, static_cast<int>(std::min(std::max<double>(count, worthwhile()), max)));
    }

    /// The number of pixels that takes as long as the fixed cost of a call.
    ///
    /// Both costs come from the fastest calls of the smallest and the largest size, which waited the shortest. A fit through all calls mistakes
    /// waiting for fixed cost and lets calls grow without bound: with 16 workers and 32 calls in flight, from 24 pixels to 3,000, which
    /// returned after 8 seconds.
    [[nodiscard]] int worthwhile() const {
        if (fastest_.size() < 2) return 1;
        const auto [few, shortest] = *fastest_.begin();
        const auto [many, longest] = *fastest_.rbegin();
        if (longest <= shortest) return many;
        return static_cast<int>(std::clamp(shortest * (many - few) / (longest - shortest) - few, 1., 1e9));
    }

private:
    static constexpr double turns = 2;  // time constant of the decay, in rounds of all calls in flight

    FrameConstants constants_;
    double pixels_ = 0, seconds_ = 0;  // decayed sums: pixels returned, seconds taken
    double since_ = 0;                 // time of the last return, or of the first call after an idle period
    int count_ = 0;
    std::map<int, double> fastest_;    // seconds of the fastest call of each size
};

}  // namespace bob
