/// The core's work on Python's threads: without the GIL, interruptible, and in order at exit.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>

#include "base/interruption.h"

namespace nb = nanobind;

/// During its lifetime, its thread works without the GIL. The end of the program stops and awaits the work of all
/// threads except the main one: Python would otherwise kill a thread that takes the GIL, in the middle of C++. Raises
/// SystemExit on other threads if the program is already ending; threading ignores it silently.
class WithoutGil {
public:
    WithoutGil();
    ~WithoutGil();
    WithoutGil(const WithoutGil&) = delete;
    WithoutGil& operator=(const WithoutGil&) = delete;

    /// Whether the work may continue. On the main thread, which alone handles signals, Python's handlers run now and
    /// then, with the GIL.
    [[nodiscard]] bool keeps_going();

    /// Whether a signal's handler raised Python's current exception.
    [[nodiscard]] bool raised() const { return raised_; }

private:
    const bool is_main_;
    bool raised_ = false;
    std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
    PyThreadState* python_;
};

/// During its lifetime, its thread alone uses a mutable object; other threads get an error in one line. A lock might
/// block a thread that holds the GIL which the owner needs. Constructed and destroyed with the GIL.
class InUse {
public:
    /// Throws ValueError if another thread uses it.
    explicit InUse(const void* object);
    ~InUse();
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;

private:
    const void* object_;
};

/// Raises SystemExit.
[[noreturn]] void leave_thread();

/// Runs work() without the GIL.
template <class Work>
auto without_gil(Work work) {
    const WithoutGil without;
    return work();
}

/// Runs work() without the GIL, in an Interruption that Ctrl-C or the end of the program stops. Exceptions of signal
/// handlers are raised here.
template <class Work>
void interruptible(Work work) {
    bool raised = false, stopped = false;
    {
        WithoutGil without;
        const bob::Interruption interruption([&] { return without.keeps_going(); });
        try {
            work();
        } catch (const bob::Stopped&) {
            stopped = true;
        }
        raised = without.raised();
    }
    if (raised) throw nb::python_error();
    if (stopped) leave_thread();
}

/// Runs work() without the GIL on an object that it changes.
template <class Object, class Work>
auto changing(const Object& object, Work work) {
    const InUse in_use(&object);
    return without_gil(work);
}

void bind_threads(nb::module_& m);
