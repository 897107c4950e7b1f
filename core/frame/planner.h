/// How a frame is made: which pixels are traced in its time, and which network completes it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "frame/pace.h"
#include "picture/camera.h"

namespace bob {

/// How the pixels of a picture are chosen.
enum class Mode : std::uint8_t {
    whole,      ///< all of them, which need no completing
    squares,    ///< `SquaresOrder`, for rays that cost little
    adaptive,   ///< `AdaptiveOrder`
    reproject,  ///< `RefreshOrder`, over what earlier pictures let expect
};
constexpr std::array<std::string_view, 4> mode_names = {"whole", "squares", "adaptive", "reproject"};

/// What completes a picture, from the quickest to the slowest.
enum class Completion : std::uint8_t { filling, small, standard };
constexpr std::array<std::string_view, 3> completion_names = {"filling", "small", "default"};

/// What is expected of a picture: the mean of 1 - SSIM over the scenes that `bench/frame_errors.py` measures.
/// `share`: of its pixels that are traced; `parallax`: since the last picture, where that is reprojected.
[[nodiscard]] float expected_error(Mode mode, Completion completion, float share, float parallax = 0);

/// How far near things move past those half of all depth behind them from one camera to another, as a share of the
/// picture's height: a median over the picture; infinite where most of it was behind the first camera.
[[nodiscard]] double parallax(const Camera& before, const Camera& after, int height, int width);

/// Decides how frames are made, by one criterion: the error that is expected when a frame's time is over. It has no clock:
/// hosts say what everything took.
class FramePlanner {
public:
    /// Of pictures of so many pixels. `completes_meanwhile`: whether another processor completes a picture while the next
    /// one is traced. `completions`: those that there are, in any order.
    FramePlanner(std::size_t pixels, std::span<const Completion> completions, bool completes_meanwhile, const FrameConstants& constants = {});

    /// Pictures have so many pixels from now on. What was measured stays.
    void resize(std::size_t pixels) { pixels_ = static_cast<double>(pixels); }

    /// So many pixels of a mode were traced in so many seconds, those included that choosing them took. Those of a first round
    /// lie all over the picture, whatever they show.
    void traced(Mode mode, double pixels, double seconds, bool is_first_round) {
        paces_[index(mode)].measured(pixels, seconds);
        if (is_first_round) first_.measured(pixels, seconds);
    }
    /// A picture of so many pixels was completed.
    void completed(Completion completion, double pixels, double seconds) { completing_[index(completion)].measured(seconds / pixels); }
    /// Earlier pictures were reprojected, which a frame of that mode begins with.
    void reprojected(double pixels, double seconds) { reprojecting_.measured(seconds / pixels); }

    /// How to make a picture in so many seconds. `parallax`: since the last one; infinite where nothing can be reprojected.
    /// `threads`: by which the seconds of what was traced are divided, where these are of one of several.
    [[nodiscard]] Mode plan(double seconds, double parallax, double threads = 1);
    /// The same where a number of pixels is asked for, whatever time they take: adaptive, or reproject.
    [[nodiscard]] Mode plan_pixels(std::size_t pixels, double parallax) const;

    /// What is to complete a picture of which this share is known, traced or expected, when a frame of so many seconds is over;
    /// infinite where it traces nothing further.
    [[nodiscard]] Completion completion(Mode mode, double known, double seconds, double threads = 1) const;

    /// Seconds for tracing in a frame of so many.
    [[nodiscard]] double for_tracing(Mode mode, Completion completion, double seconds) const;
    /// Seconds that completing takes; 0 where nothing was measured.
    [[nodiscard]] double for_completing(Completion completion) const;
    /// For calls of the tracer.
    [[nodiscard]] const Pace& pace(Mode mode) const { return paces_[index(mode)]; }

private:
    /// How long completions take beside the slowest, before that is measured.
    static constexpr std::array<double, 3> relative_times = {0.3, 0.5, 1};

    /// What happens once a frame: a median, since one that is late must not make the next ones short.
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

    /// Pixels a second of a mode, as far as anything is known; else 0.
    [[nodiscard]] double rate(Mode mode) const;
    /// Expected when a frame is over; infinite where it would be late.
    [[nodiscard]] double error(Mode mode, double seconds, double parallax, double threads) const;

    FrameConstants constants_;
    double pixels_;
    std::array<bool, completion_names.size()> is_there_{};
    bool completes_meanwhile_;
    std::array<Pace, mode_names.size()> paces_;
    Pace first_;
    std::array<Once, completion_names.size()> completing_;  // a pixel
    Once reprojecting_;                                     // a pixel
};

}  // namespace bob
