/// The planner of frames: it chooses which pixels are traced and which network completes them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "frame/pace.h"
#include "picture/camera.h"

namespace bob {

/// Ways to choose the pixels of a picture.
enum class Mode : std::uint8_t {
    whole,      ///< all pixels; no completion
    squares,    ///< by `SquaresOrder`, for fast rays
    adaptive,   ///< by `AdaptiveOrder`
    reproject,  ///< by `RefreshOrder`, over reprojected samples of earlier pictures
};
constexpr std::array<std::string_view, 4> mode_names = {"whole", "squares", "adaptive", "reproject"};

/// Networks that complete pictures, the fastest first.
enum class Completion : std::uint8_t { filling, small, standard };
constexpr std::array<std::string_view, 3> completion_names = {"filling", "small", "default"};

/// The expected error of a picture: the mean of 1 - SSIM over the scenes that `bench/frame_errors.py` measures.
/// `share`: traced pixels over all pixels; `parallax`: since the last picture, for reprojection.
[[nodiscard]] float expected_error(Mode mode, Completion completion, float share, float parallax = 0);

/// The parallax between two cameras, over the picture's height. It is the motion of a near point relative to a point
/// behind it by half of the depth range. The result is the median over the picture, and infinite if more than half of it
/// was behind the first camera.
[[nodiscard]] double parallax(const Camera& before, const Camera& after, int height, int width);

/// Plans frames by one criterion: the expected error when the frame's time is over. It has no clock; hosts report
/// durations.
class FramePlanner {
public:
    /// `pixels`: of a picture. `completions`: the available networks, in any order. `completes_meanwhile`: whether another
    /// processor completes a picture while the next one is traced.
    FramePlanner(std::size_t pixels, std::span<const Completion> completions, bool completes_meanwhile, const FrameConstants& constants = {});

    /// Changes the size of the pictures. Measurements stay.
    void resize(std::size_t pixels) { pixels_ = static_cast<double>(pixels); }

    /// Reports the time for choosing and tracing pixels. Those of a first round are spread over the picture.
    void traced(Mode mode, double pixels, double seconds, bool is_first_round) {
        paces_[index(mode)].measured(pixels, seconds);
        if (is_first_round) first_.measured(pixels, seconds);
    }
    /// Reports the time for completing a picture.
    void completed(Completion completion, double pixels, double seconds) { completing_[index(completion)].measured(seconds / pixels); }
    /// Reports the time for reprojecting earlier pictures, before the first ray.
    void reprojected(double pixels, double seconds) { reprojecting_.measured(seconds / pixels); }

    /// The mode of minimum expected error after `seconds`. `parallax`: since the last picture; infinite if nothing can
    /// be reprojected. `threads`: number of tracing threads, if reported times are for one thread.
    [[nodiscard]] Mode plan(double seconds, double parallax, double threads = 1);
    /// The same for a number of pixels, regardless of time: adaptive or reproject.
    [[nodiscard]] Mode plan_pixels(std::size_t pixels, double parallax) const;

    /// The network that completes a picture after `seconds`, or now if they are infinite. `known`: the share of its pixels that
    /// are traced or reprojected.
    [[nodiscard]] Completion completion(Mode mode, double known, double seconds, double threads = 1) const;

    /// The divisor of a moving picture's height and width, of `pixels` at 1, and sets its size. A smaller picture has a larger share of
    /// traced pixels, but is shown enlarged; the expected error of both decides. `before`: the divisor of the picture that can be
    /// reprojected. Other arguments as in `plan`.
    double scale(double pixels, double before, double seconds, double parallax, double threads = 1);

    /// The share of a frame's seconds reserved for tracing.
    [[nodiscard]] double for_tracing(Mode mode, Completion completion, double seconds) const;
    /// Seconds to complete a picture; 0 before the first measurement.
    [[nodiscard]] double for_completing(Completion completion) const { return completing_pixel(completion) * pixels_; }
    /// The measured pace of a mode, for calls of the tracer.
    [[nodiscard]] const Pace& pace(Mode mode) const { return paces_[index(mode)]; }

private:
    /// Times of the networks relative to the slowest, before measurement.
    static constexpr std::array<double, 3> relative_times = {0.3, 0.5, 1};
    /// Assumed seconds to complete a pixel, before measurement: the filling takes 7 to 9 ns in a page.
    static constexpr double first_completing = 1e-8;

    /// A duration measured once a frame: a median, because one late frame must not shorten the next ones.
    class Once {
    public:
        void measured(double seconds) { last_[count_++ % last_.size()] = seconds, trust_.measured(); }
        [[nodiscard]] bool is_known() const { return count_ > 0; }
        [[nodiscard]] double seconds() const;
        void doubt(const FrameConstants& constants) { trust_.doubt(constants); }

    private:
        std::array<double, 5> last_{};
        std::size_t count_ = 0;
        Trust trust_;
    };

    template <class Enum>
    static constexpr std::size_t index(Enum value) { return static_cast<std::size_t>(value); }

    /// Pixels per second of a mode, measured or estimated; 0 if unknown.
    [[nodiscard]] double rate(Mode mode) const;
    /// The fastest network that is available.
    [[nodiscard]] Completion fastest() const { return static_cast<Completion>(std::ranges::find(is_there_, true) - is_there_.begin()); }
    /// Seconds to complete a pixel; 0 before the first measurement.
    [[nodiscard]] double completing_pixel(Completion completion) const;
    /// The expected errors of the modes at the end of a frame; infinite for a mode that would be late.
    [[nodiscard]] std::array<double, mode_names.size()> errors(double seconds, double parallax, double threads) const;
    [[nodiscard]] double error(Mode mode, double seconds, double parallax, double threads) const;

    FrameConstants constants_;
    double pixels_;
    std::array<bool, completion_names.size()> is_there_{};
    bool completes_meanwhile_;
    std::array<Pace, mode_names.size()> paces_;
    Pace first_;
    std::array<Once, completion_names.size()> completing_;  // per pixel
    Once reprojecting_;                                     // per pixel
    MovingScale scale_{MovingScale::scales.back()};
};

}  // namespace bob
