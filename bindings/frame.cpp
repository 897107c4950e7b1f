/// The planner of frames.
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "bindings.h"
#include "frame/planner.h"
#include "frame/turnover.h"

using namespace nb::literals;

namespace {

template <class Enum, std::size_t N>
Enum named(const std::array<std::string_view, N>& names, std::string_view name) {
    const auto found = std::ranges::find(names, name);
    expect(found != names.end(), "expected a name that the planner knows");
    return static_cast<Enum>(found - names.begin());
}
bob::Mode mode(std::string_view name) { return named<bob::Mode>(bob::mode_names, name); }
bob::Completion completion(std::string_view name) { return named<bob::Completion>(bob::completion_names, name); }
std::string name_of(bob::Mode mode) { return std::string(bob::mode_names[static_cast<std::size_t>(mode)]); }
std::string name_of(bob::Completion completion) { return std::string(bob::completion_names[static_cast<std::size_t>(completion)]); }

}  // namespace

void bind_frame(nb::module_& m) {
    m.def("parallax", &bob::parallax, "before"_a, "after"_a, "height"_a, "width"_a,
          "The median motion of near points past points behind half of all depth, as a share of the picture's height; infinite if most of "
          "the picture was behind the first camera.");
    nb::class_<bob::FrameConstants>(m, "FrameConstants", "Of the planner, as core/frame/pace.h explains them.")
        .def(nb::init<>())
        .def_rw("min_tracing", &bob::FrameConstants::min_tracing)
        .def_rw("margin", &bob::FrameConstants::margin)
        .def_rw("untried", &bob::FrameConstants::untried)
        .def_rw("doubt", &bob::FrameConstants::doubt)
        .def_rw("floor", &bob::FrameConstants::floor)
        .def_rw("fade", &bob::FrameConstants::fade)
        .def_rw("growth", &bob::FrameConstants::growth);
    nb::class_<bob::FramePlanner>(m, "FramePlanner",
        "Plans frames of `pixels` by the predicted error at the deadline. Modes: \"whole\", \"squares\", \"adaptive\", \"reproject\"; "
        "completions: \"filling\", \"small\", \"default\". It has no clock.")
        .def("__init__", [](bob::FramePlanner* self, std::size_t pixels, const std::vector<std::string>& completions, const bob::FrameConstants& constants) {
            std::vector<bob::Completion> all;
            for (const std::string& name : completions) all.push_back(completion(name));
            expect(!all.empty(), "completions: expected at least one");
            new (self) bob::FramePlanner(pixels, all, false, constants);
        }, "pixels"_a, "completions"_a, "constants"_a = bob::FrameConstants())
        .def("traced", [](bob::FramePlanner& p, std::string_view name, double pixels, double seconds, bool is_first_round) {
            p.traced(mode(name), pixels, seconds, is_first_round);
        }, "mode"_a, "pixels"_a, "seconds"_a, "is_first_round"_a,
             "Reports the seconds that choosing and tracing pixels took; a first round covers the whole picture evenly.")
        .def("completed", [](bob::FramePlanner& p, std::string_view name, double pixels, double seconds) { p.completed(completion(name), pixels, seconds); },
             "completion"_a, "pixels"_a, "seconds"_a)
        .def("reprojected", &bob::FramePlanner::reprojected, "pixels"_a, "seconds"_a)
        .def("scale", &bob::FramePlanner::scale, "pixels"_a, "before"_a, "seconds"_a, "parallax"_a, "threads"_a = 1.0,
             "Chooses the divisor of the height and width of a moving picture, of `pixels` at 1, and sets its size; `before` is the divisor "
             "of the picture that can be reprojected.")
        .def("resize", &bob::FramePlanner::resize, "pixels"_a, "Sets the size of the pictures.")
        .def("plan", [](bob::FramePlanner& p, double seconds, double parallax) { return name_of(p.plan(seconds, parallax)); },
             "seconds"_a, "parallax"_a, "Returns the mode of a picture with a budget of `seconds`; an infinite parallax rules out reprojection.")
        .def("plan_pixels", [](bob::FramePlanner& p, std::size_t pixels, double parallax) { return name_of(p.plan_pixels(pixels, parallax)); },
             "pixels"_a, "parallax"_a, "The same for a budget of pixels.")
        .def("completion", [](const bob::FramePlanner& p, std::string_view name, double known, double seconds) {
            return name_of(p.completion(mode(name), known, seconds));
        }, "mode"_a, "known"_a, "seconds"_a,
             "Returns the completion of a picture whose share `known` is known when a frame of `seconds` ends; infinite `seconds` if it "
             "traces nothing more.")
        .def("for_tracing", [](const bob::FramePlanner& p, std::string_view name, std::string_view by, double seconds) {
            return p.for_tracing(mode(name), completion(by), seconds);
        }, "mode"_a, "completion"_a, "seconds"_a, "The seconds for tracing in a frame of `seconds`.")
        .def("for_completing", [](const bob::FramePlanner& p, std::string_view name) { return p.for_completing(completion(name)); }, "completion"_a,
             "The seconds for completing; 0 before any measurement.")
        .def("pixels_in", [](const bob::FramePlanner& p, std::string_view name, double seconds) { return p.pace(mode(name)).pixels_in(seconds); },
             "mode"_a, "seconds"_a, "The number of pixels in a call of `seconds`; 0 if less than a call costs.")
        .def("worthwhile", [](const bob::FramePlanner& p, std::string_view name) { return p.pace(mode(name)).worthwhile(); }, "mode"_a,
             "The number of pixels that take as long as the call around them.");
    nb::class_<bob::Turnover>(m, "Turnover", "The throughput of a tracer with several calls in flight. It has no clock.")
        .def(nb::init<>())
        .def("resumed", &bob::Turnover::resumed, "at"_a, "Reports that a call began while no other was in flight.")
        .def("returned", &bob::Turnover::returned, "pixels"_a, "seconds"_a, "at"_a, "in_flight"_a,
             "Reports that a call returned at time `at`, `seconds` after it began.")
        .def("pixels_in", &bob::Turnover::pixels_in, "seconds"_a, "in_flight"_a,
             "The number of pixels in a call of `seconds`, at least `worthwhile`.")
        .def("worthwhile", &bob::Turnover::worthwhile, "The number of pixels that take as long as the call around them.");
}
