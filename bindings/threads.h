/// The core's work among Python's threads: without the GIL, interruptible, in order until the program ends.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>

#include "base/interruption.h"

namespace nb = nanobind;

/// While one lives, its thread works without the GIL. The end of the program stops and awaits the work of all threads but the
/// main one: Python would end a thread that takes the GIL afterwards, in the midst of C++. Raises SystemExit on such a thread
/// if the program is ending already; threading passes over it in silence.
class WithoutGil {
public:
    WithoutGil();
    ~WithoutGil();
    WithoutGil(const WithoutGil&) = delete;
    WithoutGil& operator=(const WithoutGil&) = delete;

    /// Whether the work may go on. On the main thread, which alone handles signals, Python's handlers run now and then, with the
    /// GIL taken back.
    [[nodiscard]] bool keeps_going();

    /// Whether a signal's handler raised Python's current exception.
    [[nodiscard]] bool raised() const { return raised_; }

private:
    const bool is_main_;
    bool raised_ = false;
    std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
    PyThreadState* python_;
};

/// While one lives, its thread alone uses an object that changes; another one that wants to gets one clear line. A lock would
/// keep the GIL from whoever needs it to go on. It begins and ends with the GIL.
class InUse {
public:
    /// ValueError if another thread uses it.
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

/// Runs work() without the GIL, in an Interruption that lets Ctrl-C stop it, and the end of the program. What a signal's handler
/// raised is raised here.
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
