#include "frame/planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "check.h"

namespace {

using bob::Completion, bob::FramePlanner, bob::Mode;

constexpr std::size_t pixels = 640 * 480;
constexpr double never = std::numeric_limits<double>::infinity();

/// A machine without noise: seconds for all pixels of each mode, to complete a picture by the filling, the small network and the
/// default one, and to reproject. The first run of a step takes `cold` times as long.
struct Machine {
    std::array<double, 4> whole_picture;
    std::array<double, 3> completing = {0.002, 0.004, 0.006};
    double reprojecting = 0.004;
    double cold = 1;
    std::array<bool, 4> is_warm{};

    /// Makes a frame; returns how it was made, and whether it was in time.
    struct Made {
        Mode mode;
        Completion completion;
        double share;
        bool is_late;
    };
    Made frame(FramePlanner& planner, double seconds, double parallax) {
        const Mode mode = planner.plan(seconds, parallax);
        const auto m = static_cast<std::size_t>(mode);
        const double times = is_warm[m] ? 1 : cold;
        is_warm[m] = true;
        double spent = 0;
        if (mode == Mode::reproject) {
            spent = times * reprojecting;
            planner.reprojected(pixels, spent);
        }
        const Completion completion = planner.completion(mode, mode == Mode::reproject ? 0.6 : 0, seconds);
        const double left = std::max(planner.for_tracing(mode, completion, seconds) - spent, 1e-4);
        const double share = std::min(1., left / (times * whole_picture[m])), took = share * times * whole_picture[m];
        if (mode == Mode::adaptive) planner.traced(mode, pixels / 64., whole_picture[1] / 64, true);
        planner.traced(mode, share * pixels, took, false);
        spent += took;
        if (share < 1) {
            const double each = completing[static_cast<std::size_t>(completion)];
            planner.completed(completion, pixels, each);
            spent += each;
        }
        return {mode, completion, share, spent > 1.01 * seconds};
    }
};

FramePlanner planner_of(bool completes_meanwhile = false) {
    constexpr std::array all = {Completion::standard, Completion::filling, Completion::small};
    return {pixels, all, completes_meanwhile};
}

/// The commonest mode of the last of many frames, how often the mode changed in these, and how many frames were late.
struct Settled {
    Mode mode;
    int changes = 0, late = 0;
    Completion completion;
};
Settled settled(Machine machine, double seconds, double parallax) {
    FramePlanner planner = planner_of();
    std::array<int, 4> counts{};
    Settled result{};
    Mode before{};
    for (int i = 0; i < 200; ++i) {
        const auto made = machine.frame(planner, seconds, i == 0 ? never : parallax);
        if (i >= 100) {
            ++counts[static_cast<std::size_t>(made.mode)];
            result.changes += i > 100 && made.mode != before;
            result.late += made.is_late;
            result.completion = made.completion;
        }
        before = made.mode;
    }
    result.mode = static_cast<Mode>(std::max_element(counts.begin(), counts.end()) - counts.begin());
    return result;
}

TEST(expected_errors_fall_with_the_share_and_grow_with_the_parallax) {
    for (const Mode mode : {Mode::squares, Mode::adaptive, Mode::reproject}) {
        for (const Completion completion : {Completion::filling, Completion::small, Completion::standard}) {
            float before = 1;
            for (float share = 1e-5f; share < 1; share *= 1.2f) {
                const float error = bob::expected_error(mode, completion, share, 0.02f);
                CHECK(error <= before && error > 0);
                before = error;
            }
            CHECK(bob::expected_error(mode, completion, 1, 0.02f) == 0);
        }
    }
    for (const float share : {0.001f, 0.01f, 0.05f}) {
        float before = 0;
        for (float parallax = 0; parallax < 0.2f; parallax += 0.003f) {
            const float error = bob::expected_error(Mode::reproject, Completion::filling, share, parallax);
            CHECK(error >= before);
            before = error;
        }
    }
}

TEST(a_jump_shows_no_more_than_a_new_picture) {
    for (const float share : {0.003f, 0.01f, 0.03f, 0.1f}) {
        const float jump = bob::expected_error(Mode::reproject, Completion::filling, share, 0.6f);
        CHECK(jump >= bob::expected_error(Mode::adaptive, Completion::standard, share) * 0.94f);
    }
}

TEST(parallax_is_of_near_and_far_things) {
    const bob::Camera camera;
    CHECK(bob::parallax(camera, camera, 480, 640) < 1e-5);
    bob::Camera turned = camera;
    turned.roll_degrees = 30, turned.zoom = 1.2f, turned.pan_x = 0.1f;
    CHECK(bob::parallax(camera, turned, 480, 640) < 1e-5);  // parallel rays: everything moves by the same amount
    bob::Camera beside = camera;
    double before = 0;
    for (int degrees = 1; degrees < 60; ++degrees) {
        beside.azimuth_degrees = camera.azimuth_degrees + static_cast<float>(degrees);
        const double parallax = bob::parallax(camera, beside, 480, 640);
        CHECK(parallax > before);
        before = parallax;
    }
    bob::Camera inside = camera, away = camera;
    inside.fov_degrees = away.fov_degrees = 60;
    inside.standpoint = bob::Standpoint{{0, 0, 0}, {1, 0, 0}}, away.standpoint = bob::Standpoint{{0, 0, 0}, {-1, 0, 0}};
    CHECK(std::isinf(bob::parallax(inside, away, 480, 640)));
}

TEST(pictures_are_whole_where_there_is_time) {
    const auto [mode, changes, late, completion] = settled({{0.02, 0.04, 0.06, 0.05}}, 0.033, 0.016);
    CHECK(mode == Mode::whole && changes == 0 && late == 0);
}

TEST(fast_rays_are_placed_by_squares_and_slow_ones_beside_what_was_seen) {
    // A quarter of the squares' pixels fits, and a hundredth of the others.
    CHECK(settled({{0.08, 0.1, 2.5, 2.5}}, 0.033, 0.016).mode == Mode::squares);
    const auto [mode, changes, late, completion] = settled({{5., 5., 6., 6.}}, 0.033, 0.016);
    CHECK(mode == Mode::reproject && completion == Completion::filling);
    CHECK(changes <= 4 && late <= 2);
}

TEST(nothing_is_reprojected_where_that_leaves_no_time_or_says_nothing) {
    Machine machine = {{5., 5., 6., 6.}};
    CHECK(settled(machine, 0.033, never).mode == Mode::adaptive);
    machine.reprojecting = 0.05;
    const auto [mode, changes, late, completion] = settled(machine, 0.033, 0.016);
    CHECK(mode == Mode::adaptive && late <= 4);
}

TEST(what_was_slow_at_first_is_tried_again_soon) {
    Machine machine = {{5., 5., 6., 6.}};
    machine.cold = 10;
    FramePlanner planner = planner_of();
    int others = 0;
    for (int i = 0; i < 120; ++i) {
        const Mode mode = machine.frame(planner, 0.033, i == 0 ? never : 0.016).mode;
        others += i >= 40 && mode != Mode::reproject;
    }
    CHECK(others <= 5);
}

TEST(counts_of_pixels_decide_without_a_clock) {
    FramePlanner planner = planner_of();
    CHECK(planner.plan_pixels(pixels / 100, 0.016) == Mode::reproject);
    CHECK(planner.plan_pixels(pixels / 100, never) == Mode::adaptive);
    CHECK(planner.plan_pixels(pixels / 30, 0.2) == Mode::adaptive);
}

TEST(completions_that_are_too_slow_give_way) {
    FramePlanner planner = planner_of();
    for (int i = 0; i < 5; ++i) {
        planner.completed(Completion::standard, pixels, 0.05), planner.completed(Completion::small, pixels, 0.02);
        planner.completed(Completion::filling, pixels, 0.01);
    }
    CHECK(planner.completion(Mode::adaptive, 0.01, never) == Completion::standard);
    CHECK(planner.completion(Mode::adaptive, 0.01, 0.033) == Completion::small);
    CHECK(planner.completion(Mode::adaptive, 0.01, 0.005) == Completion::filling);  // late, and the quickest
    CHECK(planner.completion(Mode::squares, 0.01, never) == Completion::filling);
    CHECK(planner.for_tracing(Mode::adaptive, Completion::small, 0.033) > 0.0129);
    CHECK(planner.for_tracing(Mode::adaptive, Completion::small, 0.01) > 0.0049);  // every budget makes progress
    CHECK(planner.for_tracing(Mode::whole, Completion::small, 0.033) == 0.033);
    FramePlanner beside = planner_of(true);
    beside.completed(Completion::standard, pixels, 0.05);
    CHECK(std::abs(beside.for_tracing(Mode::adaptive, Completion::standard, 0.033) - 0.05) < 1e-9);
    CHECK(beside.for_tracing(Mode::adaptive, Completion::filling, 0.033) == 0.033);
}

TEST(moving_pictures_are_as_small_as_completing_demands) {
    FramePlanner planner = planner_of();
    const auto scale = [&](double count, double seconds) { return planner.scale(count, 1, seconds, never); };
    CHECK_EQ(scale(pixels, 0.033), 1);  // nothing is measured, and 10 ns a pixel assumed
    CHECK_EQ(scale(100 * pixels, 0.033), 4);
    CHECK_EQ(scale(pixels, 1e-6), 8);
    planner.traced(Mode::whole, pixels, 0.001, false);
    planner.completed(Completion::small, pixels, 0.17);  // the filling takes .6 of it
    CHECK_EQ(scale(pixels, 0.033), 2);
    planner.completed(Completion::filling, pixels, 0.04);
    CHECK_EQ(scale(pixels, 0.033), 1.25);
    planner.completed(Completion::filling, pixels, 0.03);  // of two medians the lower one
    CHECK_EQ(scale(pixels, 0.033), 1.25);                  // a fifth must be left before it grows
    CHECK_EQ(scale(pixels, 0.038), 1);
}

TEST(moving_pictures_are_smaller_where_few_pixels_are_traced) {
    // Seconds for all pixels by squares, and the least and the largest divisor for a frame of .033 s.
    for (const auto& [whole, min, max] : {std::array{0.02, 1., 1.}, {0.3, 1., 1.}, {0.8, 1., 2.}, {3., 2., 4.}, {30., 3., 8.}}) {
        FramePlanner planner = planner_of(true);
        planner.completed(Completion::filling, pixels, 0.002);
        planner.traced(Mode::squares, pixels / 64., whole / 64, true);
        planner.traced(Mode::adaptive, pixels / 64., 2 * whole / 64, false);
        const double scale = planner.scale(pixels, 1, 0.033, never);
        CHECK(min <= scale && scale <= max);
        planner.traced(Mode::squares, pixels / 64., 0.9 * whole / 64, false);
        CHECK_EQ(planner.scale(pixels, 1, 0.033, never), scale);  // a small change does not alternate
    }
}

TEST(a_picture_that_shows_what_was_seen_keeps_its_size) {
    FramePlanner planner = planner_of(true);
    planner.completed(Completion::filling, pixels, 0.002);
    planner.reprojected(pixels, 0.004);
    planner.traced(Mode::squares, pixels / 64., 3. / 64, true);
    planner.traced(Mode::adaptive, pixels / 64., 3. / 64, false);
    planner.traced(Mode::reproject, pixels / 64., 1. / 64, false);
    CHECK_EQ(planner.scale(pixels, 1, 0.033, 0.004), 1);
    CHECK(planner.plan(0.033, 0.004) == Mode::reproject);
    CHECK(planner.scale(pixels, 1, 0.033, never) > 1);  // nothing was seen
    CHECK(planner.scale(pixels, 4, 0.033, 0.004) > 1);  // nothing was seen in this size
}

TEST(calls_grow_step_by_step_to_what_there_is_time_for) {
    bob::Pace pace;
    CHECK(pace.pixels_in(1) == 32);
    double called = 0;
    for (int i = 0; i < 12; ++i) {
        const double count = pace.pixels_in(0.01);
        CHECK(count <= 8 * std::max(called, 4.));
        pace.measured(count, 0.001 + count * 1e-6);
        called = count;
    }
    CHECK(std::abs(called - 9000) < 90);
    CHECK(pace.pixels_in(0.0009) == 0);
    CHECK(std::abs(pace.worthwhile() - 1000) < 10);
}

}  // namespace
