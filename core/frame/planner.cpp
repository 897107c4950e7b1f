#include "frame/planner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "frame/errors.h"

namespace bob {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Linear interpolation between values at ascending places; constant outside them.
float interpolated(std::span<const float> places, std::span<const float> values, float at) {
    std::size_t after = 0;
    while (after < places.size() && places[after] <= at) ++after;
    if (after == 0) return values[0];
    if (after == places.size()) return values.back();
    const float weight = (at - places[after - 1]) / (places[after] - places[after - 1]);
    return values[after - 1] + weight * (values[after] - values[after - 1]);
}

/// Interpolates errors by the share of a picture's pixels. Both are interpolated as logarithms; the error is 0 at all
/// pixels.
float error_at(std::span<const float> errors, float share) {
    std::array<float, std::size(frame_errors::shares)> places, values;
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = std::log(frame_errors::shares[i]), values[i] = std::log(errors[i]);
    const float last = frame_errors::shares[places.size() - 1];
    if (share > last) return errors.back() * (1 - share) / (1 - last);
    return std::exp(interpolated(places, values, std::log(share)));
}

/// The median, the lower of two; by counting, which is slow but little code, as pages fetch it.
double median(std::span<const double> values) {
    const auto middle = static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    for (const double value : values) {
        const auto below = std::ranges::count_if(values, [value](double other) { return other < value; });
        if (below <= middle && middle < below + std::ranges::count(values, value)) return value;
    }
    return values[0];
}

/// The mode of minimum error; adaptive if all would be late.
Mode best_mode(const std::array<double, mode_names.size()>& errors) {
    const auto found = std::ranges::min_element(errors);
    return std::isfinite(*found) ? static_cast<Mode>(found - errors.begin()) : Mode::adaptive;
}

}  // namespace

float expected_error(Mode mode, Completion completion, float share, float parallax) {
    if (mode == Mode::whole || share >= 1) return 0;
    if (mode == Mode::squares) return error_at(frame_errors::squares_filling, share);
    if (mode == Mode::adaptive) {
        if (completion == Completion::filling) return error_at(frame_errors::adaptive_filling, share);
        return error_at(completion == Completion::small ? frame_errors::adaptive_small : frame_errors::adaptive_default, share);
    }
    std::array<float, std::size(frame_errors::parallaxes)> errors;
    for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = error_at(frame_errors::reproject[i], share);
    return interpolated(frame_errors::parallaxes, errors, parallax);
}

double parallax(const Camera& before, const Camera& after, int height, int width) {
    constexpr int places = 9;  // per side
    constexpr float far = 0.25f, near = 0.75f;
    const Projection from(after, height, width), to(before, height, width);
    std::array<double, places * places> moved;
    for (int i = 0; i < places * places; ++i) {
        const float row = static_cast<float>((height - 1) * (i / places)) / (places - 1);
        const float column = static_cast<float>((width - 1) * (i % places)) / (places - 1);
        const auto a = to.seen(from.point(row, column, far)), b = to.seen(from.point(row, column, near));
        const double rows = a.row - b.row, columns = a.column - b.column, squared = rows * rows + columns * columns;
        moved[static_cast<std::size_t>(i)] = squared < infinite ? squared : infinite;  // also if NaN
    }
    return std::sqrt(median(moved)) / height;
}

double FramePlanner::Once::seconds() const {
    return count_ == 0 ? 0 : trust_.share() * median(std::span(last_).first(std::min(count_, last_.size())));
}

FramePlanner::FramePlanner(std::size_t pixels, std::span<const Completion> completions, bool completes_meanwhile, const FrameConstants& constants)
    : constants_(constants), pixels_(static_cast<double>(pixels)), completes_meanwhile_(completes_meanwhile), first_(constants) {
    paces_.fill(Pace(constants));
    for (const Completion each : completions) is_there_[index(each)] = true;
}

double FramePlanner::rate(Mode mode) const {
    if (pace(mode).is_known()) return pace(mode).rate();
    const double known = first_.is_known() ? first_.rate() : std::ranges::max(paces_, {}, &Pace::rate).rate();
    return constants_.untried * known;
}

double FramePlanner::completing_pixel(Completion completion) const {
    const Once& measured = completing_[index(completion)];
    if (measured.is_known()) return measured.seconds();
    double slowest = 0;
    for (std::size_t i = 0; i < completing_.size(); ++i) slowest = std::max(slowest, completing_[i].seconds() / relative_times[i]);
    return slowest * relative_times[index(completion)];
}

double FramePlanner::scale(double pixels, double before, double seconds, double parallax, double threads) {
    static_assert(std::size(frame_errors::enlarged) == MovingScale::scales.size());
    const double measured = completing_pixel(fastest());
    const double chosen = scale_.next(pixels, measured > 0 ? measured : first_completing, seconds, [&](double scale) {
        pixels_ = pixels / (scale * scale);
        const auto at = std::ranges::find(MovingScale::scales, scale) - MovingScale::scales.begin();
        return std::ranges::min(errors(seconds, scale == before ? parallax : infinite, threads)) + frame_errors::enlarged[at];
    });
    pixels_ = pixels / (chosen * chosen);
    return chosen;
}

double FramePlanner::for_tracing(Mode mode, Completion completion, double seconds) const {
    if (mode == Mode::whole) return seconds;
    const double completing = for_completing(completion);
    return completes_meanwhile_ ? std::max(seconds, completing) : std::max(seconds - completing, constants_.min_tracing * completing);
}

Completion FramePlanner::completion(Mode mode, double known, double seconds, double threads) const {
    Completion best = fastest();
    if (mode == Mode::whole || mode == Mode::squares) return best;
    double min_error = infinite;
    for (const Completion each : {Completion::filling, Completion::small, Completion::standard}) {
        if (!is_there_[index(each)]) continue;
        const double completing = for_completing(each), left = completes_meanwhile_ ? seconds : seconds - completing;
        if (completing > seconds) break;
        const double more = std::isfinite(left) ? rate(mode) * left * threads / pixels_ : 0;
        const double error = expected_error(Mode::adaptive, each, static_cast<float>(known + more));
        if (error < min_error) min_error = error, best = each;
    }
    return best;
}

double FramePlanner::error(Mode mode, double seconds, double parallax, double threads) const {
    const Completion completion = this->completion(mode, 0, seconds, threads);
    const double completing = mode == Mode::whole ? 0 : for_completing(completion);
    const double before = mode == Mode::reproject ? reprojecting_.seconds() * pixels_ : 0;
    const double left = seconds - before - (completes_meanwhile_ ? 0 : completing);
    const double share = rate(mode) * left * threads / pixels_;
    if (left <= 0 || completing > seconds || (mode == Mode::whole && share < constants_.margin)) return infinite;
    return expected_error(mode, completion, static_cast<float>(std::max(share, 1 / pixels_)), static_cast<float>(parallax));
}

std::array<double, mode_names.size()> FramePlanner::errors(double seconds, double parallax, double threads) const {
    return {error(Mode::whole, seconds, 0, threads), error(Mode::squares, seconds, 0, threads), error(Mode::adaptive, seconds, 0, threads),
            std::isfinite(parallax) ? error(Mode::reproject, seconds, parallax, threads) : infinite};
}

Mode FramePlanner::plan(double seconds, double parallax, double threads) {
    const Mode chosen = best_mode(errors(seconds, parallax, threads));
    for (std::size_t i = 0; i < paces_.size(); ++i) {
        if (i != index(chosen)) paces_[i].doubt();
    }
    if (chosen != Mode::reproject) reprojecting_.doubt(constants_);
    return chosen;
}

Mode FramePlanner::plan_pixels(std::size_t pixels, double parallax) const {
    const auto share = static_cast<float>(static_cast<double>(pixels) / pixels_), moved = static_cast<float>(parallax);
    const Completion completion = this->completion(Mode::adaptive, share, infinite);
    const double anew = expected_error(Mode::adaptive, completion, share);
    return best_mode({infinite, infinite, anew, std::isfinite(moved) ? expected_error(Mode::reproject, completion, share, moved) : infinite});
}

}  // namespace bob
